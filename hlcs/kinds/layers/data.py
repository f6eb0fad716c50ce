"""Layer coefficients as measured: the CSV and the [placement] of an experiment file of kind "layers", checked hard.

Columns: grid, spacing_x, spacing_y [Dn], bottom_slope [-], layer, mean [-], cv [-], tests, campaign; one row a layer. Rows of one
grid, slope and campaign are one `LayerSet`. Every complaint names file, row and column; nothing is dropped silently.
"""

from dataclasses import dataclass, field, replace
from math import isfinite, nan
from operator import itemgetter, ne

import numpy as np

from hlcs.data.experiment_file import ExperimentFile
from hlcs.files.csv_files import CsvLayout, read_csv
from hlcs.placement.grids import RPG, TPG, WIDEST, Grid
from hlcs.placement.placement_file import checked_table, make_placement
from hlcs.placement.procedure import PlacementTest
from hlcs.placement.sea_bottom import Flat, Slope
from hlcs.placement.statistics import Sample
from minibullet.errors import InputError

COLUMNS = ("grid", "spacing_x", "spacing_y", "bottom_slope", "layer", "mean", "cv", "tests", "campaign")
LIMITS = {  # lowest and highest value, and what the number is
    "spacing_x": (0.5, WIDEST, "a spacing in nominal diameters Dn, not metres"),
    "spacing_y": (0.5, WIDEST, "a spacing in nominal diameters Dn, not metres"),
    "bottom_slope": (-0.5, 0.5, "a grade, rise over run: 0.04 for 4 %"),
    "layer": (1, 50, "a whole number"),
    "mean": (0.2, 3.0, "a layer coefficient in nominal diameters Dn"),
    "cv": (0.0, 0.5, "a fraction between tests: 0.02 for 2 %"),
    "tests": (1, 1_000_000, "a whole number of tests"),
}
PLACED = COLUMNS[:4] + ("campaign",)  # rows that agree in these are the layers of one set
GRIDS = {"TPG": TPG, "RPG": RPG}
MAY_BE_BLANK = ("spacing_x", "spacing_y", "bottom_slope", "cv", "tests", "campaign")
LAYOUT = CsvLayout(COLUMNS, ("grid", "layer", "mean"), words=("grid", "campaign"), blank=MAY_BE_BLANK, short=True)
USUAL_CV = 0.1  # beyond what any layer of the paper scatters by between tests
EACH = 0.5  # part of the first coefficient by which each next one is larger where heights of structures were written
NOT_USED = ("grid", "bottom", "seed")  # of [placement]: they come with a measured set and the command
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

    file: ExperimentFile
    test: PlacementTest = field(repr=False)  # the model under test; grid, bottom and layers come with each set
    sets: tuple[LayerSet, ...]
    hold_out: str  # "campaign", "grid" or "none"
    notes: tuple[str, ...] = ()

    def group(self, measured_set):
        """What is held out together with this set."""
        return measured_set.campaign if self.hold_out == "campaign" else f"{measured_set.grid.name} {measured_set.bottom_slope:g}"


def read_layers(file):
    """The LayerMeasurement of an ExperimentFile of kind "layers"; InputError names file, line or row, key or column, remedy."""
    table = checked_table(file.source)
    notes = [
        f"[placement] {key} is not used: grids and bottoms stand in the CSV, seeds come with the command"
        for key in NOT_USED
        if key in table
    ]
    values = file.source.values
    others = ["[surroundings]"] * ("surroundings" in values) + ["[model] time_step"] * ("time_step" in values.get("model", {}))
    notes += [f"{each} is not used: what a placement test needs to know stands under [placement]" for each in others]
    sets = read_layer_sets(file.data_file)
    stated, most = table.get("layers"), max(measured_set.layers for measured_set in sets)
    if stated not in (None, most):
        notes.append(f"[placement] layers = {stated} is not used: as many layers are placed as the CSV has, {most} at most")
    try:
        test = make_placement({key: value for key, value in table.items() if key not in (*NOT_USED, "layers")} | {"layers": most})
        slower = np.sqrt(test.unit.nominal_diameter)
        test = replace(test, **{key: value * slower for key, value in QUICK.items() if key not in table})
    except InputError as problem:
        raise InputError(f"{file.path}: {problem}") from None
    notes += odd_notes(sets)
    hold_out = file.hold_out
    if hold_out == "group":
        hold_out = "campaign" if len({measured_set.campaign for measured_set in sets}) > 1 else "grid"
    measurement = LayerMeasurement(file, test, sets, hold_out, tuple(notes))
    return measurement if len(set(map(measurement.group, sets))) > 1 else replace(measurement, hold_out="none")


