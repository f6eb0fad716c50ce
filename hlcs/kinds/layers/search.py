"""The search for what a model of layers is missing: signatures from paired simulations, least squares, the rules of acceptance.

Few data, few effects: one effect for one grid, two where several grids or campaigns were measured. An effect is accepted when its
gain in chi-squared exceeds what its number asks for under both forms of the campaign term, when it mends what it was not fitted
to, stays inside its bounds, and moves some layers by at least what these data can show of one.
"""

from dataclasses import replace

import numpy as np

from hlcs.kinds.layers import least_squares
from hlcs.kinds.layers.judge import LayerFit, LayerJudge
from hlcs.kinds.layers.least_squares import FORMS
from hlcs.kinds.layers.model import coefficients
from hlcs.selection.reasons import Rule
from hlcs.selection.thresholds import TIED as COMPETITOR_MARGIN
from minibullet.errors import InputError

BEATEN = 6.6  # chi-squared of held-out data by which a candidate within COMPETITOR_MARGIN is no rival: they refuse it at p < 0.01
SAME = 0.95  # cosine of signatures above which candidates that both gain enough are not told apart: another engine's
# signatures differ from ours by as much
SEEDS, PAIRS = 8, 4  # tests of a model, and pairs of tests of a candidate, on each measured set
SCREEN = 2  # pairs of a first look at every candidate
FULL = 4  # amounts at which a candidate is simulated in full, at most
FINALISTS = 6  # candidates that are looked at with all pairs
RESCREEN = 5  # candidates that are simulated again once an effect is in; for the others the first signatures serve


