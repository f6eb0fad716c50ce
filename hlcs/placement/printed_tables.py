"""The paper's tables as frozen values: `laboratory("table2", grid="TPG")`, `paper_numerical("table2", grid="TPG")`.

The CSV files in `hlcs/placement/printed` hold the digits as printed, each row with its table, section and column. Nothing is
corrected there; where the print slips, docs/errata.md says how it is read. All layer coefficients are in nominal diameters Dn.
"""

import csv
from dataclasses import dataclass
from functools import cache
from importlib import resources

import numpy as np

from hlcs.rendering import Result
from minibullet.errors import InputError, one_of, shown_value

STUDIES = {"physical": "laboratory", "numerical": "paper's numerical model", "centi": "Centi (2020), numerical"}


@dataclass(frozen=True, eq=False, repr=False)
class LayerTable(Result):
    """Layer coefficients of repeated tests on one grid: a `hlcs.placement.statistics.Sample` that knows where it comes from."""

    title: str  # what was measured, by whom
    source: str  # table, section and column
    grid: str  # "RPG" or "TPG"
    spacing_x: float  # a/Dn [-]
    spacing_y: float  # b/Dn [-]
    bottom_slope: float  # grade of the bottom [-]
    campaign: str  # what was measured together, by the same hands
    mean: np.ndarray  # (M,) mean layer coefficients [-], read-only
    cv: np.ndarray  # (M,) coefficients of variation between tests [-], read-only
    tests: np.ndarray  # (M,) number of tests, nan where the source does not say, read-only

    def __post_init__(self):
        for name in ("mean", "cv", "tests"):
            values = np.array(getattr(self, name), dtype=float)
            values.flags.writeable = False
            object.__setattr__(self, name, values)

    @property
    def layers(self):
        """Layer numbers 1 .. M, (M,) integers."""
        return np.arange(1, self.mean.size + 1)

    @property
    def height_over_dn(self):
        """Total height over the nominal diameter, the sum of the layer coefficients (Eq. 14) [-]."""
        return float(self.mean.sum())

    def to_dataframe(self):
        """The columns of a layers file (`kind = "layers"`), one row a layer."""
        import pandas

        rows = {
            "grid": self.grid,
            "spacing_x": self.spacing_x,
            "spacing_y": self.spacing_y,
            "bottom_slope": self.bottom_slope,
            "layer": self.layers,
            "mean": self.mean,
            "cv": self.cv,
            "tests": self.tests,
            "campaign": self.campaign,
        }
        return pandas.DataFrame(rows)


def laboratory(table, grid=None):
    """The laboratory's layer coefficients of "table2" (horizontal bottom) or "table3" (TPG on a 4 % slope) as a `LayerTable`.

    table: "table2" or "table3"; grid: "RPG" or "TPG", may be left out where the table has one grid only. Raises InputError naming
    what is known.
    """
    return _layer_table(table, grid, "physical")


def paper_numerical(table, grid=None, study="numerical"):
    """The layer coefficients of the paper's own Bullet model as a `LayerTable`.

    table, grid: as for `laboratory`; study: "numerical", or "centi" for Centi (2020), of unknown N.
    """
    if study not in ("numerical", "centi"):
        raise InputError(f"study = {shown_value(study)}; {one_of(study, ('numerical', 'centi'))}")
    return _layer_table(table, grid, study)


def design_layer_coefficients():
    """Layer coefficients of other units that design manuals tell to use, as a DataFrame: design values, not measurements.

    Columns: unit; armour_layers (1 or 2 on a slope of rock: not the layers of a low-crested structure); layer_coefficient, mean
    thickness of a layer over Dn [-]; porosity, and porosity_high where a range is given [-]; source; kind, always "design value".
    NaN where the source gives none. Two rows where two manuals differ.
    """
    import pandas

    table = pandas.DataFrame(rows_of("design_layer_coefficients"))
    numbers = ["armour_layers", "layer_coefficient", "porosity", "porosity_high"]
    table[numbers] = table[numbers].apply(pandas.to_numeric)
    return table.assign(kind="design value")


def sensitivity_values():
    """The parameter values of Table 1: {parameter: tuple of floats}; `side` in metres, lengths over Dn otherwise."""
    values = {}
    for row in rows_of("table1"):
        values.setdefault(row["parameter"], []).append(float(row["value"]))
    return {name: tuple(numbers) for name, numbers in values.items()}


def reference_runs(table, grid):
    """What other engines were measured to give on the paper's procedure, for "table2" or "table3" and a grid: dictionaries with
    run, engine, version, shape, friction, margin, layers (5 numbers, or none), mean_relative_error and to_paper [-] and fallen
    (units in all its tests), None where not known. Sources: docs/errata.md.
    """
    slope = {"table2": 0.0, "table3": 0.04}[table]
    rows = [row for row in rows_of("reference") if row["grid"] == grid and float(row["bottom_slope"]) == slope]
    return [
        {
            **{name: row[name] for name in ("run", "engine", "version", "shape")},
            "friction": float(row["contact_friction"]),
            "margin": float(row["margin"]),
            "layers": [float(row[f"k{j}"]) for j in range(1, 6) if row[f"k{j}"]],
            "mean_relative_error": _share(row["eps_physical_percent"]),
            "to_paper": _share(row["eps_numerical_percent"]),
            "fallen": int(row["fallen"]) if row["fallen"] else None,
        }
        for row in rows
    ]


def _share(percent):
    """A printed percentage as a number, None where none is printed."""
    return float(percent) / 100.0 if percent else None


@cache
def rows_of(name):
    """All rows of `printed/NAME.csv` as a tuple of dictionaries of strings, the digits as they stand in the file."""
    text = resources.files("hlcs.placement").joinpath("printed", f"{name}.csv").read_text(encoding="utf-8")
    return tuple(csv.DictReader(text.splitlines()))


def _layer_table(table, grid, study):
    grid = _grid_of(table, grid, study)
    rows = [row for row in rows_of(table) if row["grid"] == grid and row["study"] == study]
    first = rows[0]
    return LayerTable(
        title=f"{STUDIES[study]}, {grid}"
        + (f" on {float(first['bottom_slope']):.0%} slope" if float(first["bottom_slope"]) else ""),
        source=f"{first['table']}, section {first['section']}, {first['column']}",
        grid=grid,
        spacing_x=float(first["spacing_x"]),
        spacing_y=float(first["spacing_y"]),
        bottom_slope=float(first["bottom_slope"]),
        campaign=first["campaign"],
        mean=[float(row["mean"]) for row in rows],
        cv=[float(row["cv"]) for row in rows],
        tests=[float(row["tests"] or "nan") for row in rows],
    )


def _grid_of(table, grid, study):
    """The grid asked for, or the only one; refuses unknown tables, grids and studies by name."""
    if table not in ("table2", "table3"):
        raise InputError(f"table = {shown_value(table)}; {one_of(table, ('table2', 'table3'), 'layer coefficients are in')}")
    grids = sorted({row["grid"] for row in rows_of(table) if row["study"] == study})
    if not grids:
        raise InputError(f"{table} has no column {study!r}")
    if grid is None and len(grids) == 1:
        return grids[0]
    grid = getattr(grid, "name", grid)  # a placement grid knows its own name
    if grid not in grids:
        raise InputError(f"grid = {shown_value(grid)}; {one_of(grid, grids, f'{table} has')}")
    return grid
