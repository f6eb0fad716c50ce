"""The noise of the rows of a table: stated, or seen where rows repeat each other or lie about a smooth curve."""

from typing import NamedTuple

import numpy as np
from scipy import special

from hlcs.data.outcome_tables import OutcomeTable, off_means
from hlcs.data.quantities import OUTCOMES
from hlcs.data.rounded_readings import last_decimal, reading_step
from hlcs.estimation.correlated_noise import CorrelatedNoise
from hlcs.estimation.flexible_curves import polynomials
from hlcs.estimation.least_squares import basis, project_out
from hlcs.estimation.noise_model import Noise
from hlcs.kinds.outcomes.repeats import LEAST_FREEDOM, SEEN, repeats_of
from hlcs.kinds.outcomes.setting_errors import MOST_BENT

SHARES = 1 - np.geomspace(1.0, 1e-6, 121)  # of the variance that may grow: the most probable of these is taken


class TableNoise(NamedTuple):
    """The noise of the rows of a table."""

    noise: Noise  # of a row of usual size
    share: float = 0.0  # of its variance that grows with the square of the outcome: 0 = all rows scatter alike, 1 = in proportion
    usual: float = 1.0  # the outcome at which both parts together are `noise` [unit of the outcome]
    least: float = 0.0  # scatter that the last digit leaves [unit of the outcome]

    def at(self, outcome):
        """Standard deviation of rows of these outcomes, (n,) [unit of the outcome]."""
        sigma = self.noise.position * np.sqrt(1 - self.share + self.share * (np.asarray(outcome) / self.usual) ** 2)
        return np.maximum(sigma, self.least) if self.share else sigma

    def of_settings(self, table: OutcomeTable, expected=None):
        """Standard deviation of a row of each distinct setting, (d,) [unit of the outcome].

        expected: outcome of each row as a model has it, nan where it never comes (n,). It counts where the mean of a setting may
        be of it: a mean that is low by chance would else weigh more. Elsewhere the mean does: rows scatter as what they read, not
        as what a wrong model foretells. None = the means.
        """
        first, back, counts = np.unique(table.setting, return_index=True, return_inverse=True, return_counts=True)[1:]
        means = np.bincount(back, table.values) / counts
        if expected is None:
            return self.at(means)
        foretold = expected[first]
        agrees = np.abs(means - foretold) < special.ndtri(1 - SEEN / 2) * self.at(foretold) / np.sqrt(counts)
        return self.at(np.where(agrees, foretold, means))

    def notes(self, table):
        """That rows scatter the more the more they read, () where they do not."""
        if not self.share:
            return ()
        unit, ends = OUTCOMES[table.outcome], (float(np.min(table.values)), float(np.max(table.values)))
        low, high = self.at(ends)
        told = f"{low:.2g} {unit} at {ends[0]:.3g} {unit}, {high:.2g} {unit} at {ends[1]:.3g} {unit}"
        return (f"rows that repeat each other scatter the more the more they read ({told}): each weighs by its own scatter",)


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
    """The RowScatter of rows that repeat each other, None where too few do or all agree to the last digit.

    Rows that were read to a digit scatter by what it leaves at least, though most of them agree.
    """
    repeats = repeats_of(table)
    if repeats.freedom < LEAST_FREEDOM or repeats.within == 0:
        return None
    sigma = max(float(np.sqrt(repeats.within / repeats.freedom)), of_the_digit(last_digit(table.values)))
    return RowScatter(sigma, repeats.freedom, "rows that repeat each other differ by")


def last_digit(values, agree=False):
    """What readings (n,) are rounded to, 0 where they are not: their step, or their last decimal.

    agree: do all agree that repeat each other? Then settings are a step apart, and no readings.
    """
    return (0.0 if agree else reading_step(values)) or last_decimal(np.unique(values))


def of_the_digit(digit):
    """Standard deviation that rounding to a digit leaves: even between two halves of it."""
    return float(digit / np.sqrt(12))


def to_know_it(table):
    """What to do where the rows of a table tell no noise, in words."""
    if (freedom := repeats_of(table).freedom) < LEAST_FREEDOM:
        more = f"; {LEAST_FREEDOM} repeats tell a noise, here {'is' if freedom == 1 else 'are'} {freedom:g}" if freedom else ""
        return f"repeat some rows with equal inputs (replicates{more}), or state measurement.noise"
    stated, agree = "state measurement.noise", "all rows of equal inputs agree"
    digit, unit = last_digit(table.values, agree=True), OUTCOMES[table.outcome]
    if not digit:
        return f"{stated}: {agree} in all digits, so they were copied or computed, and tell no noise"
    return (
        f"{stated} = {{ {table.outcome} = {of_the_digit(digit):.2g} }}, what the last digit ({digit:g} {unit}) "
        f"leaves, or more: {agree}, so they were rounded or copied, and tell no noise"
    )


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


def growing(table):
    """The TableNoise of rows that repeat each other where their scatter grows with the outcome beyond chance, else None.

    The variance is s^2 (1 - w + w y^2 / u^2) of a mean outcome y; w and s are the most probable ones, the means of the repeats
    being unknown (restricted likelihood), and what they gain over w = 0 is asked to be more than chance gives.
    """
    repeats = repeats_of(table)
    cell, counts = repeats.cell, np.bincount(repeats.cell)
    means = np.bincount(cell, table.values) / counts
    squares, freedom = np.bincount(cell, off_means(repeats.values, cell) ** 2), counts - 1
    part = repeats.freedom / freedom.sum()  # what groups differ by was taken from the values, too
    squares = squares / part
    least = of_the_digit(last_digit(table.values))
    squares = squares + freedom * least**2  # repeats that agree to the last digit scatter below it
    usual = float(np.sqrt(freedom @ means**2 / freedom.sum()))
    variance = 1 - SHARES[:, None] + SHARES[:, None] * (means / usual) ** 2
    sigma = np.sqrt(squares @ (1 / variance).T / freedom.sum())
    cost = part * (2 * freedom.sum() * np.log(sigma) + np.log(variance) @ freedom)
    best = int(np.argmin(cost))
    if cost[0] - cost[best] < special.chdtri(1, 2 * SEEN):  # w = 0 is an end: half of all chance gains are none
        return None
    scatter = RowScatter(float(sigma[best]), repeats.freedom, "")
    return TableNoise(scatter.noise("replicates"), float(SHARES[best]), usual, least)


def table_noise(file, table):
    """The TableNoise of a table: stated, or from replicates (rows with equal inputs); unknown otherwise."""
    stated = file.noise.get(table.outcome, file.noise.get("outcome"))
    if stated is not None:
        return TableNoise(Noise(CorrelatedNoise(stated, 0.0, 0.0, np.zeros((3, 3))), None, 1.0, "stated"))
    repeats = between_repeats(table)
    if repeats is None:
        return TableNoise(Noise(None, None, 1.0, "unknown"))
    return growing(table) or TableNoise(repeats.noise("replicates"))
