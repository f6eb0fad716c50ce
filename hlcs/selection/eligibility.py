"""Which candidates can take part in a diagnosis of trajectories, and why the others cannot."""

import numpy as np
from scipy import stats

import minibullet.effects as forces
from hlcs.data.rigid_body import rigid_body
from hlcs.effects import NOT_FORCES, Candidate, candidate, class_named, classes
from hlcs.effects.contract import name_of

NEED_MASS_AND_SIZE = {
    "drag_crisis",
    "buoyancy",
    "added_mass",
    "magnus",
    "history_force",
    "ground_cushion",
    "mass_offset",
    "size_error",
}
NEED_DRAG = {"uniform_flow", "orientation_drag", "wall_drag"}
NEED_FLOOR = {"wall_drag", "ground_cushion", "tracker_smoothing"}


def candidates_for(measurement, contact, names=None, own=()):
    """(candidates, {name: why it cannot take part}) for trajectories; `names` None = all that fit, else just these."""
    trials = measurement.trials
    surroundings = trials[0].surroundings
    radius = rigid_body(trials[0].body).radius
    wanted = list(classes()) if names is None else [name_of(class_named(name, own)) for name in names]
    kinds = [class_named(name, own) for name in wanted]
    kinds += [kind for kind in own if kind not in kinds]
    found, absent = [], {}
    for kind in kinds:
        name = name_of(kind)
        why = stated(name, measurement.file) or (None if kind in own else _obstacle(kind, name, measurement, contact))
        if why:
            absent[name] = why
        else:
            found.append(candidate(kind, surroundings, radius, own=kind in own, only=_free(name, trials)))
    return sorted(found, key=lambda entry: entry.name), absent


def stated(name, file):
    """Why a candidate cannot join what an experiment file states as its model, or None."""
    names = [entry["name"] for entry in file.effects]
    if name in names:
        return "already in the model"
    if name == "drag_crisis" and "quadratic_drag" in names:  # its law holds at every Reynolds number: two would count drag twice
        return "the model states quadratic_drag, whose place it would take: leave that out of [model] effects to have it tried"
    return None


def _free(name, trials):
    """Names of the numbers to be found where not all are: drag of a body without mass or size is known per metre only."""
    if name != "quadratic_drag":
        return None
    return ("drag_coefficient",) if all(known_body(trial.body) for trial in trials) else ("drag_per_metre",)


def known_body(body):
    """Are mass and size of a body stated?"""
    return body.mass is not None and any((body.radius, body.size, body.side, body.mesh))


def _obstacle(kind, name, measurement, contact):
    """Why a shipped candidate cannot take part, or None."""
    trials = measurement.trials
    columns = set().union(*(trial.columns for trial in trials))
    spin_known = "rx" in columns or any("angular_velocity" in trial.start for trial in trials)
    if name in NEED_MASS_AND_SIZE and not all(known_body(trial.body) for trial in trials):
        return "mass and size of the body are not stated"
    if name in NEED_FLOOR and trials[0].surroundings.floor_height is None:
        return "there is no floor"
    if name in ("magnus", "orientation_drag") and not spin_known:
        return "the spin is neither measured nor stated"
    if name == "spin_decay" and "rx" not in columns:
        return "orientations are not measured"
    if name in ("inertia_error", "centre_of_mass_offset") and not (contact or "rx" in columns):
        return "orientations are not measured"
    if name in ("bottom_slope", "margin_offset") and not contact:
        return "nothing touches in these data"
    if name == "centre_of_mass_offset" and trials[0].body.shape == "sphere" and "rx" not in columns:
        return "orientations are not measured"
    if name == "clock_offset" and not any("velocity" in trial.start for trial in trials):
        return "the moment of release is not known (no start velocity stated)"
    if name in ("tilted_gravity", "tilted_frame", "uniform_flow") and not columns & {"x", "y"}:
        return "no horizontal position is measured"
    if name == "history_force" and not any("velocity" in trial.start for trial in trials):
        return "the moment of release is not known (no start velocity stated)"
    if not contact and kind not in NOT_FORCES and "contact" in Candidate(name, kind, ()).touches:
        return "nothing touches in these data"
    if name == "calibration_curve" and "z" not in columns:
        return "no height is measured"
    if name == "calibration_curve" and all_alike(trials):
        return "all recordings pass the same heights at the same times, so any misfit would look like it"
    return None


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


def blocked(candidate_entry, model):
    """Why a candidate cannot join this model now, or None: some act only through a drag that must be there first."""
    if candidate_entry.name in NEED_DRAG and not has_drag(model):
        return "acts through a drag, and the model has none"
    return None


def has_drag(model):
    """Is there a drag in the model, in its file's part or among its terms?"""
    return any(issubclass(term.candidate.kind, forces.Drag) for term in model.terms) or any(
        name in ("linear_drag", "quadratic_drag", "drag_crisis") for name in model.names
    )


def carries(model, index):
    """Does another term act only through term number `index`, so that the model cannot stand without it?"""
    rest = model.without(index)
    return any(name in NEED_DRAG for name in rest.names) and not has_drag(rest)
