"""Sea bottoms: flat, sloped, a mound, or surveyed; rigid and fixed.

Every bottom has height(x, y) [m] and normal(x, y) (unit, upwards) for numbers or arrays, and
add_to(world, friction=None, restitution=None), which returns the handles of the fixed bodies.
`parse_bottom` makes one from the words of the command line.
"""

from dataclasses import dataclass, field
from functools import cached_property
from math import isfinite
from pathlib import Path

import numpy as np

from hlcs.files.csv_files import CsvLayout, decimal, read_csv
from hlcs.placement.scattered_points import gridded
from minibullet.errors import InputError, if_alike
from minibullet.shapes.primitives import ConvexPiece

COLUMNS = ("x_m", "y_m", "z_m")
MOST_POINTS = 20_000  # two fixed prisms for each point


@dataclass(frozen=True)
class Flat:
    """The horizontal plane z = 0."""

    def height(self, x, y):
        return np.zeros(np.broadcast_shapes(np.shape(x), np.shape(y)))

    def normal(self, x, y):
        return np.broadcast_to([0.0, 0.0, 1.0], (*self.height(x, y).shape, 3))

    def add_to(self, world, friction=None, restitution=None):
        return [world.add_plane((0.0, 0.0, 1.0), 0.0, friction=friction, restitution=restitution)]


@dataclass(frozen=True)
class Slope:
    """The plane z = grade * y through the origin: it rises along +y, the wave direction of the paper (section 3.1)."""

    grade: float

    def __post_init__(self):
        if isinstance(self.grade, str | bool) or not isfinite(self.grade) or abs(self.grade) > 1.0:
            raise InputError(f"bottom: slope = {self.grade!r}; must be a rise over run between -1 and 1, such as 0.04")

    def height(self, x, y):
        return self.grade * (np.asarray(y, dtype=float) + np.zeros_like(x, dtype=float))

    def normal(self, x, y):
        normal = np.array([0.0, -self.grade, 1.0]) / np.sqrt(1.0 + self.grade * self.grade)
        return np.broadcast_to(normal, (*self.height(x, y).shape, 3))

    def add_to(self, world, friction=None, restitution=None):
        return [world.add_plane((0.0, -self.grade, 1.0), 0.0, friction=friction, restitution=restitution)]


