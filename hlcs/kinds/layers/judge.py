"""One candidate against the layers that a model misses: fitted by least squares, held out, and judged by every rule."""

from dataclasses import dataclass, field

import numpy as np

from hlcs.kinds.layers import least_squares
from hlcs.kinds.layers.least_squares import FORMS
from hlcs.kinds.layers.model import LayerModel
from hlcs.placement import statistics
from hlcs.selection.reasons import Rule

PRICE, PRICE_ALONE = 6.0, 12.0  # with and without data to hold out
QUANTILE = 1.645  # of 90 % intervals


@dataclass(eq=False)
class Tried:
    """What became of one candidate in one round."""

    candidate: object
    slope: np.ndarray  # signature (n,) per unit of its number
    slope_variance: np.ndarray
    amount: float = 0.0  # value - null
    deviation: float = 0.0
    gain: float = 0.0  # fall of chi-squared under the form that grants less
    merit: float = 0.0  # the same, mean of both forms: which of several that may be accepted is the best
    price: float = 0.0
    after: dict = field(default_factory=dict)  # chi-squared of each form
    held: dict = field(default_factory=dict)  # group -> (amount without it, chi-squared before, after), form kinder to it
    held_by: dict = field(default_factory=dict)  # the same of each form
    held_error: float | None = None
    error: float = 0.0  # mean relative error with it, as predicted
    size: float = 0.0  # largest shift of a layer, mean of all sets it moves, over what these sets together could show
    fails: list = field(default_factory=list)

    @property
    def name(self):
        return self.candidate.name

    @property
    def evidence(self):
        return self.gain - self.price

    def held_chi2(self, form):
        """Chi-squared of all held-out groups together."""
        return sum(after for _, _, after in self.held_by[form].values())

    @property
    def directions(self):
        """Relative fall of the held-out misfit in every direction."""
        return _falls(self.held)

    @property
    def value(self):
        return self.candidate.null + self.amount

    @property
    def shift(self):
        """What it adds to the model's numbers (n,)."""
        return self.slope * self.amount


@dataclass(eq=False)
class Stage:
    """A model beside the data."""

    model: LayerModel
    rows: list  # simulated (seeds, M) of each set
    numbers: least_squares.Simulated
    residual: np.ndarray  # measured - model (n,)
    accepted: tuple[Tried, ...] = ()


