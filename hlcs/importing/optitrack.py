"""CSV exports of OptiTrack Motive.

Format, from docs.optitrack.com/motive/data-export/data-export-csv (header, types of columns, blank cells where a marker was
hidden, rotation type "Quaternion" or an order of Euler angles, right-handed) and from exports of formats 1.22 to 1.25 that stand
in public tests: a row of pairs `Format Version, 1.23, Take Name, .., Capture Frame Rate, .., Length Units, ..`; an empty row;
rows with type, name, ID (and parent) of what each column belongs to; a row `Rotation` or `Position`; a row
`Frame, Time (Seconds), X, Y, Z, W, X, Y, Z, ..`; then the frames. Motive's y points up if it was not told otherwise, and its
Euler angles are taken about the axes of the turned body ("relative", right-handed), both from the samples of its NatNet SDK.
"""

import re

import numpy as np

from hlcs.importing.axes import ORDERS, from_euler, turned, turned_quaternions
from hlcs.importing.found import Assumption, Found, recording
from hlcs.importing.grids import grid_of, source_of
from hlcs.importing.units import scale
from minibullet.errors import InputError, shown

NAME = "OptiTrack Motive"
USES = ("up", "length_unit", "frame_rate", "rotation_order", "only")
TYPES = ("Rigid Body", "Marker")  # whose columns are read, the first of them that a file has
LEAST = "Motive's CSV begins with 'Format Version, .., Take Name, .., Capture Frame Rate, ..'"
HEADER = 12  # rows in which `Frame, Time (Seconds)` stands
UNIT_LENGTH = 1e-3  # farther from 1 no quaternion is: Motive writes six digits


def read(path, overrides):
    """The Found of one file: a recording for each rigid body or, where there is none, for each marker.

    Raises InputError with file, row, and what was expected.
    """
    source = source_of(path)
    other = re.match(rb'(?:\xef\xbb\xbf)?"?Format Version"?([;\t])', source.data)  # saved again by a spreadsheet
    grid = grid_of(source, other[1].decode() if other else ",")
    said = _pairs(grid)
    head = _header(grid)
    kind, bodies = _bodies(grid, head)
    times, notes = _times(grid, head, said, overrides)
    unit = said.get("Length Units", "").lower()
    factor, told = scale("length", unit, overrides, "lengths", f"{grid.place(0)}: Length Units")
    notes += told
    up = overrides.up or "y"
    if overrides.up is None:
        notes.append(
            Assumption("y of the file points up: its x, y, z become x_m, z_m, -y_m, and orientations turn alike", "--up")
        )
    recordings = []
    for name in overrides.chosen(list(bodies), grid.name):
        columns = {"t_s": times} | _positions(grid, head, bodies[name], factor, up)
        orientations, told = _orientations(grid, head, bodies[name], said, overrides)
        if orientations is not None:
            columns |= dict(zip(("qw", "qx", "qy", "qz"), turned_quaternions(orientations, up).T, strict=True))
        called = grid.stem if len(bodies) == 1 else f"{grid.stem} {name}"
        found, more = recording(called, grid, grid.lines[head + 1 :], columns, "Time (Seconds)")
        recordings.append(found)
        notes += [*told, *more]
    what = "the pivot of each rigid body" if kind == "Rigid Body" else "each marker"
    notes.append(Assumption(f"{what} is the centre of mass of its body: move the pivot in Motive where it is not"))
    return Found(tuple(recordings), None, {}, (*grid.assumptions, *notes))


def _pairs(grid):
    """What the first row says: {"Length Units": "Meters", ..}."""
    cells = grid.cells[0]
    if cells[0] != "Format Version":
        raise InputError(
            f"{grid.place(0)}: begins with '{shown(cells[0])}'; {LEAST}: switch the header on in Motive's export options"
        )
    return dict(zip(cells[::2], cells[1::2], strict=False))


def _header(grid):
    """Index of the row `Frame, Time (Seconds), X, ..`."""
    for row in range(1, min(HEADER, len(grid.cells))):
        if grid.cells[row][0] == "Frame":
            if row < 4:
                break
            return row
    raise InputError(
        f"{grid.place(min(1, len(grid.cells) - 1))}: expected rows of type, name, ID, Rotation or Position below the first row, "
        "and then 'Frame, Time (Seconds), X, ..'; export again with the header"
    )