@dataclass(frozen=True)
class Survey:
    """A surveyed bed: heights z (rows, columns) over the grid y (rows,), x (columns,) [m], x and y increasing.

    Each cell of the grid is two triangles, parted by the diagonal from (low x, low y) to (high x, high y). Under each
    triangle stands a fixed prism. The middle of the rectangle is put at x = y = 0, heights stay as surveyed.

    covered: (rows - 1, columns - 1), the cells that the survey covers, None: all; nothing stands under the others, and no unit
    is placed on them. points: (n, 3) as they were surveyed, where they were scattered and the grid is interpolated from them.
    """

    x: np.ndarray = field(compare=False)
    y: np.ndarray = field(compare=False)
    z: np.ndarray = field(compare=False)
    source: str = "survey"
    covered: np.ndarray | None = field(default=None, compare=False, repr=False)
    points: np.ndarray | None = field(default=None, compare=False, repr=False)

    @classmethod
    def from_csv(cls, path):
        """Read a CSV with the columns x_m, y_m, z_m, one row a point, in any order: the points of a full rectangular grid, which
        is kept as it is, or scattered ones, see `hlcs.placement.scattered_points`."""
        path = Path(path)
        points, rows = _read_points(path)
        x, column = np.unique(points[:, 0], return_inverse=True)
        y, row = np.unique(points[:, 1], return_inverse=True)
        cell = row * len(x) + column
        order = np.argsort(cell, kind="stable")
        double = np.flatnonzero(np.diff(cell[order]) == 0)
        if len(double):
            k = order[double[0] + 1]
            raise InputError(
                f"bottom '{path.name}', row {rows[k]}: the point x_m = {points[k, 0]:g}, y_m = {points[k, 1]:g} "
                f"stands already in row {rows[order[double[0]]]}; leave one of the two out"
            )
        if min(len(x), len(y)) < 2 or len(points) != len(x) * len(y):
            grid = gridded(points, f"bottom '{path.name}'")
            return cls(grid.x, grid.y, grid.z, path.name, grid.covered, points)
        z = points[order, 2].reshape(len(y), len(x))
        return cls(x - 0.5 * (x[0] + x[-1]), y - 0.5 * (y[0] + y[-1]), z, path.name)

    def csv_text(self):
        """The bed as the text of a CSV that reads back to the same numbers."""
        points = self.points
        if points is None:
            points = ((x, y, z) for y, row in zip(self.y, self.z, strict=True) for x, z in zip(self.x, row, strict=True))
        return "\n".join([",".join(COLUMNS), *(",".join(repr(float(value)) for value in point) for point in points), ""])

    def height(self, x, y):
        """Height [m] of the bed; InputError outside the survey."""
        return self._height(*self._locate(x, y))

    def extended_height(self, x, y):
        """Height [m] of the bed; beyond the survey that of its rim, in holes that of the nearest points."""
        x, y = np.clip(x, self.x[0], self.x[-1]), np.clip(y, self.y[0], self.y[-1])
        return self._height(*self._cell(*np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))))

    @cached_property
    def misfit(self):
        """(root of the mean square, largest) of bed minus surveyed height over the surveyed points that the bed covers [m];
        zero of a full grid, NaN where it covers none."""
        if self.points is None:
            return 0.0, 0.0
        middle = 0.5 * (self.points[:, :2].min(axis=0) + self.points[:, :2].max(axis=0))
        x, y = (self.points[:, :2] - middle).T
        cell = self._cell(x, y)
        off = (self._height(*cell) - self.points[:, 2])[self.covered[cell[0]]]
        return (float(np.sqrt(np.mean(off**2))), float(np.abs(off).max())) if len(off) else (np.nan, np.nan)

    def _height(self, cell, place, upper):
        (row, column), (s, t) = cell, place
        z00, z11 = self.z[row, column], self.z[row + 1, column + 1]
        z01, z10 = self.z[row, column + 1], self.z[row + 1, column]
        # Over the diagonal (t > s) the height follows the corners 00, 10, 11; under it 00, 01, 11.
        return np.where(upper, z00 + t * (z10 - z00) + s * (z11 - z10), z00 + s * (z01 - z00) + t * (z11 - z01))

    def normal(self, x, y):
        """Upward unit normal of the triangle at (x, y); InputError outside the survey."""
        (row, column), _, upper = self._locate(x, y)
        z00, z11 = self.z[row, column], self.z[row + 1, column + 1]
        z01, z10 = self.z[row, column + 1], self.z[row + 1, column]
        along_x = np.where(upper, z11 - z10, z01 - z00) / np.diff(self.x)[column]
        along_y = np.where(upper, z10 - z00, z11 - z01) / np.diff(self.y)[row]
        normal = np.stack([-along_x, -along_y, np.ones_like(along_x)], axis=-1)
        return normal / np.linalg.norm(normal, axis=-1, keepdims=True)

    def add_to(self, world, friction=None, restitution=None):
        """Add the prisms under the triangles as fixed bodies."""
        return [
            world.add(piece, density=1.0, position=piece.centre_of_mass, fixed=True, friction=friction, restitution=restitution)
            for piece in self.prisms
        ]

    @cached_property
    def prisms(self):
        """The solid bed: a tuple of ConvexPiece, one under each triangle, in the world frame."""
        depth = self.z.min() - max(np.diff(self.x).max(), np.diff(self.y).max())
        pieces = []
        for row in range(len(self.y) - 1):
            for column in range(len(self.x) - 1) if self.covered is None else np.flatnonzero(self.covered[row]):
                corner = [
                    np.array([self.x[column + j], self.y[row + i], self.z[row + i, column + j]])
                    for i, j in ((0, 0), (0, 1), (1, 1), (1, 0))
                ]
                for triangle in ((0, 1, 2), (0, 2, 3)):
                    top = np.array([corner[k] for k in triangle])
                    pieces.append(ConvexPiece(np.concatenate([top, top * (1.0, 1.0, 0.0) + (0.0, 0.0, depth)])))
        return tuple(pieces)

    def _locate(self, x, y):
        """Cell (row, column), place (s, t) in it from 0 to 1, and whether the point is over the diagonal."""
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        outside = ~((x >= self.x[0]) & (x <= self.x[-1]) & (y >= self.y[0]) & (y <= self.y[-1]))
        if np.any(outside):
            k = np.unravel_index(np.argmax(outside), x.shape)
            raise InputError(
                f"bottom '{self.source}': the point x = {x[k]:g} m, y = {y[k]:g} m lies outside the survey, "
                f"{self.x[-1] - self.x[0]:g} m x {self.y[-1] - self.y[0]:g} m about its middle; "
                "survey a larger area or place fewer units"
            )
        cell = self._cell(x, y)
        if self.covered is not None and not np.all(found := self.covered[cell[0]]):
            k = np.unravel_index(np.argmin(found), x.shape)
            raise InputError(
                f"bottom '{self.source}': no point was surveyed near x = {x[k]:g} m, y = {y[k]:g} m (about the middle of the "
                "survey); survey there, or place fewer units"
            )
        return cell

    def _cell(self, x, y):
        """The same within the rectangle, arrays of one shape, whether the survey covers it or not."""
        column = np.clip(np.searchsorted(self.x, x, side="right") - 1, 0, len(self.x) - 2)
        row = np.clip(np.searchsorted(self.y, y, side="right") - 1, 0, len(self.y) - 2)
        s = (x - self.x[column]) / np.diff(self.x)[column]
        t = (y - self.y[row]) / np.diff(self.y)[row]
        return (row, column), (s, t), t > s


