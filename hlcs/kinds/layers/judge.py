"""One candidate against the layers that a model misses: fitted by least squares, held out, and judged by every rule."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from hlcs.kinds.layers import least_squares
from hlcs.kinds.layers.candidates import LayerCandidate
from hlcs.kinds.layers.least_squares import FORMS
from hlcs.kinds.layers.model import LayerModel
from hlcs.placement import statistics
from hlcs.selection.reasons import Rule
from hlcs.selection.thresholds import ODDS as MARGIN
from hlcs.selection.thresholds import ODDS_ALONE as MARGIN_ALONE

QUANTILE = 1.645  # of 90 % intervals


class HeldOut(NamedTuple):
    """What a candidate does to a group that it was not fitted to."""

    amount: float  # fitted to the other groups
    before: float  # chi-squared of the group without the candidate
    after: float  # and with it

    @property
    def fall(self):
        """Relative fall of the misfit."""
        return 1.0 - np.sqrt(self.after / self.before)


@dataclass(eq=False)
class LayerTrial:
    """What became of one candidate in one round."""

    candidate: LayerCandidate
    slope: np.ndarray  # signature (n,) per unit of its number
    slope_variance: np.ndarray
    amount: float  # value - null
    deviation: float
    gain: float  # fall of chi-squared under the form of the campaign term that grants less
    mean_gain: float  # the same, mean of both forms: which of several that may be accepted is the best
    error: float  # mean relative error with it, as predicted
    required_gain: float = 0.0  # fall of chi-squared that its complexity asks for
    held_out_by_form: dict = field(default_factory=dict)  # form -> {group: HeldOut}
    held_out: dict = field(default_factory=dict)  # the same of the form kinder to it
    held_out_error: float | None = None
    relative_shift: float = 0.0  # largest shift of a layer, mean of all sets it moves, over what these sets together could show
    fails: list = field(default_factory=list)  # Explanations of the rules that it breaks

    @property
    def name(self):
        return self.candidate.name

    @property
    def evidence(self):
        return self.gain - self.required_gain

    @property
    def value(self):
        return self.candidate.number.null + self.amount

    @property
    def shift(self):
        """What it adds to the values of the model (n,)."""
        return self.slope * self.amount

    def behind(self, other, form):
        """How much larger chi-squared of all held-out groups together is than with the candidate of another trial."""
        mine, others = (sum(group.after for group in trial.held_out_by_form[form].values()) for trial in (self, other))
        return mine - others


@dataclass(eq=False)
class LayerFit:
    """A model beside the data."""

    model: LayerModel
    runs: list  # simulated (seeds, M) of each set
    simulated: least_squares.Simulated
    residual: np.ndarray  # measured - model (n,)
    accepted: tuple[LayerTrial, ...] = ()


class LayerJudge:
    """What candidates are worth on the layers of measured sets."""

    def __init__(self, measurement, sets):
        self.measurement, self.sets = measurement, sets
        self.data = least_squares.observed(sets, measurement.group)
        self.layers = self.data.layer > 0
        self.groups = tuple(dict.fromkeys(map(measurement.group, sets)))
        self.can_hold_out = measurement.hold_out != "none" and len(self.groups) > 1

    def error(self, residual, inside=True):
        """Mean relative error of the layer coefficients [-], of some rows or all."""
        layers = self.layers & inside
        return float(np.mean(np.abs(residual[layers]) / self.data.value[layers]))

    def chi2(self, fit, form):
        return least_squares.chi_squared(self.covariance(fit, form), fit.residual)

    def covariance(self, fit, form, more=0.0):
        return least_squares.covariance(self.data, self.data.variance + fit.simulated.variance + more, form)

    def required_gain(self, held_out):
        """Fall of chi-squared that one more number asks for."""
        return np.log(np.sum(self.layers)) + (MARGIN if held_out else MARGIN_ALONE)

    def held_out_error(self, fit, trial=None):
        """Mean relative error where every group is predicted by numbers fitted without it; None where nothing can be held out."""
        return self.error(self._held_out_residual(fit, trial)) if self.can_hold_out else None

    def _held_out_residual(self, fit, trial=None):
        """Residuals (n,) with every accepted amount, and that of a trial, as the other groups give it."""
        residual = fit.residual.copy()
        for accepted in fit.accepted:
            for group, held_out in accepted.held_out.items():
                inside = self.data.group == group
                residual[inside] -= (accepted.slope * (held_out.amount - accepted.amount))[inside]
        for group in range(len(self.groups)) if trial else ():
            inside = self.data.group == group
            amount = trial.held_out[group].amount if group in trial.held_out else trial.amount
            residual[inside] -= (trial.slope * amount)[inside]
        return residual

    def weigh(self, fit, candidate, slope, slope_variance):
        """The LayerTrial of a candidate on the residuals of a fit, judged by every rule."""
        estimates = [self._estimate(fit, candidate, slope, slope_variance, form) for form in FORMS]
        gain, amount, deviation, unbounded = min(reversed(estimates), key=lambda estimate: estimate[0])
        mean_gain, error = float(np.mean([estimate[0] for estimate in estimates])), self.error(fit.residual - slope * amount)
        trial = LayerTrial(candidate, slope, slope_variance, amount, deviation, gain, mean_gain, error)
        if self.can_hold_out:
            trial.held_out_by_form = {form: self._held_out(fit, trial, form) for form in FORMS}
            trial.held_out = max(trial.held_out_by_form.values(), key=_least_fall)
        if trial.held_out:
            trial.held_out_error = self.held_out_error(fit, trial)
        trial.required_gain = self.required_gain(trial.held_out)
        trial.relative_shift = self._relative_shift(fit, trial.shift)
        self._judge(fit, trial, unbounded)
        return trial

    def _estimate(self, fit, candidate, slope, slope_variance, form):
        """(gain, amount, its deviation, amount without bounds) that fits the residuals best under one form of the campaign term.

        The covariance grows with the amount of an uncertain signature.
        """
        free = amount = candidate.step if candidate.switch else 0.0
        deviation = 0.0 if candidate.switch else np.inf
        for _ in range(0 if candidate.switch else 4):
            matrix = self.covariance(fit, form, amount**2 * slope_variance)
            free, deviation = least_squares.amount(matrix, fit.residual, slope)
            amount = _bounded(candidate, free)
        matrix = self.covariance(fit, form, amount**2 * slope_variance)
        before, after = (least_squares.chi_squared(matrix, part) for part in (fit.residual, fit.residual - slope * amount))
        return before - after, amount, deviation, free

    def _held_out(self, fit, trial, form):
        """{group: HeldOut} of a candidate fitted to all groups but one, and looked at on that one."""
        before, groups, slope = self._held_out_residual(fit), {}, trial.slope
        matrix = self.covariance(fit, form, trial.amount**2 * trial.slope_variance)
        for group in range(len(self.groups)):
            inside = self.data.group == group
            if not np.any(slope[inside & self.layers]) or not np.any(slope[~inside & self.layers]):
                continue  # nothing of this effect in the group, or in all others
            amount = trial.amount
            if not trial.candidate.switch:
                others = matrix[np.ix_(~inside, ~inside)]
                amount = _bounded(trial.candidate, least_squares.amount(others, fit.residual[~inside], slope[~inside])[0])
            block = matrix[np.ix_(inside, inside)]
            chi2 = [least_squares.chi_squared(block, part[inside]) for part in (before, before - slope * amount)]
            groups[group] = HeldOut(amount, *chi2)
        return groups

    def _judge(self, fit, trial, unbounded):
        """Note the rules that a trial breaks."""
        candidate, amount, deviation = trial.candidate, trial.amount, trial.deviation
        outside = abs(unbounded - amount) > 2.0 * deviation and trial.value != candidate.removed_at
        if not np.any(trial.slope[self.layers]):
            trial.fails.append(Rule.MOVES_A_LAYER())
        elif outside or (amount == 0.0 and not candidate.switch):
            trial.fails.append(Rule.NUMBER_INSIDE_BOUNDS())
        elif abs(amount) <= QUANTILE * deviation and not candidate.switch:
            trial.fails.append(Rule.NOT_ZERO())
        if trial.gain <= trial.required_gain:
            trial.fails.append(Rule.PRICE_OF_LAYERS(gain=trial.gain, price=trial.required_gain))
        if trial.relative_shift < 1.0:
            trial.fails.append(Rule.RESOLUTION(size=trial.relative_shift))
        falls = {self.groups[group]: held_out.fall for group, held_out in trial.held_out.items()}
        worse = [f"{group} {100 * fall:+.0f} %" for group, fall in falls.items() if fall <= 0.02]
        if worse:
            trial.fails.append(Rule.EVERY_GROUP(groups=", ".join(worse)))
        if trial.held_out_error is not None and trial.held_out_error > 0.98 * self.held_out_error(fit):
            trial.fails.append(Rule.HELD_OUT_LAYERS())

    def _relative_shift(self, fit, shift):
        """Largest shift of a layer, mean of the sets it moves, over what is detectable in that mean; campaigns differ, too."""
        matrix, ratios = self.covariance(fit, "common"), [0.0]
        most = max(measured_set.layers for measured_set in self.sets)
        for layer in range(1, most + 1):
            rows = np.flatnonzero((self.data.layer == layer) & (shift != 0.0))
            if len(rows):
                error = np.sqrt(matrix[np.ix_(rows, rows)].mean())
                ratios.append(abs(float(shift[rows].mean())) / statistics.detectable_shift(error, most))
        return max(ratios)


def _bounded(candidate, amount):
    number = candidate.number
    return float(np.clip(amount, number.low - number.null, number.high - number.null))


def _least_fall(groups):
    """The smallest fall of the misfit of held-out groups; 0 where there are none."""
    return min((held_out.fall for held_out in groups.values()), default=0.0)
