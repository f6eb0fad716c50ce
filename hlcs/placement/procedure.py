"""The placement test: frozen values that define a run completely.

test = hlcs.PlacementTest(grid=hlcs.TPG, layers=5, seed=1) result = test.run()
"""

import time
from dataclasses import dataclass, fields, replace

import numpy as np

import minibullet as mb
from hlcs.placement import hanging, layer_placement, plate_readings, sea_bottom, validation
from hlcs.placement.deep_layers import DeepLayers
from hlcs.placement.grids import TPG, Grid
from hlcs.placement.mesh_units import parse_armour, unit_of
from hlcs.placement.placement_result import PlacementResult
from hlcs.placement.standing_units import covered, parse_standing, seats
from hlcs.placement.units import CONCRETE
from minibullet.errors import InputError, is_number, one_of, shown_value
from minibullet.values import Value

ROUGHNESS_LENGTH = 1.5  # distance of the points at which a rough bed has heights of their own [Dn]
POSITIVE = float(np.nextafter(0.0, 1.0))
RANGES = {  # lowest and highest value of every number; where the default is a whole number, only whole ones
    "layers": (1, 50),
    "rows": (1, 1000),
    "columns": (1, 1000),
    "plates": (1, 20),
    "plate_margin": (0.0, 0.5),
    "iterations": (1, 10**6),
    "seed": (0, 2**63 - 1),
    "side": (POSITIVE, 1e6),
    "density": (POSITIVE, 1e6),
    "friction": (0.0, np.inf),
    "falling_distance": (0.0, 100.0),
    "margin": (0.0, 0.5),
    "settle_time": (POSITIVE, np.inf),
    "time_step": (POSITIVE, 1.0),
    "placement_scatter": (0.0, 1.0),
    "placement_offset_x": (-1.0, 1.0),
    "placement_offset_y": (-1.0, 1.0),
    "yaw_constraint": (0.0, 1e6),
    "lost_units": (0.0, 0.5),
    "vibration": (0.0, 10.0),
    "bottom_roughness": (0.0, 0.5),
    "inertia_factor": (0.01, 100.0),
    "tip_share": (0.0, 1.0),
    "set_back": (0.0, 5.0),
}
WORDS = {
    "reference": ("layer", "blind"),
    "shape": ("pieces", "hull"),
    "crowding": hanging.CROWDING,
    "damping_law": ("bullet", "per_step"),
}
MOST_ROWS = 20  # of plates on a layer


