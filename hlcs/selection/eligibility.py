"""Which candidates can take part in a diagnosis, and why the others cannot."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import stats

import minibullet.effects as forces
from hlcs.data.rigid_body import known_body, rigid_body
from hlcs.effects import candidate, wanted
from hlcs.effects.contract import DataNeed
from minibullet.effects.contract import Need, name_of

NO_TURNING = "orientations are not measured"


@dataclass(frozen=True)
class Shown:
    """What recordings show that a candidate may need."""

    trials: tuple
    contact: bool  # does anything touch?

    @property
    def body_known(self):
        return all(known_body(trial.body) for trial in self.trials)

    @cached_property
    def columns(self):
        return set().union(*(trial.columns for trial in self.trials))

    def starts_with(self, key):
        """Does any recording state this part of its start?"""
        return any(key in trial.start for trial in self.trials)


# need: (what is said where it is missing, test of what recordings show)
NEEDS = {
    Need.MASS_AND_SIZE: ("mass and size of the body are not stated", lambda shown: shown.body_known),
    Need.FLOOR: ("there is no floor", lambda shown: shown.trials[0].surroundings.floor_height is not None),
    Need.CONTACT: ("nothing touches in these data", lambda shown: shown.contact),
    Need.SPIN: (
        "the spin is neither measured nor stated",
        lambda shown: "rx" in shown.columns or shown.starts_with("angular_velocity"),
    ),
    Need.ROTATION: (NO_TURNING, lambda shown: "rx" in shown.columns),
    DataNeed.TURNING: (NO_TURNING, lambda shown: "rx" in shown.columns or shown.contact),
    DataNeed.LEANING: (
        NO_TURNING,
        lambda shown: "rx" in shown.columns or shown.contact and shown.trials[0].body.shape != "sphere",
    ),
    Need.RELEASE: ("the moment of release is not known (no start velocity stated)", lambda shown: shown.starts_with("velocity")),
    Need.SIDEWAYS: ("no horizontal position is measured", lambda shown: bool(shown.columns & {"x", "y"})),
    DataNeed.HEIGHT: ("no height is measured", lambda shown: "z" in shown.columns),
    DataNeed.UNLIKE_HEIGHTS: (
        "all recordings pass the same heights at the same times, so any misfit would look like it",
        lambda shown: not all_alike(shown.trials),
    ),
}


def candidates_for(measurement, contact, names=None, own=()):
    """(candidates, {name: why it cannot take part}) for trajectories; `names` None = all that fit, else just these."""
    first, shown = measurement.trials[0], Shown(measurement.trials, contact)
    why = {kind: stated(kind, measurement.file) or obstacle(kind, shown) for kind in wanted(names, own)}
    heights = np.concatenate([trial.position[:, 2] for trial in measurement.trials])
    extent = float(np.nanmax(heights) - np.nanmin(heights)) if np.isfinite(heights).any() else 1.0
    return eligible(why, first.body, first.surroundings, shown.body_known, own, max(extent, 1e-3))


def eligible(why, body, surroundings, body_known, own, extent=1.0):
    """(candidates, {name: why it cannot take part}), both by name, from {class: why it cannot, or None}."""
    solid = rigid_body(body)
    found = [candidate(kind, surroundings, solid, body_known, kind in own, extent) for kind, text in why.items() if not text]
    return sorted(found, key=lambda entry: entry.name), {name_of(kind): text for kind, text in why.items() if text}


def obstacle(kind, shown):
    """What a class needs that recordings do not show, in words, or None."""
    return next((text for text, met in map(NEEDS.get, kind.needs) if not met(shown)), None)


def stated(kind, file):
    """Why a class cannot join what an experiment file states as its model, or None."""
    names = [entry["name"] for entry in file.effects]
    if name_of(kind) in names:
        return "already in the model"
    taken = next((name_of(law) for law in kind.contains if name_of(law) in names), None)
    return taken and (f"the model states {taken}, whose place it would take: leave that out of [model] effects to have it tried")


def all_alike(trials):
    """Do all recordings run through their heights once, in one direction, and in the same way, to a tenth of the range?"""
    tracks = []
    for trial in trials:
        there = np.isfinite(trial.position[:, 2])
        t, z = trial.times[there], trial.position[there, 2]
        if len(t) < 6 or abs(stats.spearmanr(t, z).statistic) < 0.97:
            return False
        tracks.append((t - t[0], z))
    span = max(np.ptp(z) for _, z in tracks)
    shared = np.linspace(0.0, min(t[-1] for t, _ in tracks), 20)
    table = np.array([np.polyval(np.polyfit(t, z, 4), shared) for t, z in tracks])
    return bool(np.max(np.ptp(table, axis=0)) < 0.1 * span)


def lacks_drag(entry, model):
    """Does a candidate act only through a drag, and the model has none?"""
    return entry.through_drag and not has_drag(model)


def has_drag(model):
    """Is there a drag in the model, in its file's part or among its terms?"""
    return any(issubclass(kind, forces.Drag) for kind in model.kinds)
