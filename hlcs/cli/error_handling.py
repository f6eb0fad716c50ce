"""The outermost handling of errors: whatever happens in the command
ends in one line on stderr and an exit status, never in a traceback.

Exit status: 0 done, 2 the user's input is at fault, 1 anything else. What nobody foresaw is written, with its traceback, to a
report. Nothing heavy is imported here: errors are handled before NumPy and the compiler are loaded. All that the command
prints goes through `say`.
"""

import os
import re
import sys
import warnings

from hlcs.processes import interrupts

# Characters of a file's text that would steer the terminal, and not be seen: control characters but for line end and tab, line
# separators, marks that turn the direction of writing, halves of characters.
STEERING = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069\ud800-\udfff]")
LONGEST = 1000  # letters of a complaint: a screen of a terminal, whatever the file holds

_lasting = []  # what stays, whatever happens from now on: (words, whether they say that the same command goes on)


def handled(command):
    """command() and its exit status (None is 0); everything it raises is reported in one line."""
    with warnings.catch_warnings():
        try:
            interrupts.listen()
            _lasting.clear()
            _open_streams()
            warnings.showwarning = _warning_printer()
            if _folder_is_gone():
                return _complain("the current folder is not there any more; go to another one: cd", 2)
            status = command()
            sys.stdout.flush()
            return status if isinstance(status, int) else 0
        except BaseException as problem:
            with interrupts.held_off():
                return _report_line(problem)


def say(text, stream=None):
    """Print a text of lines, to stdout if not said otherwise; what would steer a terminal is shown as in a Python string."""
    stream = stream or sys.stdout
    stream.write(STEERING.sub(lambda found: repr(found[0])[1:-1], text) + "\n")
    stream.flush()


def flush():
    """Write what still waits in the streams; where they take nothing that was said already."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except (OSError, ValueError):
            pass


def remember(what, goes_on=False):
    """Remember for the last line what stays whatever happens from now on, such as "out is written".

    goes_on: it says that the same command goes on, which is not said of a command whose input is refused: it would be again."""
    _lasting.append((what, goes_on))


def _report_line(problem):
    """The exit status of what was raised, after its one line."""
    if _is(problem, "click.exceptions", "Abort"):  # which stands for Ctrl-C, and for any file that ended too early
        problem = problem.__cause__ or problem
    if interrupts.seen() or isinstance(problem, KeyboardInterrupt):
        return _complain("interrupted; nothing half done was left behind" + _lasts(), 1)
    if _lost_output(problem):
        _to_nowhere(sys.stdout)
        if isinstance(problem, BrokenPipeError):  # the reader went away, as `head` does
            return 1
        return _complain(f"standard output cannot be written ({problem.strerror}); give it a place, or --quiet" + _lasts(), 1)
    if _is(problem, "minibullet.errors", "InputError"):
        return _complain(f"{problem}" + _lasts(refused=True), 2)
    if _is(problem, "minibullet.errors", "RunError"):
        if problem.result is not None:  # what could be written nowhere
            say(problem.result)
        return _complain(f"{problem}" + _lasts(), 1)
    if _is(problem, "click.exceptions", "NoArgsIsHelpError"):
        say(problem.format_message())
        return 2
    if _is(problem, "click.exceptions", "ClickException"):
        command = getattr(getattr(problem, "ctx", None), "command_path", None)
        return _complain(problem.format_message() + (f" (see: {command} --help)" if command else ""), 2)
    if isinstance(problem, MemoryError):
        return _complain("not enough memory; take fewer units, rows, repeats or workers" + _lasts("nothing was written"), 1)
    what = f"{type(problem).__name__}: {problem}".rstrip(": ")
    return _complain(
        f"unexpected {what[:300]}; not foreseen, please report it; {_report(problem)}" + _lasts("nothing was written"), 1
    )


def _complain(what, status):
    """One line on stderr; where even that cannot be written the exit status must do."""
    line = " ".join(what.split())
    if len(line) > LONGEST:
        line = f"{line[: LONGEST * 2 // 3]} .. {line[-LONGEST // 3 :]}"
    try:
        say("hlcs: " + line, sys.stderr)
    except OSError:
        _to_nowhere(sys.stderr)
    return status


def _warning_printer():
    """What shows a warning: one line, each text once. A number that ran over inside a library names no file and no remedy: the
    check that meets it tells of it."""
    printed = set()

    def show(message, *_, **__):
        if str(message) not in printed and not isinstance(message, RuntimeWarning):
            printed.add(str(message))
            _complain(f"warning: {message}", 0)

    return show


def _lasts(nothing="", refused=False):
    words = "; ".join(what for what, goes_on in _lasting if not (refused and goes_on)) or nothing
    return f"; {words}" if words else ""


def _is(problem, module, name):
    """Whether it is of a class of a module that may not be loaded yet (then it is not)."""
    kind = getattr(sys.modules.get(module), name, None)
    return kind is not None and isinstance(problem, kind)


def _report(problem):
    """Write a file with the traceback; in words, where it is."""
    import tempfile
    import traceback

    try:
        trace = "".join(traceback.format_exception(problem))
        version = f"Python {sys.version}\nplatform {sys.platform}\ncommand {sys.argv!r}\n\n"
        for place in (tempfile.gettempdir, os.getcwd):
            try:
                number, path = tempfile.mkstemp(".txt", "hlcs-report-", place())
                with open(number, "w", encoding="utf-8", errors="backslashreplace") as file:
                    file.write(version + trace)
                return f"report with the traceback: {path}"
            except OSError as refused:
                why = refused
    except Exception as refused:  # whatever happens to the report, the line is said
        why = refused
    return f"no report could be written ({why})"


# -------------------------------------------------------------------------------------------------------------- surroundings
def _folder_is_gone():
    """Whether the current folder was deleted under us: half of Python fails in such a one, in many ways."""
    try:
        os.getcwd()
    except OSError:
        return True
    return False


def _open_streams():
    """Streams that can be written, or say why not: a letter that a terminal does not have is shown by its number; a stream that
    was closed (`>&-`) is opened, for no file of ours may take its number, but not for writing."""
    for number, name in ((1, "stdout"), (2, "stderr")):
        stream = getattr(sys, name)
        if stream is None:
            found = os.open(os.devnull, os.O_RDONLY if name == "stdout" else os.O_WRONLY)
            if found != number:
                os.dup2(found, number)
                os.close(found)
            setattr(sys, name, open(number, "w", encoding="utf-8", errors="backslashreplace"))
        elif hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


def _lost_output(problem):
    """Whether it was raised as standard output was written, by one of those that do so."""
    if not isinstance(problem, OSError):
        return False
    last = problem.__traceback__
    while last.tb_next:
        last = last.tb_next
    echo = getattr(sys.modules.get("click"), "echo", say)  # the texts of --help
    return last.tb_frame.f_code in (say.__code__, handled.__code__, echo.__code__)


def _to_nowhere(stream):
    """Let what is still waiting to be written go nowhere: Python tries again as it ends, and would complain in its own words."""
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        stream.flush()
    except (OSError, ValueError):
        pass