@dataclass(frozen=True)
class PlacementTest(Value):
    """One placement test. Lengths in Dn where the paper gives them so; those of the paper are the preset "paper".

    grid: Grid, "TPG", "RPG" or "a,b"; layers; rows, columns of the first layer; bottom: "flat", "slope:0.04", a survey CSV or
    a bottom; reference: "layer" (each layer's grid starts from a unit of the layer below) or "blind" (from one unit of the
    first layer); armour: "cubipod", "cube", a mesh file of the unit or a MeshUnit; shape: "pieces" (the true unit) or "hull";
    side of the unit's cube [m], or of a unit from a file the metres per unit of its lengths;
    friction: coefficient of the contact [-], 0.36 is what Bullet makes of the paper's 0.6 on each of two bodies; restitution [-];
    linear_damping, angular_damping [-]; damping_law, "bullet" or "per_step" (Eqs. 6-7 as printed); margin around each unit
    [Dn]; falling_distance [Dn]; density [kg/m3]; seed; time_step [s], iterations, tolerance [-], solver: how the engine computes;
    settle_time: longest wait for a layer [s]; plates per side; plate_rows: how many rows of plates on each layer in place of
    that, such as (4, 3, 3, 2, 1) or "4,3,3,2,1", layers above the last one like it; plate_margin around each plate [Dn];
    crowding: what is done about hanging units that overlap, "turn", "redraw" or "lift" (`hlcs.placement.hanging`); standing:
    units that stand already, a CSV or StandingUnits, to which units are added where places are empty.

    How the crane really places, all absent by default: placement_scatter, standard deviation of the aims from layer 2 on
    [Dn]; placement_offset_x, placement_offset_y, by which every layer misses its aim more than the one below [Dn];
    yaw_constraint, concentration of the first layer's headings about x on a triangular grid (von Mises) [-]; lost_units,
    fraction left out [-]; sequential_placement: rows of a layer one after another, each at rest before the next;
    unit_by_unit: so are its units;
    loose_lower_layers: no layer is ever fixed; vibration: peak acceleration to and fro along x after each layer [g].
    Where and how the layers stand: set_back, spacings by which every layer keeps back from the edge of the one below, at least
    (0: as far as the hollows do; 1/3 at the steep flank of a triangular grid); walls: between the side walls of a flume,
    half a spacing beyond the outermost units (triangular grids); tip_share, of the first layer's units that stand on a tip
    rather than on an edge [-].
    What the unit and the bed really are: bottom_roughness, standard deviation of the bed's heights, one every 1.5 Dn
    [Dn];
    inertia_factor, moments of inertia over the true ones [-]; effects: values of minibullet.Effect beside gravity.

    Raises InputError that names the field, its value and the rule.
    """

    grid: Grid = TPG
    layers: int = 5
    rows: int = 8
    columns: int = 8
    bottom: object = "flat"
    reference: str = "layer"
    armour: object = "cubipod"
    shape: str = "pieces"
    side: float = 1.0
    friction: float = 0.36
    restitution: float = 0.0
    linear_damping: float = 0.0
    angular_damping: float = 0.0
    damping_law: str = "bullet"
    margin: float = 0.0
    falling_distance: float = 0.25
    density: float = CONCRETE
    seed: int = 1
    time_step: float = 1.0 / 240.0
    iterations: int = 50
    tolerance: float = 1e-4
    solver: str = "gauss_seidel"
    settle_time: float = 30.0
    plates: int = 3
    plate_rows: tuple = ()
    plate_margin: float = 0.0
    crowding: str = "turn"
    standing: object = ""
    placement_scatter: float = 0.0
    placement_offset_x: float = 0.0
    placement_offset_y: float = 0.0
    yaw_constraint: float = 0.0
    lost_units: float = 0.0
    sequential_placement: bool = False
    unit_by_unit: bool = False
    loose_lower_layers: bool = False
    vibration: float = 0.0
    bottom_roughness: float = 0.0
    inertia_factor: float = 1.0
    tip_share: float = 0.0
    set_back: float = 0.0
    walls: bool = False
    effects: tuple = ()

    _units = validation.UNITS
    _told = ("grid", "layers", "rows", "columns", "bottom", "armour", "side", "friction", "seed")

    def __post_init__(self):
        object.__setattr__(self, "grid", Grid.parse(self.grid))
        if isinstance(self.bottom, str):
            object.__setattr__(self, "bottom", sea_bottom.parse_bottom(self.bottom))
        object.__setattr__(self, "armour", parse_armour(self.armour))
        object.__setattr__(self, "standing", parse_standing(self.standing))
        object.__setattr__(self, "effects", tuple(self.effects))
        object.__setattr__(self, "plate_rows", _rows_of_plates(self.plate_rows))
        for field in fields(self):
            _check(field.name, getattr(self, field.name), type(field.default))
        if self.layers > min(self.rows, self.columns):
            raise InputError(
                f"placement: layers = {self.layers} with {self.rows} rows and {self.columns} columns; every layer has one row "
                f"and one column less, so at most {min(self.rows, self.columns)} layers"
            )
        if self.bottom_roughness and isinstance(self.bottom, sea_bottom.Survey):
            raise InputError("placement: bottom_roughness on a surveyed bottom; its roughness stands in the survey")
        if self.walls and not (self.grid.triangular and self.rows > 1):
            raise InputError(
                f"placement: walls = true on grid {self.grid.name} with {self.rows} row(s); only a triangular grid of two "
                "rows or more is placed between walls"
            )
        empty = [layer for layer in range(1, self.layers + 1) if not len(self.centres(layer))]
        if empty:
            raise InputError(
                f"placement: set_back = {self.set_back:g} spacings leaves layer {empty[0]} of {self.rows} rows and "
                f"{self.columns} columns without units; take more rows and columns, fewer layers, or a smaller set_back"
            )
        if self.unit_by_unit and self.sequential_placement:
            raise InputError("placement: unit_by_unit = true and sequential_placement = true (row by row); give one of the two")
        _ = self.settings  # checked now, not after minutes
        validation.tell_unlikely(self)

    @property
    def unit(self):
        """The armour unit of this side."""
        return unit_of(self.armour, self.side)

    def centres(self, layer):
        """Where the units of a layer (numbered from 1) are meant to be, in plan, before any reference shifts it: (n, 2) [Dn]."""
        return self.grid.centres(self.rows, self.columns, layer, self.set_back, self.walls)

    @property
    def settings(self):
        """The engine's settings."""
        return mb.Settings(
            time_step=self.time_step,
            friction=self.friction,
            restitution=self.restitution,
            linear_damping=self.linear_damping,
            angular_damping=self.angular_damping,
            damping_law=self.damping_law,
            margin=self.margin * self.unit.nominal_diameter,
            solver=self.solver,
            iterations=self.iterations,
            tolerance=self.tolerance,
        )

    @property
    def bed(self):
        """The bottom as it really is: the nominal one, or that with its roughness."""
        if not self.bottom_roughness:
            return self.bottom
        dn, last = self.unit.nominal_diameter, np.array([self.columns + 1, self.rows + 1])
        half = 0.5 * last * (self.grid.spacing_x, self.grid.spacing_y)
        generator = np.random.default_rng([self.seed, 0])  # a stream of its own: other draws are the same with and without
        return sea_bottom.roughened(self.bottom, self.bottom_roughness * dn, ROUGHNESS_LENGTH * dn, half * dn, generator)

    def plate_places(self, layer, centres):
        """Where plates are laid on a layer (numbered from 1) whose units were meant for centres (n, 2) [m]: (k, 2) [m]."""
        rows = self.plate_rows[min(layer, len(self.plate_rows)) - 1] if self.plate_rows else self.plates
        return plate_readings.plate_centres(centres, self.unit.nominal_diameter, self.plates, rows)

    def run(self, progress=None, watch=None):
        """Place and measure all layers; ``progress(layer)`` is called after each, ``watch(layer, world)`` after every step while
        a layer settles. Returns a PlacementResult."""
        started = time.perf_counter()
        validation.check_effort(self)
        site = _Site(self, watch)
        for layer in range(1, self.layers + 1):
            site.place(layer)
            if progress is not None:
                progress(layer)
        return PlacementResult(
            self,
            tuple(reading.heights for reading in site.readings),
            tuple(_poses(record) for record in site.records),
            tuple(replace(record, handles=(), standing=()) for record in site.records),
            time.perf_counter() - started,
            tuple(reading.carried_by for reading in site.readings),
            tuple(site.aims),
            site.world.notices,
            tuple(reading.faces for reading in site.readings),
            tuple(record.stands for record in site.records),
        )


