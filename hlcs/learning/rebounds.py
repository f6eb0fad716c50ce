"""The law by which rebounds depend on the speed of the impact, where none of the known effects is it.

Impacts show it without any engine, rows of a table beside the model: restitution against speed of approach. What they show is
written as an effect, and fitted to the data through the simulator.
"""

from dataclasses import replace
from functools import partial

import numpy as np
from scipy import optimize

import minibullet as mb
from hlcs.data.rigid_body import rigid_body
from hlcs.data.shown_by_impacts import mean_and_trend, rebounds_among
from hlcs.effects import candidate
from hlcs.estimation.cross_validation import CrossValidation
from hlcs.learning.learned import QUANTILE, Learned, beside_last, interval, left_with
from hlcs.report.words import value as number_told
from hlcs.selection.thresholds import HELPS
from hlcs.simulation.model import Term
from minibullet.effects.catalogue import module_of
from minibullet.errors import InputError

FEWEST = 8  # impacts that show a law of three numbers, and whether it is one
SHOWN = 5.0  # standard errors by which their restitution must change with speed
LEAVES = 0.1  # part of what the best known effects leave beyond noise that may be left with the law: real ones are not just so
FLATTEST, STEEPEST = 0.1, 4.0  # exponents: toward 0 as the library's power; above 4 the fastest impacts alone show it
LAWS = ("restitution", "velocity_dependent_restitution", "learned_restitution")  # in whose place it stands
GROUPS = 8  # of impacts of like speed, to be drawn
DRAWN = 60  # places at which the law is told, to be drawn
SOURCE = '''"""Restitution as a function of the speed of the impact, as learned from measurements. {text}"""

from dataclasses import dataclass

import minibullet as mb
import numpy as np


@dataclass(frozen=True)
class LearnedRestitution(mb.Effect):
    """{text}"""

    change: float = mb.parameter({change!r}, unit="-", low=-1.0, high=1.0, least=-1.0, most=1.0, null=0.0)
    exponent: float = mb.parameter({exponent!r}, unit="-", {ends})
    reference: float = mb.parameter({reference!r}, unit="m/s", given=True)
    group = "contact_normal"

    def at(self, restitution, speed):
        return np.clip(restitution + self.change * ((speed / self.reference) ** self.exponent - 1.0), 0.0, 1.0)

    def contact_law(self, contacts, bodies, law):
        speed = np.maximum(-(contacts.velocity * contacts.normal).sum(axis=1), 0.0)
        return law._replace(restitution=self.at(law.restitution, speed))
'''


def learn_rebounds(problem, fit, best, readings, polished, hold_out):
    """The Learned restitution e = e_r + c ((v/v_r)^n - 1) of impacts at a speed v [m/s], in place of what a Fit has of it; n = 1
    is a straight line. best: Fit of the best known effects; readings: [(restitution, its error, speed [m/s])] of impacts;
    polished: (problem, fit) -> the fit without the error of the step; hold_out: as in the experiment file.

    None where the impacts show no change with speed, where bodies or floors differ or the file has another law of its own, where
    the law leaves more than LEAVES of what the best fit leaves beyond noise, or foretells less than HELPS of it in other data.
    """
    readings = () if _unlike(problem.trials, fit.model) else _changing(readings)
    cross_validation = CrossValidation(problem.trials, hold_out)
    if not readings or not cross_validation.possible:
        return None
    values, errors, speeds = readings
    reference = float(np.median(speeds))
    try:
        found = _refitted(problem, fit, _read(values, errors, speeds, reference), reference)
    except InputError:  # what cannot be simulated with it loses no verdict
        return None
    before, after = (problem.error(cross_validation.residuals(each)) for each in (best, found))
    foretold = before**2 - after**2 > HELPS * (before**2 - problem.noise_level**2)
    if found.chi2 - found.freedom > LEAVES * (best.chi2 - best.freedom) or not foretold:
        return None
    return _told(problem, polished(problem, found), readings, reference, {"before": before, "after": after})


def _unlike(trials, model):
    """Do trials differ in what rebounds, or does the file's own model hold a law of restitution other than a constant?"""
    known = {entry["name"] for entry in model.fixed} & set(LAWS[1:])
    return bool(known) or len({(trial.body, trial.surroundings.restitution) for trial in trials}) > 1


def _changing(readings):
    """(values, errors, speeds), (n,) each, of the rebounds among readings [(value, error, speed)]; () where they are few, or
    change little with speed."""
    if len(readings) < FEWEST:
        return ()
    rebounds = rebounds_among(*map(np.array, zip(*readings, strict=True)))
    trend, error = mean_and_trend(*rebounds)[2:] if len(rebounds[0]) >= FEWEST else (None, None)
    return () if trend is None or abs(trend) < SHOWN * error else rebounds


