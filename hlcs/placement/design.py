"""Which grid, how many layers and which units reach a height, how surely, and with how much concrete.

Every grid is placed `repeats` times, each time with another seed and another friction, spread evenly over what concrete on
concrete may have. A run of M layers gives the heights of 1, 2, .. M layers. What the heights are uncertain by is added up in
`hlcs.placement.design_budget`; the runs go through a store, so that they are made once.
"""

import warnings
from dataclasses import dataclass
from math import ceil, floor, isfinite, log10

import numpy as np

from hlcs.files.limits import unlikely
from hlcs.files.versions import versions
from hlcs.placement import run_queue, sea_bottom
from hlcs.placement.design_budget import FRICTIONS, Budget, Promise, budget_of, line_through, model_ratio
from hlcs.placement.grids import RPG, TPG, Grid
from hlcs.placement.printed_tables import laboratory
from hlcs.placement.procedure import RANGES, PlacementTest
from hlcs.placement.run_store import Store, key_of
from hlcs.placement.sea_bottom import Flat, Slope
from hlcs.placement.settings_table import settings_of
from hlcs.placement.single_run import result_of
from hlcs.placement.units import Cubipod
from hlcs.rendering import Result
from minibullet.errors import InputError, InputWarning, is_number, shown_value

CAMPAIGNS = (("table2", "TPG"), ("table2", "RPG"), ("table3", "TPG"))  # laboratory tests that the model is judged by
CAMPAIGN_REPEATS = 20  # runs beside each of them, seeds from 1: the same for every design, so that they are made once
THIN = 0.92  # least thickness of a layer above the second [Dn]: Table 2 has 0.915 to 0.984
FIRST_TWO = 1.32 + 1.05 - 2 * THIN  # by which the first two layers are thicker than that [Dn], Table 2, RPG
RESERVE = 1.06  # how much higher than wanted the highest structure is that is tried
MOST_LAYERS = 12  # 12 layers have 1,500 units and more, a minute or more a run
LEAST_REPEATS = 5  # a straight line and the scatter about it need so many
SECTION = 8  # least rows and columns of the first layer


@dataclass(frozen=True)
class Wanted:
    """What is asked for; InputError names what cannot be.

    height: of the structure above the bed [m]; or crest: its level above the datum of the bed [m]; nominal_diameters: of the
    units [m]; grids, bottom: as `PlacementTest` has them; probability: with which the height is to be reached; layers: most
    that are tried, None: as many as the height may need; rows, columns: of the first layer, None: 8, or 3 more than layers;
    repeats: runs of a grid; seed: of the first of them.
    """

    height: float | None = None
    crest: float | None = None
    nominal_diameters: tuple[float, ...] = ()
    grids: tuple[Grid, ...] = (TPG, RPG)
    bottom: object = "flat"
    probability: float = 0.95
    layers: int | None = None
    rows: int | None = None
    columns: int | None = None
    repeats: int = 20
    seed: int = 1

    def __post_init__(self):
        object.__setattr__(self, "bottom", sea_bottom.parse_bottom(self.bottom))
        object.__setattr__(self, "grids", tuple(map(Grid.parse, self.grids)))
        object.__setattr__(self, "nominal_diameters", tuple(dict.fromkeys(self.nominal_diameters)))
        if (self.height is None) == (self.crest is None):
            raise InputError("design: give either a height above the bed (--height) or a level of the crest (--crest)")
        for name, values in (("height", (self.height,)), ("nominal_diameter", self.nominal_diameters)):
            for value in values:
                if value is not None and not (is_number(value) and isfinite(value) and value > 0.0):
                    raise InputError(f"design: {name} = {shown_value(value)}; it must be a finite number > 0, in m")
        for size in self.nominal_diameters:
            if said := unlikely("side", Cubipod(nominal_diameter=size).side):
                warnings.warn(f"design: nominal_diameter = {size:g} m: a side of {said}", InputWarning, stacklevel=3)
        if self.crest is not None and not (is_number(self.crest) and isfinite(self.crest)):
            raise InputError(f"design: crest = {shown_value(self.crest)}; it must be a finite level above datum, in m")
        if not self.nominal_diameters:
            raise InputError("design: no size of unit; give --nominal-diameter, in m, once for every size that there is")
        if not (is_number(self.probability) and 0.5 <= self.probability < 1.0):
            raise InputError(f"design: probability = {shown_value(self.probability)}; it must be at least 0.5 and below 1")
        if not LEAST_REPEATS <= self.repeats <= 10_000:
            raise InputError(f"design: repeats = {self.repeats}; must be {LEAST_REPEATS} to 10000 to tell scatter from friction")

    @property
    def target(self):
        """The height or the level [m]."""
        return self.crest if self.height is None else self.height

    def layers_for(self, nominal_diameter):
        """Most layers that are tried of units of this size."""
        if self.layers is not None:
            return self.layers
        height = self.target - (0.0 if self.height is not None else float(self.bottom.height(0.0, 0.0)))
        if height <= 0.0:
            raise InputError(f"design: crest = {self.target:g} m is not above the middle of the bed, {self.target - height:g} m")
        found = max(1, ceil((RESERVE * height / nominal_diameter - FIRST_TWO) / THIN))
        if found > MOST_LAYERS:
            raise InputError(
                f"design: {height:g} m may need {found} layers of units of {nominal_diameter:g} m; at most {MOST_LAYERS} are "
                f"tried unasked: {_instead(height, found)}"
            )
        return found

    @property
    def any_size(self):
        """Whether one run stands for units of every size: on a flat bed all lengths scale with the unit."""
        return isinstance(self.bottom, Flat)

    def cases(self):
        """{(grid, nominal diameter): its tests}; InputError where such a test cannot be."""
        return {(grid, size): self.case(grid, size) for grid in self.grids for size in self.nominal_diameters}

    def case(self, grid, nominal_diameter):
        """The tests of a grid with units of this size."""
        layers = max(map(self.layers_for, self.nominal_diameters)) if self.any_size else self.layers_for(nominal_diameter)
        size = {"side": 1.0} if self.any_size else {"side": Cubipod(nominal_diameter=nominal_diameter).side}
        rows, columns = (given or max(SECTION, layers + 3) for given in (self.rows, self.columns))
        settings = {"grid": grid, "bottom": self.bottom, "layers": layers, "rows": rows, "columns": columns, **size}
        return repeated(self.repeats, self.seed, **settings)


