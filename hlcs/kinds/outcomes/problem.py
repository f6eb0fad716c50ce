"""Outcome tables (one number per experiment): the same search on rows in place of recordings. No start absorbs anything here."""

from dataclasses import replace

import numpy as np

from hlcs.data.combinations import fluids_told
from hlcs.data.quantities import OUTCOMES
from hlcs.data.rigid_body import known_body, known_to_drag
from hlcs.effects import as_stated, wanted
from hlcs.effects.body import InertiaError, MassOffset, SizeError
from hlcs.effects.candidates import each_session
from hlcs.effects.measurement import ClockOffset, LengthScale, TimeScale
from hlcs.effects.numerics import MarginOffset
from hlcs.effects.witnesses import Camera
from hlcs.estimation.adequacy import fit_adequacy
from hlcs.estimation.designs import Designs, other_bodies_tell
from hlcs.estimation.direct_problem import DirectProblem, Rows
from hlcs.estimation.linearization import Recording
from hlcs.estimation.whitening import whitening_of_settings
from hlcs.kinds.outcomes.checks import check_magnitude, check_table
from hlcs.kinds.outcomes.designs import ON_A_FLOOR, SLOPED, TOO_LONG, rows_of, said
from hlcs.kinds.outcomes.never import all_that_was_measured, told
from hlcs.kinds.outcomes.repeats import between_groups
from hlcs.kinds.outcomes.rolling import held_told
from hlcs.kinds.outcomes.row_noise import TableNoise, table_noise
from hlcs.kinds.outcomes.setting_errors import SettingErrors, of_inputs, outcomes_at, setting_errors, settings_at
from hlcs.kinds.protocol import Prepared, misses
from hlcs.selection.eligibility import NEEDS, eligible, stated, with_drag_that_fits
from hlcs.simulation import outcome_motion
from hlcs.simulation.model import Model
from hlcs.simulation.row_setups import row_setup, row_setups
from minibullet import effects
from minibullet.effects.contract import Need

FORCES = (
    effects.LinearDrag,
    effects.StokesDrag,
    effects.SphereDrag,
    effects.TubeDrag,
    effects.QuadraticDrag,
    effects.DragCrisis,
    effects.Buoyancy,
    effects.AddedMass,
    MassOffset,
    SizeError,
)
SLIDING = (
    effects.Friction,
    effects.StribeckFriction,
    effects.ViscousFriction,
    effects.LoadDependentFriction,
    effects.LinearDrag,
    effects.QuadraticDrag,
    MassOffset,
)
CLOCK = (ClockOffset, TimeScale)
FITTING = {  # what acts on each outcome
    "fall_time_s": (*FORCES, *CLOCK, LengthScale),
    "rebound_height_m": (*FORCES, effects.Restitution, effects.VelocityDependentRestitution, LengthScale),
    "stop_distance_m": (*SLIDING, LengthScale),
    "slide_time_s": (*SLIDING, effects.RollingFriction, InertiaError, *CLOCK, LengthScale),
    "rest_height_m": (SizeError, MarginOffset, LengthScale),
    "passage_time_s": (*FORCES, *CLOCK, LengthScale),
    "bounce_time_s": (*FORCES, *CLOCK, effects.Restitution, effects.VelocityDependentRestitution, LengthScale),
    "bounce_interval_s": (*FORCES, TimeScale, effects.Restitution, effects.VelocityDependentRestitution, LengthScale),
    "rebound_speed_m_s": (effects.Restitution, effects.VelocityDependentRestitution),
    "range_m": (*FORCES, effects.Magnus, effects.UniformFlow, LengthScale),
}
LENGTHS = ("height_m", "distance_m", "mark_2_m")
RULER = 1e-3  # [m]
LEGIBLE = 5.0  # standard deviations that an outcome must be above zero
SAME = 0.1  # part by which the error of a row may be another at the best model: no cost moves by more than a fifth
BLOCKS = 6  # contiguous blocks of the main input, held out alternately, where no groups are given


