"""Learn the missing law: which variable carries the force that no known effect explains, and in which form."""

from dataclasses import replace
from itertools import combinations

import numpy as np

from hlcs.data.rigid_body import rigid_body
from hlcs.effects import candidate
from hlcs.estimation.whitening import colour
from hlcs.learning.flights import flights_of, rows_with_force
from hlcs.learning.laws import AXES, NEEDED, Ranges, knots_of, laws, one_law, seen
from hlcs.learning.learned import QUANTILE, Learned, beside_last, interval, left_with, sentence
from hlcs.learning.regression import Regression
from hlcs.selection.thresholds import NOISE, TIED
from hlcs.simulation.model import Term

FEWEST = 3  # flights: two of them must foretell a third
CURVED = 0.05  # share of the force's chi2 that a table may miss beside: straight lines between knots are not the curve
SEEN = 5.0  # standard deviations of chi2 by which the force must stand above the noise
STEP = 1 / 240  # of the simulation of a law that swings or goes on and off [s]
SUDDEN = ("oscillation", "switch")  # forms that longer steps would pass over
SWUNG = 0.5  # share of what an oscillation takes away that its swing must hold itself: else a drift beside it does the work
FORMS = ("power", "oscillation", "switch", "exponential", "table")  # where several do as well: from the plainest on
DRAWN = 100  # places at which a law is told, to be drawn


def learn(problem, fit):
    """What the recordings of a TrajectoryProblem show of the force that a Fit of the best known effects lacks: Learned or None.

    None where they show no force, where no law of one variable foretells recordings held out, or where these are too few.
    """
    if any(trial.accelerations for trial in problem.trials):
        return None  # the law is read from positions
    flights = flights_of(problem, fit)
    if len(flights) < FEWEST or len({flight.part.group for flight in flights}) < 2:
        return None
    force = Force(flights)
    if not force.seen:
        return None
    regression = Regression(flights, force.size)
    ranges = _ranges(problem, regression)
    ranked = [
        one
        for one in regression.fits(laws(*ranges), force.explained_by, TIED)
        if force.explained_by(one.law, one.missed, one.unforetold) and _does_it_by_swinging(regression, one, ranges[1].measured)
    ]
    if not ranked:
        return None
    best = _plainest(ranked)
    alike = dict.fromkeys(one.law.variable for one in ranked if one.score < ranked[0].score + TIED)
    also = [variable for variable in alike if variable != best.law.variable]
    return _learned(problem, fit, regression, ranges, _fewest_axes(regression, best, ranges), also)


class Force:
    """How far the force stands above the noise, in those rows of the residuals where it does."""

    def __init__(self, flights):
        residual = np.concatenate([flight.residual for flight in flights])
        self.rows = rows_with_force(flights)
        self.noise = np.sqrt(2 * self.rows.sum())  # standard deviation of chi2
        strength = np.concatenate([flight.strength for flight in flights])
        moments = sum(3 * len(flight.times) for flight in flights)
        self.size = float(np.sqrt(max(self.excess(residual / strength, 1 / strength**2), 0.0) / moments))  # RMS [m/s2]
        self.seen = self.size > 0 and self.excess(residual) > SEEN * self.noise

    def excess(self, residual, noise=1.0):
        """Sum of squares of these rows beyond that of noise, of its variance (rows,)."""
        return float(np.sum((residual**2 - noise)[self.rows]))

    def explained_by(self, law, left, without):
        """Is what a law leaves (rows,) noise, where there is a force without it?"""
        excess = self.excess(without)
        return excess > SEEN * self.noise and self.excess(left) < NOISE * self.noise + CURVED * excess * (law.form == "table")


def _does_it_by_swinging(regression, one, measured):
    """Does a law that is an oscillation take away what it does by its swing? Any other law does what it does.

    A force that swings from the start on also carries a body away, A w t beside A cos(w t): with a high frequency that drift is a
    wrong start, and the swing beside it hardly a millimetre of the error.
    """
    if one.law.form != "oscillation":
        return True
    linear, _ = regression.estimate(one.law, one.searched)
    swings = linear.reshape(len(regression.flights) if one.law.own_phases else 1, -1)
    errors = _errors(regression, one.foretold)
    seen_along = [number.name[-1] in measured for number in one.law.linear[::2]]
    swung = float(np.sum(seen_along * _sizes(swings, one.searched) ** 2)) / 2 / len(measured)  # mean square of the observations
    return swung > SWUNG * (errors["before"] ** 2 - errors["after"] ** 2)


