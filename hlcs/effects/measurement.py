"""What the measurement itself does to the data: frames, scales, clocks, smoothing. On the same footing as forces."""

from dataclasses import dataclass

import numpy as np

from hlcs.effects.contract import Change, DataNeed
from minibullet import rotations
from minibullet.effects.contract import Need, parameter

# nodes and weights of Gauss-Legendre on [-1/2, 1/2]: a moving average of a smooth motion to high order
_NODES, _WEIGHTS = (0.5 * half for half in np.polynomial.legendre.leggauss(5))


@dataclass(frozen=True)
class TiltedFrame(Change):
    """The camera's axes lean about its origin: recorded = R_y(angle_y) R_x(angle_x) true; in flight like tilted gravity."""

    angle_x: float = parameter(0.0, unit="rad", low=-0.05, high=0.05, null=0.0, source="levelling by eye: within 3 degrees")
    angle_y: float = parameter(0.0, unit="rad", low=-0.05, high=0.05, null=0.0, source="levelling by eye: within 3 degrees")
    plain = "a camera that leans"
    group = "measurement"
    by_session = True
    alike = "tilt"
    needs = (Need.SIDEWAYS,)

    def look(self, look, scene):
        turn = rotations.product(
            rotations.exponential(np.array([0.0, self.angle_y, 0.0])), rotations.exponential(np.array([self.angle_x, 0.0, 0.0]))
        )

        def seen(times):
            position, orientation = look(times)
            return rotations.rotate(turn, position), rotations.product(turn, orientation)

        return seen


@dataclass(frozen=True)
class LengthScale(Change):
    """Wrong scale of the picture: recorded = factor times true coordinates, about the origin of the file's frame.

    In a table the recorded length is the outcome or, where the outcome is a time, the way that was measured beforehand.
    """

    factor: float = parameter(1.0, unit="-", low=0.9, high=1.1, null=1.0)
    plain = "a wrong scale of length"
    group = "measurement"
    by_session = True
    alike = "effective_gravity"

    def look(self, look, scene):
        def seen(times):
            position, orientation = look(times)
            return self.factor * position, orientation

        return seen

    def inputs(self, inputs, unit):
        lengths = ("height_m", "distance_m", "mark_1_m", "mark_2_m") if unit == "s" else ()
        return {name: values / self.factor if name in lengths else values for name, values in inputs.items()}

    def outcome(self, values, unit):
        return self.factor * values if unit == "m" else values


@dataclass(frozen=True)
class TimeScale(Change):
    """Wrong frame rate: true time = factor times stamped time since the start, so apparent accelerations scale with factor^2."""

    factor: float = parameter(1.0, unit="-", low=0.95, high=1.05, null=1.0)
    plain = "a clock at a wrong rate"
    group = "measurement"
    by_session = True
    alike = "effective_gravity"

    def look(self, look, scene):
        return lambda times: look(self.factor * times)

    def outcome(self, values, unit):
        return values / self.factor if unit == "s" else values


@dataclass(frozen=True)
class ClockOffset(Change):
    """Late release or early trigger: the motion starts `offset` after its stamp; a body known to rest waits until then."""

    offset: float = parameter(0.0, unit="s", low=-0.3, high=0.3, null=0.0)
    plain = "a release that is stamped too early or too late"
    group = "measurement"
    by_session = True
    needs = (Need.RELEASE,)

    def look(self, look, scene):
        def seen(times):
            late = times - self.offset
            return look(np.where(scene.still_before[:, None], np.maximum(late, 0.0), late))

        return seen

    def outcome(self, values, unit):
        return values + self.offset if unit == "s" else values


@dataclass(frozen=True)
class CalibrationCurve(Change):
    """The scale of height is not uniform: recorded z = z + sum c_k T_k(u), T_k the Chebyshev polynomials.

    u runs from -1 at the lowest to 1 at the highest recorded height, so c_1 .. c_5 are amplitudes in metres.
    """

    c_1: float = parameter(0.0, unit="m", low=-0.05, high=0.05, null=0.0, bounds_in="extent")
    c_2: float = parameter(0.0, unit="m", low=-0.05, high=0.05, null=0.0, bounds_in="extent")
    c_3: float = parameter(0.0, unit="m", low=-0.05, high=0.05, null=0.0, bounds_in="extent")
    c_4: float = parameter(0.0, unit="m", low=-0.05, high=0.05, null=0.0, bounds_in="extent")
    c_5: float = parameter(0.0, unit="m", low=-0.05, high=0.05, null=0.0, bounds_in="extent")
    plain = "a scale of height that is not uniform"
    group = "measurement"
    needs = (DataNeed.HEIGHT, DataNeed.UNLIKE_HEIGHTS)

    def look(self, look, scene):
        half = max((scene.high - scene.low) / 2, 1e-9)
        coefficients = [0.0, self.c_1, self.c_2, self.c_3, self.c_4, self.c_5]

        def seen(times):
            position, orientation = look(times)
            u = np.clip((position[..., 2] - (scene.high + scene.low) / 2) / half, -1.2, 1.2)
            position = position.copy()
            position[..., 2] += np.polynomial.chebyshev.chebval(u, coefficients)
            return position, orientation

        return seen


@dataclass(frozen=True)
class TrackerSmoothing(Change):
    """The tracker averages over a window: recorded = mean of the motion over [t - window/2, t + window/2]."""

    window: float = parameter(0.0, unit="s", low=0.0, high=0.2, null=0.0)
    plain = "a tracker that smooths the motion"
    group = "measurement"
    needs = (Need.FLOOR,)

    def look(self, look, scene):
        def seen(times):
            here, orientation = look(times)
            mean = sum(weight * look(times + node * self.window)[0] for node, weight in zip(_NODES, _WEIGHTS, strict=True))
            return (mean if self.window > 0 else here), orientation

        return seen
