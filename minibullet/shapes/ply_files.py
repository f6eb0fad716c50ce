"""The triangles of a PLY file, of text or of bytes: a header says what follows. G. Turk, The PLY Polygon File Format (1994)."""

from io import BytesIO
from typing import NamedTuple

import numpy as np

from minibullet.errors import InputError
from minibullet.shapes import mesh_text
from minibullet.shapes.mesh_text import Indexed, integer, lines, quoted, refuse_many

# Elements of a file, and properties of one: a scanner writes ten or so to a vertex, and each costs a step for every face.
MOST_PROPERTIES = 30
ORDERS = {"ascii": None, "binary_little_endian": "<", "binary_big_endian": ">"}
TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "float": "f4",
    "double": "f8",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "float32": "f4",
    "float64": "f8",
}
CORNERS = ("vertex_indices", "vertex_index")


class _Property(NamedTuple):
    name: str
    kind: np.dtype
    length: np.dtype | None  # kind of the number before a list; None where there is one value


class _Element(NamedTuple):
    name: str
    count: int
    properties: list
    place: str  # where the header announces it, for messages


def read_ply(data, name):
    """The Surface of the elements `vertex` and `face`; others before them are passed over, others behind not looked at."""
    text = BytesIO(data)
    line, order, elements = _header(text, name)
    mesh, at, following = Indexed(name, 0, "face" if order else "line"), text.tell(), lines(text, name, line)
    most = {"vertex": mesh_text.MOST_VERTICES, "face": mesh_text.MOST_TRIANGLES}
    for element in elements:
        # Each property takes so many bytes at least, in a text a digit and a blank.
        least = sum((part.length or part.kind).itemsize if order else 2 for part in element.properties)
        if element.count * max(least, 1) > len(data) - at + 1:
            raise _cut_off(name, element, len(data))
        refuse_many(element.count, name, most.pop(element.name, mesh_text.MOST_LINES), f"of {quoted([element.name])}")
        _check_properties(name, element)
        at = _binary_element(mesh, element, data, at) if order else _text_element(mesh, element, following, at, len(data))
        if not most:
            break
    return mesh.surface()


def _cut_off(name, element, size):
    return InputError(f"{name}, {element.place}, the file has {size} bytes; it was cut off")


def _header(text, name):
    """(number of its last line, order of the bytes or None in a text, list of _Element)."""
    line, order, elements, following = 0, "", [], lines(text, name)
    if next(following, (0, []))[1] == ["ply"]:
        for line, words in following:
            if words == ["end_header"] and order != "":
                return line, order, elements
            place = f"line {line}: {quoted(words)}"
            if words[0] == "format" and words[1:2] and words[1] in ORDERS:
                order = ORDERS[words[1]]
            elif words[0] == "element" and len(words) == 3 and words[2].isascii() and words[2].isdigit():
                refuse_many(len(elements) + 1, name, MOST_PROPERTIES, "elements")
                elements.append(_Element(words[1], integer(words[2]), [], place))
            elif words[0] == "property" and elements and order != "":
                refuse_many(len(elements[-1].properties) + 1, name, MOST_PROPERTIES, "properties")
                elements[-1].properties.append(_property(words, order or "=", f"{name}, {place}"))
            elif words[0] not in ("comment", "obj_info"):
                raise InputError(f"{name}, {place} is not readable in the header of a PLY file")
    raise InputError(f"{name}: no PLY header; the file must begin with 'ply' and have the lines 'format ...' and 'end_header'")


def _property(words, order, where):
    """`property KIND NAME` or `property list KIND KIND NAME`."""
    listed = words[1:2] == ["list"]
    kinds = words[1 + listed : -1]
    if len(kinds) == 1 + listed and set(kinds) <= set(TYPES):
        *length, kind = (np.dtype(TYPES[kind]).newbyteorder(order) for kind in kinds)
        if not (length and "f" in length[0].kind + kind.kind * (words[-1] in CORNERS)):
            return _Property(words[-1], kind, length[0] if length else None)
    raise InputError(f"{where} is not readable in the header of a PLY file")


def _check_properties(name, element):
    """Refuse an element that the readers below cannot walk."""
    lists = [part.name for part in element.properties if part.length is not None]
    if element.name == "face" and len(set(lists) & set(CORNERS)) != 1:
        raise InputError(f"{name}, {element.place}: a face needs one 'property list ... vertex_indices'")
    if element.name != "face" and lists:
        raise InputError(f"{name}, {element.place}: lists are read of faces only; export vertices and faces alone")
    if element.name == "vertex" and not {"x", "y", "z"} <= {part.name for part in element.properties}:
        raise InputError(f"{name}, {element.place}: a vertex needs the properties x, y and z")


def _text_element(mesh, element, following, at, size):
    """Read an element of a text from the following lines, one each; -> at, the first byte behind the header."""
    names = [part.name for part in element.properties]
    for _ in range(element.count):
        line, words = next(following, (0, None))
        if words is None:
            raise _cut_off(mesh.name, element, size)
        if element.name == "vertex":
            mesh.vertex([words[k] for k in map(names.index, "xyz") if k < len(words)], line)
        elif element.name == "face":
            place = 0
            for part in element.properties:
                length = 1 if part.length is None else integer("".join(words[place : place + 1]))
                place += part.length is not None
                if length is None or not 0 <= length <= len(words) - place:
                    raise InputError(
                        f"{mesh.name}, line {line}: face {quoted(words)}; the number of corners must stand first, then they"
                    )
                if part.name in CORNERS:
                    mesh.face(mesh.vertex_numbers(words[place : place + length], line), line)
                place += length
    return at


def _binary_element(mesh, element, data, at):
    """Read an element of bytes from data[at]; -> the first byte behind it."""
    if element.name != "face":
        record = np.dtype([(str(k), part.kind) for k, part in enumerate(element.properties)])
        if element.name == "vertex":
            names = [part.name for part in element.properties]
            values = np.frombuffer(data, record, element.count, at)
            points = np.column_stack([values[str(names.index(axis))].astype(float) for axis in "xyz"])
            bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
            if len(bad):
                raise InputError(f"{mesh.name}: vertex {bad[0]} (from 0) = {points[bad[0]].tolist()} is not finite")
            mesh.vertices.frombytes(points.tobytes())
        return at + element.count * record.itemsize
    for face in range(element.count):
        for part in element.properties:
            length = 1
            if part.length is not None:
                (length,) = _values(data, part.length, 1, at, mesh, element)
                at += part.length.itemsize
            if part.name in CORNERS:
                mesh.face(_values(data, part.kind, length, at, mesh, element), face)
            at += length * part.kind.itemsize
    return at


def _values(data, kind, count, at, mesh, element):
    if not 0 <= count * kind.itemsize <= len(data) - at:
        raise _cut_off(mesh.name, element, len(data))
    return np.frombuffer(data, kind, count, at).tolist()