def _plainest(ranked):
    """Of the laws of the best variable that do as well as the best one, that of the form that comes first in FORMS."""
    best = ranked[0]
    alike = [one for one in ranked if one.law.variable == best.law.variable and one.score < best.score + TIED]
    return min(alike, key=lambda one: FORMS.index(one.law.form))


def _fewest_axes(regression, best, ranges):
    """The law with the axes left out along which it shows no strength, by Schwarz's criterion."""
    if best.law.way != "axes":
        return best

    def cost(axes):
        one = one_law(best.law.variable, best.law.form, "axes", ranges[0][best.law.variable], ranges[1], axes)
        one = replace(one, own_phases=best.law.own_phases)
        left = regression.left(one, one.kind(), best.searched)
        count = len(one.linear) * (len(regression.flights) if one.own_phases else 1)
        return float(left @ left) + count * np.log(len(left)), axes, replace(best, law=one)

    chosen = ["".join(axes) for count in (1, 2, 3) for axes in combinations(AXES, count)]
    return min(map(cost, chosen), key=lambda choice: choice[0])[-1]


def _learned(problem, fit, regression, ranges, best, also):
    """The Learned law, its numbers refitted through the simulator where it is an effect; None where recordings that these were
    not fitted to are foretold no better by it, or where the simulator contradicts it."""
    law = best.law
    linear, spread = regression.estimate(law, best.searched)
    errors, axes = _errors(regression, best.foretold), ranges[1].measured
    if not errors["after"] < errors["before"]:
        return None
    if law.own_phases:
        numbers = _swings(law, linear.reshape(len(regression.flights), -1), best.searched, spread)
        return Learned("time", law.form, numbers, sentence(law, numbers, None, also, axes), "", errors, {}, tuple(also))
    refit = _refitted(problem, fit, law.at(linear, best.searched))
    if not refit.chi2 < fit.chi2:
        return None
    place, count = refit.numbers_of(-1), len(law.linear)
    values, covariance = refit.estimate[place], max(refit.chi2_per_freedom, 1.0) * refit.covariance[place, place]
    law, spread = law.at(values[:count], values[count:]), np.sqrt(np.diag(covariance))
    numbers = {number.name: interval(number.value, error, number.unit) for number, error in zip(law.fitted, spread, strict=True)}
    if law.form == "oscillation":
        numbers = _swings(law, values[None, :count], values[count:], spread)
    text, band = sentence(law, numbers, law.direction, also, axes), _band(regression, law, ranges)
    told = law.variable, law.form, numbers, text, law.source(text), errors, band, tuple(also)
    return Learned(*told, refit, beside_last(refit), left_with(problem, refit))


def _band(regression, law, ranges):
    """The force per mass as a table of the law's variable {grid, value, low, high}, (k,) each, and as the law has it {places,
    law}, (m,) each, where it is no table; {} of an oscillation."""
    if law.form == "oscillation":
        return {}
    values, searched = ranges[0][law.variable], ()
    if law.way == "point":
        searched = [number.value for number in law.searched if number.name.startswith("point")]
        values = np.linalg.norm(regression.bodies.position - searched, axis=1)
    elif law.direction is not None:
        searched = np.arctan2(law.direction[1], law.direction[0]), np.arcsin(np.clip(law.direction[2], -1.0, 1.0))
    free = ranges[1]._replace(measured=AXES)  # its direction is that of the law
    table = one_law(law.variable, "table", "axes" if law.way == "direction" else law.way, values, free)
    found, _ = regression.solve(table, table.kind(), searched)
    grid, count = knots_of(values), len(table.linear)
    rows = np.eye(count) if table.knots else np.column_stack([grid**0] + [f(k * grid) for k in (1, 2) for f in (np.cos, np.sin)])
    error = QUANTILE * np.sqrt(np.einsum("ki,ij,kj->k", rows, found.covariance[:count, :count], rows))
    value = rows @ found.estimate[:count]
    places = np.linspace(grid[0], grid[-1], DRAWN)
    of_law = {} if law.form == "table" else {"places": places, "law": law.force_at(places)}
    return {"grid": grid, "value": value, "low": value - error, "high": value + error} | of_law


