"""Results on disk: a folder or file appears whole or not at all; JSON and TOML that other programs can read.

Everything is first written under a temporary name beside its target and then renamed, so a run killed at any moment leaves
the old result, nothing, or the whole new one. No pickle anywhere.
"""

import hashlib
import os
import re
import secrets
import shutil
import stat
import tempfile
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path, PurePosixPath

from hlcs.files.documents import to_json, to_toml
from hlcs.processes import interrupts
from minibullet.errors import InputError, RunError
from minibullet.files import reading
from minibullet.files.reading import read_text
from minibullet.files.writing import refused, whole

# in every result folder: hash, size and name of each file this program wrote, so that a later run replaces those and no others
CONTENTS = ".hlcs"
RESULT = r'\s*\{\s*"format"\s*:\s*\d'  # how the JSON of this program begins, whoever set its spaces
LONGEST_MARK = 200  # bytes at the head of a file that tell who wrote it
MOST_LISTED = 1_000_000  # bytes of that list; a line takes about a hundred


@contextmanager
def result_folder(path):
    """Context manager: yields a `Path` to an empty temporary folder that becomes `path` when the block ends well.

    An earlier result at `path` is replaced where every file in it is as it was written; a folder that holds anything else is
    refused (InputError) before any work is done, as are a file in the way and a place where nothing can be written. If the
    block raises or is interrupted, `path` is left as it was. Where `path` cannot be replaced at the end, the result is kept
    beside it or in the temporary folder, and the error says where. A link to a folder stays; the folder is replaced.
    """
    target = _real(path)
    if Path(os.path.realpath(os.curdir)).is_relative_to(target):  # who stands in it would be left in one that is gone
        raise InputError(f"folder '{target}' is the current folder, or holds it, and would be replaced; name a new one")
    _refuse_foreign(target)
    partial = _hidden(target.parent, target.name)
    try:
        with _explained(target):
            target.parent.mkdir(parents=True, exist_ok=True)
            _clear_up(target.parent, target.name)
            partial.mkdir()
        yield partial
        interrupts.check()
        try:
            with _explained(target):
                _list_contents(partial)
                _put_in_place(partial, target)
        except (InputError, RunError) as problem:
            if (place := _elsewhere(partial, target)) is None:
                texts = [path.read_text(encoding="utf-8") for path in sorted(partial.glob("*.json"))]
                raise RunError(f"{problem}; the result is printed", "".join(texts)) from None
            raise type(problem)(f"{problem}; the result is in '{place}'") from None
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def path_of(path):
    """The Path of a file or folder that somebody names, ~ for his own folder; InputError where it can be none."""
    try:
        return reading.path_of(path, "file or folder").expanduser()
    except RuntimeError as problem:  # ~ of nobody
        raise InputError(f"'{path}': {problem}") from None


def check_folder(path):
    """InputError where no folder can be: a file in its place, or a link to nothing; returns the folder's Path."""
    target = _real(path)
    with _explained(target):
        if target.exists() and not target.is_dir():
            raise InputError(f"'{target}' is a file, not a folder; give another folder for the results")
    return path_of(path)


def check_file(path, begins=RESULT, form="JSON"):
    """InputError where a file of somebody else stands at a path, or a folder or device, or no folder can hold it.

    begins: regular expression with which a file begins that this program wrote; form: what that is. An empty file is nobody's.
    """
    path = path_of(path)
    check_folder(path.parent)
    with _explained(path):
        if not path.exists():
            return
        if not path.is_file():
            what = "folder" if path.is_dir() else "device, a pipe or a socket"
            raise InputError(f"'{path}' is a {what}; give the name of a file")
        with open(path, "rb") as file:
            head = file.read(LONGEST_MARK)
    if head and not re.match(begins.encode(), head):
        raise InputError(f"'{path}' is there already and was not written by this program as {form}; give another name")


def save_files(folder, found):
    """Write `found`, a dictionary {name: bytes}, into a folder that may hold other files; made where it is not there.

    All of them or none. Earlier files of this program are replaced; where a file of the same name is not as this program wrote
    it, nothing is touched and all goes elsewhere, see `keep`. Returns the folder's Path.
    """
    target = check_folder(folder)
    document = next((text.decode() for name, text in found.items() if name.endswith(".json")), None)
    keep(lambda place: _add(place, found), target, document)
    return target


