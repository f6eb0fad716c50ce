"""What a phone tells by how it reads gravity: does it lie or fly, and which of its axes points up at the start."""

import numpy as np

from hlcs.data.accelerometers import STEADY, felt, ways_through_air
from hlcs.importing.found import Assumption
from minibullet import rotations

STANDARD_GRAVITY = 9.80665  # m/s2: what Android and iOS take out of a linear acceleration (SensorManager.STANDARD_GRAVITY)
AT_ONCE = 3  # samples, one after the other, that tell how a phone lies
FLIGHT = 0.1  # of a fall of 5 cm: what rattles over a floor reads next to nothing for shorter times [s]
TILTED = 20.0  # degrees that an axis may lean that is told to point up: the offset of an accelerometer alone looks like 5


def flies(times, vectors, name):
    """(does a phone with readings (n, 3) [m/s2] at times (n,) [s] fly, the Assumptions made); None where they do not tell."""
    reads = felt(vectors, STANDARD_GRAVITY)
    if not np.isfinite(vectors).any(axis=0).all() or len(reads) < AT_ONCE:
        return None, ()
    begun, ended = ways_through_air(reads)
    if len(begun) and np.max(times[ended - 1] - times[begun]) > FLIGHT:
        return True, (
            Assumption(f"{name}: the phone flies, as it reads next to nothing for a while: no floor is stated", of_motion=True),
        )
    if np.abs(np.median(reads) - 1) < STEADY:
        return False, (
            Assumption(f"{name}: the phone lies or slides on a floor, as it reads gravity: its floor is stated", of_motion=True),
        )
    return None, ()


def attitude(vectors, name):
    """(start of a [[trial]], the Assumptions made) by the readings (n, 3) [m/s2] of a phone along its axes, still at first;
    {} where none of them points up then."""
    reads = felt(vectors, STANDARD_GRAVITY)
    still = vectors[: int(np.argmax(np.append(np.abs(reads - 1) > STEADY, True)))]
    if len(still) < AT_ONCE or not np.isfinite(still).any(axis=0).all():
        return {}, ()
    up = np.nanmedian(still, axis=0)
    axis = int(np.argmax(np.abs(up)))
    if np.abs(up[axis]) < np.cos(np.radians(TILTED)) * np.linalg.norm(up):
        return {}, ()
    turn = rotations.between(np.sign(up[axis]) * np.eye(3)[axis], np.array([0.0, 0.0, 1.0]))
    sign = "-" if up[axis] < 0 else ""
    told = (
        f"{name}: the {sign}{'xyz'[axis]} axis of the phone points up at the start, where it reads gravity, and it does not turn"
    )
    return {"orientation": [round(float(part), 9) + 0.0 for part in turn], "angular_velocity": [0.0] * 3}, (
        Assumption(told, of_motion=True),
    )
