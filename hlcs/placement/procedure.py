"""The placement test: frozen values that define a run completely.

test = hlcs.PlacementTest(grid=hlcs.TPG, layers=5, seed=1) result = test.run()
"""

import time
from dataclasses import dataclass, fields, replace

import numpy as np

import minibullet as mb
from hlcs.placement import layer_placement, plate_readings, sea_bottom, validation
from hlcs.placement.grids import TPG, Grid
from hlcs.placement.placement_result import PlacementResult
from hlcs.placement.units import CONCRETE, UNITS
from minibullet.errors import InputError, is_number, shown_value

ROUGHNESS_LENGTH = 1.5  # distance of the points at which a rough bed has heights of their own [Dn]
POSITIVE = float(np.nextafter(0.0, 1.0))
RANGES = {  # lowest and highest value of every number; where the default is a whole number, only whole ones
    "layers": (1, 50),
    "rows": (1, 1000),
    "columns": (1, 1000),
    "plates": (1, 20),
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
}
WORDS = {"reference": ("layer", "blind"), "shape": ("pieces", "hull"), "armour": tuple(UNITS)}


@dataclass(frozen=True)
class PlacementTest:
    """One placement test. Lengths in Dn where the paper gives them so; the defaults are the paper's calibrated values.

    grid: Grid, "TPG", "RPG" or "a,b"; layers; rows, columns of the first layer; bottom: "flat", "slope:0.04", a survey CSV or
    a bottom; reference: "layer" (each layer's grid starts from a unit of the layer below) or "blind" (from one unit of the
    first layer); armour: "cubipod" or "cube"; shape: "pieces" (the true unit) or "hull"; side of the unit's cube [m];
    friction: *contact* coefficient [-], 0.36 is what Bullet makes of the paper's 0.6 on each of two bodies; restitution [-];
    linear_damping, angular_damping [-]; margin around each unit [Dn]; falling_distance [Dn]; density [kg/m3]; seed;
    time_step [s], iterations, tolerance [-], solver: how the engine computes; settle_time: longest wait for a layer [s]; plates
    per side.

    How the crane really places, all absent by default: placement_scatter, standard deviation of the aims from layer 2 on
    [Dn]; placement_offset_x, placement_offset_y, by which every layer misses its aim more than the one below [Dn];
    yaw_constraint, concentration of the first layer's headings about x on a triangular grid (von Mises) [-]; lost_units,
    fraction left out [-]; sequential_placement: rows of a layer one after another, each at rest before the next;
    loose_lower_layers: no layer is ever fixed; vibration: peak acceleration to and fro along x after each layer [g].
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
    armour: str = "cubipod"
    shape: str = "pieces"
    side: float = 1.0
    friction: float = 0.36
    restitution: float = 0.0
    linear_damping: float = 0.0
    angular_damping: float = 0.0
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
    placement_scatter: float = 0.0
    placement_offset_x: float = 0.0
    placement_offset_y: float = 0.0
    yaw_constraint: float = 0.0
    lost_units: float = 0.0
    sequential_placement: bool = False
    loose_lower_layers: bool = False
    vibration: float = 0.0
    bottom_roughness: float = 0.0
    inertia_factor: float = 1.0
    effects: tuple = ()

    def __post_init__(self):
        object.__setattr__(self, "grid", Grid.parse(self.grid))
        if isinstance(self.bottom, str):
            object.__setattr__(self, "bottom", sea_bottom.parse_bottom(self.bottom))
        object.__setattr__(self, "effects", tuple(self.effects))
        for field in fields(self):
            _check(field.name, getattr(self, field.name), type(field.default))
        if self.layers > min(self.rows, self.columns):
            raise InputError(
                f"placement: layers = {self.layers} with {self.rows} rows and {self.columns} columns; every layer has one row "
                f"and one column less, so at most {min(self.rows, self.columns)} layers"
            )
        if self.bottom_roughness and isinstance(self.bottom, sea_bottom.Survey):
            raise InputError("placement: bottom_roughness on a surveyed bottom; its roughness stands in the survey")
        _ = self.settings  # checked now, not after minutes
        validation.tell_unlikely(self)

    @property
    def unit(self):
        """The armour unit of this side."""
        return UNITS[self.armour](side=self.side)

    @property
    def settings(self):
        """The engine's settings."""
        return mb.Settings(
            time_step=self.time_step,
            friction=self.friction,
            restitution=self.restitution,
            linear_damping=self.linear_damping,
            angular_damping=self.angular_damping,
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

    def run(self, progress=None):
        """Place and measure all layers; ``progress(layer)`` is called after each. Returns a PlacementResult."""
        started = time.perf_counter()
        validation.check_effort(self)
        site = _Site(self)
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
        )


