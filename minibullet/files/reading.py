"""Files that a user names, read with bounds: a regular file, no larger than its reader can use, or one line of complaint."""

import stat
from pathlib import Path

from minibullet.errors import InputError, shown, shown_value

WORKBOOKS = {b"PK\x03\x04": "an Excel workbook or a zip archive", b"\xd0\xcf\x11\xe0": "an old Excel workbook"}


def path_of(path, name):
    """The Path that somebody gave; InputError where it can be none. name: what messages call the file."""
    try:
        return Path(path)
    except TypeError:
        raise InputError(f"{name}: {shown_value(path)} is no path; give its name as text") from None


def read_bytes(path, name, most_bytes, remedy):
    """The bytes of a regular file.

    path: the file; name: what messages call it; most_bytes: the most that is read; remedy: what to do where it is larger.
    Raises InputError where it cannot be read, is no regular file (a folder, a device, a pipe), or is larger.
    """
    try:
        path = Path(path)
        found = path.stat()
        if stat.S_ISDIR(found.st_mode):
            raise InputError(f"{name}: is a folder; give a file")
        if not stat.S_ISREG(found.st_mode):  # a device never ends, a pipe may never begin
            raise InputError(f"{name}: is not a regular file (a device, a pipe or a socket); copy its content into a file")
        data, size = b"", found.st_size
        if size <= most_bytes:
            with open(path, "rb") as file:
                data = file.read(size + 1)  # Python sets aside at once what it is asked to read
                while len(data) <= most_bytes and (more := file.read(min(1 << 20, most_bytes + 1 - len(data)))):
                    data += more  # it grew while it was read
            size = len(data)
    except OSError as error:
        raise InputError(f"{name}: cannot be read ({error.strerror or error}); looked for {shown(path, 255)}") from None
    except InputError:  # which is a ValueError too
        raise
    except ValueError as error:  # a name that no system can have, as one with a zero byte
        raise InputError(f"{name}: cannot be read ({error})") from None
    if size > most_bytes:
        raise InputError(f"{name}: {size / 1e6:.3g} MB; at most {most_bytes / 1e6:.3g} MB are read: {remedy}")
    return data


def no_workbook(data, name):
    """Refuse the bytes of a workbook, which may have the name of a table; name: what messages call it."""
    for mark, what in WORKBOOKS.items():
        if data.startswith(mark):
            raise InputError(f"{name}: is {what}, not text; export it as CSV, or save it as CSV from the spreadsheet")


def read_text(path, name, most_bytes, remedy):
    """The UTF-8 text of a regular file, without the mark that some editors put before it; InputError as `read_bytes`."""
    data = read_bytes(path, name, most_bytes, remedy)
    no_workbook(data, name)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{name}: is not text in UTF-8; save it as UTF-8 text") from None
    if "\0" in text:
        line = text[: text.index("\0")].count("\n") + 1
        raise InputError(f"{name}, line {line}: a zero byte (NUL), which no text has; save it as UTF-8 text, not as UTF-16")
    return text
