"""Errors that all rows of one setting share: of its inputs, and what else differs from one setting to the next.

A height that was set 1 cm too high is so in every repeat at that height, and no scatter of replicates shows it. Such an error is
no noise of single rows: it stands in the covariance of the rows of one setting.
"""

from typing import NamedTuple

import numpy as np
from scipy import special

from hlcs.data.quantities import INPUTS, OUTCOMES
from hlcs.kinds.outcomes.repeats import DRAWS, LEAST_FREEDOM, SEEN
from hlcs.simulation import outcome_motion
from hlcs.simulation.row_setups import row_setup

LEAST_SETTINGS = 6  # from which scatter between settings is told from the bend of an effect
MOST_BENT = 3  # degree of the curve: what the library does to an outcome bends no more over a range of one input
APART = 0.05  # probability below which neighbours are too much alike for scatter: the rest of an effect would be so
LARGEST = 0.25  # of the mean step from one setting to the next that an error of it may be: heights 0.2 m apart are set better
FINE = 400  # variances, from far below that of a mean to far above the misfit, among which the most probable is looked for
NO_ERROR = (
    "beyond what their replicates and the stated errors of inputs explain: an error of the input that makes so much is more than "
    "a quarter of the way to the next setting, so it is not taken for one"
)


class SettingErrors(NamedTuple):
    """What rows of one setting share."""

    deviation: np.ndarray  # one sigma of each distinct setting [unit of the outcome] (d,)
    doubt: float = 0.0  # standard deviation of its logarithm, where it was read from few settings
    scatter: float = 0.0  # the part of it that no input explains, one sigma [unit of the outcome]
    notes: tuple[str, ...] = ()

    @property
    def of_inputs(self):
        """The part of it that the stated errors of inputs are (d,) [unit of the outcome]."""
        return np.sqrt(np.maximum(self.deviation**2 - self.scatter**2, 0.0))


def of_inputs(file, table, model):
    """One sigma of the outcome of each distinct setting from the errors of its inputs (d,) [unit of the outcome].

    The outcome that a model foretells at the input plus and minus one sigma differs by twice its error; errors of several inputs
    are independent. An input that has its error already at its limit (a height of zero) is taken from there; where an outcome
    never comes at one end (a slope too gentle to slide), the other end is set beside the input itself.
    """
    _, first = np.unique(table.setting, return_index=True)
    inputs, total = {name: values[first] for name, values in table.inputs.items()}, np.zeros(len(first))
    usual = settings_at(file, table, model, inputs) if table.input_sd else None
    for name, sd in table.input_sd.items():
        ends = [within(name, inputs[name] + sign * sd[first]) for sign in (1, -1)]
        found = [settings_at(file, table, model, inputs | {name: end}) for end in ends]
        high, low = (np.where(np.isnan(there), usual, there) for there in found)
        above, below = (np.where(np.isnan(there), inputs[name], end) for there, end in zip(found, ends, strict=True))
        width = above - below
        total += (np.where(width > 0, high - low, 0.0) * sd[first] / np.where(width > 0, width, 1.0)) ** 2
    return np.sqrt(np.nan_to_num(total))


def within(name, values):
    """Values of an input, kept where there are such."""
    low, high = INPUTS[name]
    return np.clip(values, low, high)


def outcomes_at(file, table, model):
    """Outcomes (n,) that a model foretells of the rows of a table."""
    _, first, back = np.unique(table.setting, return_index=True, return_inverse=True)
    return settings_at(file, table, model, {name: values[first] for name, values in table.inputs.items()}, len(first))[back]


def settings_at(file, table, model, inputs, count=None):
    """Outcomes (d,) that a model foretells at inputs {name: (d,)}; count: d, where there may be no inputs."""
    count = len(next(iter(inputs.values()))) if count is None else count
    setups = [row_setup(file, inputs, row) for row in range(count)]
    with np.errstate(all="ignore"):
        return outcome_motion.outcomes(model, setups, inputs, table.outcome)


def setting_errors(file, table, sigma, model, expected):
    """The SettingErrors of a table.

    sigma: of one row of each setting (d,) [unit of the outcome]; model: at which errors of inputs are propagated; expected: what
    it foretells of each row (n,).
    """
    known = of_inputs(file, table, model)
    _, first = np.unique(table.setting, return_index=True)
    scatter, unit = between_settings(table, sigma, known, expected[first]), OUTCOMES[table.outcome]
    if scatter.alone is not None:
        return SettingErrors(known, notes=(_stands_alone(table, first[scatter.alone]),))
    if scatter.too_large:
        return SettingErrors(known, notes=(f"settings scatter by {scatter.too_large:.2g} {unit} {NO_ERROR}",))
    if not scatter.size > 0:
        return SettingErrors(known)
    note = (
        f"settings scatter by {scatter.size:.2g} {unit} beyond what their replicates (each off by {np.median(sigma):.2g} {unit}) "
        "and the stated errors of inputs explain, in no order that so few settings show: taken as an error that the rows "
        "of a setting share. If no setting can be so far off, something is missing: state what each may be off by, "
        "measurement.input_sd"
    )
    return SettingErrors(np.hypot(known, scatter.size), float(1 / np.sqrt(2 * scatter.freedom)), scatter.size, (note,))


def _stands_alone(table, row):
    """The note on the one setting, of which a row is given, that all the scatter comes from."""
    inputs = ", ".join(f"{name} = {values[row]:g}" for name, values in table.inputs.items() if np.ptp(values) > 0)
    return (
        f"the rows at {inputs} lie off a curve through all others, which scatter no more than they should: check that setting, "
        "where nothing that was found explains it"
    )