def keep(write, folder, document=None):
    """write(folder); where that is refused, once more into a new folder under the temporary one.

    Raises the InputError or RunError of the first try with the place where everything is; where not even that can be written
    and a document (JSON text) is given, a RunError that carries it.
    """
    try:
        with _explained(folder):
            write(folder)
    except (InputError, RunError) as problem:
        spare = None
        try:
            spare = Path(tempfile.mkdtemp(prefix="hlcs-"))
            write(spare)
            _list_contents(spare)
        except (InputError, RunError, OSError):
            if spare is not None:
                shutil.rmtree(spare, ignore_errors=True)
            if document is None:
                raise problem from None
            raise RunError(f"{problem}; the result is printed", document) from None
        raise type(problem)(f"{problem}; the result is in '{spare}'") from None


def write_bytes(path, data):
    """Write a file whole or not at all; `data` is bytes. Raises InputError or RunError where it cannot be written."""
    target = path_of(path).absolute()
    with _explained(target):
        target.parent.mkdir(parents=True, exist_ok=True)
        with whole(target) as partial:
            partial.write_bytes(data)


def write_text(path, text):
    """Write UTF-8 text whole or not at all, with the line ends it has."""
    write_bytes(path, text.encode("utf-8"))


def write_json(path, value):
    """Write `value` as strict JSON, see `to_json`; where `path` refuses it or holds something else, it is kept elsewhere.

    See `check_file` and `keep`.
    """
    target, text = path_of(path).absolute(), to_json(value)

    def write(folder):
        check_file(folder / target.name)
        write_text(folder / target.name, text)

    keep(write, target.parent, text)


def write_toml(path, table):
    """Write the nested dictionary `table` as TOML, see `to_toml`."""
    write_text(path, to_toml(table))


# ------------------------------------------------------------------------------------------------------------- folders
def _add(place, found):
    """Files into a folder beside what it holds: first written in a folder of their own, then renamed one by one, or all back."""
    place.mkdir(parents=True, exist_ok=True)
    _clear_up(place, "")
    stage, listed, old = _hidden(place, ""), _listed(place), {}
    for name in filter(lambda name: os.path.lexists(place / name), found):
        if not _as_written(place / name, listed.get(name, ())):
            raise InputError(f"folder '{place}' holds '{name}', which is not as this program wrote it; give another one")
        old[name] = (place / name).read_bytes()
        listed[name] = {mark(old[name])}
    for name, content in found.items():  # old and new: a run killed between two renames must know its own again
        listed[name] = listed.get(name, set()) | {mark(content)}
    try:
        stage.mkdir()
        for name, content in old.items():
            write_bytes(stage / "old" / name, content)
        for name, content in {CONTENTS: _list_text(listed).encode(), **found}.items():
            write_bytes(stage / name, content)
        with ExitStack() as undo:
            for name in (CONTENTS, *found):
                os.replace(stage / name, place / name)
                if name in old:
                    undo.callback(os.replace, stage / "old" / name, place / name)
                elif name != CONTENTS:  # which names the old ones too
                    undo.callback((place / name).unlink, missing_ok=True)
            undo.pop_all()
    finally:
        shutil.rmtree(stage, ignore_errors=True)


def _hidden(folder, name):
    """A new hidden name in a folder, which tells whose it is and what it is to be called, see `_clear_up`."""
    return folder / f".{name}.{os.getpid()}.{secrets.token_hex(4)}.partial"


def _real(path):
    """The folder itself where `path` is a link to one; InputError where it is a link to nothing."""
    target = path_of(path).absolute()
    with _explained(target):
        if target.is_symlink() and not target.exists():
            raise InputError(f"'{target}' is a link to '{os.readlink(target)}', which is not there; make that folder first")
        return target.resolve()


def _refuse_foreign(target):
    """InputError if `target` is a file or a folder that holds what this program did not write, or not so."""
    with _explained(target):
        if not target.exists():
            return
        if not target.is_dir():
            raise InputError(f"'{target}' is a file, not a folder; give another folder for the results")
        foreign = _foreign(target)
    if foreign:
        raise InputError(
            f"folder '{target}' holds '{foreign}', which is no earlier result as this program wrote it; give an empty or a new "
            "folder for the results, or move that away"
        )


def _list_contents(folder):
    """Write the list of a folder's files, with their marks."""
    paths = (path for path in folder.rglob("*") if path.is_file())
    write_text(folder / CONTENTS, _list_text({path.relative_to(folder).as_posix(): {mark(path.read_bytes())} for path in paths}))


def mark(content):
    """Size and hash of a file: what tells whether it is still as it was written."""
    return len(content), hashlib.sha256(content).hexdigest()