class TableProblem(DirectProblem):
    """Rows of an outcome table as independent observations."""

    subject = "what the body does"

    def __init__(self, file, table, scatter, groups=None, errors=None, never=None, own=None):
        """scatter: TableNoise; groups: Rows each, where rows are not held out together in the usual way; errors: SettingErrors,
        None = none; never: rows whose outcome never comes under the model under test (n,), None = none; own: standard
        deviation of a row of each setting by itself (d,), None = that at the means that were measured."""
        self.file, self.table, self.scatter, self.values = file, table, scatter, table.values
        self.noise = scatter.noise
        _, first, self.back = np.unique(table.setting, return_index=True, return_inverse=True)
        self.never = np.zeros(len(table.values), bool) if never is None else never
        self.setups = [row_setup(file, table.inputs, row) for row in first]
        self.distinct = {name: values[first] for name, values in table.inputs.items()}
        self.errors = errors or SettingErrors(np.zeros(len(first)))
        self.own = scatter.of_settings(table) if own is None else own
        self.trials = row_groups(file, table, self.errors.deviation.any()) if groups is None else groups
        self.shared_doubt = self.errors.doubt
        self.recordings = [self._record(group) for group in self.trials]
        self.unit = OUTCOMES[table.outcome]
        self.predicted, self.difference_steps = {}, {}

    def _record(self, group):
        count = len(group.rows)
        common, own = self.errors.deviation[self.back[group.rows]], self.own[self.back[group.rows]]
        if common.any():
            whitening = whitening_of_settings(self.back[group.rows], own, common)
        else:
            whitening = self.noise.whitening(np.zeros(count, int), np.arange(count) * 1.0)._replace(sigma=own)
        return Recording(np.zeros(count, int), group.rows, np.arange(count) * 1.0, whitening, ())

    @property
    def measured(self):
        """The settings: what repeats one says no more of the law."""
        return len(self.setups)

    def predict(self, model):
        """Outcomes of all rows, (n,); nan where one never comes, zero where the model under test says that too (`never`)."""
        if model.terms not in self.predicted:  # the rest of the model is the file's and stays
            groups = np.unique(self.table.groups if model.by_session else "")
            setups = [replace(setup, session=str(group)) for group in groups for setup in self.setups]
            inputs = {name: np.tile(values, len(groups)) for name, values in self.distinct.items()}
            with np.errstate(all="ignore"):
                distinct = outcome_motion.outcomes(model, setups, inputs, self.table.outcome).reshape(len(groups), -1)
            of_row = np.searchsorted(groups, self.table.groups) if model.by_session else 0
            self.predicted[model.terms] = all_that_was_measured(distinct[of_row, self.back], self.values, self.never)
        return self.predicted[model.terms]

    def linearise(self, model, initial_states):
        found = super().linearise(model, initial_states)
        # a number a little aside may lose an outcome: no outcome, no derivative
        return replace(found, parameter_columns=[np.nan_to_num(part) for part in found.parameter_columns])

    @property
    def sigmas(self):
        """Standard deviation of each row, errors of its setting included (n,)."""
        return np.hypot(self.own, self.errors.deviation)[self.back]

    @property
    def noise_level(self):
        return float(np.sqrt(np.mean(self.sigmas**2)))

    def beside(self, model):
        """The problem with the scatter of its rows and the errors of its inputs as another model has them; itself where they stay
        within SAME."""
        expected = outcomes_at(self.file, self.table, model)
        own = self.scatter.of_settings(self.table, expected)
        errors = setting_errors(self.file, self.table, own, model, expected)
        moved = np.hypot(own, errors.deviation) / np.hypot(self.own, self.errors.deviation)
        if np.all(np.abs(moved - 1) < SAME):
            return self
        return TableProblem(self.file, self.table, self.scatter, errors=errors, never=self.never, own=own)

    def with_noise(self, noise):
        """The same problem with another Noise of a row."""
        return TableProblem(self.file, self.table, TableNoise(noise), self.trials, self.errors, self.never)

    def with_inputs(self, table):
        """The same problem with a table of other inputs, in the same settings."""
        return TableProblem(self.file, table, self.scatter, self.trials, self.errors, self.never, self.own)

    # --- the next experiment --------------------------------------------------------------------------------------------------

    @property
    def camera(self):
        """What a direct reading depends on: a ruler over the longest way, a clock as sharp as that of the table."""
        table, ways = self.table, [self.table.inputs[name] for name in LENGTHS if name in self.table.inputs]
        ways += [table.values] if self.unit == "m" else []
        sliding = table.outcome in (*ON_A_FLOOR, "rest_height_m")
        return Camera(
            RULER,
            np.sqrt(12) * self.noise.position,
            max((float(np.max(way)) for way in ways), default=1.0),
            filmed=False,
            upright=False,
            touching=sliding,
            level=sliding and not any(np.any(table.inputs.get(name, 0.0)) for name in SLOPED),
            liquid=self.file.surroundings.in_liquid,
        )

    def designs(self, final, other):
        """Designs that tell two fits apart: further rows, with outcomes that can be read and are not far from those there."""
        found = rows_of(self.file, self.table, other_bodies_tell((*final.model.terms, *other.model.terms)))
        problem = self.with_rows([row for _, row in found], final.model)
        low, high = LEGIBLE * self.own.min(), TOO_LONG * float(np.max(np.abs(self.table.values)))
        outcomes = np.array([problem.predict(fit.model) for fit in (final, other)])
        kept = [k for k in range(len(found)) if np.all((outcomes[:, k] > low) & (outcomes[:, k] < high))]
        problem = self.with_rows([found[k][1] for k in kept], final.model)
        return Designs(problem, problem.initial_guess(), tuple(found[k][0] for k in kept))

    def with_rows(self, rows, model):
        """The problem that rows {input: value} pose, each by itself; model: at which errors of inputs are propagated."""
        count = len(rows)
        inputs = {name: np.array([row[name] for row in rows]) for name in (rows[0] if rows else ())}
        each, names = np.arange(count), np.array([f"row {k}" for k in range(count)])
        usual = {name: np.full(count, np.median(sd)) for name, sd in self.table.input_sd.items() if name in inputs}
        foretold = np.zeros(count)
        if count and self.scatter.share:  # what is read there tells how far it scatters
            foretold = np.nan_to_num(settings_at(self.file, self.table, model, inputs, count))
        new = dict(values=foretold, inputs=inputs, groups=names, setting=each, rows=each, notes=(), input_sd=usual)
        table = replace(self.table, **new)
        body, surroundings = self.file.body, self.file.surroundings
        groups = tuple(Rows(str(name), each[k : k + 1], body, surroundings) for k, name in enumerate(names))
        errors = SettingErrors(of_inputs(self.file, table, model)) if count and usual else None
        return TableProblem(self.file, table, self.scatter, groups, errors)

    def by_row(self, fit):
        """What a fit leaves of the outcome of each row, in their order (n,) [unit of the outcome]."""
        raw = np.empty(len(self.values))
        raw[np.concatenate([group.rows for group in self.trials])] = np.concatenate(fit.linearization.raw)
        return raw

    def worst(self, fit):
        """(where a fit misses most, in words; the same as {input: value})."""
        raw = self.by_row(fit)
        settings = [(raw[self.back == k], self.own[k], self.errors.deviation[k]) for k in range(len(self.setups))]
        misses = [float(np.mean(part) / np.hypot(own / np.sqrt(len(part)), shared)) for part, own, shared in settings]
        index = int(np.argmax(np.abs(misses)))
        row = {name: float(values[index]) for name, values in self.distinct.items()}
        at = f"the rows {said(row, self.table.outcome)}" if row else "the rows"
        return f"{at} (whose mean the model misses by {abs(misses[index]):.2g} standard errors)", row


