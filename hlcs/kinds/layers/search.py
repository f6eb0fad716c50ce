"""The search for what a model of layers is missing: signatures from paired simulations, least squares, the rules of acceptance.

Few numbers, few effects: one effect for one grid, two where several grids or campaigns were measured. An effect is accepted when
it pays its price under both forms of the campaign term, mends what it was not fitted to, stays inside its bounds, and moves some
layers by at least twice what these data can show of one.
"""

from dataclasses import replace

import numpy as np

from hlcs.kinds.layers import least_squares
from hlcs.kinds.layers.judge import PRICE, PRICE_ALONE, LayerJudge, Stage
from hlcs.kinds.layers.least_squares import FORMS
from hlcs.kinds.layers.model import coefficients
from hlcs.selection.reasons import Rule
from minibullet.errors import InputError

RIVAL_MARGIN, BEATEN = 6.0, 6.6  # evidence within which a candidate is a rival, unless the held-out data refuse it at p < 0.01
SAME = 0.95  # cosine of signatures above which candidates that both pay their price are not told apart: another engine's
# signatures differ from ours by as much
SEEDS, PAIRS = 8, 4  # tests of a model, and pairs of tests of a candidate, on each measured set
SCREEN = 2  # pairs of a first look at every candidate
FULL = 4  # amounts at which a candidate is simulated in full, at most
FINALISTS = 6  # candidates that are looked at with all pairs
RESCREEN = 5  # candidates that are simulated again once an effect is in; for the others the first signatures serve


class LayerSearch(LayerJudge):
    """One search over candidates; simulations by a `Simulator`."""

    def __init__(self, measurement, sets, simulator, seed=0, seeds=SEEDS, pairs=PAIRS):
        super().__init__(measurement, sets)
        self.simulator = simulator
        self.seeds, self.pairs = [seed + 1 + k for k in range(seeds)], pairs
        self.most = 2 if len({(one.grid, one.bottom_slope) for one in sets}) > 1 or len({one.campaign for one in sets}) > 1 else 1
        self.signatures = {}

    def stage(self, model, accepted=()):
        """Simulate a model on every set."""
        rows = coefficients(self.simulator, [model], self.sets, self.seeds, "model " + ", ".join(model.effects))[0]
        for one, runs in zip(self.sets, rows, strict=True):
            if np.isfinite(runs).all(axis=1).sum() < 2:
                raise InputError(
                    f"the model under test cannot be placed on {one.name}: fewer than two of {len(runs)} simulated tests "
                    f"stand; {self.simulator.refused or 'run `hlcs place` with these settings to see why'}"
                )
        numbers = least_squares.simulated(self.data, rows)
        return Stage(model, rows, numbers, self.data.value - numbers.value, tuple(accepted))

    # --- signatures ----------------------------------------

    def sign(self, stage, entries, pairs=None):
        """Signatures of candidates at a model, by paired simulations; {key: (F, variance) or None}."""
        wanted = [entry for entry in entries if entry.simulated]
        models = [stage.model.with_effect(entry, entry.trial) for entry in wanted]
        found = {}
        if models:
            tables = coefficients(self.simulator, models, self.sets, self.seeds[: pairs or self.pairs], "signatures")
            for entry, rows in zip(wanted, tables, strict=True):
                found[key(entry)] = least_squares.signature(self.data, stage.rows, rows, entry.step)
        for entry in entries:
            if not entry.simulated:
                rows = [entry.read(runs, entry.trial, one) for runs, one in zip(stage.rows, self.sets, strict=True)]
                slope, _ = least_squares.signature(self.data, stage.rows, rows, entry.step)
                found[key(entry)] = slope, np.zeros(len(slope))
        return found

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
                found = self.stage(stage.model.with_effect(entry, one.value), (*stage.accepted, one))
            except InputError:
                found = None
            if not beyond:
                following = found
                break
            line = least_squares.signature(self.data, stage.rows, found.rows, one.amount) if found else None
            if line is None:  # too few tests stand with it
                one = replace(one, amount=(one.amount + simulated) / 2.0)
                continue
            simulated, line = one.amount, self.weigh(stage, entry, *line)
            if line.fails:
                return line, None
            found.accepted, following = (*stage.accepted, replace(line, amount=simulated)), found
            if abs(line.amount - simulated) <= line.deviation:
                break
            one = replace(line, amount=(line.amount + simulated) / 2.0)
        if following is None:
            one.fails.append(Rule.STANDS())
            return one, None
        one = following.accepted[-1]
        falls = [self.chi2(stage, form) - self.chi2(following, form) for form in FORMS]
        if min(falls) <= one.price:
            one.fails.append(Rule.IN_FULL(gain=min(falls)))
        return one, following

    def rivals(self, stage, winner, tried):
        """[(Tried, cosine)] of the candidates that do as well as an accepted one on the stage it was accepted at."""
        found, matrix = [], self.covariance(stage, "individual")
        for one in tried:
            if one.name == winner.name:
                continue
            angle = least_squares.cosine(matrix, winner.slope, one.slope)
            bounded = not any(fail.reason in (Rule.NUMBER_INSIDE_BOUNDS, Rule.NOT_ZERO) for fail in one.fails)
            close = one.evidence >= winner.evidence - RIVAL_MARGIN or (angle > SAME and one.gain > one.price)
            both = one.held and winner.held
            beaten = both and all(one.held_chi2(form) - winner.held_chi2(form) > BEATEN for form in FORMS)
            if bounded and close and not beaten:
                found.append((one, angle))
        return found


def key(entry):
    """What a signature is kept under."""
    return entry.name, entry.needs
