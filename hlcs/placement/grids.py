"""Placement grids: where the centres of the units of a layer are aimed at, in plan, in units of Dn."""

from dataclasses import dataclass, replace
from math import isfinite

import numpy as np
from scipy.spatial import ConvexHull, Delaunay, QhullError, Voronoi

from hlcs.files.csv_files import decimal
from minibullet.errors import InputError, if_alike, one_of
from minibullet.values import Value

STACKINGS = ("ABC", "ABA")
WIDEST = 10.0  # spacing of a grid: units so far apart are no layer, they never touch [Dn]


@dataclass(frozen=True)
class Grid(Value):
    """A placement grid (the paper's Fig. 3).

    spacing_x (the paper's a) along a row and spacing_y (b) from row to row, both in Dn. On a triangular grid every
    other row is shifted by half of spacing_x.

    Each layer sits over hollows of the layer below and has one row and one column less: 8 x 8 units in the first of
    five layers are 64 + 49 + 36 + 25 + 16 = 190. A rectangular grid has one hollow to a unit, amid four. A triangular
    grid has two, amid three, so there is a choice, `stacking`:
    "ABC" takes the same kind of hollow each time, so that the fourth layer is again over the first; the flank at low y
    recedes by b/3 a layer and is steep, that at high y by 2b/3. "ABA" alternates: the third layer is over the first.
    The default is ABC: the paper's Fig. 13 shows three layers whose grids do not cover each other.
    """

    name: str  # for tables and files
    spacing_x: float  # along a row [Dn]
    spacing_y: float  # from row to row [Dn]
    triangular: bool = False  # every other row is shifted by half of spacing_x
    stacking: str = "ABC"  # which hollow the next layer takes: "ABC" or "ABA"

    _units = {"spacing_x": "Dn", "spacing_y": "Dn"}

    def __post_init__(self):
        for field in ("spacing_x", "spacing_y"):
            value = getattr(self, field)
            if isinstance(value, str | bool) or not (isfinite(value) and value > 0):
                raise InputError(f"grid '{self.name}': {field} = {value!r}; must be a finite number > 0, in units of Dn")
            if value > WIDEST:
                raise InputError(
                    f"grid '{self.name}': {field} = {value:g}; at most {WIDEST:g}: spacings are in nominal "
                    "diameters Dn, not in mm"
                )
        if self.stacking not in STACKINGS:
            raise InputError(f"grid '{self.name}': stacking = {self.stacking!r}; {one_of(self.stacking, STACKINGS)}")

    @classmethod
    def parse(cls, text):
        """The grid named by "TPG", "RPG", "A,B" (rectangular) or "A,B,triangular", with A and B in Dn."""
        if isinstance(text, cls):
            return text
        named = {"TPG": TPG, "RPG": RPG}.get(str(text).strip().upper())
        if named:
            return named
        words = [word.strip() for word in str(text).split(",")]
        try:
            spacing_x, spacing_y = (decimal(word) for word in words[:2])
            triangular = {(): False, ("rectangular",): False, ("triangular",): True}[tuple(words[2:])]
        except (ValueError, KeyError):
            raise InputError(
                f"grid '{text}': not understood; give TPG, RPG, or two spacings in Dn such as 1.5,1.3 (or 1.5,1.3,triangular)"
                f"{if_alike(text, ('TPG', 'RPG'))}"
            ) from None
        return cls(",".join(words), spacing_x, spacing_y, triangular)

    def stacked(self, stacking):
        """The same grid with another stacking, "ABC" or "ABA"."""
        return replace(self, stacking=stacking)

    @property
    def packing_density(self):
        """Units per Dn^2 in plan, phi = 1/(a b) [-]."""
        return 1.0 / (self.spacing_x * self.spacing_y)

    def units(self, rows, columns, layer):
        """Number of units in a layer (numbered from 1)."""
        self._check(rows, columns, layer)
        return (rows - layer + 1) * (columns - layer + 1)

    def centres(self, rows, columns, layer, set_back=0.0, walls=False):
        """Centres of the units of a layer (numbered from 1), row by row, (n, 2) in Dn.

        rows and columns are those of the first layer, whose middle is the origin. set_back: spacings by which every layer keeps
        back from the edge of the layer below, at least; units nearer to it are left out (n may be 0). walls: between the side
        walls of a flume, half a spacing beyond the first layer (`wall_distance`), where every row has all its columns.
        """
        self._check(rows, columns, layer)
        wide = columns if walls else columns - layer + 1
        row, column = np.divmod(np.arange((rows - layer + 1) * wide), wide)
        x, y, shift = self._first_unit(layer)
        half = 0.25 if self.triangular and rows > 1 else 0.0  # half the extra width of the shifted rows
        x = (x + (row % 2) * shift) % 1.0 + column if walls else x + column + (row % 2) * shift
        y, back = y + row, (layer - 1) * set_back - 1e-9
        kept = (y >= back) & (y <= rows - 1 - back)
        if not walls:
            kept &= (x >= back) & (x <= columns - 1 + 2.0 * half - back)
        x, y = x - 0.5 * (columns - 1) - half, y - 0.5 * (rows - 1)
        return np.column_stack([self.spacing_x * x, self.spacing_y * y])[kept]

    def wall_distance(self, columns):
        """Distance of the side walls from the middle of the structure, half the clear width of the flume [Dn].

        The rows of a triangular grid are shifted by half a spacing in turn, so that `columns` units of each fit into a width of
        columns + 1/2 spacings.
        """
        return 0.5 * (columns + 0.5) * self.spacing_x

    def _first_unit(self, layer):
        """Of a layer's first unit the place (x, y), and the shift of the odd rows in x; in spacings."""
        if not self.triangular:
            return 0.5 * (layer - 1), 0.5 * (layer - 1), 0.0
        x, thirds, shift = 0.0, 0, 0.5
        for below in range(1, layer):
            if self.stacking == "ABC" or below % 2 == 1:
                # amid two units of a row and one of the next row
                x, thirds = x + 0.5, thirds + 1
            else:
                # amid one unit of a row and two of the next; the row that reaches further out has no such first hollow
                x, thirds, shift = x + (1.0 if shift > 0 else 0.0), thirds + 2, -shift
        return x, thirds / 3, shift

    def _check(self, rows, columns, layer):
        for field, value in (("rows", rows), ("columns", columns), ("layer", layer)):
            if int(value) != value or value < 1:
                raise InputError(f"grid '{self.name}': {field} = {value!r}; must be a whole number >= 1")
        if layer > min(rows, columns):
            raise InputError(
                f"grid '{self.name}': layer {layer} of {rows} rows and {columns} columns has no units; "
                f"at most {min(rows, columns)} layers, or more rows and columns"
            )


def interior_density(places):
    """Units per unit area in the inner part of a layer, by where they are in plan (n, 2): NaN where it has no inner part.

    Each inner unit has the area that is nearer to it than to any other (its Voronoi cell); a cell that reaches beyond the
    outermost units belongs to an edge unit and is left out.
    """
    try:
        cells, outline = Voronoi(places), Delaunay(places)
    except (QhullError, ValueError):  # fewer than three units, or all in one row
        return np.nan
    areas = []
    for region in (cells.regions[index] for index in cells.point_region):
        corners = cells.vertices[region]
        if region and -1 not in region and np.all(outline.find_simplex(corners, tol=1e-6) >= 0):
            areas.append(ConvexHull(corners).volume)
    return len(areas) / sum(areas) if areas else np.nan


RPG = Grid("RPG", 1.40, 1.30)
TPG = Grid("TPG", 1.58, 1.27, triangular=True)