def row_groups(file, table, whole=False):
    """Groups of rows, or contiguous blocks of the main input where the table has none: tuple of Rows.

    whole: rows of one setting share an error, so they stay together; where groups part them, blocks are taken.
    """
    names = np.unique(table.groups)
    if not 2 <= len(names) < len(table.values) or whole and parted(table):
        main = table.inputs.get(table.main, np.arange(len(table.values)))
        order = np.argsort(main, kind="stable")
        labels = np.empty(len(main), int)
        settings = list(dict.fromkeys(table.setting[order].tolist()))
        for place, setting in enumerate(settings):
            labels[table.setting == setting] = place * min(BLOCKS, len(settings)) // len(settings)
        groups = np.array([f"block {label + 1}" for label in labels])
        names = np.unique(groups)
    else:
        groups = table.groups
    return tuple(Rows(str(name), np.flatnonzero(groups == name), file.body, file.surroundings) for name in names)


def parted(table):
    """Do rows of one setting stand in different groups?"""
    return len(set(zip(table.setting.tolist(), table.groups.tolist(), strict=True))) > len(np.unique(table.setting))


def fastest_rows(file, table):
    """The highest speed that each row saw, about (n,) [m/s]: that of a free fall at its end where the time is that of a free one,
    the mean where it took much longer: then it is near its final speed, and the gain over the mean goes as 1/time^2."""
    inputs, none, gravity = table.inputs, np.zeros(1), file.surroundings.gravity
    way, begin = inputs.get("height_m", inputs.get("mark_2_m", none)), inputs.get("mark_1_m", none)
    free = np.sqrt(2 * gravity * way)
    if table.outcome in ("fall_time_s", "passage_time_s"):
        shortest, passed = (free - np.sqrt(2 * gravity * begin)) / gravity, np.maximum(way - begin, 1e-12)
        gain = (free * shortest / passed - 1) * np.minimum(shortest / np.maximum(table.values, 1e-9), 1.0) ** 2
        free = np.minimum(free, passed / np.maximum(table.values, 1e-9) * (1 + gain))
    begun = [np.abs(inputs.get(name, none)) for name in ("speed_m_s", "start_speed_m_s", "impact_speed_m_s")]
    return np.sqrt(sum(speed**2 for speed in (np.zeros(len(table.values)), free, *begun)))  # what falls gains on its launch


