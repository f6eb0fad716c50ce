"""What the readers of mesh files have in common: their limits, lines of text, and faces that number their vertices.

A file is believed only after its sizes, indices and numbers are checked; every refusal is an InputError that names
file, line, value and remedy.
"""

from array import array
from math import isfinite
from typing import NamedTuple

import numpy as np

from minibullet.errors import InputError, shown

# A rigid body is made of few faces; a file beyond these sizes is a mistake, and would take longer than a user waits.
MOST_TRIANGLES = 100_000
MOST_VERTICES = 3 * MOST_TRIANGLES  # no two triangles need share a corner
MOST_LINES = 20 * MOST_TRIANGLES  # an ASCII STL has 7 to a triangle; OBJ as many with normals, textures and blanks
MOST_LINE = 24 * MOST_TRIANGLES  # bytes: one face of so many corners, each vertex/texture/normal


class Surface(NamedTuple):
    """Triangles as they stand in a file."""

    corners: np.ndarray  # (t, 3, 3) m: triangle, corner, coordinate
    group: np.ndarray  # (t,) which named part of the file a triangle belongs to


def refuse_many(count, name, most, what):
    """Refuse a count that would cost too much, before anything is made of it."""
    if count > most:
        raise InputError(f"{name}: {str(count)[:20]} {what} or more, at most {most} are read; simplify the mesh")


def lines(text, name, before=0):
    """(line number, words) of every line of a BytesIO that says something, from where it stands; a backslash joins lines.

    before: number of the last line read already.
    """
    words = []
    for number, line in enumerate(text, before + 1):
        if len(line) > MOST_LINE or len(words) > MOST_TRIANGLES:
            raise InputError(f"{name}, line {number}: longer than {MOST_LINE} bytes; this is no mesh file")
        if number > MOST_LINES:
            refuse_many(number, name, MOST_LINES, "lines")
        if b"#" in line:
            line = line.split(b"#", 1)[0]
        # No face may have so many corners: what follows need not be cut into words.
        more = line.decode("latin-1").split(None, MOST_TRIANGLES + 3)
        if more and more[-1][-1] == "\\":
            more[-1] = more[-1][:-1]
            words += more if more[-1] else more[:-1]
        elif words:
            yield number, words + more
            words = []
        elif more:
            yield number, more
    if words:
        yield number, words


def quoted(words):
    """Words of a file as a message quotes them."""
    return f"'{shown(' '.join(word[:60] for word in words[:9]))}'"


def integer(word):
    """The whole number that a word is, or None; beyond forty digits only that it is large is kept."""
    try:
        return int(word[:40])
    except ValueError:
        return None


class Indexed:
    """Vertices and the faces that number them, as they are read; a face becomes a fan of triangles."""

    def __init__(self, name, first, unit="line"):
        self.name, self.unit = name, unit  # unit: what the places count, in messages
        self.first = first  # number of the first vertex, as the file counts
        self.vertices, self.triangles = array("d"), array("q")
        self.group, self.places = array("q"), array("q")  # of each triangle

    @property
    def defined(self):
        """How many vertices have been read."""
        return len(self.vertices) // 3

    def vertex(self, words, line):
        """One more vertex; InputError unless these words are three finite numbers."""
        try:
            x, y, z = map(float, words)
        except ValueError:
            raise InputError(f"{self.name}, line {line}: vertex {quoted(words)}; 3 numbers are needed") from None
        if not (isfinite(x) and isfinite(y) and isfinite(z)):
            raise InputError(f"{self.name}, line {line}: vertex {quoted(words)} is not finite")
        self.vertices.extend((x, y, z))
        if len(self.vertices) > 3 * MOST_VERTICES:
            refuse_many(self.defined, self.name, MOST_VERTICES, "vertices")

    def vertex_numbers(self, words, place):
        """The whole numbers of a face's corners such as 3, 3/1, 3//2 or -1; InputError where a word is none."""
        try:
            return [int(word.partition("/")[0]) for word in words]
        except ValueError:  # letters, or thousands of digits
            bad = next(word for word in words if integer(word.partition("/")[0]) is None or len(word) > 40)
            raise InputError(f"{self.name}, {self.unit} {place}: face corner {quoted([bad])} is no vertex number") from None

    def face(self, loop, place, group=0, numbers=None):
        """One more face; loop: indices of its corners from 0; numbers: the same as the file writes them, for messages."""
        if len(loop) < 3:
            raise InputError(f"{self.name}, {self.unit} {place}: face with {len(loop)} vertices; a face needs 3 or more")
        if min(loop) < 0 or max(loop) >= 2**62:
            self.refuse(next(n for n, k in zip(numbers or loop, loop, strict=True) if not 0 <= k < 2**62), place)
        if len(self.group) + len(loop) - 2 > MOST_TRIANGLES:
            refuse_many(len(self.group) + len(loop) - 2, self.name, MOST_TRIANGLES, "triangles")
        for k in range(1, len(loop) - 1):
            self.triangles.extend((loop[0], loop[k], loop[k + 1]))
            self.group.append(group)
            self.places.append(place)

    def refuse(self, number, place):
        """Refuse a face that uses a vertex which is not there."""
        counted = "" if self.first else " (from 0)"
        raise InputError(
            f"{self.name}, {self.unit} {place}: face uses vertex {str(number)[:40]}{counted}, "
            f"but only {self.defined} vertices are defined"
        )

    def surface(self):
        """All faces as a Surface, after the check that their vertices are there."""
        vertices, triangles = np.array(self.vertices).reshape(-1, 3), np.array(self.triangles, dtype=np.int64).reshape(-1, 3)
        outside = np.flatnonzero((triangles >= len(vertices)).any(axis=1))
        if len(outside):
            self.refuse(triangles[outside[0]].max() + self.first, self.places[outside[0]])
        return Surface(vertices[triangles] if len(triangles) else np.zeros((0, 3, 3)), np.array(self.group, dtype=int))
