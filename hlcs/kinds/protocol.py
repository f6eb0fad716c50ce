"""What a kind of measurement must offer. `compare` and `diagnose` know nothing else of it: a new kind is one more class.

An OpenExperiment is an experiment whose data are read and checked, its noise known or known to be unknown. It can show the model
under test beside the measurement (`observe`), and search for what that model is missing (`search`).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from hlcs.data.experiment_file import Layout
from hlcs.estimation.linearization import Fit
from hlcs.estimation.noise_model import Noise
from hlcs.estimation.problem import Problem
from hlcs.records import Explanation
from hlcs.selection.planning import Pilot
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
    shown: dict  # what else a Comparison has of this kind: trials, channels, against, impacts, stated, noise_shown, ..
    aside: tuple[np.ndarray, ...] = ()  # samples that were set aside, (n, channels) booleans of each recording


class OpenExperiment(Protocol):
    """One experiment of one kind of measurement, opened."""

    kind: str  # its name in experiment files
    layout: Layout  # what such a file holds
    title: str
    unit: str  # of the error
    measure: str  # of the error, "rms" or "mean relative error"
    carried_noise: bool  # does a model carry errors of inputs into the noise, so that the better model tells it?
    shows_motion: bool  # do the data tell apart what acts on the way and what acts at its end?
    judgeable: bool  # is the noise known?
    noise: dict  # what is known of it, as it is told
    notes: tuple[str, ...]  # what a reader must know of the data
    advice: str  # where the noise is unknown: what to record
    unjudged: Explanation  # where it is unknown: what is said of every candidate

    def observe(self, aside=()) -> Observation:
        """The model under test beside the measurement.

        aside: of an Observation of the same data, given only where that one had any: its samples are set aside here too, in place
        of those that stand alone beside this model, so that two models are compared on the same data.
        """

    def names(self, candidates) -> tuple[str, ...]:
        """Names of all candidates that could be tried; candidates: names to choose from, None = the library."""

    def search(self, candidates) -> Selection:
        """What the model under test is missing."""

    def pilot(self, effect) -> Pilot:
        """These data as what other experiments, to find an effect of this name, would be like."""


class Tabulated:
    """What the kinds of measurement have in common whose models foretell every number of a table at once."""

    shows_motion = False

    @staticmethod
    def polisher(problem, best, on_all):
        """Function fit -> (problem, fit) as they are: no time step stands between them and the numbers, and all rows are used."""
        return lambda fit: (problem, fit)

    @staticmethod
    def alone(problem, fit):
        """The fit itself."""
        return fit

    with_step_error = alone

    @staticmethod
    def polished_notes(problem, final):
        """None: nothing is changed."""
        return ()

    @staticmethod
    def moved(problem):
        """Nothing: no body moves through a fluid."""
        return []

    def noise_shown(self, problem, fit):
        """Nothing: the scatter of tables is known from what repeats each other in them."""
        return None

    @staticmethod
    def starts_shown(problem, fit):
        """Nothing: what a table states of its starts are its inputs."""
        return None

    @staticmethod
    def learn(problem, fit, best):
        """Nothing: a law is learned from motion, and from tables of rebounds."""


@dataclass(frozen=True)
class Prepared:
    """An experiment with a Problem that is ready to be compared or diagnosed."""

    noise: Noise
    problem: Problem | None  # None where the noise is unknown
    base: Fit | None  # of the model under test
    notes: tuple[str, ...]
    aside: tuple[str, ...] = ()  # sentences on the samples that were set aside


def misfit(residual, unit, noise):
    """The error of residuals (n,), measured - model, beside their noise."""
    return {"rms": float(np.sqrt(np.mean(residual**2))), "unit": unit, "noise": noise, "bias": float(np.mean(-residual))}


def misses(table, inside):
    """How far the model misses some observations of a table: in their unit, and in units of their noise."""
    return {
        name: float(np.sqrt(np.mean(table[column][inside] ** 2))) for name, column in (("rms", "residual"), ("sigma", "sigmas"))
    }