def table_candidates(file, table, names, own):
    """(candidates, {name: why not}) for an outcome table; where its groups differ, a clock offset is another one in each: persons
    have their own reaction times, and share a ruler."""
    inputs, speeds = table.inputs, fastest_rows(file, table)
    sizes, densities = (inputs.get(name, 1.0) for name in ("radius_m", "fluid_density_kg_m3"))
    row = int(np.argmax(speeds * sizes * densities))  # that of the largest Reynolds number speaks for all
    largest, speed = row_setup(file, inputs, row), float(speeds[row])
    body, surroundings = largest.body, largest.surroundings  # what a column states counts as what a key does
    met = {
        Need.FLUID: surroundings.fluid_density,
        Need.MASS_AND_SIZE: known_body(body),
        Need.SIZE: body.sized,
        Need.TUBE: surroundings.walled,
        Need.SPHERE: body.shape == "sphere",
        Need.EDGES: body.shape != "sphere",
        Need.UNLIKE_LOADS: "mass_kg" in inputs,
        Need.SPIN: bool(np.any(inputs.get("spin_rad_s", 0.0))),
    }
    extent = float(max((np.max(inputs[name]) for name in LENGTHS if name in inputs), default=1.0))

    def obstacle(kind):
        if kind not in own and kind not in FITTING[table.outcome]:
            return f"not known to change {table.outcome}"
        if missing := next((need for need in kind.needs if not met.get(need, True)), None):
            return NEEDS[missing][0]
        if kind in (effects.RollingFriction, InertiaError) and body.shape != "sphere":
            return "no other body than a sphere rolls"
        if kind is ClockOffset and np.any(inputs.get("mark_1_m", 0.0)):
            return "its clock starts at the first mark"
        return None

    entries = as_stated(file.effects, row_setups(file, table), own)
    why = with_drag_that_fits({kind: obstacle(kind) for kind in wanted(names, own)}, body, surroundings, speed)
    why = {kind: stated(kind, entries, own) or text for kind, text in why.items()}
    found, absent = eligible(why, entries, body, surroundings, known_to_drag(body), own, extent, speed)
    sessions = np.unique(table.groups).tolist() if between_groups(table).seen else ()
    found = [_called(entry, table) for entry in found]
    return [each_session(entry, sessions) if getattr(entry.kind, "by_person", False) else entry for entry in found], absent


