"""Units that stand already, as after a storm: where they are, and which places of a layer they leave empty.

A placement test to which they are given is a repair: they are fixed where they stand, and units are added at the empty places.
"""

import hashlib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment

from hlcs.files.csv_files import CsvLayout, read_csv
from minibullet.errors import InputError, shown_value

COLUMNS = ("layer", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")
MOST_LAYER = 50  # as of a placement test
FILLS = 0.6  # spacings in plan from its place up to which a unit fills it: beyond, it is nearer to a neighbour's [-]
COVERS = 1.0  # [Dn] in plan up to which a unit of a higher layer lies over a place: it stood on the unit that is missing there


@dataclass(frozen=True, eq=False)
class StandingUnits:
    """Units that stand already.

    layer: (n,) whole numbers from 1, 0 for units that lie about and belong to no layer; poses: (n, 7) positions of the centres
    of mass [m] and orientations (w, x, y, z), world frame, in the axes of the unit; source: what messages call them.
    """

    layer: np.ndarray = field(repr=False)
    poses: np.ndarray = field(repr=False)
    source: str = "standing units"

    @classmethod
    def read(cls, path):
        """The units of a CSV with the columns COLUMNS; InputError that names file, row, column and remedy."""
        path = Path(path)
        table = read_csv(path, CsvLayout(COLUMNS, COLUMNS, others=True), f"standing '{path.name}'")
        layer = table.columns["layer"]
        for k in np.flatnonzero((layer != np.floor(layer)) | (layer < 0) | (layer > MOST_LAYER))[:1]:
            raise InputError(
                f"{table.place(k, 'layer')}: {layer[k]:g}; give the layer that the unit belongs to, 1 to {MOST_LAYER}, or 0 "
                "where it lies about"
            )
        poses = np.column_stack([table.columns[name] for name in COLUMNS[1:]])
        length = np.sqrt((poses[:, 3:] ** 2).sum(axis=1))
        for k in np.flatnonzero(np.abs(length - 1.0) > 0.01)[:1]:
            raise InputError(f"{table.place(k, 'qw')}: the quaternion has the length {length[k]:.4g}; it must be 1")
        return cls(layer.astype(int), poses, path.name)

    @classmethod
    def of(cls, result):
        """The units of a PlacementResult: those that fell out of their layer lie about."""
        layer = [np.where(inside, number, 0) for number, inside in enumerate(result.in_layer, start=1)]
        return cls(np.concatenate(layer), np.concatenate(result.poses), "placement result")

    def without(self, chosen):
        """The same structure without the units that `chosen` (n,) says."""
        keep = ~np.asarray(chosen, dtype=bool)
        return StandingUnits(self.layer[keep], self.poses[keep], self.source)

    def csv_text(self):
        """The units as the text of a CSV that reads back to the same numbers."""
        rows = (f"{layer}," + ",".join(map(repr, pose)) for layer, pose in zip(self.layer, self.poses.tolist(), strict=True))
        return "\n".join([",".join(COLUMNS), *rows, ""])

    def write(self, path):
        """Write the CSV that `read` reads."""
        from hlcs.files import folders  # here: what only writes is no part of a run, nor of the hash of its code

        folders.write_text(Path(path), self.csv_text())

    @property
    def digest(self):
        """Hash of the units, 64 hexadecimal digits."""
        return hashlib.sha256(self.csv_text().encode()).hexdigest()

    def __eq__(self, other):
        return isinstance(other, StandingUnits) and self.csv_text() == other.csv_text()

    def __hash__(self):
        return hash(self.digest)


def parse_standing(value, folder="."):
    """None for nothing, StandingUnits from the name of a CSV relative to folder, or StandingUnits as they are."""
    if isinstance(value, StandingUnits):
        return value
    if value is None or value == "":
        return None
    if isinstance(value, str) and value.strip().lower().endswith(".csv"):
        return StandingUnits.read(Path(folder) / value.strip())
    raise InputError(f"placement: standing = {shown_value(value)}; it must be a CSV of units that stand, such as damaged.csv")


def seats(aims, places, spacing):
    """Which unit fills which place: for each aim (n, 2) the number of its unit among places (m, 2), or -1 where it is empty.

    Every unit fills one place at most, together with the least sum of squared distances; spacing: the smaller one of the grid,
    of which a unit may be FILLS away. All in one unit of length.
    """
    found = np.full(len(aims), -1)
    if len(places):
        apart = ((aims[:, None] - places[None]) ** 2).sum(axis=2)
        far = (FILLS * spacing) ** 2
        # a unit too far from a place is as good as none: beyond the limit all distances cost the same
        rows, columns = linear_sum_assignment(np.minimum(apart, far))
        near = apart[rows, columns] < far
        found[rows[near]] = columns[near]
    return found


def covered(aims, above, nominal_diameter):
    """Which places (n, 2) lie under a unit of a higher layer at above (m, 2), boolean (n,): nothing can be lowered into them."""
    if not len(above):
        return np.zeros(len(aims), dtype=bool)
    apart = ((aims[:, None] - above[None]) ** 2).sum(axis=2).min(axis=1)
    return apart < (COVERS * nominal_diameter) ** 2