class LayerJudge:
    """What candidates are worth on the layers of measured sets."""

    def __init__(self, measurement, sets):
        self.measurement, self.sets = measurement, sets
        self.data = least_squares.observed(sets, measurement.group)
        self.groups = tuple(dict.fromkeys(measurement.group(one) for one in sets))
        self.can_hold_out = measurement.hold_out != "none" and len(np.unique(self.data.group)) > 1

    def error(self, residual, inside=None):
        """Mean relative error of the layer coefficients [-], of some rows or all."""
        layers = self.data.layer > 0 if inside is None else (self.data.layer > 0) & inside
        return float(np.mean(np.abs(residual[layers]) / self.data.value[layers]))

    def chi2(self, stage, form):
        return least_squares.chi_squared(self.covariance(stage, form), stage.residual)

    def covariance(self, stage, form, more=0.0):
        return least_squares.covariance(self.data, self.data.variance + stage.numbers.variance + more, form)

    def held_out_error(self, stage, tried=None):
        """Mean relative error where every group is predicted by numbers fitted without it; None where nothing can be held out."""
        if not self.can_hold_out:
            return None
        return self.error(self._held_residual(stage, tried))

    def _held_residual(self, stage, tried=None):
        """Residuals (n,) with every accepted amount, and that of `tried`, as the other groups give it."""
        residual = stage.residual.copy()
        for one in stage.accepted:
            for group, (without, _, _) in one.held.items():
                inside = self.data.group == group
                residual[inside] -= (one.slope * (without - one.amount))[inside]
        if tried is not None:
            for group in np.unique(self.data.group):
                inside = self.data.group == group
                amount = tried.held[group][0] if group in tried.held else tried.amount
                residual[inside] -= (tried.slope * amount)[inside]
        return residual

    def weigh(self, stage, entry, slope, slope_variance):
        """Fit one candidate to the residuals of a stage and judge it by every rule."""
        tried, count = Tried(entry, slope, slope_variance), int(np.sum(self.data.layer > 0))
        low, high = entry.low - entry.null, entry.high - entry.null
        gains = {}
        for form in FORMS:
            size, spread, free = (entry.step, 0.0, entry.step) if entry.switch else (0.0, np.inf, 0.0)
            for _ in range(1 if entry.switch else 4):  # the covariance grows with the amount of an uncertain signature
                matrix = self.covariance(stage, form, size**2 * slope_variance)
                if not entry.switch:
                    free, spread = least_squares.amount(matrix, stage.residual, slope)
                    size = float(np.clip(free, low, high))
            matrix = self.covariance(stage, form, size**2 * slope_variance)
            gains[form] = least_squares.chi_squared(matrix, stage.residual) - least_squares.chi_squared(
                matrix, stage.residual - slope * size
            )
            if not gains or gains[form] <= min(gains.values()):
                tried.gain, tried.amount, tried.deviation, unbound = gains[form], size, spread, free
        tried.merit = float(np.mean(list(gains.values())))
        tried.error = self.error(stage.residual - tried.shift)
        self._hold_out(stage, tried)
        tried.price = np.log(count) + (PRICE if tried.held else PRICE_ALONE)
        self._judge(stage, tried, unbound)
        return tried

    def _hold_out(self, stage, tried):
        """Fit to all groups but one, and look at that one, under the form of the campaign term kinder to the candidate."""
        if self.can_hold_out:
            tried.held_by = {form: self._held(stage, tried, form) for form in FORMS}
            tried.held = max(tried.held_by.values(), key=lambda held: min(_falls(held).values(), default=0.0))
        if tried.held:
            tried.held_error = self.held_out_error(stage, tried)

    def _held(self, stage, tried, form):
        """{group: (amount fitted without it, chi-squared of the group before, after)}."""
        before, found = self._held_residual(stage), {}
        entry, data = tried.candidate, self.data
        matrix = self.covariance(stage, form, tried.amount**2 * tried.slope_variance)
        for group in np.unique(data.group):
            inside, seen = data.group == group, (data.layer > 0)
            if not np.any(tried.slope[inside & seen]) or not np.any(tried.slope[~inside & seen]):
                continue  # nothing of this effect in the group, or in all others
            size = tried.amount
            if not entry.switch:
                size, _ = least_squares.amount(matrix[np.ix_(~inside, ~inside)], stage.residual[~inside], tried.slope[~inside])
                size = float(np.clip(size, entry.low - entry.null, entry.high - entry.null))
            own = matrix[np.ix_(inside, inside)]
            found[group] = (
                size,
                least_squares.chi_squared(own, before[inside]),
                least_squares.chi_squared(own, (before - tried.slope * size)[inside]),
            )
        return found

    def _judge(self, stage, tried, unbound):
        """The reasons against it."""
        layers = self.data.layer > 0
        tried.size = self._size(stage, tried.shift)
        outside = abs(unbound - tried.amount) > 2.0 * tried.deviation and tried.value != tried.candidate.gone
        if not np.any(tried.slope[layers]):
            tried.fails.append(Rule.MOVES_A_LAYER())
        elif outside or (tried.amount == 0.0 and not tried.candidate.switch):
            tried.fails.append(Rule.NUMBER_INSIDE_BOUNDS())
        elif abs(tried.amount) <= QUANTILE * tried.deviation and not tried.candidate.switch:
            tried.fails.append(Rule.NOT_ZERO())
        if tried.gain <= tried.price:
            tried.fails.append(Rule.PRICE_OF_LAYERS(gain=tried.gain, price=tried.price))
        if tried.size < 1.0:
            tried.fails.append(Rule.RESOLUTION(size=tried.size))
        names = self.groups
        worse = [f"{names[group]} {100 * fall:+.0f} %" for group, fall in tried.directions.items() if fall <= 0.02]
        if worse:
            tried.fails.append(Rule.EVERY_GROUP(groups=", ".join(worse)))
        if tried.held_error is not None and tried.held_error > 0.98 * self.held_out_error(stage):
            tried.fails.append(Rule.HELD_OUT_LAYERS())

    def _size(self, stage, shift):
        """Largest shift of a layer, mean of the sets it moves, over what is detectable in that mean; campaigns differ, too."""
        matrix, sizes = self.covariance(stage, "common"), [0.0]
        for layer in range(1, max(one.layers for one in self.sets) + 1):
            rows = np.flatnonzero((self.data.layer == layer) & (shift != 0.0))
            if len(rows):
                error = np.sqrt(matrix[np.ix_(rows, rows)].mean())
                shown = statistics.detectable_shift(error, max(one.layers for one in self.sets))
                sizes.append(abs(float(shift[rows].mean())) / shown)
        return max(sizes)


def _falls(held):
    """{group: relative fall of the misfit of a held-out group}."""
    return {group: 1.0 - np.sqrt(after / before) for group, (_, before, after) in held.items()}