def _refitted(problem, fit, law):
    """Fit of the model with the law in it, through the simulator, in flight in steps from sample to sample at most: it was read
    there. Through contacts in those that the error of the step is known of."""
    trial, simulator = problem.trials[0], problem.simulator
    kind = candidate(law.kind(), trial.surroundings, rigid_body(trial.body), True, own=True)
    term = Term(kind, ()).at({number.name: number.value for number in law.fitted})
    step = simulator.time_step
    shortest = STEP if law.form in SUDDEN else min(np.median(np.diff(trial.times)) for trial in problem.trials)
    try:
        simulator.time_step = step if simulator.contact else min(step, shortest)
        return problem.fit(fit.model.with_term(term), fit.initial_states)
    finally:
        simulator.time_step = step


def _per_metre(searched):
    """Acceleration of a swing of one metre at the frequency that was searched [1/s2]."""
    return (2 * np.pi * searched[0]) ** 2


def _sizes(swings, searched):
    """Amplitude along each axis (axes,) [m], root mean square over recordings; swings: as in `_swings`."""
    return np.sqrt(np.mean(swings[:, ::2] ** 2 + swings[:, 1::2] ** 2, axis=0)) / _per_metre(searched)


def _swings(law, swings, searched, spread):
    """Numbers of an oscillation: its frequency and, along each axis, how far it moves what is seen.

    swings: of cosine and sine along each axis, of each recording or of all (k, 2 axes) [m/s2]; spread: standard deviations.
    """
    (frequency,), turns = searched, _per_metre(searched)
    numbers = {"frequency_hz": interval(frequency, spread[-1], "Hz")}
    sizes = _sizes(swings, searched)
    errors = np.sqrt(np.mean(spread[:-1].reshape(len(swings), -1) ** 2, axis=0))[::2] / turns / np.sqrt(len(swings))
    for number, size, error in zip(law.linear[::2], sizes, errors, strict=True):
        numbers[f"amplitude_{number.name[-1]}"] = interval(size, error, "m")
    return numbers


def _errors(regression, foretold):
    """RMS of the positions before, and after with the numbers of the other recordings, in their unit.

    foretold: what these leave of the rows of the regression; what no force can cause stays as it is.
    """
    flights = regression.flights
    gone = np.split(regression.residual - foretold, np.cumsum([len(flight.residual) for flight in flights])[:-1])

    def rms(white):
        parts = [flight.part for flight in flights]
        raw = [colour(part.whitening, values)[part.channel < 3] for part, values in zip(parts, white, strict=True)]
        return float(np.sqrt(np.mean(np.concatenate(raw) ** 2)))

    after = [flight.part.white - flight.rows @ change for flight, change in zip(flights, gone, strict=True)]
    return {"before": rms([flight.part.white for flight in flights]), "after": rms(after)}


def _ranges(problem, regression):
    """(variable -> its values, Ranges) of the data."""
    flights, position = regression.flights, regression.bodies.position
    box = np.array([position.min(axis=0), position.max(axis=0)])
    values = seen(regression.bodies, regression.times) | {"distance": np.array([0.0, np.linalg.norm(box[1] - box[0])])}
    if not any((recording.channel >= 3).any() for recording in problem.recordings):
        del values["spin"]
    known = np.unique(np.concatenate([flight.part.channel for flight in flights]))
    measured = "".join(AXES[channel] for channel in known if channel < 3)  # axes along which positions were, such as "xz"
    values = {name: known for name, known in values.items() if set(NEEDED.get(name, "")) <= set(measured)}
    step = max(float(np.median(np.diff(trial.times))) for trial in problem.trials)
    shortest = min(float(np.ptp(flight.times)) for flight in flights)
    # an oscillation comes back one and a half times: a slower one is any force that changes once; four frames a period show it
    return values, Ranges(box, float(values["time"].max()), 1.5 / shortest, 0.25 / step, measured)
