"""The problem that tables of layers pose to the search: what was measured and simulated, their scatter, designs of more tests."""

from dataclasses import replace
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular

from hlcs.effects.witnesses import OF_LAYERS
from hlcs.estimation.designs import Design, Designs
from hlcs.estimation.direct_problem import DirectProblem, Rows
from hlcs.kinds.layers import observations
from hlcs.kinds.layers.notes import noise_floor
from hlcs.kinds.layers.responses import Responses


class LayerProblem(DirectProblem):
    """Values of all measured sets, or of some rows of them, beside the responses of a model."""

    unit = "1"
    subject = "how the units lie"

    def __init__(self, responses: Responses, groups, variance, shared=True):
        """groups: Rows each; variance (n,) of measured and simulated values by the scatter between tests; shared: does what
        campaigns and engines change come to it?"""
        self.responses, self.data, self.trials, self.difference_steps = responses, responses.data, groups, {}
        self.rows, self.variance, self.values = np.concatenate([group.rows for group in groups]), variance, self.data.value
        doubt = observations.doubt(self.data, *responses.stated)
        covariance = observations.covariance(self.data, variance, doubt) if shared else np.diag(variance)
        self.sigma, self.factor = np.sqrt(np.diag(covariance)), self._factor(covariance)

    def _factor(self, covariance):
        return np.linalg.cholesky(covariance[np.ix_(self.rows, self.rows)])

    @cached_property
    def noise_level(self):
        """Mean relative error that a perfect model would show on these data [-]."""
        return noise_floor(self, self.responses.model)

    def predict(self, model):
        return self.responses.values(model)

    def doubt(self, model):
        """The `observations.doubt` (n,) of a model: of all that effects change in it, those that its file states among them."""
        of_terms, stated = self.responses.change(model), self.responses.stated
        return observations.doubt(self.data, *map(np.add, of_terms, stated))

    def fit(self, model, initial_states=None, limit=None):
        """The Fit of a model's numbers; its cost knows how well is known what its effects do, so that no limit cuts it short."""
        fit = super().fit(model, initial_states)
        factor = self._factor(observations.covariance(self.data, self.variance, self.doubt(fit.model)))
        white = solve_triangular(factor, self.coloured(fit.linearization.white)[self.rows], lower=True)
        spread = 2 * np.sum(np.log(np.diag(factor) / np.diag(self.factor)))
        return replace(fit, doubt=float(white @ white + spread - fit.chi2))

    def split(self, values):
        """Values of all groups in one row as a list."""
        return np.split(values, np.cumsum([len(group.rows) for group in self.trials])[:-1])

    def whitened(self, raw):
        return self.split(solve_triangular(self.factor, np.concatenate(raw), lower=True))

    def coloured(self, white):
        """White residuals turned back into residuals of all rows of the table (n,)."""
        residual = np.zeros(len(self.values))
        residual[self.rows] = self.factor @ np.concatenate(white)
        return residual

    def in_sigmas(self, white):
        residual = self.coloured(white) / self.sigma
        return [residual[group.rows] for group in self.trials]

    def error(self, white):
        """Mean relative error of the layer coefficients (Eq. 11)."""
        layers = self.data.layer > 0
        return float(np.mean(np.abs(self.coloured(white)[layers]) / self.data.value[layers]))

    # --- the next experiment ----------------------------------------------------------------------------------------------------

    def reading(self, term):
        """(what measures an effect directly, its separation: it decides alone), None where nothing does."""
        return (OF_LAYERS[term.name], np.inf) if term.name in OF_LAYERS else None

    def designs(self, final, other):
        """More tests on one of the measured grids, by other hands: a campaign is off by itself, however many its tests are."""
        data, found, groups, shared = self.data, [], [], []
        variance = np.full(len(self.values), np.inf)
        for index, measured_set in enumerate(self.responses.sets):
            what = {"grid": measured_set.grid.name, "bottom_slope": measured_set.bottom_slope}
            rows = np.flatnonzero((data.set == index) & (data.layer > 0))
            if what in [design.what for design in found]:
                continue
            bottom = f"a bottom of slope {measured_set.bottom_slope:g}" if measured_set.bottom_slope else "a flat bottom"
            text = f"place {measured_set.grid.name} on {bottom} again"
            found.append(Design(text, what))
            groups.append(Rows(measured_set.name, rows))
            variance[rows] = (data.variance * data.tests)[rows]
            deviation, mean = np.sqrt(variance[rows]), data.value[rows]
            upper = observations.MODEL * mean * (data.layer[rows] > 1)
            columns = [observations.EITHER * mean[:, None], np.diag(observations.EITHER * mean), np.diag(upper)]
            shared.append(np.hstack(columns) / deviation[:, None])
        problem = LayerProblem(self.responses, tuple(groups), variance, shared=False)
        return Designs(problem, problem.initial_guess(), tuple(found), shared)

    def worst(self, fit):
        """(where a fit misses most, in words; the same for a program)."""
        residual = self.coloured(fit.linearization.white) / self.sigma
        place = int(np.argmax(np.abs(residual) * (self.data.layer > 0)))
        measured_set = self.responses.sets[self.data.set[place]]
        text = f"the tests of {measured_set.name} (whose layer {self.data.layer[place]} the model misses most)"
        return text, {"grid": measured_set.grid.name, "bottom_slope": measured_set.bottom_slope}
