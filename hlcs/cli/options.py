"""What the commands of `hlcs` share: options, examples, progress, and what they print and write at the end."""

import functools
import inspect
import json
import sys
from contextlib import nullcontext, redirect_stdout
from pathlib import Path

import click
from tqdm import tqdm

from hlcs.cli import error_handling
from hlcs.files import folders
from hlcs.placement.presets import PRESETS
from hlcs.processes import interrupts


class PathName(click.ParamType):
    """A name that the system can take, of something that is there or not: refused now, not after the work."""

    name = "path"

    def convert(self, value, param, ctx):
        try:
            if value.strip():
                Path(value).expanduser().lstat()
                return value
            problem = "it is empty; give a name"
        except FileNotFoundError:
            return value
        except (OSError, ValueError, RuntimeError) as refused:  # RuntimeError: ~ of nobody
            problem = getattr(refused, "strerror", None) or refused
        self.fail(f"'{value[:60]}': {problem}", param, ctx)


SEED = click.IntRange(0, 2**63 - 1)


def path_option(*names, **settings):
    """An option that names a file or a folder."""
    return click.option(*names, type=PathName(), **settings)


def json_option(command):
    """--json FILE; with "-" the command gets standard output itself, and all its other words go to standard error."""

    @functools.wraps(command)
    def given(json_file=None, **others):
        if json_file != "-":
            if json_file:
                folders.check_file(json_file)  # refused now, not after the work
            return command(json_file=json_file, **others)
        stream = sys.stdout
        with redirect_stdout(sys.stderr):
            return command(json_file=stream, **others)

    words = "the result for a program; - is standard output, then all other words go to standard error"
    return path_option("--json", "json_file", metavar="FILE", help=words)(given)


def quiet_option(command):
    """--quiet."""
    return click.option("--quiet", "-q", is_flag=True, help="print nothing, show no progress")(command)


def details_option(command):
    """--details."""
    return click.option("--details", is_flag=True, help="print the statistics behind the report as well")(command)


def output_options(command):
    """--out, --json, --quiet."""
    command = json_option(quiet_option(command))
    return path_option("--out", metavar="DIR", help="folder for files: tables, pictures, settings")(command)


def effects_option(words):
    """--effects; words: what it is good for in this command."""
    words = f"a Python file with effects of your own{words}. Effects files are run as code: give only files that you trust"
    return path_option("--effects", "effects_file", metavar="FILE.py", help=words)


def allow_outside_option(command):
    """--allow-outside."""
    words = "let the file name files outside its own folder"
    return click.option("--allow-outside", is_flag=True, help=words)(command)


def preset_option(command):
    """--preset."""
    words = "settings by one name: paper, the paper's own (docs/paper.md); options given beside it win"
    return click.option("--preset", "preset_name", type=click.Choice(list(PRESETS)), help=words)(command)


def workers_option(command):
    """--workers."""
    return click.option("--workers", type=click.IntRange(1), help="processes  [default: as many as processors]")(command)


def example(*lines):
    """Add real command lines to the end of a command's help."""

    def add(function):
        function.__doc__ = inspect.cleandoc(function.__doc__) + "\n\n\b\nExample:\n" + "\n".join(f"  {line}" for line in lines)
        return function

    return add


class ProgressBar:
    """A progress bar on a terminal, nothing elsewhere; total None = known only when the work starts."""

    def __init__(self, name, total, quiet):
        self._name, self._quiet, self._bar = name, quiet, None
        if total is not None:
            self.start(total)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self._bar is not None:
            self._bar.close()

    def start(self, total, done=0):
        """Show a bar of so many pieces; returns the function to be called as each one ends."""
        # disable=None: none where stderr is not a terminal
        hidden = True if self._quiet else None
        self._bar = tqdm(total=total, initial=done, desc=self._name, leave=False, disable=hidden, file=sys.stderr)
        self._bar.refresh()
        return self.update

    def update(self):
        """One piece is done."""
        interrupts.check()
        self._bar.update()


def out_folder(out):
    """The context of a folder that appears whole as `out`; of nothing where no folder is asked for."""
    return folders.result_folder(out) if out else nullcontext()


def publish(document, text, json_file, out, quiet):
    """The last words of a command: its JSON, the report, and where things were written; what fails first does not take the rest.

    json_file: name of a file, a stream, or None; out: the folder that was written, or None.
    """
    if out:
        error_handling.remember(f"{out} is written")
    try:
        if hasattr(json_file, "write"):  # in ASCII: the same on every terminal, and nothing in it steers one
            error_handling.say(json.dumps(json.loads(folders.to_json(document)), indent=1).replace("\x7f", "\\u007f"), json_file)
        elif json_file:
            folders.write_json(json_file, document)
            error_handling.remember(f"{json_file} is written")
    finally:
        words = text + (f"\n\nwritten to {out}" if out else "")
        if words and not quiet:
            error_handling.say(words)
