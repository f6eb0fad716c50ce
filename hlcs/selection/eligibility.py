"""Which candidates can take part in a diagnosis, and why the others cannot."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

import minibullet.effects as forces
from hlcs.data.quantities import CHANNELS
from hlcs.data.rigid_body import borne, fluid_presumed, known_body, known_to_drag, rigid_body
from hlcs.effects import as_stated, candidate, class_named, wanted
from hlcs.effects.candidates import each_session, in_doubt, numbers_stated
from hlcs.effects.contract import Change, DataNeed
from hlcs.effects.measurement import LengthScale
from hlcs.simulation.initial_state import gained
from minibullet.effects.contract import Need, name_of
from minibullet.effects.fluid import AIR_VISCOSITY, WATER_VISCOSITY

SAME_LAW = "the same law as stokes_drag of a body whose size is known"
NO_TURNING = "orientations are not measured"


@dataclass(frozen=True)
class Shown:
    """What recordings show that a candidate may need."""

    trials: tuple
    contact: bool  # does anything touch?
    seated: tuple = ()  # does a body lie on its floor at the start (trials,)

    @cached_property
    def columns(self):
        """The channels that they measure."""
        return set().union(*(trial.columns for trial in self.trials))

    @property
    def loads_differ(self):
        """May bodies press on their floor with unlike forces? Not where all lie on it, of one mass and on one slope."""
        return not (self.seated and all(self.seated)) or len({(trial.body, trial.surroundings) for trial in self.trials}) > 1


# need: (what is said where it is missing, test of what recordings show)
NEEDS = {
    Need.MASS_AND_SIZE: (
        "the mass or the size of the body is not stated",
        lambda shown: all(known_body(trial.body) for trial in shown.trials),
    ),
    Need.SIZE: ("the size of the body is not stated", lambda shown: all(trial.body.sized for trial in shown.trials)),
    Need.SPHERE: ("the body is no sphere", lambda shown: all(trial.body.shape == "sphere" for trial in shown.trials)),
    Need.EDGES: ("a sphere has no edges", lambda shown: all(trial.body.shape != "sphere" for trial in shown.trials)),
    Need.FLUID: (
        "the file states a vacuum (fluid_density = 0.0)",
        lambda shown: any(trial.surroundings.fluid_density for trial in shown.trials),
    ),
    Need.FLOOR: (
        "there is no floor, or not under all recordings",
        lambda shown: all(trial.surroundings.floor_height is not None for trial in shown.trials),
    ),
    Need.TUBE: (
        "there is no liquid, and no tube is stated (surroundings.tube_radius)",
        lambda shown: all(trial.surroundings.walled for trial in shown.trials),
    ),
    Need.CONTACT: ("nothing touches in these data", lambda shown: shown.contact),
    Need.SPIN: (
        "the spin is neither measured nor stated",
        lambda shown: "rx" in shown.columns or any("angular_velocity" in trial.start for trial in shown.trials),
    ),
    Need.ROTATION: (NO_TURNING, lambda shown: "rx" in shown.columns),
    DataNeed.TURNING: (NO_TURNING, lambda shown: "rx" in shown.columns or shown.contact),
    DataNeed.LEANING: (
        NO_TURNING,
        lambda shown: "rx" in shown.columns or shown.contact and any(trial.body.shape != "sphere" for trial in shown.trials),
    ),
    Need.RELEASE: (
        "the moment of release is not known: no start velocity is stated, or the body is let go after the first sample",
        lambda shown: any("velocity" in trial.start for trial in shown.trials),
    ),
    Need.UNLIKE_LOADS: ("the load does not vary", lambda shown: shown.loads_differ),
    Need.SIDEWAYS: ("no horizontal position is measured", lambda shown: bool(shown.columns & {"x", "y"})),
    DataNeed.ACCELERATIONS: ("no accelerations are read", lambda shown: bool(shown.columns & set(CHANNELS[6:]))),
    DataNeed.HEIGHT: ("no height is measured", lambda shown: "z" in shown.columns),
    DataNeed.UNLIKE_HEIGHTS: (
        "all recordings pass the same heights at the same times, so any misfit would look like it",
        lambda shown: not all_alike(shown.trials),
    ),
}

# what a laboratory can state or measure, of what effects need
TO_GIVE = {Need.MASS_AND_SIZE: "the mass and the size of the body", Need.SIZE: "the size of the body", Need.SPIN: "the spin"}


def to_be_given(absent):
    """What to state or measure so that more effects can be tried, of {name: why it was not}; "" where nothing would help."""
    waiting = {what: sorted(name for name, why in absent.items() if why == NEEDS[need][0]) for need, what in TO_GIVE.items()}
    told = {what: ", ".join(names) for what, names in waiting.items() if names}
    return "; ".join(f"state or measure {what}, without which {names} cannot be tried" for what, names in told.items())


def candidates_for(measurement, contact, names=None, own=(), seated=()):
    """(candidates, {name: why it cannot take part}) for trajectories; `names` None = all that fit, else just these; seated: does
    a body lie on its floor at the start (trials,)."""
    trials, shown = measurement.trials, Shown(measurement.trials, contact, tuple(seated))
    # a drag must hold in every recording: the one of the largest Reynolds number speaks for all
    seen = [(trial.body, trial.surroundings, fastest(trial)) for trial in trials]
    body, surroundings, speed = max(seen, key=lambda each: (reynolds_numbers(*each)[1], each[1].fluid_density))
    entries = as_stated(measurement.file.effects, trials, own)
    why = with_drag_that_fits({kind: obstacle(kind, shown) for kind in wanted(names, own)}, body, surroundings, speed)
    why = {kind: stated(kind, entries, own) or text for kind, text in why.items()}
    heights = np.concatenate([trial.position[:, 2] for trial in trials])
    extent = float(np.nanmax(heights) - np.nanmin(heights)) if np.isfinite(heights).any() else 1.0
    drag_known = all(known_to_drag(trial.body) for trial in trials)
    found, absent = eligible(why, entries, body, surroundings, drag_known, own, max(extent, 1e-3), speed)
    sessions = sorted({trial.session for trial in trials} - {""})
    found = [each_session(entry, sessions) for entry in found]
    if error := measurement.file.scale_error:
        found = [in_doubt(entry, "factor", error) if entry.kind is LengthScale else entry for entry in found]
    return found, absent


def eligible(why, entries, body, surroundings, body_known, own, extent, speed):
    """(candidates, {name: why it cannot take part}), both by name, from {class: why it cannot, or None}; entries: of [model]
    effects, as `as_stated` has them; the rest as `candidate` takes it."""
    presumed, light = fluid_presumed(body, surroundings), borne(body, surroundings)
    if presumed:
        surroundings = replace(surroundings, fluid_stated=True)
    known = surroundings, rigid_body(body), body_known
    found = [
        candidate(kind, *known, kind in own, extent, speed, entries.get(name_of(kind))) for kind, text in why.items() if not text
    ]
    if presumed and not light:  # nobody throws a balloon in a vacuum; of a heavy ball a model may leave the air out
        found = [replace(entry, presumed=any(free.certain for free in entry.free)) for entry in found]
    return sorted(found, key=lambda entry: entry.name), {name_of(kind): text for kind, text in why.items() if text}


def obstacle(kind, shown):
    """What a class needs that recordings do not show, in words, or None."""
    unfilmed = shown.columns and shown.columns <= set(CHANNELS[6:])
    if unfilmed and getattr(kind, "look", Change.look) is not Change.look:
        return "it is an error of a camera, and accelerations alone are measured"
    return next((text for text, met in map(NEEDS.get, kind.needs) if not met(shown)), None)


def fastest(trial):
    """The highest speed over an eighth of a recording, by what was measured of its position [m/s].

    By its accelerometer where nothing else is measured, from the start that is stated, or from rest; with the speed of a free
    fall where nothing holds a body in the air whose height was not measured.
    """
    if trial.unplaced:
        speeds = np.asarray(trial.start.get("velocity", np.zeros(3))) + gained(trial, trial.times[0])
        return float(np.linalg.norm(speeds, axis=1).max())
    seen, around = np.isfinite(trial.position).any(axis=0), trial.surroundings
    there = np.isfinite(trial.position[:, seen]).all(axis=1)
    times, position = trial.times[there], trial.position[there]
    far = max(len(times) // 8, 1)
    if len(times) <= far or not np.isfinite(position).any():
        return 0.0
    speed = np.nanmax(np.sqrt(np.nansum((position[far:] - position[:-far]) ** 2, axis=1)) / (times[far:] - times[:-far]))
    held = seen[2] or around.floor_height is not None or around.planar or around.in_liquid
    return float(speed if held else np.hypot(speed, around.gravity * np.ptp(trial.times)))


def reynolds_numbers(body, surroundings, speed):
    """(least, most) that a speed [m/s] may mean, 2 r rho v / eta; a liquid whose viscosity nobody stated may have any."""
    size = 2 * rigid_body(body).radius * surroundings.fluid_density * speed
    if surroundings.fluid_viscosity:
        return (size / surroundings.fluid_viscosity,) * 2
    return (0.0, size / WATER_VISCOSITY) if surroundings.in_liquid else (size / AIR_VISCOSITY,) * 2


def with_drag_that_fits(why, body, surroundings, speed):
    """{class: why it cannot take part, or None}, laws that do not hold at the Reynolds numbers of this speed [m/s] left out.

    Where Stokes's law may hold, a drag in proportion to speed is that law, and its number the viscosity.
    """
    least, most = reynolds_numbers(body, surroundings, speed)
    found = {kind: text or _out_of_reach(kind, least, most) for kind, text in why.items()}
    if forces.LinearDrag in found and found.get(forces.StokesDrag, SAME_LAW) is None:
        found[forces.LinearDrag] = found[forces.LinearDrag] or SAME_LAW
    return found


def grouped(number):
    """Two digits without powers of ten: 21,000."""
    return f"{float(f'{number:.2g}'):,.10g}"


def _out_of_reach(kind, least, most):
    """Why a law does not hold at these Reynolds numbers, or None."""
    begins, ends = kind.reynolds
    if most == 0.0 and np.isfinite(ends):
        return "there is no fluid, or no motion through it"
    if most < begins:
        reached = grouped(most) if grouped(most) != grouped(begins) else f"{most:,.5g}"
        return f"Reynolds numbers reach {reached} only, and it needs {grouped(begins)}"
    return f"Reynolds numbers reach {grouped(least)}, and it holds up to {grouped(ends)}" if least > ends else None


def stated(kind, entries, own=()):
    """Why a class can neither join what an experiment file states as its model nor change a number of it, or None; entries: as
    `as_stated` has them."""
    if name_of(kind) in entries:
        doubtful = numbers_stated(kind, entries[name_of(kind)])
        return None if doubtful else "already in the model, without a number that may be wrong"
    laws = {name: class_named(name, own) for name in entries}
    taken = next((name for name, law in laws.items() if law in kind.contains or kind in law.contains), None)
    return taken and f"the model states {taken}, whose place it would take: leave that out of [model] effects to have it tried"


def all_alike(trials):
    """Do all recordings run through their heights once, in one direction, and in the same way, to a tenth of the range?"""
    tracks = []
    for trial in trials:
        there = np.isfinite(trial.position[:, 2])
        t, z = trial.times[there], trial.position[there, 2]
        order = np.argsort(np.argsort(z, kind="stable"))  # Spearman's correlation with time is that of the ranks
        if len(t) < 6 or abs(np.corrcoef(np.arange(len(z)), order)[0, 1]) < 0.97:
            return False
        tracks.append((t - t[0], z))
    span = max(np.ptp(z) for _, z in tracks)
    shared = np.linspace(0.0, min(t[-1] for t, _ in tracks), 20)
    table = np.array([np.polyval(np.polyfit(t, z, 4), shared) for t, z in tracks])
    return bool(np.max(np.ptp(table, axis=0)) < 0.1 * span)


def lacks_drag(entry, kinds):
    """Does a candidate act only through a drag, and there is none such among these classes of effects?"""
    return entry.through_drag and not any(issubclass(kind, entry.kind.acts_on) for kind in kinds)
