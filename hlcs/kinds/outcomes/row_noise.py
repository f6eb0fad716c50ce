"""The noise of the rows of a table: stated, or seen where rows repeat each other or lie about a smooth curve."""

from typing import NamedTuple

import numpy as np

from hlcs.estimation.correlated_noise import CorrelatedNoise
from hlcs.estimation.least_squares import basis, project_out
from hlcs.estimation.noise_model import Noise, polynomials
from hlcs.kinds.outcomes.repeats import LEAST_FREEDOM, repeats_of
from hlcs.kinds.outcomes.setting_errors import MOST_BENT


class RowScatter(NamedTuple):
    """How far rows differ that no model needs to tell apart."""

    sigma: float  # of one row [unit of the outcome]
    freedom: int  # degrees of freedom that it was read from
    seen: str  # how, in words

    def noise(self, source):
        """The Noise of so much scatter, as well known as its degrees of freedom tell."""
        covariance = np.zeros((3, 3))
        covariance[0, 0] = 1 / (2 * self.freedom)
        return Noise(CorrelatedNoise(self.sigma, 0.0, 0.0, covariance), None, 1.0, source)


def between_repeats(table):
    """The RowScatter of rows that repeat each other, None where too few do or all agree to the last digit."""
    repeats = repeats_of(table)
    if repeats.freedom < LEAST_FREEDOM or repeats.within == 0:
        return None
    return RowScatter(float(np.sqrt(repeats.within / repeats.freedom)), repeats.freedom, "rows that repeat each other differ by")


def about_a_curve(table, misfit):
    """The RowScatter about a polynomial of the one input that varies, of third degree, None where there are several or few rows.

    misfit: measured less foretold of each row (n,): what an effect does to it follows a curve (`setting_errors`).
    """
    varied = [values for values in table.inputs.values() if np.ptp(values) > 0]
    freedom = len(misfit) - 1 - MOST_BENT
    if len(varied) != 1 or freedom < LEAST_FREEDOM or len(np.unique(varied[0])) <= MOST_BENT + 1:
        return None
    order = np.argsort(varied[0], kind="stable")
    rest = project_out(basis(polynomials(varied[0][order], MOST_BENT)), misfit[order])
    return RowScatter(float(np.sqrt(rest @ rest / freedom)), freedom, "beside a smooth curve of the input, rows are off by")


def table_noise(file, table):
    """Noise of an outcome: stated, or from replicates (rows with equal inputs); unknown otherwise."""
    stated = file.noise.get(table.outcome, file.noise.get("outcome"))
    if stated is not None:
        return Noise(CorrelatedNoise(stated, 0.0, 0.0, np.zeros((3, 3))), None, 1.0, "stated")
    repeats = between_repeats(table)
    return repeats.noise("replicates") if repeats else Noise(None, None, 1.0, "unknown")
