"""The placement test: frozen values that define a run completely, and the frozen result.

test = hlcs.PlacementTest(grid=hlcs.TPG, layers=5, seed=1) result = test.run()
"""

import time
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

import minibullet as mb
from hlcs import bottoms, files, placement, plates, statistics
from hlcs.armour import CONCRETE, Cubipod
from hlcs.grids import TPG, Grid
from minibullet.errors import InputError


@dataclass(frozen=True)
class PlacementTest:
    """One placement test. Lengths in Dn where the paper gives them so; the defaults are the paper's calibrated values.

    grid: Grid, "TPG", "RPG" or "a,b"; layers; rows, columns of the first layer; bottom: "flat", "slope:0.04", a survey CSV or
    a bottom; reference: "layer" (each layer's grid starts from a unit of the layer below) or "blind" (from one unit of the
    first layer); shape: "pieces" (the true unit) or "hull"; side of the unit's cube [m]; friction: *contact* coefficient [-],
    0.36 is what Bullet makes of the paper's 0.6 on each of two bodies; restitution [-]; linear_damping, angular_damping [-];
    margin around each unit [Dn]; falling_distance [Dn]; density [kg/m3]; seed; time_step [s], iterations, tolerance, solver:
    how the engine computes; settle_time: longest wait for a layer [s]; plates per side. How the crane really places, all
    absent by default: placement_scatter, standard deviation of the aims from layer 2 on [Dn]; placement_offset_x,
    placement_offset_y, by which every layer misses its aim more than the one below [Dn]; yaw_constraint, concentration of the
    first layer's headings about x on a triangular grid (von Mises) [-]; lost_units, fraction left out [-].

    Raises InputError that names the field, its value and the rule.
    """

    grid: Grid = TPG
    layers: int = 5
    rows: int = 8
    columns: int = 8
    bottom: object = "flat"
    reference: str = "layer"
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
    tolerance: float = 1e-3
    solver: str = "gauss_seidel"
    settle_time: float = 30.0
    plates: int = 3
    placement_scatter: float = 0.0
    placement_offset_x: float = 0.0
    placement_offset_y: float = 0.0
    yaw_constraint: float = 0.0
    lost_units: float = 0.0

    def __post_init__(self):
        object.__setattr__(self, "grid", Grid.parse(self.grid))
        if isinstance(self.bottom, str):
            object.__setattr__(self, "bottom", bottoms.parse_bottom(self.bottom))
        for name, low, high in (
            ("layers", 1, 50),
            ("rows", 1, 1000),
            ("columns", 1, 1000),
            ("plates", 1, 20),
            ("iterations", 1, 10**6),
            ("seed", 0, 2**63 - 1),
        ):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not low <= value <= high:
                raise InputError(f"placement: {name} = {value!r}; it must be a whole number from {low} to {high}")
        for name, low, high in (
            ("side", 0, np.inf),
            ("density", 0, np.inf),
            ("friction", -1, np.inf),
            ("falling_distance", -1, 100),
            ("margin", -1, 0.5),
            ("settle_time", 0, np.inf),
            ("time_step", 0, 1),
            ("placement_scatter", -1, 1),
            ("yaw_constraint", -1, 1e6),
            ("lost_units", -1, 0.5),
        ):
            value = getattr(self, name)
            if isinstance(value, (bool, str)) or not np.isfinite(value) or not low < value <= high or (low == -1 and value < 0):
                words = f"> {low}" if low != -1 else ">= 0"
                raise InputError(f"placement: {name} = {value!r}; it must be a finite number {words}")
        for name in ("placement_offset_x", "placement_offset_y"):
            value = getattr(self, name)
            if isinstance(value, (bool, str)) or not abs(value) <= 1:
                raise InputError(f"placement: {name} = {value!r}; it must be a number from -1 to 1")
        for name, allowed in (("reference", ("layer", "blind")), ("shape", ("pieces", "hull"))):
            if getattr(self, name) not in allowed:
                raise InputError(f"placement: {name} = {getattr(self, name)!r}; it must be one of {', '.join(allowed)}")
        if self.layers > min(self.rows, self.columns):
            raise InputError(
                f"placement: layers = {self.layers} with {self.rows} rows and {self.columns} columns; every layer has one row "
                f"and one column less, so at most {min(self.rows, self.columns)} layers"
            )
        _ = self.settings  # checked now, not after minutes

    @property
    def unit(self):
        """The armour unit, a Cubipod of this side."""
        return Cubipod(side=self.side)

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

    def run(self, progress=None):
        """Place and measure all layers; ``progress(layer)`` is called after each. Returns a PlacementResult."""
        started = time.perf_counter()
        unit, shape, dn = self.unit, self.unit.shape(self.shape), self.unit.nominal_diameter
        generator = np.random.default_rng(self.seed)
        world = mb.World([mb.Gravity(9.81)], self.settings)
        self.bottom.add_to(world)
        margin, shift, envelope, level = self.margin * dn, np.zeros(2), 0.0, -np.inf
        records, readings, previous = [], [], []
        for layer in range(1, self.layers + 1):
            centres = self.grid.centres(self.rows, self.columns, layer) * dn + shift
            aims = placement.missed(self, centres, layer)
            if layer == 1:
                handles = placement.lay_first_layer(
                    world,
                    unit,
                    shape,
                    centres,
                    self.bottom,
                    self.grid.triangular,
                    generator,
                    self.density,
                    margin,
                    self.yaw_constraint,
                )
            else:
                lowest = self.bottom.height(*aims.T) + envelope + self.falling_distance * dn
                handles = placement.hang_layer(world, layer, shape, aims, lowest, generator, self.density)
            records.append(placement.settle_layer(world, layer, handles, self.bottom, level, self.settle_time))
            if self.reference == "layer":
                shift = shift + placement.reference_shift(handles, aims)
            heights = plates.envelope_heights(
                [*previous, *handles], self.bottom, plates.plate_centres(centres, dn, self.plates), dn, self.settings
            )
            if np.isnan(heights).all():
                raise InputError(
                    f"placement: no plate found a place on layer {layer}; too few units stand "
                    "(grid too wide, or friction too low)"
                )
            readings.append(heights)
            envelope, previous = float(np.nanmean(heights)), handles
            level = _level(records[-1], self.bottom)
            if progress is not None:
                progress(layer)
        return PlacementResult(
            self,
            tuple(readings),
            tuple(_poses(record) for record in records),
            tuple(replace(record, handles=()) for record in records),
            time.perf_counter() - started,
        )


