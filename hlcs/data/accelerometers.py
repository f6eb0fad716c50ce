"""Can these readings be those of an accelerometer at the centre of a body, in m/s2, along axes that are known?"""

import numpy as np

from minibullet.errors import InputError
from minibullet.rotations import rotation_matrices

UNSEEN = 0.05  # part of the weight that may lie along an axis that was not read
FREE = 0.5  # of gravity: what moves through the air reads less, unless its drag is half its weight
STEADY = 0.25  # of gravity that the reading of what lies, or is held in a hand, is more or less
FASTEST_READ = 200.0  # typical reading of an accelerometer beyond which it is in no m/s2: phones end at 16 g [m/s2]


def felt(values, gravity):
    """Readings along all axes together (n, 3), NaN = missing, over gravity (n,): 1 at rest, 0 in free fall."""
    return np.linalg.norm(np.nan_to_num(values), axis=1) / max(gravity, 1e-9)


def ways_through_air(reads):
    """(first samples, samples after the last) of the runs in which readings over gravity (n,) are those of free flight."""
    free = np.concatenate([[False], reads < FREE, [False]]).astype(int)
    return tuple(np.flatnonzero(np.diff(free) == sign) for sign in (1, -1))


def check_accelerations(trial, path):
    """Refuse accelerations in another unit than m/s2, without gravity in them, or along axes of which nothing is known."""
    if trial.accelerations is None:
        return
    values, around = trial.accelerations.values, trial.surroundings
    typical = float(np.nanmedian(np.abs(values))) if np.isfinite(values).any() else 0.0
    if typical > FASTEST_READ:
        raise InputError(
            f"{path}, columns ax_m_s2..az_m_s2: typically {typical:.3g}, more than a body in flight or on a floor feels; units "
            "that cannot be right: accelerations in m/s2, not in cm/s2 or mm/s2"
        )
    if trial.accelerations.in_body:
        for key in ("orientation", "angular_velocity"):
            if key not in trial.start:
                value = "[1.0, 0.0, 0.0, 0.0]" if key == "orientation" else "[0.0, 0.0, 0.0]"
                raise InputError(
                    f'{path}, columns ax_m_s2..az_m_s2: accelerometer = "body", but how the body lies and turns at the start is '
                    f"not stated; write start = {{ {key} = {value} }} under its [[trial]], or turn the columns into the axes of "
                    'the world and write accelerometer = "world"'
                )
    if trial.unplaced and around.floor_height is not None and "position" not in trial.start:
        normal, turning = around.normal, False
        if trial.accelerations.in_body:
            normal = rotation_matrices(np.array([trial.start["orientation"]], dtype=float))[0].T @ normal
            turning = np.any(trial.start["angular_velocity"])
            values = values[: max(len(values) // 10, 3)]  # a body that rolls turns soon
        axes = np.isfinite(values).any(axis=0)  # of which there is a column
        if not turning and np.abs(normal[~axes]).max(initial=0.0) < UNSEEN:
            _check_gravity_read(values, axes, normal, around, path)


def _check_gravity_read(values, axes, normal, around, path):
    """Refuse readings (n, 3) of a body that lies on its floor and that do not hold gravity along its normal, which is given along
    the axes of the instrument; axes: which of them were read (3,)."""
    along = values[:, axes] @ normal[axes]
    along = along[np.isfinite(along)]
    load = around.gravity * around.floor_normal[2]
    if not load > 1 or not len(along):
        return
    middle = float(np.median(along))
    name = f"a{'xyz'[int(np.argmax(np.abs(normal)))]}_m_s2"
    each = {f"a{axis}_m_s2": float(np.nanmedian(values[:, k])) for k, axis in enumerate("xyz") if axes[k]}
    elsewhere = next((other for other, read in each.items() if other != name and abs(abs(read) - load) < load / 4), None)
    if abs(middle - load) < load / 2:
        return
    if elsewhere:
        remedy = f"gravity is read in column {elsewhere}: turn the axes so that {name} points up"
    elif abs(middle + load) < load / 2:
        remedy = "an accelerometer at rest reads +9.81 upwards: turn the sign of the columns"
    elif abs(middle - 1) < 0.1:
        remedy = "these look like multiples of g: multiply them by 9.81"
    else:
        remedy = f"gravity seems to be taken out of them: add it, {load:.3g} m/s2 along the normal of the floor"
    raise InputError(
        f"{path}, column {name}: reads {middle:+.3g} m/s2 away from the floor that the body lies on, where {load:+.3g} m/s2 "
        f"are due; {remedy}"
    )