class _Site:
    """Where a test is run: the world, what was placed and read in it, and what the next layer takes over from those below.

    shift: of the next layer's grid [m] (2,); envelope: height that its falling distance starts from [m]; level: median height of
    the centres of the layer below [m].
    """

    def __init__(self, test):
        self.test, self.unit, self.dn, self.bed = test, test.unit, test.unit.nominal_diameter, test.bed
        self.load = layer_placement.load_of(self.unit, test)
        self.generator = np.random.default_rng(test.seed)
        self.world = mb.World([mb.Gravity(9.81), *test.effects], test.settings)
        self.bed.add_to(self.world)
        self.shift, self.envelope, self.level = np.zeros(2), 0.0, -np.inf
        self.records, self.readings, self.aims, self.loose = [], [], [], []

    def place(self, layer):
        """Place, settle, fix and measure one layer."""
        test, dn = self.test, self.dn
        centres = test.grid.centres(test.rows, test.columns, layer) * dn + self.shift
        aims = layer_placement.missed(test, centres, layer)
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
        places, layers = plate_readings.plate_centres(centres, dn, test.plates), [below.handles for below in self.records]
        self.readings.append(plate_readings.read_plates(layers, record.standing, self.bed, places, dn, test.settings))
        self.envelope = _envelope(self.readings[-1].heights, record.standing, self.bed, self.envelope)
        self.level = layer_placement.level_of(_heights(record.handles, self.bed), self.level, dn)

    def _first_layer(self, aims):
        """The record of the first layer, laid on the bottom and settled."""
        handles = layer_placement.lay_first_layer(self.world, self.unit, self.load, aims, self.bed, self.test, self.generator)
        pushed = _farthest(handles, layer_placement.first_places(self.unit, aims, self.bed, self.test))
        return self._settled(1, handles).started(pushed=pushed)

    def _upper_layer(self, layer, aims, centres):
        """The record of a layer, dropped at once or row after row, and settled."""
        handles, lifts, record = [], [], None
        rows = layer_placement.rows_of(aims, centres) if self.test.sequential_placement else ()
        for row in rows or (aims,):  # a layer may have lost all its units
            ground = -sea_bottom.height_above(self.bed, np.insert(row, 2, 0.0, axis=1))
            lowest = ground + self.envelope + self.test.falling_distance * self.dn
            hung, lifted = layer_placement.hang_layer(self.world, layer, self.load, row, lowest, self.generator, len(handles))
            handles, lifts = handles + hung, [*lifts, *lifted]
            record = self._settled(layer, handles).after(record)
        return record.started(lifts)

    def _settled(self, layer, handles):
        """The record of a layer after its units have come to rest."""
        return layer_placement.settle_layer(self.world, layer, handles, self.bed, self.level, self.dn, self.test.settle_time)


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
        raise InputError(f"placement: {name} = {value!r}; it must be one of {', '.join(WORDS[name])}")
    elif name == "effects" and not all(isinstance(effect, mb.Effect) for effect in value):
        raise InputError(f"placement: effects = {value!r}; each must be a value of minibullet.Effect")


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