def _level(record, bottom):
    """Median height of a layer's centres above the bottom [m]: units of the next layer that come to lie lower are lost."""
    place = np.array([handle.position for handle in record.handles])
    return float(np.median(place[:, 2] - bottom.height(*place[:, :2].T)))


def _poses(record):
    """Positions and orientations of a layer's units (n, 7)."""
    return np.array([np.concatenate([handle.position, handle.orientation]) for handle in record.handles])


@dataclass(frozen=True, eq=False)
class PlacementResult:
    """What a placement test gave: a frozen value.

    test; readings: per layer the plates' heights above the bottom [m], NaN where a plate found no rest; poses: per layer (n,
    7) positions [m] and orientations; records: how each layer came to rest; wall_seconds.
    """

    test: PlacementTest
    readings: tuple = field(repr=False)
    poses: tuple = field(repr=False)
    records: tuple = field(repr=False)
    wall_seconds: float = 0.0

    @cached_property
    def heights(self):
        """Mean height of the envelope after each layer [Dn], (M,)."""
        return np.array([np.nanmean(r) for r in self.readings]) / self.test.unit.nominal_diameter

    @cached_property
    def layer_coefficients(self):
        """k_j = (h_j - h_(j-1)) / Dn, Eq. (3), (M,)."""
        return np.diff(self.heights, prepend=0.0)

    @cached_property
    def cv(self):
        """Scatter of single plates: standard deviation of the readings of a layer over k_j Dn, (M,)."""
        dn = self.test.unit.nominal_diameter
        return (
            np.array([np.nanstd(r, ddof=1) / dn if np.isfinite(r).sum() > 1 else np.nan for r in self.readings])
            / self.layer_coefficients
        )

    @property
    def height_over_dn(self):
        """Total height [Dn], Eq. (14)."""
        return float(self.heights[-1])

    @cached_property
    def lost(self):
        """Units of each layer that fell out of it: centre below the median centre of the layer under it, (M,)."""
        heights = [p[:, 2] - self.test.bottom.height(*p[:, :2].T) for p in self.poses]
        return np.array([0] + [int((heights[j] < np.median(heights[j - 1])).sum()) for j in range(1, len(heights))])

    @property
    def porosity(self):
        """1 - n phi / sum k [-], from Eq. (2)."""
        return float(statistics.porosity(self.test.grid.packing_density, self.layer_coefficients))

    def to_dict(self):
        """The JSON of ``hlcs place``."""
        from hlcs.placement_files import placement_table

        test, dn = self.test, self.test.unit.nominal_diameter
        layers = [
            {
                "layer": j + 1,
                "k": float(k),
                "readings": int(np.isfinite(self.readings[j]).sum()),
                "cv": float(self.cv[j]),
                "units": len(self.poses[j]),
                "lost": int(self.lost[j]),
                "unsettled": self.records[j].unsettled,
            }
            for j, k in enumerate(self.layer_coefficients)
        ]
        return {
            "format": 1,
            "grid": test.grid.name,
            "spacing_x": test.grid.spacing_x,
            "spacing_y": test.grid.spacing_y,
            "seed": test.seed,
            "shape": test.shape,
            "nominal_diameter_m": dn,
            "layers": layers,
            "height_over_dn": self.height_over_dn,
            "porosity": self.porosity,
            "packing_density": test.grid.packing_density,
            "max_penetration_over_dn": max(r.penetration for r in self.records) / dn,
            "max_transient_penetration_over_dn": max(r.transient_penetration for r in self.records) / dn,
            "wall_seconds": self.wall_seconds,
            "unsolved_steps": sum(r.unsolved_steps for r in self.records),
            "steps": sum(r.steps for r in self.records),
            "settings": placement_table(test),
            "versions": files.versions(),
        }

    def to_dataframe(self):
        """One row a layer: layer, k, readings, cv, units, lost, unsettled."""
        import pandas as pd

        return pd.DataFrame(self.to_dict()["layers"])

    def save(self, folder):
        """Write layers.csv, result.json, poses.npz, settings.toml, scene.glb, structure.png and report.html into a folder;
        returns it."""
        from hlcs.results import save_placement

        return save_placement(self, folder)

    @staticmethod
    def load(folder):
        """The result that `save` wrote."""
        from hlcs.results import load_placement

        return load_placement(folder)

    def summary(self):
        """A few lines of text: the layers, the height, what was lost or did not settle."""
        data = self.to_dict()
        lines = [
            f"{data['grid']} grid, {len(self.poses)} layers, {sum(len(p) for p in self.poses)} units, shape {data['shape']}, "
            f"contact friction {self.test.friction:g}, seed {data['seed']}",
            "layer       k   plates      CV  units  lost  unsettled",
        ]
        lines += [
            f"{r['layer']:5d}  {r['k']:6.3f}  {r['readings']:6d}  {r['cv']:6.4f}  {r['units']:5d}  {r['lost']:4d}  "
            f"{r['unsettled']:9d}"
            for r in data["layers"]
        ]
        lines.append(
            f"height {data['height_over_dn']:.3f} Dn, porosity {data['porosity']:.3f}, "
            f"packing density {data['packing_density']:.3f}, deepest overlap {data['max_penetration_over_dn']:.1e} Dn, "
            f"{self.wall_seconds:.1f} s"
        )
        if data["unsolved_steps"]:
            lines.append(f"{data['unsolved_steps']} of {data['steps']} steps did not reach residual {self.test.tolerance:g}")
        return "\n".join(lines)

    __str__ = summary

    def _repr_html_(self):
        return f"<pre>{self.summary().splitlines()[0]}</pre>" + self.to_dataframe().to_html(index=False)