class Scatter(NamedTuple):
    """What differs between settings beside their inputs."""

    size: float = 0.0  # one sigma [unit of the outcome]; 0 = none is seen
    freedom: int = 0  # degrees of freedom that it was read from
    alone: int | None = None  # the distinct setting that carries it alone, then no scatter; None = all do
    too_large: float = 0.0  # one sigma that is seen, and that no error of the input can make [unit of the outcome]; 0 = none


def between_settings(table, sigma, known, expected):
    """The Scatter of a table.

    sigma: of one row of each setting; known: of each setting from its inputs; expected: outcomes of the model under test (d,).

    It must not be the signal of an effect. So it is looked for only where one input alone varies, where rows are repeated, and in
    what is left of the misfit of the setting means once a polynomial of that input is taken away, at least of second degree:
    effects follow an input along a curve, and one that a polynomial does not follow leaves neighbours alike (J. von Neumann, Ann.
    Math. Stat. 12 (1941) 367). Where that is seen, or fewer than six settings were measured, none is taken; nor where an error of
    the input would have to be so large that settings could be taken for each other (where the outcome hardly depends on the
    input, it is something else that differs from one setting to the next). Its variance is that of R. DerSimonian and
    N. Laird, Control. Clin. Trials 7 (1986) 177: what the weighted sum of squares has in excess.
    """
    _, first, counts = np.unique(table.setting, return_index=True, return_counts=True)
    varied = [values[first] for values in table.inputs.values() if np.ptp(values) > 0]
    freedom_of_rows = int(np.sum(counts - 1))
    if len(varied) != 1 or len(first) < LEAST_SETTINGS or np.any(counts < 2) or not np.isfinite(expected).all():
        return Scatter()
    order = np.argsort(varied[0])
    x = varied[0][order]
    means = np.array([np.mean(table.values[table.setting == setting]) for setting in np.unique(table.setting)])
    misfit, variance = (means - expected)[order], (sigma**2 / counts + known**2)[order]
    degree = min(MOST_BENT, len(x) - 1 - LEAST_FREEDOM)
    curve = np.polynomial.chebyshev.chebvander(2 * (x - x[0]) / (x[-1] - x[0]) - 1, degree)
    weights = 1 / variance
    hat = curve @ np.linalg.solve(curve.T @ (weights[:, None] * curve), curve.T * weights)
    left = np.eye(len(x)) - hat
    rest, freedom = left @ misfit, len(x) - degree - 1
    excess = float(weights @ rest**2)
    seen = special.fdtrc(freedom, freedom_of_rows, excess / freedom) < SEEN
    if not seen or neighbours_alike(rest, left, np.sqrt(variance)):
        return Scatter()
    alone = carried_by_one(misfit, curve, variance)
    if alone is not None:
        return Scatter(alone=int(order[alone]))
    size = float(np.sqrt((excess - freedom) / np.trace(weights[:, None] * left)))
    step = (x[-1] - x[0]) / (len(x) - 1) * np.median(np.abs(np.gradient(expected[order], x)))  # of the outcome
    return Scatter(too_large=size) if LARGEST * step < size < np.ptp(expected) else Scatter(size, freedom)


def carried_by_one(misfit, curve, variance):
    """Which of the observations (d,) is more probably wrong by itself than all scatter alike; None where all do.

    curve: columns that are fitted to them (d, p); variance: of each without any scatter (d,). Two models of one number each are
    compared by what is left of the observations beside the curve (restricted likelihood: H. D. Patterson, R. Thompson, Biometrika
    58 (1971) 545): an unknown variance of all, or an unknown variance of one, which may be any of the d.
    """
    beside = np.linalg.qr(curve, mode="complete")[0][:, curve.shape[1] :]
    rest, covariance = beside.T @ misfit, beside.T @ (variance[:, None] * beside)
    sizes, axes = np.linalg.eigh(covariance)
    shared = sizes[0] * 1e-2 * np.geomspace(1.0, 1e4 * max(rest @ rest / sizes[0], 1.0), FINE)[:, None]
    of_all = np.min(np.sum(np.log1p(shared / sizes) + (axes.T @ rest) ** 2 / (sizes + shared), axis=1))
    white = beside @ np.linalg.inv(covariance)
    deleted = (white @ rest) ** 2 / np.einsum("ij,ij->i", white, beside)  # fall of chi2 if one alone may be anything
    worst = int(np.argmax(deleted))
    # log(1 + u) - z^2 u/(1 + u) is least where the variance u of the one, in its own, is z^2 - 1
    most = max(deleted[worst], 1.0)
    of_one = rest @ np.linalg.solve(covariance, rest) + np.log(most) - (most - 1.0)
    return worst if of_one + 2 * np.log(len(misfit)) < of_all else None


def neighbours_alike(rest, left, deviations):
    """Are neighbours among what a curve leaves (d,) more alike than scatter without order would leave them?

    left: what the curve leaves of observations, a projection (d, d); deviations: of these (d,).
    """

    def ratio(values):
        return np.sum(np.diff(values, axis=0) ** 2, axis=0) / np.sum(values**2, axis=0)

    drawn = np.random.default_rng(12345).standard_normal((len(rest), DRAWS)) * deviations[:, None]
    return bool(np.mean(ratio(left @ drawn) <= ratio(rest[:, None])) < APART)