def _instead(height, layers):
    """What can be typed where so many layers are not tried unasked for a height [m]."""
    most = RANGES["layers"][1]
    larger = f"take units of {_least_size(height, MOST_LAYERS)} m or more"
    if layers <= most:
        return f"{larger}, or say --layers {layers} and wait"
    return f"{larger}, or of {_least_size(height, most)} m or more with --layers {most}, the most that can be placed, and wait"


def _least_size(height, layers):
    """The smallest nominal diameter with which so many layers do for a height [m], rounded up to three digits, as text."""
    size = RESERVE * height / (THIN * layers + FIRST_TWO)
    step = 10.0 ** (floor(log10(size)) - 2)
    return f"{step * ceil(size / step):.3g}"


def frictions(count):
    """Contact friction of each of `count` runs: the middles of as many equal parts of FRICTIONS, (n,) [-]."""
    low, high = FRICTIONS
    return low + (high - low) * (np.arange(count) + 0.5) / count


def repeated(count, seed, **settings):
    """The PlacementTests of one case, one a friction, each with a seed of its own, from `seed` on."""
    return [PlacementTest(friction=float(f), seed=seed + k, **settings) for k, f in enumerate(frictions(count))]


def campaign_tests(table, grid):
    """The tests that stand beside a campaign of the laboratory."""
    measured = laboratory(table, grid=grid)
    bottom = Slope(measured.bottom_slope) if measured.bottom_slope else Flat()
    return repeated(CAMPAIGN_REPEATS, 1, grid=grid, bottom=bottom, layers=len(measured.mean), rows=SECTION, columns=SECTION)


@dataclass(frozen=True)
class Option:
    """One way to build it: a grid, a number of layers, a size of unit, and how surely it reaches the target."""

    grid: Grid
    layers: int
    nominal_diameter: float  # [m]
    budget: Budget
    lost_share: float  # of its units that fell out of their layer in the runs
    runs: int
    test: PlacementTest  # the first of its runs, with this many layers of this size
    promise: Promise | None  # what one more run reaches; None where fewer than three runs left a structure

    def to_dict(self):
        """Its row of the JSON: plain numbers, None where there is none."""
        per_square_metre = self.layers * self.grid.packing_density / self.nominal_diameter**2
        return {
            "grid": self.grid.name,
            "nominal_diameter_m": self.nominal_diameter,
            "spacing_x": self.grid.spacing_x,
            "spacing_y": self.grid.spacing_y,
            "layers": self.layers,
            **self.budget.to_dict(),
            "concrete_m3_per_m2": per_square_metre * self.nominal_diameter**3,
            "units_per_m2": per_square_metre,
            "lost_share": self.lost_share,
            "runs": self.runs,
        }


