"""Files that appear whole or not at all, whatever happens while they are written."""

import errno
import os
import secrets
from contextlib import contextmanager, suppress
from pathlib import Path

from minibullet.errors import InputError, RunError
from minibullet.files.reading import path_of

# refusals that speak of the name that was given; all others (a full disk, a broken one, too many open files) are nobody's input
NAMED = {
    errno.ENOENT,
    errno.ENOTDIR,
    errno.EISDIR,
    errno.EEXIST,
    errno.EACCES,
    errno.EPERM,
    errno.EROFS,
    errno.ENAMETOOLONG,
    errno.ELOOP,
    errno.EINVAL,
    errno.ENXIO,
    errno.ENODEV,
}


@contextmanager
def whole(path):
    """A name beside `path` to write to: it becomes `path` when the block ends well, and is gone when not. Raises OSError.

    Links are followed. What is there and no regular file is refused: a rename would put a file in the place of a device.
    """
    if os.path.exists(path) and not os.path.isfile(path):
        kind = errno.EISDIR if os.path.isdir(path) else errno.EINVAL
        raise OSError(kind, "is a folder" if kind == errno.EISDIR else "is no regular file (a device, a pipe or a socket)")
    target = Path(os.path.realpath(path))
    partial = target.with_name(f".{target.name[:40]}.{secrets.token_hex(4)}.partial")
    try:
        yield partial
        with open(partial, "rb+") as file:
            os.fsync(file.fileno())  # on disk before the name points at it
        os.replace(partial, target)
    except BaseException:
        with suppress(OSError):  # what went wrong first is told
            partial.unlink(missing_ok=True)
        raise


def refused(error, what):
    """The exception for an OSError or ValueError of the system: InputError where the name is at fault, RunError where not.

    what: what could not be done, such as "cannot write 'out'".
    """
    at_fault = not isinstance(error, OSError) or error.errno in NAMED
    opened = os.name == "nt" and isinstance(error, PermissionError)  # so Windows protects a file that a program holds open
    words = f"{what}: {getattr(error, 'strerror', None) or error}" + ("; is it open in another program?" if opened else "")
    return InputError(words) if at_fault and not opened else RunError(words)


def replace_file(path, content):
    """Bytes into a file, whole or not at all; InputError or RunError where it cannot be written."""
    path = path_of(path, "world")
    try:
        with whole(path) as partial:
            partial.write_bytes(content)
    except (OSError, ValueError) as error:  # ValueError: a zero byte
        raise refused(error, f"world: cannot be saved as {str(path)!r}") from None