class _Site:
    """Where a test is run: the world, what was placed and read in it, and what the next layer takes over from those below.

    shift: of the next layer's grid [m] (2,); envelope: height that its falling distance starts from [m]; level: median height of
    the centres of the layer below [m].
    """

    def __init__(self, test, watch=None):
        self.test, self.unit, self.dn, self.bed = test, test.unit, test.unit.nominal_diameter, test.bed
        self.load = layer_placement.load_of(self.unit, test)
        self.generator = np.random.default_rng(test.seed)
        self.world = mb.World([mb.Gravity(9.81), *test.effects], test.settings)
        self.bed.add_to(self.world)
        self.deep = DeepLayers(self.world)
        self.watchers = (self.deep.watch,) if watch is None else (self.deep.watch, watch)
        if test.walls:
            for side in (-1.0, 1.0):
                self.world.add_plane((side, 0.0, 0.0), -test.grid.wall_distance(test.columns) * self.dn)
        self.shift, self.envelope, self.level = np.zeros(2), 0.0, -np.inf
        self.records, self.readings, self.aims, self.loose = [], [], [], []
        self.standing = layer_placement.stand(self.world, self.load, test.standing, self.dn) if test.standing else {}

    def place(self, layer):
        """Place, settle, fix and measure one layer."""
        test, dn = self.test, self.dn
        if not (test.loose_lower_layers or test.vibration):  # what is shaken, or not fixed, is all in motion
            self.deep.set_aside([below.handles for below in self.records])
        centres = test.centres(layer) * dn + self.shift
        aims = layer_placement.missed(test, centres, layer)
        if test.standing:
            record, aims = self._repaired_layer(layer, aims)
        else:
            record = self._first_layer(aims) if layer == 1 else self._upper_layer(layer, aims, centres)
        self.loose = [*(self.loose if test.loose_lower_layers else ()), *record.handles]
        if test.vibration:
            layer_placement.shake(self.world, self.loose, test.vibration, dn)
            record = self._settled(layer, record.handles).after(record)
        if not test.loose_lower_layers:
            self.world.freeze(record.handles)
        self.records.append(record)
        self.aims.append(aims)
        if test.reference == "layer":
            self.shift = self.shift + layer_placement.reference_shift(record, aims)
        places, layers = test.plate_places(layer, centres), self.deep.at_hand_of([below.handles for below in self.records])
        self.readings.append(
            plate_readings.read_plates(layers, record.standing, self.bed, places, dn, test.settings, test.plate_margin * dn)
        )
        self.envelope = _envelope(self.readings[-1].heights, record.standing, self.bed, self.envelope)
        self.level = layer_placement.level_of(_heights(record.handles, self.bed), self.level, dn)

    def _first_layer(self, aims):
        """The record of the first layer, laid on the bottom and settled."""
        handles = layer_placement.lay_first_layer(self.world, self.unit, self.load, aims, self.bed, self.test, self.generator)
        pushed = _farthest(handles, layer_placement.first_places(self.unit, aims, self.bed, self.test))
        return self._settled(1, handles).started(pushed=pushed)

    def _upper_layer(self, layer, aims, centres):
        """The record of a layer, dropped at once, row after row or unit after unit, and settled."""
        test, handles, lifts, redrawn, record = self.test, [], [], 0, None
        rows = np.split(aims, len(aims)) if test.unit_by_unit and len(aims) else ()
        rows = layer_placement.rows_of(aims, centres) if test.sequential_placement else rows
        for row in rows or (aims,):  # a layer may have lost all its units
            hung = self._hung(layer, row, len(handles))
            handles, lifts, redrawn = handles + hung.handles, [*lifts, *hung.lifts], redrawn + hung.redrawn
            record = self._settled(layer, handles).after(record)
        return record.started(lifts, redrawn=redrawn)

    def _repaired_layer(self, layer, aims):
        """The record of a layer of which units stand already, after units were added at its empty places; and the aims (n, 2) of
        all its units, those added last."""
        own = self.standing.get(layer, [])
        above = [handle for number, handles in self.standing.items() if number > layer for handle in handles]
        places, over = (np.reshape([handle.position[:2] for handle in handles], (-1, 2)) for handles in (own, above))
        seat = seats(aims, places, min(self.test.grid.spacing_x, self.test.grid.spacing_y) * self.dn)
        hidden = (seat < 0) & covered(aims, over, self.dn)
        gaps, filled = aims[(seat < 0) & ~hidden], seat >= 0
        hung = self._hung(layer, gaps, len(own))
        record = self._settled(layer, hung.handles).started(hung.lifts, redrawn=hung.redrawn)
        extra = np.setdiff1d(np.arange(len(own)), seat[filled])  # they stand in the layer, but at no place of it
        kept = [own[k] for k in (*seat[filled], *extra)]
        inside = layer_placement.in_place(_heights(kept, self.bed), self.level, self.dn)
        stands = [handle for handle, there in zip(kept, inside, strict=True) if there]
        record = replace(
            record,
            handles=(*kept, *hung.handles),
            standing=(*stands, *record.standing),
            added=len(hung.handles),
            covered=int(hidden.sum()),
        )
        return record, np.concatenate([aims[filled], places[extra], gaps])

    def _hung(self, layer, aims, first):
        """The Hung units over aims (n, 2), their lowest points a falling distance above what is below."""
        ground = -sea_bottom.height_above(self.bed, np.insert(aims, 2, 0.0, axis=1))
        lowest = ground + self.envelope + self.test.falling_distance * self.dn
        return hanging.hang_layer(self.world, layer, self.load, aims, lowest, self.generator, first, self.test.crowding)

    def _settled(self, layer, handles):
        """The record of a layer after its units have come to rest."""
        limits = self.level, self.dn, self.test.settle_time
        return layer_placement.settle_layer(self.world, layer, handles, self.bed, *limits, watchers=self.watchers)


