"""A camera: what it reports of a motion, with its clock, its ruler and its noise.

Like `motion` it imports nothing of the engine.
"""

from typing import NamedTuple

import numpy as np

from hlcs.mystery import motion

STILL = 300  # pictures of a body at rest, from which the noise can be estimated
DIGITS = 6  # of a number in a file: micrometres and microseconds


class Camera(NamedTuple):
    """Standard deviations of what is reported, white noise."""

    position: float  # m
    orientation: float  # rad
    rate: float  # pictures a second


def stamps(camera, duration):
    """Times of the pictures (n,) [s] from the release to the end."""
    return np.round(np.arange(int(duration * camera.rate) + 1) / camera.rate, DIGITS)


def film(scene, laws, trial, start, times):
    """Positions (n, 3) [m] and orientations (n, 4) that a camera without noise reports at its stamps (n,) [s].

    Time that has passed = factor of `time_scale` x stamp - offset of `clock_offset`; reported = factor of `length_scale` x true.
    """
    passed = times * motion.number(laws, "time_scale", "factor", 1.0) - motion.number(laws, "clock_offset", "offset")
    position, orientation = scene.move(laws, trial, start, passed)
    return position * motion.number(laws, "length_scale", "factor", 1.0), orientation


def seen(rng, camera, position, orientation):
    """The same (n, 3) and (n, 4) with the noise of the camera."""
    turn = rng.normal(size=(len(position), 3)) * camera.orientation
    return position + rng.normal(size=position.shape) * camera.position, motion.product(motion.quaternion(turn), orientation)


def csv_of(times, position, orientation=None):
    """Text of a recording; orientation None = none was recorded."""
    columns, values = ["t_s", "x_m", "y_m", "z_m"], [times[:, None], position]
    if orientation is not None:
        columns, values = [*columns, "qw", "qx", "qy", "qz"], [*values, orientation]
    rows = (",".join(f"{value:.{DIGITS}f}" for value in row) for row in np.concatenate(values, axis=1))
    return "\n".join([",".join(columns), *rows]) + "\n"


def still_life(rng, camera, turns):
    """Text of a recording of a body at rest."""
    times = stamps(camera, (STILL - 0.5) / camera.rate)
    position, orientation = np.tile([0.1, 0.2, 1.0], (STILL, 1)), np.tile([1.0, 0.0, 0.0, 0.0], (STILL, 1))
    position, orientation = seen(rng, camera, position, orientation)
    return csv_of(times, position, orientation if turns else None)


# --- how much of an effect a camera can see ---------------------------------------------------------------------------------

STEP = 1e-4  # by which a start is moved to see what that changes: m, m/s, rad, rad/s


class View(NamedTuple):
    """What a camera sees of one trial without what is hidden."""

    times: np.ndarray  # (n,) s
    film: tuple  # positions (n, 3) m, orientations (n, 4)
    absorbed: np.ndarray  # (values, k): what a small change of each unknown number of the start changes, per unit


def views(scene, laws):
    """A View of every trial of a scene; laws: of the complete motion without what is hidden."""
    found = []
    for trial in scene.trials:
        times = stamps(Camera(0.0, 0.0, scene.rate), trial.duration)
        plain = film(scene, laws, trial, trial.start, times)
        columns = [_apart(scene, plain, film(scene, laws, trial, start, times)) / STEP for start in _moved(trial, scene.turns)]
        found.append(View(times, plain, np.stack(columns or [np.zeros(plain[0].size)], axis=1)))
    return found


def shift(scene, laws, views):
    """What these laws change in the recordings after the best choice of what is not known of the starts: root mean square [m].

    Turns [rad] count as the way that the surface of the body makes. The starts are fitted to first order: what a small change
    of them can do is taken out of the change.
    """
    squares, count = 0.0, 0
    for trial, view in zip(scene.trials, views, strict=True):
        change = _apart(scene, view.film, film(scene, laws, trial, trial.start, view.times))
        change = change - view.absorbed @ np.linalg.lstsq(view.absorbed, change, rcond=1e-9)[0]
        squares, count = squares + change @ change, count + len(change)
    return float(np.sqrt(squares / count))


def _apart(scene, one, other):
    """Difference of two films, flat [m]."""
    parts = [other[0] - one[0]]
    if scene.turns:
        parts.append(scene.shape["radius"] * motion.turn_between(one[1], other[1]))
    return np.concatenate(parts, axis=1).ravel()


def _moved(trial, turns):
    """Starts that differ from the true one by `STEP` in one of the numbers that the file does not state."""
    names = ["position", "velocity"] + (["orientation", "angular_velocity"] if turns else [])
    for name in (name for name in names if name not in trial.known):
        value = getattr(trial.start, name)
        for axis in np.eye(3) * STEP:
            moved = motion.product(motion.quaternion(axis), value) if name == "orientation" else value + axis
            yield trial.start._replace(**{name: moved})