def height_above(bottom, position):
    """Height of points (.., 3) above the bottom [m]; beyond a survey
    its rim counts, so that what rolls off it is only far down."""
    x, y, z = np.moveaxis(np.asarray(position, dtype=float), -1, 0)
    return z - (bottom.extended_height(x, y) if isinstance(bottom, Survey) else bottom.height(x, y))


def mound(height, crest_width, grade, length):
    """A mound along x on level ground at z = 0, as a Survey: trapezoidal, its sides of that grade (rise over run), all in m.

    On both sides lies ground as wide as the mound's half, so that what rolls off finds a bed. InputError names a number that
    cannot be.
    """
    for name, value in (("height", height), ("crest width", crest_width), ("grade", grade), ("length", length)):
        if not (isfinite(value) and value > 0.0) or name == "grade" and value > 1.0:
            least = "above 0 and at most 1" if name == "grade" else "finite and above 0, in m"
            raise InputError(f"bottom: the {name} of the mound is {value:g}; it must be {least}")
    edge = 0.5 * crest_width
    toe = edge + height / grade
    y = np.array([-2.0 * toe, -toe, -edge, edge, toe, 2.0 * toe])
    cells = np.ceil(length / np.diff(y).max())  # as long as the widest face, so that no triangle is a needle
    if 6 * cells > MOST_POINTS:
        raise InputError(
            f"bottom: the length of the mound is {length:g}, {cells:g} times the width of its faces; take a shorter one"
        )
    x = np.linspace(-0.5 * length, 0.5 * length, int(cells) + 1)
    z = np.repeat(np.array([0.0, 0.0, height, height, 0.0, 0.0])[:, None], len(x), axis=1)
    return Survey(x, y, z, f"mound of {height:g} m")


def roughened(bottom, deviation, length, half, generator):
    """A bed like `bottom` but rough, as a Survey: at points `length` apart its height is off by a normal `deviation` [m].

    half: half the extent in x and y (2,) [m]; four lengths more are added on every side, so that what rolls off finds a bed.
    """
    x, y = (length * np.arange(-np.ceil(h / length) - 4, np.ceil(h / length) + 5) for h in half)
    z = bottom.height(*np.meshgrid(x, y)) + deviation * generator.standard_normal((len(y), len(x)))
    return Survey(x, y, z, f"{deviation:g} m rough")


def parse_bottom(text, folder="."):
    """A bottom from "flat", "slope:0.04" (or "slope:4%"), "mound:HEIGHT,CREST_WIDTH,GRADE,LENGTH" (see `mound`), or the name of a
    CSV survey, relative to folder."""
    if isinstance(text, Flat | Slope | Survey):
        return text
    text = str(text).strip()
    kind, _, value = text.partition(":")
    if text.lower() == "flat":
        return Flat()
    if kind.strip().lower() == "slope":
        percent = value.strip().endswith("%")
        try:
            grade = decimal(value.strip().removesuffix("%"))
        except ValueError:
            raise InputError(f"bottom '{text}': the slope is not a number; give a rise over run such as slope:0.04") from None
        return Slope(grade / 100.0 if percent else grade)
    if kind.strip().lower() == "mound":
        try:
            height, crest_width, grade, length = map(decimal, value.split(","))
        except ValueError:
            raise InputError(
                f"bottom '{text}': a mound has four numbers, its height, crest width, grade of the sides and length, such as "
                "mound:1.5,8,0.5,20"
            ) from None
        return mound(height, crest_width, grade, length)
    if text.lower().endswith(".csv"):
        return Survey.from_csv(Path(folder) / text)
    raise InputError(
        f"bottom '{text}': not understood; give flat, slope:0.04, mound:1.5,8,0.5,20, or a survey such as bed.csv"
        f"{if_alike(kind, ('flat', 'slope', 'mound'))}"
    )


def _read_points(path):
    """The points (n, 3) of a survey and the row each stands in, checked number by number."""
    table = read_csv(path, CsvLayout(COLUMNS, COLUMNS, others=True), f"bottom '{path.name}'", MOST_POINTS)
    if not 4 <= len(table.rows) <= MOST_POINTS:
        raise InputError(f"{table.name}: {len(table.rows)} points; a survey has 4 to {MOST_POINTS} (thin it out, or add points)")
    return np.column_stack([table.columns[name] for name in COLUMNS]), table.rows