def _check(name, value, kind):
    """InputError where a field cannot have this value; kind: the type of its default."""
    if name in RANGES:
        low, high = RANGES[name]
        number = is_number(value) and (kind is not int or isinstance(value, int | np.integer))
        if not number or not low <= value <= high:
            least = "> 0" if low == POSITIVE else f">= {low:g}"
            rule = f"a whole number from {low} to {high}" if kind is int else f"a finite number {least}"
            most = f" and at most {high:g}" if kind is not int and np.isfinite(high) else ""
            raise InputError(f"placement: {name} = {shown_value(value)}; it must be {rule}{most}")
    elif name == "bottom" and not hasattr(value, "add_to"):
        raise InputError(
            f'placement: bottom = {value!r}; it must be text such as "slope:0.04", or a bottom of hlcs.placement.sea_bottom'
        )
    elif kind is bool and not isinstance(value, bool):
        raise InputError(f"placement: {name} = {value!r}; it must be true or false")
    elif name in WORDS and value not in WORDS[name]:
        raise InputError(f"placement: {name} = {shown_value(value)}; {one_of(value, WORDS[name])}")
    elif name == "effects" and not all(isinstance(effect, mb.Effect) for effect in value):
        raise InputError(f"placement: effects = {value!r}; each must be a value of minibullet.Effect")


