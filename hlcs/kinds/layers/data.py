"""Layer coefficients as measured: the CSV and the [placement] of an experiment file of kind "layers", checked hard.

Columns: grid, spacing_x, spacing_y [Dn], bottom_slope [-], layer, mean [-], cv [-], tests, campaign; one row a layer. Rows of one
grid, slope and campaign are one `LayerSet`. Every complaint names file, row and column; nothing is dropped silently.
"""

from dataclasses import dataclass, field, replace
from math import isfinite, nan

import numpy as np

from hlcs.files.csv_files import CsvLayout, read_csv
from hlcs.files.toml_files import TomlFile
from hlcs.placement.grids import RPG, TPG, WIDEST, Grid
from hlcs.placement.placement_file import KEYS, checked_table, make_placement
from hlcs.placement.procedure import PlacementTest
from hlcs.placement.sea_bottom import Flat, Slope
from hlcs.placement.statistics import Sample
from minibullet.errors import InputError

COLUMNS = ("grid", "spacing_x", "spacing_y", "bottom_slope", "layer", "mean", "cv", "tests", "campaign")
LIMITS = {  # lowest and highest value, and what the number is
    "spacing_x": (0.5, WIDEST, "a spacing in nominal diameters Dn, not metres"),
    "spacing_y": (0.5, WIDEST, "a spacing in nominal diameters Dn, not metres"),
    "bottom_slope": (-0.5, 0.5, "a grade, rise over run: 0.04 for 4 %"),
    "layer": (1, 50, "a whole number from 1"),
    "mean": (0.2, 3.0, "a layer coefficient in nominal diameters Dn"),
    "cv": (0.0, 0.5, "a fraction between tests: 0.02 for 2 %"),
    "tests": (1, 1_000_000, "a whole number of tests"),
}
MAY_BE_BLANK = ("spacing_x", "spacing_y", "bottom_slope", "cv", "tests", "campaign")
LAYOUT = CsvLayout(COLUMNS, ("grid", "layer", "mean"), words=("grid", "campaign"), blank=MAY_BE_BLANK, short=True)
# settings of the simulations of a unit of Dn = 1 m where the file states none, smaller ones as the root of their size: coarser
# than those of a single test, which changes no layer coefficient by more than the scatter between seeds; a finer step and more
# iterations are tried as candidates [s]
QUICK = {"time_step": 1.0 / 120.0, "settle_time": 4.0}


@dataclass(frozen=True, eq=False)
class LayerSet:
    """Repeated tests on one grid and bottom, of one campaign."""

    grid: Grid
    bottom_slope: float  # grade [-]
    campaign: str
    sample: Sample = field(repr=False)  # mean, cv, tests, each (M,); nan where not stated
    name: str = ""  # grid and bottom in words, and the campaign where only that tells two sets apart

    @property
    def layers(self):
        return len(self.sample.mean)

    @property
    def judgeable(self):
        """Whether scatter and number of tests are known for every layer; zero scatter in all of them is none that was seen."""
        cv = self.sample.cv
        return bool(np.all(np.isfinite(cv)) and np.any(cv > 0.0) and np.all(self.sample.tests >= 2))

    def placed(self, test):
        """The PlacementTest on this grid and bottom with as many layers as were measured."""
        bottom = Slope(self.bottom_slope) if self.bottom_slope else Flat()
        return replace(test, grid=self.grid.stacked(test.grid.stacking), bottom=bottom, layers=self.layers)


@dataclass(frozen=True, eq=False)
class LayerMeasurement:
    """An experiment file of layers, read and checked."""

    title: str
    test: PlacementTest = field(repr=False)  # the model under test; grid, bottom and layers come with each set
    sets: tuple[LayerSet, ...]
    hold_out: str  # "campaign", "grid" or "none"
    effects: tuple[dict, ...] = ()  # entries of [model] effects
    notes: tuple[str, ...] = ()
    data_file: object = None  # path of the CSV
    where: str = "model.effects"  # file and line of the effects, for complaints

    def group(self, one):
        """What is held out together with this set."""
        return one.campaign if self.hold_out == "campaign" else f"{one.grid.name} {one.bottom_slope:g}"

    @property
    def groups(self):
        return tuple(dict.fromkeys(self.group(one) for one in self.sets))