def odd_notes(sets):
    """Sentences on what is hardly meant in some LayerSets."""
    notes = []
    for each in sets:
        if (largest := np.nanmax(each.sample.cv, initial=0.0)) > USUAL_CV:
            notes.append(f"{each.name}: cv up to {largest:g} between tests; it is a fraction, not per cent: 0.02 for 2 %")
        if each.layers > 1 and np.all(np.diff(each.sample.mean) > EACH * each.sample.mean[0]):
            notes.append(f"{each.name}: means grow as heights do; a coefficient is the thickness of one layer alone")
        own = GRIDS.get(each.grid.name.split()[0].upper())
        if own and (each.grid.spacing_x, each.grid.spacing_y) != (own.spacing_x, own.spacing_y):
            here, there = (f"{grid.spacing_x:g} x {grid.spacing_y:g} Dn" for grid in (each.grid, own))
            notes.append(f"{each.name}: spacings of {here}, where the paper's are {there}: spacing_x is along a row")
    return notes


def read_layer_sets(path):
    """The LayerSets of a CSV, in the order of their first rows, with names that tell them apart."""
    table = read_csv(path, LAYOUT)
    if not len(table.rows):
        raise InputError(f"{table.name}: has no rows; write one row a layer")
    placed = {}  # what places a set -> {layer: (row of the file, its values)}
    for row, values in [(int(row), _checked(table, index)) for index, row in enumerate(table.rows)]:
        layers, layer = placed.setdefault(tuple(values[name] for name in PLACED), {}), int(values["layer"])
        if layer in layers:
            raise InputError(
                f"{path}, row {row}, column layer: layer {layer} of {values['grid']}, campaign '{values['campaign']}' "
                f"stands already in row {layers[layer][0]}; leave one out, or name another campaign"
            )
        layers[layer] = row, values
    _refuse_gaps(path, placed)
    spacings = {}  # name of a grid -> those that it stands for
    for name, *spacing, _, _ in placed:
        spacings.setdefault(name, set()).add(tuple(spacing))
    sets = [_layer_set(path, *place, layers, len(spacings[place[0]]) > 1) for place, layers in placed.items()]
    names = [each.name for each in sets]
    sets = [replace(each, name=f"{each.name}, {each.campaign}") if names.count(each.name) > 1 else each for each in sets]
    return tuple(sets)


def _refuse_gaps(path, placed):
    """InputError where a set lacks a layer; where another one has it that differs in little, such as a spacing, it is named."""
    for place, layers in placed.items():
        gap = next((layer for layer in range(1, max(layers) + 1) if layer not in layers), None)
        if gap is None:
            continue
        first_row, values = next(iter(layers.values()))
        told = (
            f"{path}, column layer: {values['grid']}, campaign '{values['campaign']}' (from row {first_row}) has no layer {gap}"
        )
        others = [(sum(map(ne, place, other)), *its[gap]) for other, its in placed.items() if other[0] == place[0] and gap in its]
        if not others:
            raise InputError(f"{told}; layers are numbered from 1 without gaps")
        _, row, theirs = min(others, key=itemgetter(0))
        unlike = [f"{name} = {theirs[name]} (here {values[name]})" for name in PLACED if theirs[name] != values[name]]
        raise InputError(f"{told}: row {row} has it with {', '.join(unlike)}; layers of one set have one of each, in all rows")


def _layer_set(path, name, spacing_x, spacing_y, bottom_slope, campaign, layers, several):
    """The LayerSet of its rows; layers: as in `read_layer_sets`; several: do grids of other spacings have the name as well?"""
    first_row, _ = next(iter(layers.values()))
    ordered = [values for _, (_, values) in sorted(layers.items())]
    sample = Sample(*(np.array([values[column] for values in ordered], dtype=float) for column in ("mean", "cv", "tests")))
    known, triangular = GRIDS.get(name.upper()), name.upper() == "TPG" or name.lower().startswith("tri")
    try:
        as_known = known is not None and (spacing_x, spacing_y) == (known.spacing_x, known.spacing_y)
        grid = known if as_known else Grid(name, spacing_x, spacing_y, triangular)
    except InputError as problem:
        raise InputError(f"{path}, row {first_row}: {problem}") from None
    if several:
        grid = replace(grid, name=f"{grid.name} {spacing_x:g} x {spacing_y:g} Dn")
    bottom = f"{100 * bottom_slope:g} % slope" if bottom_slope else "flat"
    return LayerSet(grid, bottom_slope, campaign, sample, f"{grid.name} {bottom}")


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
    known = GRIDS.get(values["grid"].upper())
    for name in ("spacing_x", "spacing_y"):
        if not isfinite(values[name]):
            if known is None:
                raise InputError(f"{table.place(index, name)}: is blank; only TPG and RPG have spacings of their own")
            values[name] = getattr(known, name)
    return values