def _list_text(listed):
    lines = [f"{mark} {size} {name}\n" for name in sorted(listed) if name != CONTENTS for size, mark in sorted(listed[name])]
    return "".join(lines)


def _listed(folder):
    """{name: marks} of the list in a folder; nothing where there is none, or one that this program did not write.

    A name has two marks while it is being replaced.
    """
    found = {}
    try:
        for line in read_text(folder / CONTENTS, CONTENTS, MOST_LISTED, "").splitlines():
            mark, size, name = line.split(" ", 2)
            found.setdefault(name, set()).add((int(size), mark))
    except ValueError:  # an InputError among them
        return {}
    return found


def _as_written(path, marks):
    """Whether a file is one whose mark was listed."""
    found = path.lstat()
    return stat.S_ISREG(found.st_mode) and any(size == found.st_size for size, _ in marks) and mark(path.read_bytes()) in marks


def _foreign(folder):
    """The name of something in a folder that this program did not write, or not so; None where all is its own."""
    listed = _listed(folder)
    inside = {parent.as_posix() for name in listed for parent in PurePosixPath(name).parents}
    for place, folders, names in os.walk(folder, onerror=_fail):
        for name in sorted(folders + names):
            path = Path(place, name)
            known = path.relative_to(folder).as_posix()
            if path.is_dir() and not path.is_symlink():
                own = known in inside
            else:
                own = (known == CONTENTS and bool(listed) and not path.is_symlink()) or _as_written(path, listed.get(known, ()))
            if not own:
                return known
    return None


def _fail(error):
    raise error


def _remove(folder):
    """Remove the files of an earlier result, one by one: what somebody adds meanwhile stays, and so does its folder."""
    for name in [*_listed(folder), CONTENTS]:
        (folder / name).unlink(missing_ok=True)
    for place, _, _ in os.walk(folder, topdown=False):
        os.rmdir(place)


def _clear_up(folder, name):
    """Settle what runs that were killed (kill -9, power) left in a folder, see `_hidden`; their process is no more.

    Half a new result is removed; an old one that had stepped aside comes back, or goes where a new one has taken its place.
    """
    target = folder / name
    for entry in folder.iterdir():
        words = entry.name.removeprefix(f".{name}.").split(".")
        if not entry.name.startswith(f".{name}.") or len(words) != 3 or not words[0].isdecimal() or runs(int(words[0])):
            continue
        if words[2] == "partial" and entry.is_dir():
            shutil.rmtree(entry, ignore_errors=True)
        elif words[2] == "old" and entry.is_dir() and not target.exists():
            os.rename(entry, target)
            _refuse_foreign(target)
        elif words[2] == "old" and entry.is_dir() and not _foreign(entry):
            _remove(entry)


def runs(process):
    """Whether a process of that number runs on this computer; where it cannot be asked without harm (Windows), True."""
    if os.name != "posix":
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True  # somebody else's, or no number of a process
    return True


def _put_in_place(partial, target):
    """Rename `partial` to `target`, an earlier result stepping aside first and coming back if that fails.

    Aside, where no other program finds it, it is looked at once more:
    minutes have gone by, and somebody may have put his own file there.
    """
    if not target.exists():
        os.rename(partial, target)
        return
    aside = target.with_name(partial.name.removesuffix("partial") + "old")
    os.rename(target, aside)
    try:
        _refuse_foreign(aside)
        os.rename(partial, target)
    except BaseException:
        with suppress(OSError):  # a new one has come meanwhile
            os.rename(aside, target)
        raise
    with suppress(OSError):
        _remove(aside)


def _elsewhere(partial, target):
    """Keep a finished folder beside `target`, or failing that under the temporary folder; returns where, None if nowhere."""
    for number in range(2, 100):
        beside = target.with_name(f"{target.name}-{number}")
        if not os.path.lexists(beside):
            with suppress(OSError):
                os.rename(partial, beside)
                return beside
            break
    with suppress(OSError):
        return shutil.copytree(partial, tempfile.mkdtemp(prefix="hlcs-"), dirs_exist_ok=True)


@contextmanager
def _explained(target):
    """Turn the operating system's refusal to write `target` into one line, under the name that it is to have in the end."""
    try:
        yield
    except (InputError, RunError):
        raise
    except (OSError, ValueError) as error:  # ValueError: a name that no system can have, as one with a zero byte
        names = (part[1:].rsplit(".", 3)[0] if part.endswith(".partial") else part for part in Path(target).parts)
        raise refused(error, f"cannot write '{Path(*names)}'") from error