def read_layers(file):
    """The LayerMeasurement of an ExperimentFile of kind "layers"; InputError names file, line or row, key or column, remedy."""
    reader = TomlFile(file.path, {"": list(file_keys()), "placement": list(KEYS)}, file.allow_outside)
    table = dict(checked_table(reader))
    notes = [
        f"[placement] {key} is not used: grids and bottoms stand in the CSV, seeds come with the command"
        for key in ("grid", "bottom", "seed")
        if key in table
    ]
    stated = table.get("layers")
    for key in ("grid", "bottom", "seed", "layers"):
        table.pop(key, None)
    sets = read_layer_sets(file.data_file)
    most = max(one.layers for one in sets)
    if stated not in (None, most):
        notes.append(f"[placement] layers = {stated} is not used: as many layers are placed as the CSV has, {most} at most")
    try:
        test = make_placement({**table, "layers": most})
        slower = np.sqrt(test.unit.nominal_diameter)
        test = replace(test, **{key: value * slower for key, value in QUICK.items() if key not in table})
    except InputError as problem:
        raise InputError(f"{file.path}: {problem}") from None
    hold_out = file.hold_out
    if hold_out == "group":
        hold_out = "campaign" if len({one.campaign for one in sets}) > 1 else "grid"
    measurement = LayerMeasurement(
        file.title, test, sets, hold_out, file.effects, tuple(notes), file.data_file, file.place("model.effects")
    )
    if hold_out != "none" and len(measurement.groups) < 2:
        measurement = replace(measurement, hold_out="none")
    return measurement


def _named(sets):
    """The sets with names that tell them apart."""
    names = [f"{one.grid.name} " + (f"{100 * one.bottom_slope:g} % slope" if one.bottom_slope else "flat") for one in sets]
    return tuple(
        replace(one, name=f"{name}, {one.campaign}" if names.count(name) > 1 else name)
        for name, one in zip(names, sets, strict=True)
    )


def file_keys():
    """Top-level keys of an experiment file."""
    from hlcs.data.experiment_file import SECTIONS

    return SECTIONS[""]


def read_layer_sets(path):
    """The LayerSets of a CSV, in the order of their first rows."""
    rows = _rows(path)
    sets, lines = {}, {}
    for line, row in rows:
        key = (row["grid"], row["spacing_x"], row["spacing_y"], row["bottom_slope"], row["campaign"])
        found = sets.setdefault(key, {})
        layer = int(row["layer"])
        if layer in found:
            raise InputError(
                f"{path}, row {line}, column layer: layer {layer} of {row['grid']}, campaign '{row['campaign']}' "
                f"stands already in row {found[layer][0]}; leave one out, or name another campaign"
            )
        found[layer] = (line, row)
        lines.setdefault(key, line)
    result = []
    for key, found in sets.items():
        for layer in range(1, max(found) + 1):
            if layer not in found:
                raise InputError(
                    f"{path}, column layer: {key[0]}, campaign '{key[4]}' (from row {lines[key]}) has no layer "
                    f"{layer}; layers are numbered from 1 without gaps"
                )
        ordered = [found[layer][1] for layer in sorted(found)]
        sample = Sample(*(np.array([row[name] for row in ordered], dtype=float) for name in ("mean", "cv", "tests")))
        result.append(LayerSet(_grid(path, lines[key], *key[:3]), key[3], key[4], sample))
    return _named(result)


def _rows(path):
    """[(row of the file, checked values)]"""
    table = read_csv(path, LAYOUT)
    if not len(table.rows):
        raise InputError(f"{table.name}: has no rows; write one row a layer")
    return [(int(row), _checked(table, index)) for index, row in enumerate(table.rows)]


def _checked(table, index):
    """The values of a row: words and numbers, nan where blank."""
    values = {name: str(table.columns[name][index]) if name in table.columns else "" for name in ("grid", "campaign")}
    if not values["grid"]:
        raise InputError(f"{table.place(index, 'grid')}: is blank; give TPG, RPG or a name of your own")
    for name, (low, high, what) in LIMITS.items():
        value = float(table.columns[name][index]) if name in table.columns else nan
        if isfinite(value) and (not low <= value <= high or name in ("layer", "tests") and value != int(value)):
            raise InputError(f"{table.place(index, name)}: '{value:g}'; it must be {what}, from {low:g} to {high:g}")
        values[name] = 0.0 if name == "bottom_slope" and not isfinite(value) else value
    known = {"TPG": TPG, "RPG": RPG}.get(values["grid"].upper())
    for name in ("spacing_x", "spacing_y"):
        if not isfinite(values[name]):
            if known is None:
                raise InputError(f"{table.place(index, name)}: is blank; only TPG and RPG have spacings of their own")
            values[name] = getattr(known, name)
    return values


def _grid(path, line, name, spacing_x, spacing_y):
    """The Grid of a set: TPG, RPG, "triangular", or rectangular under a name of the user's."""
    triangular = name.upper() in ("TPG", "TRIANGULAR") or name.lower().startswith("tri")
    try:
        for known in (TPG, RPG):
            if name.upper() == known.name and (spacing_x, spacing_y) == (known.spacing_x, known.spacing_y):
                return known
        return Grid(name, spacing_x, spacing_y, triangular)
    except InputError as problem:
        raise InputError(f"{path}, row {line}: {problem}") from None
