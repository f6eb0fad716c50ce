"""What a fit is made of: which numbers are observations, the linearisation
at one point, the fitted model, and what became of a candidate."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from hlcs.effects import Candidate
from hlcs.estimation.least_squares import basis, least_squares, project_out
from hlcs.estimation.whitening import Whitening
from hlcs.simulation.model import Model


@dataclass(frozen=True)
class Recording:
    """Which numbers of one trial are observations, sorted by channel and time."""

    channel: np.ndarray  # 0-2 position, 3-5 rotation (n,)
    sample: np.ndarray  # row of the trial (n,)
    times: np.ndarray  # (n,) [s]
    whitening: Whitening
    unknown: tuple  # what of the initial state is fitted: (slot, direction (3,)) each


@dataclass(frozen=True)
class Linearization:
    """The problem around one point; lists over the recordings, whose observations are rows (n_i,)."""

    raw: list  # residuals in units of the channels
    white: list  # whitened residuals
    state_columns: list  # white changes per unit of each unknown of the initial state (n_i, unknowns_i)
    parameter_columns: list  # white changes per unit of each free number of the model (n_i, p)
    state_moves: list | None = None  # what the initial states do along with each free number, per unit of it (unknowns_i, p)
    trajectories: list | None = None  # the runs that `raw` was read from: (position (n, 3), orientation (n, 4)) each

    @cached_property
    def state_bases(self):
        """Orthonormal bases of the columns of the initial states."""
        return [basis(columns) for columns in self.state_columns]

    @cached_property
    def projected(self):
        """(white residuals, parameter columns) with the initial states projected out."""
        return tuple(
            [project_out(q, part) for q, part in zip(self.state_bases, parts, strict=True)]
            for parts in (self.white, self.parameter_columns)
        )

    @cached_property
    def residual(self):
        """(projected residual of all recordings with the free numbers projected out (n,), orthonormal basis of the latter)."""
        r, s = (np.concatenate(parts) for parts in self.projected)
        q = basis(s)
        return project_out(q, r), q


@dataclass(frozen=True)
class Fit:
    """A fitted model."""

    model: Model
    initial_states: np.ndarray  # (trials, 13)
    linearization: Linearization
    estimate: np.ndarray  # of the free numbers of model.terms, in order (p,)
    covariance: np.ndarray  # for the stated noise (p, p)
    at_bound: tuple[bool, ...]

    def numbers_of(self, index):
        """Where the free numbers of one term stand among those of all, a slice; -1 is the newest term."""
        counts = [len(term.candidate.free) for term in self.model.terms]
        first = sum(counts[: index % len(counts)])
        return slice(first, first + counts[index])

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


@dataclass
class CandidateTrial:
    """What became of one candidate in one round."""

    candidate: Candidate
    linear_gain: float = 0.0
    gain: float = 0.0  # fall of chi2 after the refit
    required_gain: float = 0.0  # fall of chi2 that its complexity asks for
    fit: Fit | None = None
    p: float = 1.0  # one-sided, of being no better on held-out data
    holm: float = 1.0
    directions: tuple[float, ...] = ()  # relative fall of the held-out error in each direction
    falls: float = 0.0  # relative fall of the held-out error, all directions
    falls_sigma: float = 0.0
    fails: list = field(default_factory=list)
    signature: list | None = None
    by_linear_step: bool = False  # its fit is a linear step only
    visible: float = 0.0  # norm of the projected signature: 0 = these data cannot show it


def free_numbers(model):
    """Free numbers of a model's terms, in order, list of Free."""
    return [free for term in model.terms for free in term.candidate.free]


def best_view(views, q, aim):
    """The (values while absent, signature, linear step) of the view that explains most of aim (n,), q projected out of it.

    views: [(values at which a candidate is absent, its projected signature there)].
    """
    steps = [least_squares(project_out(q, np.concatenate(signature)), project_out(q, aim)) for _, signature in views]
    best = max(range(len(views)), key=lambda place: steps[place].gain)
    return *views[best], steps[best].estimate
