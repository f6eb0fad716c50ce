"""What a fit is made of: which numbers are observations, the linearisation at one point, the fitted model."""

from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np

from hlcs.estimation.least_squares import basis, belief, least_squares, project_out
from hlcs.estimation.whitening import Whitening
from hlcs.simulation.model import Model

AT_END = 1e-3  # spreads from where a law ends: a fit comes no nearer than its last step


@dataclass(frozen=True)
class Recording:
    """Which numbers of one trial are observations, sorted by channel and time."""

    channel: np.ndarray  # number in CHANNELS (n,)
    sample: np.ndarray  # row of the trial (n,)
    times: np.ndarray  # (n,) [s]
    whitening: Whitening
    unknown: tuple  # what of the initial state is fitted: (slot, direction (3,)) each
    spreads: np.ndarray | None = None  # how wide the belief in each of them is (unknowns,); None = none is spared its price

    @property
    def freedom(self):
        """Observations less unknowns of the initial state."""
        return max(len(self.times) - len(self.unknown), 1)


@dataclass(frozen=True)
class Linearization:
    """The problem around one point; lists over the recordings, whose observations are rows (n_i,)."""

    raw: list  # residuals in units of the channels
    white: list  # whitened residuals
    state_columns: list  # white changes per unit of each unknown of the initial state (n_i, unknowns_i)
    parameter_columns: list  # white changes per unit of each free number of the model (n_i, p)
    state_moves: list | None = None  # what the initial states do along with each free number, per unit of it (unknowns_i, p)
    trajectories: list | None = None  # the runs that `raw` was read from: a Motion each
    state_spreads: list | tuple = ()  # `spreads` of the recordings

    @cached_property
    def state_bases(self):
        """Orthonormal bases of the columns of the initial states."""
        return [basis(columns) for columns in self.state_columns]

    @cached_property
    def projected(self):
        """(white residuals, parameter columns) with the initial states projected out."""
        return self.without_states(self.white), self.without_states(self.parameter_columns)

    def without_states(self, white):
        """White values of every recording, list of (n_i,) or (n_i, k), with the initial states projected out."""
        return [project_out(q, part) for q, part in zip(self.state_bases, white, strict=True)]

    def spared(self, overdispersion=1.0):
        """What is not paid for unknowns of the initial states, as `occam` has it, since the data do not show them.

        Usual motions show each of them better than one observation would, so that every model pays the same for them: 0. But a
        strong drag ends a start at once; where it is missing the same paths need starts that are tuned as finely as they are
        read, and a bead that weighs nothing in its liquid would stand for all that sink slowly.
        """
        total = 0.0
        for columns, spreads in zip(self.state_columns, self.state_spreads, strict=False):
            if spreads is None:
                continue
            count = max(len(columns) / overdispersion, 1.0)
            seen = columns * spreads
            total += len(spreads) * np.log(count) - occam(seen.T @ seen / overdispersion, count)
        return total