def _told(problem, fit, readings, reference, held_out):
    """The Learned law of the last term of a Fit."""
    (values, errors, speeds), (level, own) = readings, fit.model.terms[-2:]
    found = {"restitution": level.numbers["coefficient"]} | own.numbers
    spread = np.sqrt(np.diag(fit.covariance_at(max(fit.chi2_per_freedom, 1.0)))[-len(found) :])
    numbers = {name: interval(value, error, "1") for (name, value), error in zip(found.items(), spread, strict=True)}
    of_law = partial(_kind(reference, **own.numbers)().at, found["restitution"])
    text = _sentence(numbers, reference, speeds, of_law)
    told = text, _source(text, reference, **own.numbers), held_out, _band(values, errors, speeds, of_law), ()
    left = beside_last(fit), left_with(problem, fit)
    return Learned("speed", "power", numbers, *told, fit, *left, quantity="restitution [-]", unit=problem.unit)


def _read(values, errors, speeds, reference):
    """The numbers of the law as readings (n,) show them."""
    kind = _kind(reference)

    def missed(numbers):
        restitution, change, exponent = map(float, numbers)
        return (kind(change=change, exponent=exponent).at(restitution, speeds) - values) / errors

    bounds = np.array([(0.0, 1.0), (-1.0, 1.0), (FLATTEST, STEEPEST)]).T
    found = optimize.least_squares(missed, (float(np.clip(np.median(values), 0.01, 0.99)), 0.0, 1.0), bounds=bounds).x
    return dict(zip(("restitution", "change", "exponent"), map(float, found), strict=True))


def _refitted(problem, fit, numbers, reference):
    """Fit of the model with a restitution of its own and the law behind it, in place of what it has of both, through the
    simulator."""
    kind = _kind(reference, numbers["change"], numbers["exponent"])
    trial, model = problem.trials[0], fit.model
    own = candidate(kind, trial.surroundings, rigid_body(trial.body), True, own=True)
    model = replace(model, terms=tuple(term for term in model.terms if term.name not in LAWS))
    model = with_restitution(model, trial, numbers["restitution"])
    model = model.with_term(Term(own, ()).at({free.name: numbers[free.name] for free in own.free}))
    return problem.fit(model, fit.initial_states)


def with_restitution(model, trial, coefficient):
    """The model with a restitution of its own; trial: whose body and surroundings these are."""
    level = candidate(mb.Restitution, trial.surroundings, rigid_body(trial.body), True)
    return model.with_term(Term(level, ()).at({"coefficient": coefficient}))


def _kind(reference, change=0.0, exponent=1.0):
    """The effect class that the file defines: what is tried is the text of it."""
    return module_of(_source("..", reference, change, exponent), "learned_effect", "learned_effect.py").LearnedRestitution


def _source(text, reference, change, exponent):
    """The text of the effect's file."""
    ends = f"low={FLATTEST!r}, high={STEEPEST!r}, least={FLATTEST!r}, most={STEEPEST!r}"
    return SOURCE.format(text=text, reference=reference, change=change, exponent=exponent, ends=ends)


def _sentence(numbers, reference, speeds, of_law):
    """What the law says of the speeds (n,) of the impacts, in one sentence; of_law: speed [m/s] -> restitution."""
    values = {name: entry["value"] for name, entry in numbers.items()}
    slow, fast = (f"{of_law(speed):.3f} at {speed:.2g} m/s" for speed in (speeds.min(), speeds.max()))
    way, sign = ("falls", "-") if values["change"] < 0 else ("grows", "+")
    grown = f"{abs(values['change']):.3g} ((v/{reference:.3g} m/s)^{values['exponent']:.3g} - 1)"
    told = f"by a part that goes as speed^{number_told(numbers['exponent'])}: e = {values['restitution']:.3g} {sign} {grown}"
    return f"Restitution {way} with the speed of the impact, from {slow} to {fast}, {told}"


def _band(values, errors, speeds, of_law):
    """What is drawn: the restitution of impacts of like speed {grid, value, low, high}, (k,) each, and the law {places, law}."""
    parts = np.array_split(np.argsort(speeds), GROUPS)
    weights = [1.0 / errors[part] ** 2 for part in parts]
    grid, value = (
        np.array([w @ what[part] / w.sum() for w, part in zip(weights, parts, strict=True)]) for what in (speeds, values)
    )
    reach = QUANTILE / np.sqrt([w.sum() for w in weights])
    places = np.linspace(speeds.min(), speeds.max(), DRAWN)
    return {"grid": grid, "value": value, "low": value - reach, "high": value + reach, "places": places, "law": of_law(places)}