def _rows_of_plates(value):
    """The rows of plates of each layer as a tuple, from numbers or text such as "4,3,3,2,1"; InputError where it is none."""
    given = value.split(",") if isinstance(value, str) else value
    try:
        rows = tuple(int(row) if isinstance(row, str) else row for row in given)
    except (TypeError, ValueError):
        rows = (None,)
    if not all(isinstance(row, int | np.integer) and not isinstance(row, bool) and 1 <= row <= MOST_ROWS for row in rows):
        raise InputError(
            f"placement: plate_rows = {shown_value(value)}; it must be whole numbers from 1 to {MOST_ROWS}, one a layer from the "
            "first on, such as 4,3,3,2,1"
        )
    return tuple(map(int, rows))


def _envelope(readings, standing, bottom, below):
    """Height that the next layer's falling distance starts from [m]: the mean of the plates; where none found support, the
    mean top of the units that stand; where none stands, the envelope below."""
    if np.isfinite(readings).any():
        return float(np.nanmean(readings))
    if not standing:
        return below
    tops = [(*handle.position[:2], plate_readings.top(handle)) for handle in standing]
    return float(sea_bottom.height_above(bottom, tops).mean())


def _heights(handles, bottom):
    """Heights of the centres of units above the bottom [m], (n,)."""
    return sea_bottom.height_above(bottom, np.reshape([handle.position for handle in handles], (-1, 3)))


def _farthest(handles, places):
    """The longest way from places (n, 3) to where the units are, in plan [m]."""
    off = np.array([handle.position[:2] for handle in handles]) - places[:, :2]
    return np.hypot(*off.T).max()


def _poses(record):
    """Positions and orientations of a layer's units (n, 7)."""
    return np.reshape([np.concatenate([handle.position, handle.orientation]) for handle in record.handles], (-1, 7))
