"""Arrays of an npz file that somebody may have changed: each as its table says, or one line that names it.

NumPy believes what a file claims of itself: it sets 7 TiB aside because a header says so, and unpacks whatever a small file
unpacks to. Here a claim is compared with the table and with the bytes that are there before anything is set aside.
"""

import io
import tokenize
import zipfile
import zlib

import numpy as np

from minibullet.errors import InputError
from minibullet.files.reading import read_bytes

HEADER = 10_000  # most characters of an array's header: NumPy's own limit [-]
BROKEN = (zipfile.BadZipFile, zlib.error, EOFError, OSError, ValueError, NotImplementedError, RuntimeError, SyntaxError,
          tokenize.TokenError, RecursionError, TypeError, KeyError, OverflowError, MemoryError)  # fmt: skip


class ArrayFile:
    """An npz file held in memory.

    path: the file; name: what messages call it; most_bytes: the largest file; remedy: what to do where it cannot be used;
    packed: whether its arrays may be packed, they then unpack to ``most_bytes`` at most. Raises InputError.
    """

    def __init__(self, path, name, most_bytes, remedy, packed=False):
        self.name, self.remedy, self.sizes = name, remedy, {}
        data = read_bytes(path, name, most_bytes, remedy)
        self._left = most_bytes if packed else len(data)
        try:
            self._zip = zipfile.ZipFile(io.BytesIO(data))
            members = self._zip.infolist()
        except BROKEN as error:
            self.fail(f"not a whole npz file ({_line(error)})")
        self._names = {member.filename for member in members}
        if len(self._names) < len(members):
            self.fail("two of its arrays have one name")
        if any(member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) for member in members):
            self.fail("an array is packed in a way that NumPy does not use")

    def fail(self, what):
        """InputError about this file."""
        raise InputError(f"{self.name}: {what}; {self.remedy}") from None

    def __contains__(self, key):
        return f"{key}.npy" in self._names

    def take(self, key, kind, shape):
        """The array ``key``, a copy of its own. kind: float, int or str; shape: its lengths, each a number, or a word for a
        length that all arrays with that word share (``sizes`` holds them once known)."""
        if key not in self:
            self.fail(f"{key} is missing")
        try:
            with self._zip.open(f"{key}.npy") as member:
                claimed, in_columns, dtype = _header(member)
                wanted = tuple(self.sizes.get(length, length) for length in shape)
                fits = len(claimed) == len(wanted) and all(
                    length >= 0 and (isinstance(want, str) or length == want)
                    for length, want in zip(claimed, wanted, strict=True)
                )
                if dtype.kind != {float: "f", int: "i", str: "U"}[kind] or (kind is not str and dtype.itemsize != 8) or not fits:
                    text = ", ".join(map(str, wanted)) + ("," if len(wanted) == 1 else "")
                    self.fail(f"{key} is {dtype} {claimed}; it must be {kind.__name__} ({text})")
                count = 1
                for length in claimed:  # whole numbers of any size: their product cannot overflow
                    count *= length
                if count * dtype.itemsize > self._left:
                    self.fail(f"{key} claims {count * dtype.itemsize:.3g} bytes; there is room for {self._left:.3g}")
                content = member.read(count * dtype.itemsize + 1)
                if len(content) != count * dtype.itemsize:
                    self.fail(f"{key} claims {claimed}, which its {len(content)} bytes are not")
                array = np.ndarray(claimed, dtype, content, order="F" if in_columns else "C")
        except InputError:
            raise
        except BROKEN as error:
            self.fail(f"{key} cannot be read ({_line(error)})")
        self._left -= len(content)
        self.sizes.update((word, length) for word, length in zip(shape, claimed, strict=True) if isinstance(word, str))
        return array.astype(dtype.newbyteorder("="), order="C", copy=True)


def _header(member):
    """Shape, whether stored by columns, and dtype of the array that a file begins with."""
    if np.lib.format.read_magic(member) != (1, 0):  # later versions have headers of up to 4 GB, which no plain array needs
        raise ValueError("its npy format is not 1.0")
    return np.lib.format.read_array_header_1_0(member, max_header_size=HEADER)


def _line(error):
    """What an error says, on one line."""
    return " ".join((str(error) or type(error).__name__).split())[:200]