@dataclass(frozen=True, eq=False)  # no other one is the same
class Fit:
    """A fitted model."""

    model: Model
    initial_states: np.ndarray  # (trials, 13)
    linearization: Linearization
    estimate: np.ndarray  # of the free numbers of model.terms, in order (p,)
    covariance: np.ndarray  # for the stated noise (p, p)
    converged: bool = True
    withheld: dict = field(default_factory=dict)  # (effect, number) -> why its value is not given
    sides: np.ndarray | float = 1.0  # standard errors that each number may go down and up for one (2, p)
    step_error: np.ndarray | float = 0.0  # what is left of the error of the time step may move its numbers by so much (p,)
    doubt: float = 0.0  # -2 log of its likelihood less chi2, where what its effects do is not known exactly

    @property
    def numbers(self):
        """Its free numbers, in order: [(effect, Free, value)]."""
        free = [(term.name, free) for term in self.model.terms for free in term.candidate.free]
        return [(*number, value) for number, value in zip(free, self.estimate, strict=True)]

    @cached_property
    def spreads(self):
        """How wide the belief in each free number is (p,)."""
        return np.array([free.spread for free in free_numbers(self.model)])

    @property
    def errors(self):
        """Standard errors of its numbers, above zero (p,)."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 1e-300))

    @cached_property
    def ends(self):
        """How far each free number may go down and up until its law ends, (2, p)."""
        return np.array([(free.least - value, free.most - value) for _, free, value in self.numbers]).reshape(-1, 2).T

    @cached_property
    def held(self):
        """Which free numbers stand where their law ends while the data would have them beyond, (p,): nothing gives way along
        them."""
        residuals, columns = (np.concatenate(part) for part in self.linearization.projected)
        wanted, (down, up) = columns.T @ residuals, self.ends
        return (down > -AT_END * self.spreads) & (wanted < 0) | (up < AT_END * self.spreads) & (wanted > 0)

    def numbers_of(self, index):
        """Where the free numbers of one term stand among those of all, a slice; -1 is the newest term."""
        counts = [len(term.candidate.free) for term in self.model.terms]
        first = sum(counts[: index % len(counts)])
        return slice(first, first + counts[index])

    @cached_property
    def surprise(self):
        """-2 log of what was believed of its numbers, relative to what was expected; infinite where one cannot be, such as a
        liquid so dense that a bead of steel weighs nothing in it."""
        possible = all(free.possible(value) for _, free, value in self.numbers)
        return sum(free.surprise(value) for _, free, value in self.numbers) if possible else np.inf

    @property
    def implausible(self):
        """How many of its numbers lie beyond their plausible ranges."""
        return sum(not free.plausible(value) for _, free, value in self.numbers)

    @cached_property
    def contradicts(self):
        """Does it need a number that contradicts what the file states?"""
        return any(free.contradicts(value) for _, free, value in self.numbers)

    @cached_property
    def information(self):
        """What the data tell of its numbers, in units of their spreads (p, p)."""
        columns = np.concatenate(self.linearization.projected[1]) * self.spreads
        return columns.T @ columns

    @cached_property
    def cost(self):
        """-2 log of the evidence for the model, up to a constant of the data."""
        return self.tempered(1.0)

    def tempered(self, overdispersion):
        """The same where so many residuals count as one (`estimation.adequacy`): the data tell less, what is believed stays."""
        paid = occam(self.information / overdispersion, self.count / overdispersion)
        return self.chi2 / overdispersion + self.doubt + self.surprise + paid - self.linearization.spared(overdispersion)

    @cached_property
    def known_from_data(self):
        """What the data tell of its numbers by their covariance, what was believed of them aside, in units of their spreads
        (p, p)."""
        known = np.linalg.pinv(self.covariance / np.outer(self.spreads, self.spreads), hermitian=True)
        size, axes = np.linalg.eigh(known - self._believed)
        return (axes * np.maximum(size, 0.0)) @ axes.T

    @property
    def _believed(self):
        """What is believed of its numbers where they stand, in units of their spreads (p, p)."""
        return np.diag((self.belief[1] * self.spreads) ** 2)

    @property
    def belief(self):
        """What is believed of its numbers as rows of least squares (`least_squares.belief`)."""
        return belief(self.estimate, free_numbers(self.model))

    def moved_by(self, white):
        """By how much its numbers move where its predictions change by white amounts, list of (n_i,), to first order (p,)."""
        columns = white_columns(self.linearization, self.estimate, free_numbers(self.model))
        changes = np.concatenate([*self.linearization.without_states(white), np.zeros(len(self.estimate))])
        if not (np.isfinite(columns).all() and np.isfinite(changes).all()):
            return np.zeros(len(self.estimate))  # such a fit is told to leave the finite numbers
        return -least_squares(columns, changes).estimate

    def covariance_at(self, overdispersion):
        """Covariance of its numbers where so many residuals count as one (p, p): the data tell less, what is believed stays. The
        error of the time step is one more source, which no number of readings makes smaller."""
        covariance = self.covariance
        if overdispersion != 1:
            known = np.linalg.pinv(self.known_from_data / overdispersion + self._believed, hermitian=True)
            covariance = known * np.outer(self.spreads, self.spreads)
        return covariance + np.outer(self.step_error, self.step_error)

    def savings(self, overdispersion):
        """By how much `tempered` would fall were each number where it is expected and the others beside it where the data then
        have them, foreseen from here (p,)."""
        aside = np.array([free.aside(value) for _, free, value in self.numbers])
        errors = np.diag(np.linalg.pinv(self.known_from_data, hermitian=True))
        surprise = np.array([free.surprise(value) for _, free, value in self.numbers])
        return surprise - aside**2 / np.maximum(errors, 1e-300) / overdispersion

    @cached_property
    def chi2_per_recording(self):
        """chi2 of each recording, initial states projected out (trials,)."""
        return np.array([float(r @ r) for r in self.linearization.projected[0]])

    @property
    def chi2(self):
        """Sum of squares of the whitened residuals; infinite where the model left the finite numbers."""
        total = float(self.chi2_per_recording.sum())
        return total if np.isfinite(total) else np.inf

    @cached_property
    def count(self):
        """Number of observations."""
        return sum(len(r) for r in self.linearization.white)

    @cached_property
    def freedom(self):
        """Observations less fitted numbers."""
        return max(self.count - sum(q.shape[1] for q in self.linearization.state_bases) - len(self.estimate), 1)

    @property
    def chi2_per_freedom(self):
        """chi2 per degree of freedom."""
        return self.chi2 / self.freedom


def occam(information, count):
    """What a model pays for numbers of this information (p, p), in units of their spreads.

    For each eigenvalue l of it log(1 + l), at most the logarithm of the count of observations.

    Laplace's approximation of the evidence (D. J. C. MacKay, Neural Comput. 4 (1992) 415): twice the logarithm of spread over
    standard error, nothing for what the data do not show. Nobody is charged for more ignorance than one observation would end
    (G. Schwarz, Ann. Stat. 6 (1978) 461), so that laws which say the same pay the same, however wide their ranges are.
    """
    if not np.isfinite(information).all():
        return np.inf
    return float(np.sum(np.minimum(np.log1p(np.maximum(np.linalg.eigvalsh(information), 0.0)), np.log(max(count, 1.0)))))


def white_columns(linear, values, frees):
    """What a fit of free numbers at values (p,) is: white changes of all observations, and of what is believed, per unit of each
    number, the initial states projected out (n + p, p)."""
    return np.concatenate([*linear.projected[1], np.diag(belief(values, frees)[1])])


def free_numbers(model):
    """Free numbers of a model's terms, in order, list of Free."""
    return [free for term in model.terms for free in term.candidate.free]


def width_of(free):
    """Width of the plausible range of a number, at most a thousand: some have no end."""
    return min(free.high - free.low, 1e3)


def values_of(model):
    """Values of the free numbers of a model's terms, in order (p,)."""
    return np.array([term.numbers[free.name] for term in model.terms for free in term.candidate.free])


def varied(model):
    """[(effect, Free, value, function value -> the model with it)] of the free numbers of a model's terms, in order."""

    def moved(index, name, value):
        return model.with_at(index, model.terms[index].numbers | {name: value})

    return [
        (term.name, free, term.numbers[free.name], partial(moved, index, free.name))
        for index, term in enumerate(model.terms)
        for free in term.candidate.free
    ]
