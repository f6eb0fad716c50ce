"""Candidates that are not forces: the same face as an effect of the engine, another hook.

An effect of the engine adds forces, added mass or a contact law. A `Change` instead alters the set-up before the model
runs (`setup`: the body, the surroundings, the settings) or what the camera saw of the run (`look`). Parameters carry the
same metadata, and at its null value a change is exactly absent.
"""

from dataclasses import dataclass
from enum import Enum, auto
from typing import NamedTuple

import numpy as np

from hlcs.data.experiment_file import Body, Surroundings
from minibullet.effects.contract import Facts


class DataNeed(Enum):
    """What a change needs of the data, beside what laws of physics need (minibullet.effects.contract.Need)."""

    HEIGHT = auto()  # measured
    UNLIKE_HEIGHTS = auto()  # recordings that do not all pass the same heights at the same times
    TURNING = auto()  # the body is seen to turn, or a contact turns it
    LEANING = auto()  # the same, where the contact of a sphere is none that leans


@dataclass(frozen=True)
class Setup:
    """All that a run of the model depends on, besides effects and the start."""

    body: Body
    surroundings: Surroundings
    time_step: float = 1 / 240  # [s]
    margin: float = 0.0  # gap that contacts keep open [m]
    centre: tuple = (0.0, 0.0, 0.0)  # centre of mass from the tracked centre, body axes [m]


class Scene(NamedTuple):
    """What a change of the measurement may know of B runs seen together."""

    start_position: np.ndarray  # (B, 3) [m]
    still_before: np.ndarray  # the body is known to rest until its release, boolean (B,)
    floor_height: float | None  # [m]
    low: float  # lowest and highest measured height of the whole experiment [m]
    high: float


@dataclass(frozen=True)
class Change(Facts):
    """Base of the candidates that are not forces; override one hook and state its facts."""

    def setup(self, setup: Setup) -> Setup:
        """The set-up as it really was, given the nominal one."""
        return setup

    def look(self, look, scene: Scene):
        """What was recorded, given what happened: a function times (B, n) -> (position (B, n, 3), orientation (B, n, 4))."""
        return look

    def inputs(self, inputs, unit):
        """True inputs of a table, given the stated ones (name -> (n,)); unit of the outcome, "s" or "m"."""
        return inputs

    def outcome(self, values, unit):
        """Recorded outcomes of a table, given the true ones (n,); unit "s" or "m"."""
        return values