@dataclass(frozen=True, eq=False, repr=False)
class Design(Result):
    """What reaches a height: the options, cheapest in concrete first, and where the figures come from.

    wanted: Wanted; options: tuple of Option; ratio: the ModelRatio; ran, kept: runs made now, and found in the store; told: one
    line on rows of the store that are not used, or nothing.
    """

    wanted: Wanted
    options: tuple
    ratio: object
    ran: int = 0
    kept: int = 0
    told: str = ""

    @property
    def chosen(self):
        """Index of the option that reaches the target with the wanted probability and needs least concrete; None: none does."""
        good = (k for k, option in enumerate(self.options) if option.budget.reaches >= self.wanted.probability)
        return next(good, None)

    def to_dict(self):
        """The JSON of ``hlcs design``."""
        rows, sizes = [option.to_dict() for option in self.options], self.wanted.nominal_diameters
        chosen = self.chosen
        return {
            "format": 1,
            "height_m": self.wanted.height,
            "crest_level_m": self.wanted.crest,
            "nominal_diameter_m": sizes[0] if chosen is None else rows[chosen]["nominal_diameter_m"],
            "nominal_diameters_m": list(sizes),
            "probability": self.wanted.probability,
            "chosen": chosen,
            "options": rows,
            "model_error": self.ratio.to_dict(),
            "friction": list(FRICTIONS),
            "repeats": self.wanted.repeats,
            "seeds": [self.wanted.seed, self.wanted.seed + self.wanted.repeats - 1],
            "ran": self.ran,
            "kept": self.kept,
            "told": self.told,
            "versions": versions(),
        }

    def to_dataframe(self):
        """One row an option, as `to_dict` has them."""
        import pandas as pd

        rows = [option.to_dict() for option in self.options]
        return pd.DataFrame([{k: v for k, v in row.items() if k != "variance_shares"} | row["variance_shares"] for row in rows])


def design(wanted, store_path, workers=None, progress=None):
    """The Design for a `Wanted`; runs that the store does not hold are made now.

    store_path: file of finished runs; workers: processes; progress(total, kept) gives the function to be called as each run
    ends. InputError where the physics refuses a run, such as one beyond a survey.
    """
    cases = wanted.cases()
    campaigns = {campaign: campaign_tests(*campaign) for campaign in CAMPAIGNS}
    tests = {key_of(settings_of(test)): test for each in (*cases.values(), *campaigns.values()) for test in each}
    with Store(store_path, row_of) as store:
        missing = {key: test for key, test in tests.items() if key not in store}
        told, kept = run_queue.unused_rows(store, missing), len(tests) - len(missing)
        done = progress(len(tests), kept) if progress else None
        ran = run_queue.finish(store, missing, result_of, settings_of, workers, None, done, kept)
        rows = dict(zip(tests, run_queue.results(store, tests), strict=True))

    def runs_of(each):
        return [checked(rows[key_of(settings_of(test))], test) for test in each]

    tables = {campaign: laboratory(campaign[0], grid=campaign[1]) for campaign in CAMPAIGNS}
    ratio = model_ratio([(tables[c], [run["height_over_dn"][-1] for run in runs_of(each)]) for c, each in campaigns.items()])
    options = [
        _option(wanted, each, runs_of(each), size, layers, ratio)
        for (_, size), each in cases.items()
        for layers in range(max(1, wanted.layers_for(size) - 2), wanted.layers_for(size) + 1)
    ]
    options.sort(key=lambda option: option.layers * option.grid.packing_density * option.nominal_diameter)
    return Design(wanted, tuple(options), ratio, ran, len(tests) - ran, told)


def _option(wanted, tests, runs, size, layers, ratio):
    """The Option of the first `layers` layers of some runs, with units of a nominal diameter `size` [m]."""
    heights, crests = heights_of(wanted, runs, size, layers)
    friction = np.array([test.friction for test in tests])
    budget = budget_of(wanted, friction, heights, crests, ratio)
    known = np.isfinite(heights) & np.isfinite(crests)
    promise = Promise(line_through(friction[known], crests[known]), float(known.mean())) if known.sum() > 2 else None
    units, lost = (sum(sum(run[name][:layers]) for run in runs) for name in ("units", "lost"))
    unit = Cubipod(nominal_diameter=size)
    first = tests[0]
    shown = {"layers": layers, "side": unit.side}
    test = PlacementTest(
        grid=first.grid, bottom=first.bottom, rows=first.rows, columns=first.columns, friction=first.friction, **shown
    )
    return Option(first.grid, layers, size, budget, lost / units, len(runs), test, promise)


def heights_of(wanted, runs, size, layers):
    """Heights above the bed and, where a level was asked for, levels of the crest (else the heights) of runs that `row_of` gives,
    after so many layers of units of nominal diameter `size`: two arrays (n,) [m], NaN of a run that left none."""
    heights = np.array([run["height_over_dn"][layers - 1] for run in runs], dtype=float) * size
    if wanted.crest is None or wanted.any_size:  # a flat bed lies at the datum, whatever the size of the units
        return heights, heights
    return heights, np.array([run["level_m"][layers - 1] for run in runs], dtype=float)


def row_of(result):
    """What a design needs of a stored result; heights and levels after each layer are None where no plate found support."""
    if "error" in result:
        return {"error": str(result["error"])}
    heights = [[h for h in plates["height_over_dn"] if h is not None] for plates in result["plates"]]
    return {
        "height_over_dn": [sum(h) / len(h) if h else None for h in heights],
        "level_m": [row["level_m"] for row in result["layers"]],
        "units": [row["units"] for row in result["layers"]],
        "lost": [row["lost"] for row in result["layers"]],
    }


def checked(row, test):
    """The row; InputError where the physics refused the test."""
    if "error" in row:
        raise InputError(
            f"design: {test.grid.name} grid of units of {test.unit.nominal_diameter:.4g} m, seed {test.seed}: {row['error']}"
        )
    return row
