"""What a fit is made of: which numbers are observations, the problem around one point, the fitted model, and what it
says of a candidate."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from hlcs.effects import Candidate
from hlcs.estimation import inference
from hlcs.simulation.model import Model


@dataclass(frozen=True)
class Recording:
    """Which numbers of one trial are observations, sorted by channel and time."""

    channel: np.ndarray  # 0-2 position, 3-5 rotation (n,)
    sample: np.ndarray  # row of the trial (n,)
    times: np.ndarray  # (n,) [s]
    links: inference.Chain
    unknown: tuple  # what of the start is fitted: (slot, direction (3,)) each


@dataclass(frozen=True)
class Linear:
    """The problem around one point: per recording white residuals r, start columns N, parameter columns S (all n_i rows)."""

    raw: list  # residuals in units of the channels
    r: list
    n: list
    s: list
    t: list | None = None  # what the starts do along with each parameter in S, per unit of it (unknowns_i, p)
    answers: list | None = None  # the runs that `raw` was read from: (position (n, 3), orientation (n, 4)) each

    @cached_property
    def bases(self):
        """Orthonormal bases of the start columns."""
        return [inference.basis(columns) for columns in self.n]

    @cached_property
    def projected(self):
        """(residuals, signatures) with the starts projected out."""
        return (
            [inference.project_out(q, r) for q, r in zip(self.bases, self.r, strict=True)],
            [inference.project_out(q, s) for q, s in zip(self.bases, self.s, strict=True)],
        )


@dataclass(frozen=True)
class Fit:
    """A fitted model."""

    model: Model
    starts: np.ndarray  # (trials, 13)
    linear: Linear
    estimate: np.ndarray  # of the free numbers of model.terms, in order (p,)
    covariance: np.ndarray  # for the stated noise (p, p)
    at_bound: tuple[bool, ...]

    def bounds_of(self, index):
        """at_bound of the numbers of one term, tuple of booleans."""
        counts = [len(term.candidate.free) for term in self.model.terms]
        first = sum(counts[: index % len(counts)])
        return self.at_bound[first : first + counts[index]]

    @cached_property
    def losses(self):
        """chi2 of each recording, starts projected out (trials,)."""
        return np.array([float(r @ r) for r in self.linear.projected[0]])

    @property
    def chi2(self):
        """Sum of squares of the whitened residuals; infinite where the model left the finite numbers."""
        total = float(self.losses.sum())
        return total if np.isfinite(total) else np.inf

    @cached_property
    def count(self):
        """Number of observations."""
        return sum(len(r) for r in self.linear.r)

    @cached_property
    def freedom(self):
        """Observations less fitted numbers."""
        return max(self.count - sum(q.shape[1] for q in self.linear.bases) - len(self.estimate), 1)


@dataclass
class Try:
    """What became of one candidate in one round."""

    candidate: Candidate
    linear_gain: float = 0.0
    gain: float = 0.0  # fall of chi2 after the refit
    price: float = 0.0
    fit: Fit | None = None
    held_out: float | None = None  # RMS over sigma on data not used
    p: float = 1.0  # one-sided, of being no better on held-out data
    holm: float = 1.0
    directions: tuple[float, ...] = ()  # relative fall of the held-out error in each direction
    falls: float = 0.0  # relative fall of the held-out error, all directions
    falls_sigma: float = 0.0
    fails: list = field(default_factory=list)
    signature: list | None = None
    linear: bool = False  # its fit is a linear step only
    visible: float = 0.0  # norm of the projected signature: 0 = these data cannot show it


def chosen(looks, q, aim):
    """(values while absent, signature, linear step) of the look that explains most of aim (n,), q projected out of it."""
    found = []
    for view, signature in looks:
        step = inference.least_squares(inference.project_out(q, np.concatenate(signature)), inference.project_out(q, aim))
        found.append((step.gain, view, signature, step.estimate))
    best = max(range(len(found)), key=lambda place: found[place][0])
    return found[best][1:]
