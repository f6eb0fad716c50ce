"""Candidates that are not forces: the same face as an effect of the engine, another hook.

An effect of the engine adds forces, added mass or a contact law. A `Change` instead alters the set-up before the model
runs (`setup`: the body, the surroundings, the settings) or what the camera saw of the run (`look`). Parameters carry the
same metadata, and at its null value a change is exactly absent.
"""

from dataclasses import dataclass
from enum import Enum, auto
from typing import ClassVar, NamedTuple

import numpy as np

from hlcs.data.experiment_file import Body, Surroundings
from minibullet.effects.contract import Facts


class DataNeed(Enum):
    """What a change needs of the data, beside what laws of physics need (minibullet.effects.contract.Need)."""

    HEIGHT = auto()  # measured
    UNLIKE_HEIGHTS = auto()  # recordings that do not all pass the same heights at the same times
    TURNING = auto()  # the body is seen to turn, or a contact turns it
    LEANING = auto()  # the same, where the contact of a sphere is none that leans
    ACCELERATIONS = auto()  # read


@dataclass(frozen=True)
class Setup:
    """All that a run of the model depends on, besides effects and the start."""

    body: Body
    surroundings: Surroundings
    margin: float = 0.0  # gap that contacts keep open [m]
    centre: tuple = (0.0, 0.0, 0.0)  # centre of mass from the tracked centre, body axes [m]
    session: str = ""  # of a row of a table: whose clock and ruler measured it


class Scene(NamedTuple):
    """What a change of the measurement may know of B runs seen together."""

    still_before: np.ndarray  # the body is known to rest until its release, boolean (B,)
    low: float  # lowest and highest measured height of the whole experiment [m]
    high: float
    session: np.ndarray | None = None  # names of the sessions of the runs (B,)


@dataclass(frozen=True)
class Change(Facts):
    """Base of the candidates that are not forces; override one hook and state its facts."""

    by_session: ClassVar[bool] = False  # may its numbers be others in each session of a measurement?
    by_person: ClassVar[bool] = False  # and for each person, whose reaction time is their own?

    def setup(self, setup: Setup) -> Setup:
        """The set-up as it really was, given the nominal one."""
        return setup

    def look(self, look, scene: Scene):
        """What was recorded, given what happened: a function times (B, n) -> (position (B, n, 3), orientation (B, n, 4))."""
        return look

    def read(self, force):
        """What an accelerometer read along its axes, given what there was to be read (B, n, 3) [m/s2]."""
        return force

    def inputs(self, inputs, unit):
        """True inputs of a table, given the stated ones (name -> (n,)); unit of the outcome, "s" or "m"."""
        return inputs

    def outcome(self, values, unit):
        """Recorded outcomes of a table, given the true ones (n,); unit "s" or "m"."""
        return values

    def in_session(self, name):
        """What it is for rows of a table that were measured in that session."""
        return self


@dataclass(frozen=True)
class BySession(Change):
    """A change of what was recorded that is another one in each session; runs of no session that it names stay as they are."""

    parts: tuple[tuple[str, Change], ...] = ()

    def in_session(self, name):
        return dict(self.parts).get(name, Change())

    def look(self, look, scene):
        parts = [(np.flatnonzero(scene.session == name), change.look(look, scene)) for name, change in self.parts]

        def seen(times):
            position, orientation = (np.array(part) for part in look(times))
            for inside, recorded in parts:
                if len(inside):
                    its_position, its_orientation = recorded(times)
                    position[inside], orientation[inside] = its_position[inside], its_orientation[inside]
            return position, orientation

        return seen


def in_sessions(numbers):
    """{session: {number: value}} of numbers {"offset A": value, ..}, as each stands in one session; {} where none names one."""
    found = {}
    for key, value in numbers.items():
        name, _, session = key.partition(" ")
        if session:
            found.setdefault(session, {})[name] = value
    return found
