"""The search for what a model of layers is missing: signatures from paired simulations, least squares, the rules of acceptance.

Few numbers, few effects: one effect for one grid, two where several grids or campaigns were measured. An effect is accepted when
it pays its price under both forms of the campaign term, mends what it was not fitted to, stays inside its bounds, and moves some
layers by at least twice what these data can show of one.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from hlcs import layer_fit, statistics
from hlcs.layer_fit import FORMS
from hlcs.layer_model import LayerModel, coefficients
from minibullet.errors import InputError

PRICE, PRICE_ALONE = 6.0, 12.0  # with and without data to hold out
RIVAL_MARGIN, BEATEN = 6.0, 6.6  # evidence within which a candidate is a rival, unless the held-out data refuse it at p < 0.01
SAME = 0.95  # cosine of signatures above which candidates that both pay their price are not told apart: another engine's
# signatures differ from ours by as much
SEEDS, PAIRS = 8, 4  # tests of a model, and pairs of tests of a candidate, on each measured set
SCREEN = 2  # pairs of a first look at every candidate
FULL = 4  # amounts at which a candidate is simulated in full, at most
FINALISTS = 6  # candidates that are looked at with all pairs
RESCREEN = 5  # candidates that are simulated again once an effect is in; for the others the first signatures serve
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
    numbers: layer_fit.Simulated
    residual: np.ndarray  # measured - model (n,)
    accepted: tuple[Tried, ...] = ()


class LayerSearch:
    """One search over candidates; simulations by a `Simulator`."""

    def __init__(self, measurement, sets, simulator, seed=0, seeds=SEEDS, pairs=PAIRS):
        self.measurement, self.sets, self.simulator = measurement, sets, simulator
        self.seeds, self.pairs = [seed + 1 + k for k in range(seeds)], pairs
        self.data = layer_fit.observed(sets, measurement.group)
        self.groups = tuple(dict.fromkeys(measurement.group(one) for one in sets))
        self.can_hold_out = measurement.hold_out != "none" and len(np.unique(self.data.group)) > 1
        self.most = 2 if len({(one.grid, one.bottom_slope) for one in sets}) > 1 or len({one.campaign for one in sets}) > 1 else 1
        self.signatures = {}

    def stage(self, model, accepted=()):
        """Simulate a model on every set."""
        rows = coefficients(self.simulator, [model], self.sets, self.seeds, "model " + ", ".join(model.effects))[0]
        for one, runs in zip(self.sets, rows, strict=True):
            if np.isfinite(runs).all(axis=1).sum() < 2:
                raise InputError(
                    f"the model under test cannot be placed on {one.name}: fewer than two of {len(runs)} simulated tests "
                    "stand; run `hlcs place` with these settings to see why"
                )
        numbers = layer_fit.simulated(self.data, rows)
        return Stage(model, rows, numbers, self.data.value - numbers.value, tuple(accepted))

    # --- errors ----------------------------------------

    def error(self, residual, inside=None):
        """Mean relative error of the layer coefficients [-], of some rows or all."""
        layers = self.data.layer > 0 if inside is None else (self.data.layer > 0) & inside
        return float(np.mean(np.abs(residual[layers]) / self.data.value[layers]))

    def chi2(self, stage, form):
        return layer_fit.chi_squared(self.covariance(stage, form), stage.residual)

    def covariance(self, stage, form, more=0.0):
        return layer_fit.covariance(self.data, self.data.variance + stage.numbers.variance + more, form)

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

    # --- signatures ----------------------------------------

    def sign(self, stage, entries, pairs=None):
        """Signatures of candidates at a model, by paired simulations; {key: (F, variance) or None}."""
        wanted = [entry for entry in entries if entry.simulated]
        models = [stage.model.with_effect(entry, entry.trial) for entry in wanted]
        found = {}
        if models:
            tables = coefficients(self.simulator, models, self.sets, self.seeds[: pairs or self.pairs], "signatures")
            for entry, rows in zip(wanted, tables, strict=True):
                found[key(entry)] = layer_fit.signature(self.data, stage.rows, rows, entry.step)
        for entry in entries:
            if not entry.simulated:
                rows = [entry.read(runs, entry.trial, one) for runs, one in zip(stage.rows, self.sets, strict=True)]
                slope, _ = layer_fit.signature(self.data, stage.rows, rows, entry.step)
                found[key(entry)] = slope, np.zeros(len(slope))
        return found

    # --- one candidate ----------------------------------------

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
                    free, spread = layer_fit.amount(matrix, stage.residual, slope)
                    size = float(np.clip(free, low, high))
            matrix = self.covariance(stage, form, size**2 * slope_variance)
            gains[form] = layer_fit.chi_squared(matrix, stage.residual) - layer_fit.chi_squared(
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
                size, _ = layer_fit.amount(matrix[np.ix_(~inside, ~inside)], stage.residual[~inside], tried.slope[~inside])
                size = float(np.clip(size, entry.low - entry.null, entry.high - entry.null))
            own = matrix[np.ix_(inside, inside)]
            found[group] = (
                size,
                layer_fit.chi_squared(own, before[inside]),
                layer_fit.chi_squared(own, (before - tried.slope * size)[inside]),
            )
        return found

    def _judge(self, stage, tried, unbound):
        """The reasons against it."""
        layers = self.data.layer > 0
        tried.size = self._size(stage, tried.shift)
        outside = abs(unbound - tried.amount) > 2.0 * tried.deviation and tried.value != tried.candidate.gone
        if not np.any(tried.slope[layers]):
            tried.fails.append("it moves no layer")
        elif outside or (tried.amount == 0.0 and not tried.candidate.switch):
            tried.fails.append("its number leaves the bounds")
        elif abs(tried.amount) <= QUANTILE * tried.deviation and not tried.candidate.switch:
            tried.fails.append("the interval of its number holds zero effect")
        if tried.gain <= tried.price:
            tried.fails.append(f"its gain in chi2 of {tried.gain:.1f} does not pay its price of {tried.price:.1f}")
        if tried.size < 1.0:
            tried.fails.append(f"below resolution: it moves no layer by more than {tried.size:.1f} times what these data show")
        names = self.groups
        worse = [f"{names[group]} {100 * fall:+.0f} %" for group, fall in tried.directions.items() if fall <= 0.02]
        if worse:
            tried.fails.append("held-out misfit does not fall by 2 % on " + ", ".join(worse))
        if tried.held_error is not None and tried.held_error > 0.98 * self.held_out_error(stage):
            tried.fails.append("the held-out error does not fall by 2 %")

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

    # --- rounds ----------------------------------------

    def run(self, stage, entries):
        """(stages, rounds): a stage for every accepted effect after the first, and what was tried in each round."""
        stages, rounds = [stage], []
        while len(stage.accepted) < self.most:
            price = np.log(np.sum(self.data.layer > 0)) + (PRICE if self.can_hold_out else PRICE_ALONE)
            if min(self.chi2(stage, form) for form in FORMS) <= price:
                break  # nothing could pay its price
            left = [entry for entry in entries if entry.name not in stage.model.effects]
            tried = self._round(stage, left)
            rounds.append(tried)
            following = self._best(stage, tried)
            if following is None:
                break
            stage = following
            stages.append(stage)
        return stages, rounds

    def _round(self, stage, entries):
        """What every candidate is worth at a stage: a quick look at all of them, or their earlier signatures, says which are
        worth all pairs."""
        most = RESCREEN if self.signatures else FINALISTS
        if not self.signatures:
            self.signatures.update(self.sign(stage, entries, SCREEN))
        screened = [one for one in self._weighed(stage, entries) if one.candidate.simulated]
        best = [one.candidate for one in sorted(screened, key=lambda one: -one.gain)[:most]]
        best += [one.candidate for one in screened if one.candidate.gone is not None and one.candidate not in best]
        self.signatures.update(self.sign(stage, best + [entry for entry in entries if not entry.simulated]))
        return self._weighed(stage, entries)

    def _weighed(self, stage, entries):
        """Every candidate that has a signature, judged."""
        return [self.weigh(stage, entry, *self.signatures[key(entry)]) for entry in entries if self.signatures.get(key(entry))]

    def _best(self, stage, tried):
        """The stage after the best acceptable candidate that keeps its promise when it is simulated in full, or None."""
        for one in sorted((one for one in tried if not one.fails), key=lambda one: one.price - one.merit):
            last, following = self._in_full(stage, one)
            tried[tried.index(one)] = last
            if not last.fails:
                return following
        return None

    def _in_full(self, stage, one):
        """(Tried, stage with it) of a candidate simulated at its amount; the reason is noted where it does not keep its promise.

        An amount beyond the one that was simulated is a straight line drawn on, which may miss, or lead to where no unit stands.
        There the amount comes half-way back, a new line is drawn through what was simulated, and so on until both agree.
        """
        entry, simulated, following = one.candidate, one.candidate.step, None
        beyond = not entry.switch and abs(one.amount) > 1.1 * abs(entry.step)
        for _ in range(FULL):
            try:
                following = self.stage(stage.model.with_effect(entry, one.value), (*stage.accepted, one))
            except InputError:
                one = replace(one, amount=(one.amount + simulated) / 2.0)
                if beyond:
                    continue
                break
            simulated = one.amount
            if not beyond:
                break
            line = self.weigh(stage, entry, *layer_fit.signature(self.data, stage.rows, following.rows, simulated))
            if line.fails:
                return line, None
            following.accepted = (*stage.accepted, replace(line, amount=simulated))
            if abs(line.amount - simulated) <= line.deviation:
                break
            one = replace(line, amount=(line.amount + simulated) / 2.0)
        if following is None:
            one.fails.append("no placement stands with it")
            return one, None
        one = following.accepted[-1]
        falls = [self.chi2(stage, form) - self.chi2(following, form) for form in FORMS]
        if min(falls) <= one.price:
            one.fails.append(f"simulated in full, chi2 falls by {min(falls):.1f} only")
        return one, following

    def rivals(self, stage, winner, tried):
        """[(Tried, cosine)] of the candidates that do as well as an accepted one on the stage it was accepted at."""
        found, matrix = [], self.covariance(stage, "individual")
        for one in tried:
            if one.name == winner.name:
                continue
            angle = layer_fit.cosine(matrix, winner.slope, one.slope)
            bounded = not any(fail.startswith(("its number", "the interval")) for fail in one.fails)
            close = one.evidence >= winner.evidence - RIVAL_MARGIN or (angle > SAME and one.gain > one.price)
            both = one.held and winner.held
            beaten = both and all(one.held_chi2(form) - winner.held_chi2(form) > BEATEN for form in FORMS)
            if bounded and close and not beaten:
                found.append((one, angle))
        return found


def _falls(held):
    """{group: relative fall of the misfit of a held-out group}."""
    return {group: 1.0 - np.sqrt(after / before) for group, (_, before, after) in held.items()}


def key(entry):
    """What a signature is kept under."""
    return entry.name, entry.needs
