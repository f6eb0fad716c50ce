"""What a kind of measurement must offer. `compare` and `diagnose` know nothing else of it: a new kind is one more class.

An Experiment is an experiment file read and checked, its noise known or known to be unknown. It can show the model under test
beside the measurement (`observe`), and search for what that model is missing (`search`).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from hlcs.records import Explanation
from hlcs.selection.verdict import Selection


@dataclass(frozen=True)
class Options:
    """How the user wants a comparison or a diagnosis to be made."""

    user_effects: tuple[type, ...] = ()  # effect classes of the user's own
    seed: int = 0  # of simulations
    workers: int | None = None  # processes, None = one for each core
    progress: bool = False
    log: Callable[[str], None] = lambda text: None  # told what is being tried


class Observation(NamedTuple):
    """The model under test beside the measurement; fields as in `records.Comparison`."""

    adequate: bool
    statistic: float
    p: float
    error: dict
    where: tuple[dict, ...]
    table: dict
    notes: tuple[str, ...]
    shown: dict  # what else a Comparison has of this kind: trials, channels, against, impacts, stated


class Experiment(Protocol):
    """One experiment file of one kind of measurement."""

    kind: str  # its name in experiment files
    title: str
    unit: str  # of the error
    measure: str  # of the error, "rms" or "mean relative error"
    judgeable: bool  # is the noise known?
    noise: dict  # what is known of it, as it is told
    notes: tuple[str, ...]  # what a reader must know of the data
    advice: str  # where the noise is unknown: what to record
    unjudged: Explanation  # where it is unknown: what is said of every candidate

    def observe(self) -> Observation:
        """The model under test beside the measurement."""

    def names(self, candidates) -> tuple[str, ...]:
        """Names of all candidates that could be tried; candidates: names to choose from, None = the library."""

    def search(self, candidates) -> Selection:
        """What the model under test is missing."""


def misfit(residual, unit, noise):
    """The error of residuals (n,), measured - model, beside their noise."""
    return {"rms": float(np.sqrt(np.mean(residual**2))), "unit": unit, "noise": noise, "bias": float(np.mean(-residual))}