class LayerSearch(LayerJudge):
    """One search over candidates; simulations by a `PlacementSimulator`."""

    def __init__(self, measurement, sets, simulator, seed=0, seeds=SEEDS, pairs=PAIRS):
        super().__init__(measurement, sets)
        self.simulator = simulator
        self.seeds, self.pairs = [seed + 1 + k for k in range(seeds)], pairs
        places = {(measured_set.grid, measured_set.bottom_slope, measured_set.campaign) for measured_set in sets}
        self.most_effects = 2 if len(places) > 1 else 1
        self.signatures = {}  # key of a candidate -> (F, variance), None where it could not be simulated

    def fit(self, model, accepted=()):
        """The LayerFit of a model: simulated on every set."""
        (runs,) = coefficients(self.simulator, [model], self.sets, self.seeds, "model " + ", ".join(model.effects))
        for measured_set, tests in zip(self.sets, runs, strict=True):
            if np.isfinite(tests).all(axis=1).sum() < 2:
                raise InputError(
                    f"the model under test cannot be placed on {measured_set.name}: fewer than two of {len(tests)} simulated "
                    f"tests stand; {self.simulator.refused or 'run `hlcs place` with these settings to see why'}"
                )
        simulated = least_squares.simulated(self.data, runs)
        return LayerFit(model, runs, simulated, self.data.value - simulated.value, tuple(accepted))

    # --- signatures ----------------------------------------

    def sign(self, fit, candidates, pairs):
        """Take the signatures of candidates at a model, by paired simulations where they need them."""
        simulated = [candidate for candidate in candidates if candidate.simulated]
        models = [fit.model.with_effect(candidate, candidate.number.start) for candidate in simulated]
        tables = coefficients(self.simulator, models, self.sets, self.seeds[:pairs], "signatures") if models else []
        for candidate, runs in zip(simulated, tables, strict=True):
            self.signatures[candidate.key] = least_squares.signature(self.data, fit.runs, runs, candidate.step)
        for candidate in candidates:
            if not candidate.simulated:
                sets = zip(fit.runs, self.sets, strict=True)
                runs = [candidate.read(tests, candidate.number.start, measured_set) for tests, measured_set in sets]
                slope, _ = least_squares.signature(self.data, fit.runs, runs, candidate.step)
                self.signatures[candidate.key] = slope, np.zeros(len(slope))

    # --- rounds ----------------------------------------

    def run(self, fit, candidates):
        """(fits, rounds): a fit for every accepted effect after the first, and the trials of each round."""
        fits, rounds = [fit], []
        while len(fit.accepted) < self.most_effects:
            if min(self.chi2(fit, form) for form in FORMS) <= self.required_gain(self.can_hold_out):
                break  # no candidate could gain enough
            trials = self._round(fit, [candidate for candidate in candidates if candidate.name not in fit.model.effects])
            rounds.append(trials)
            fit = self._best(fit, trials)
            if fit is None:
                break
            fits.append(fit)
        return fits, rounds

    def _round(self, fit, candidates):
        """Trials of all candidates on a fit: a quick look at all of them,
        or their earlier signatures, says which are worth all pairs."""
        most = RESCREEN if self.signatures else FINALISTS
        if not self.signatures:
            self.sign(fit, candidates, SCREEN)
        screened = [trial for trial in self._weighed(fit, candidates) if trial.candidate.simulated]
        best = [trial.candidate for trial in sorted(screened, key=lambda trial: -trial.gain)[:most]]
        best += [trial.candidate for trial in screened if trial.candidate.removed_at is not None and trial.candidate not in best]
        self.sign(fit, best + [candidate for candidate in candidates if not candidate.simulated], self.pairs)
        return self._weighed(fit, candidates)

    def _weighed(self, fit, candidates):
        """Trials of the candidates that have a signature."""
        signed = [(candidate, self.signatures.get(candidate.key)) for candidate in candidates]
        return [self.weigh(fit, candidate, *signature) for candidate, signature in signed if signature]

    def _best(self, fit, trials):
        """The fit after the best acceptable candidate that gains enough when it is simulated in full, or None."""
        acceptable = [trial for trial in trials if not trial.fails]
        for trial in sorted(acceptable, key=lambda trial: trial.required_gain - trial.mean_gain):
            last, following = self._in_full(fit, trial)
            trials[trials.index(trial)] = last
            if not last.fails:
                return following
        return None

    def _in_full(self, fit, trial):
        """(LayerTrial, fit with it) of a candidate simulated at its amount; noted where it gains less than promised.

        An amount beyond the one that was simulated is a straight line drawn on, which may miss, or lead to where no unit stands.
        There the amount comes half-way back, a new line is drawn through what was simulated, and so on until both agree.
        """
        candidate, simulated, following = trial.candidate, trial.candidate.step, None
        beyond = not candidate.switch and abs(trial.amount) > 1.1 * abs(candidate.step)
        for _ in range(FULL):
            try:
                whole = self.fit(fit.model.with_effect(candidate, trial.value), (*fit.accepted, trial))
            except InputError:
                whole = None
            if not beyond:
                following = whole
                break
            line = least_squares.signature(self.data, fit.runs, whole.runs, trial.amount) if whole else None
            if line is None:  # too few tests stand with it
                trial = replace(trial, amount=(trial.amount + simulated) / 2.0)
                continue
            simulated, line = trial.amount, self.weigh(fit, candidate, *line)
            if line.fails:
                return line, None
            whole.accepted, following = (*fit.accepted, replace(line, amount=simulated)), whole
            if abs(line.amount - simulated) <= line.deviation:
                break
            trial = replace(line, amount=(line.amount + simulated) / 2.0)
        if following is None:
            trial.fails.append(Rule.STANDS())
            return trial, None
        trial = following.accepted[-1]
        least = min(self.chi2(fit, form) - self.chi2(following, form) for form in FORMS)
        if least <= trial.required_gain:
            trial.fails.append(Rule.IN_FULL(gain=least))
        return trial, following

    def rivals(self, fit, winner, trials):
        """[(LayerTrial, cosine)] of the candidates that do as well as an accepted one on the fit it was accepted at."""
        rivals, matrix = [], self.covariance(fit, "individual")
        for trial in trials:
            unbounded = any(broken.reason in (Rule.NUMBER_INSIDE_BOUNDS, Rule.NOT_ZERO) for broken in trial.fails)
            if unbounded or trial.name == winner.name:
                continue
            cosine = least_squares.cosine(matrix, winner.slope, trial.slope)
            close = trial.evidence >= winner.evidence - COMPETITOR_MARGIN or (cosine > SAME and trial.evidence > 0.0)
            beaten = winner.held_out and trial.held_out and all(trial.behind(winner, form) > BEATEN for form in FORMS)
            if close and not beaten:
                rivals.append((trial, cosine))
        return rivals