def _called(entry, table):
    """A Candidate as a table calls it: one ruler that told a length beforehand and the outcome alike shows no scale."""
    beside = next((name for name in LENGTHS if name in table.inputs), None)
    if entry.kind is not LengthScale or OUTCOMES[table.outcome] != "m" or beside is None:
        return entry
    return replace(entry, words=f"a wrong scale of {table.outcome}, not of {beside}")


def prepare_table(file, table, own=()):
    """The table Prepared: its noise, its problem and the fit of the model under test."""
    check_table(file, table, own)
    scatter = table_noise(file, table)
    noise = scatter.noise
    model = Model(fixed=file.effects, own=tuple(own))
    model.changes(file.surroundings)
    expected = outcomes_at(file, table, model)
    check_magnitude(file, table, expected)
    if noise.position is None:
        return Prepared(noise, None, None, table.notes)
    sigma = scatter.of_settings(table, expected)
    errors = setting_errors(file, table, sigma, model, expected)
    problem = TableProblem(file, table, scatter, errors=errors, never=np.isnan(expected), own=sigma)
    return posed(problem, model)


def posed(problem, model):
    """The Prepared of a problem and the model under test."""
    notes = (
        *problem.table.notes,
        *fluids_told(problem.file, problem.setups),
        *problem.scatter.notes(problem.table),
        *told(problem.table, problem.never),
        *held_told(problem, model),
        *problem.errors.notes,
    )
    if problem.errors.deviation.any() and len(np.unique(problem.table.groups)) < len(problem.values) and parted(problem.table):
        notes += (
            "rows of one setting share an error and stand in different groups: blocks of settings are held out, not groups",
        )
    return Prepared(problem.noise, problem, problem.fit(model), notes)


def judge_table(problem, fit):
    """Adequacy of a fit (lack of fit by setting, slow misfit along the main input) and the table of observations."""
    table, rows = problem.table, np.concatenate([group.rows for group in problem.trials])
    main = table.inputs.get(table.main, np.zeros(len(table.values)))
    _, which, count = np.unique(main[rows], return_inverse=True, return_counts=True)
    order = (np.cumsum(count) - count / 2)[which]  # rows of one value, sorted by what they read, stay together
    settings = len(np.unique(table.setting))
    partitions = {"lack of fit by setting": table.setting[rows]}
    for parts in (3, 6):
        if settings >= 2 * parts:
            partitions[f"{parts} ranges of the main input"] = (order * parts // len(order)).astype(int)
    judged = fit_adequacy(problem, fit, partitions)
    raw = np.concatenate(fit.linearization.raw)
    columns = {
        "trial": np.concatenate([np.full(len(group.rows), k) for k, group in enumerate(problem.trials)]),
        "channel": np.zeros(len(rows), int),
        "row": table.rows[rows],
        "input": main[rows],
        "measured": table.values[rows],
        "model": np.where(problem.never[rows], np.nan, table.values[rows] - raw),
        "residual": raw,
        "sigmas": raw / problem.sigmas[rows],
        "white": np.concatenate(fit.linearization.projected[0]),
    }
    return judged, {**{name: values[rows] for name, values in table.inputs.items()}, **columns}


def where_in_table(problem, table):
    """Rows {trial, channel, phase, rms, sigma, ...} by value of the main input, the worst first."""
    name = problem.table.main or "row"
    where = []
    for value in np.unique(table["input"]):
        inside = table["input"] == value
        mean = float(np.mean(table["residual"][inside]))
        row = {"trial": f"{name} = {value:g}", "channel": problem.table.outcome, "phase": "table"}
        where.append({**row, **misses(table, inside), "mean": mean})
    return tuple(sorted(where, key=lambda row: (-row["sigma"], row["trial"])))