def _bodies(grid, head):
    """(type, {name: {("Position", "X"): index, ..}}) of the first of TYPES that the file has."""
    types, names, quantities, axes = grid.cells[1], grid.cells[2], grid.cells[head - 1], grid.cells[head]
    length = min(map(len, (types, names, quantities, axes)))
    for kind in TYPES:
        bodies = {}
        for index in range(2, length):
            if types[index] == kind and quantities[index] in ("Rotation", "Position"):
                own, what = bodies.setdefault(names[index], {}), (quantities[index], axes[index])
                if what in own:
                    raise InputError(
                        f"{grid.place(2)}: {kind} '{shown(names[index])}' stands twice with {' '.join(what)}; give each a name "
                        "of its own in Motive, and export again"
                    )
                own[what] = index
        if bodies:
            return kind, bodies
    there = ", ".join(dict.fromkeys(cell for cell in types if cell and cell != "Type")) or "nothing"
    raise InputError(
        f"{grid.place(1)}: columns of {shown(there, 100)}; a Rigid Body or a Marker is needed: choose them in Motive's export "
        "options"
    )


def _times(grid, head, said, overrides):
    """(times of all rows [s], assumptions)."""
    if overrides.frame_rate is not None:
        return grid.column(head + 1, 0, "Frame") / overrides.frame_rate, []
    if len(grid.cells[head]) > 1 and grid.cells[head][1].startswith("Time"):
        return grid.column(head + 1, 1, "Time (Seconds)"), []
    for key in ("Export Frame Rate", "Capture Frame Rate"):
        try:
            rate = float(said[key].replace(",", "."))
        except (KeyError, ValueError):
            continue
        if rate > 0:
            frames = grid.column(head + 1, 0, "Frame")
            return frames / rate, [
                Assumption(f"{grid.name}: time is the frame number over {rate:g} 1/s, the {key}", "--frame-rate")
            ]
    raise InputError(
        f"{grid.place(head)}: neither a column 'Time (Seconds)' nor a frame rate in row {grid.lines[0]}; state --frame-rate"
    )


def _positions(grid, head, own, factor, up):
    vectors = np.full((len(grid.cells) - head - 1, 3), np.nan)
    for axis, letter in enumerate("XYZ"):
        if ("Position", letter) in own:
            vectors[:, axis] = factor * grid.column(head + 1, own["Position", letter], f"Position {letter}")
    return dict(zip(("x_m", "y_m", "z_m"), turned(vectors, up).T, strict=True))


def _orientations(grid, head, own, said, overrides):
    """(unit quaternions (n, 4), scalar first, in the axes of the file, or None; assumptions)."""
    letters = [letter for letter in "XYZW" if ("Rotation", letter) in own]
    if not letters:
        return None, []
    values = np.column_stack([grid.column(head + 1, own["Rotation", letter], f"Rotation {letter}") for letter in letters])
    notes, kind = [], said.get("Rotation Type", "")
    if letters == list("XYZW"):
        if overrides.rotation_order:
            raise InputError(
                f"{grid.place(head)}: Rotation has X, Y, Z and W, a quaternion; --rotation-order is for Euler angles"
            )
        q = values[:, [3, 0, 1, 2]]
        length = np.linalg.norm(q, axis=1)
        wrong = np.flatnonzero(np.abs(length - 1) > UNIT_LENGTH)
        if len(wrong):
            raise InputError(
                f"{grid.place(head + 1 + wrong[0])}, columns Rotation X..W: a quaternion of length {length[wrong[0]]:.4g}, must "
                "be 1; blank if it was not tracked"
            )
        return q, notes
    if letters != list("XYZ"):
        raise InputError(
            f"{grid.place(head)}: Rotation has {', '.join(letters)}; expected X, Y, Z, W (quaternion) or X, Y, Z (Euler angles)"
        )
    order = overrides.rotation_order or kind.upper()
    if order not in ORDERS:
        raise InputError(
            f"{grid.place(0)}: Rotation Type '{shown(kind)}', and Euler angles X, Y, Z; state --rotation-order, one of "
            f"{', '.join(ORDERS)}"
        )
    notes.append(
        Assumption(
            f"Euler angles in degrees, about {order[0]}, then about the turned {order[1]} and {order[2]} of the body",
            "--rotation-order",
        )
    )
    return from_euler(values, order), notes
