"""What the measurement itself does to the data: frames, scales, clocks, smoothing. On the same footing as forces."""

from dataclasses import dataclass

import numpy as np

from hlcs.effects.contract import Change, DataNeed
from minibullet import rotations
from minibullet.effects.body import HARDLY_SEEN, LEVELLED
from minibullet.effects.contract import Need, parameter

# nodes and weights of Gauss-Legendre on [-1/2, 1/2]: a moving average of a smooth motion to high order
_NODES, _WEIGHTS = (0.5 * half for half in np.polynomial.legendre.leggauss(5))


@dataclass(frozen=True)
class TiltedFrame(Change):
    """The camera's axes lean about its origin; in flight like tilted gravity."""

    angle_x: float = parameter(0.0, **LEVELLED, about="of the camera about its x axis", typical=HARDLY_SEEN)
    angle_y: float = parameter(0.0, **LEVELLED, about="of the camera about its y axis, after the first")
    plain = "a camera that leans"
    formula = "seen = R_y(angle_y) R_x(angle_x) true"
    symbols = {"R_x": "turn about the x axis", "R_y": "turn about the y axis"}
    looks_like = "A fall that leans to one side, as if gravity did; unlike with tilted gravity, a floor looks tilted too."
    confused_with = ("bottom_slope",)
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
    """Wrong scale of the picture, about the origin of the file's frame.

    In a table the recorded length is the outcome or, where the outcome is a time, the way that was measured beforehand.
    """

    factor: float = parameter(
        1.0,
        unit="-",
        low=0.9,
        high=1.1,
        null=1.0,
        about="recorded over true length",
        typical=((1.02, "ruler 2 % nearer to the camera than the motion, at 2 m by 40 mm"),),
    )
    plain = "a wrong scale of length"
    formula = "seen = factor true"
    looks_like = (
        "Every acceleration, and every known length, is wrong by the same factor; a free fall is too slow or too fast as "
        "1/2 g t^2."
    )
    confused_with = ("calibration_curve",)
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
    """Wrong frame rate, so that apparent accelerations scale with the square of the factor."""

    factor: float = parameter(
        1.0,
        unit="-",
        low=0.95,
        high=1.05,
        null=1.0,
        about="true over stamped time since the start",
        typical=((1.001, "30 frames a second for 29.97: NTSC video"),),
    )
    plain = "a clock at a wrong rate"
    formula = "seen(t) = true(factor t)"
    looks_like = (
        "Speeds are wrong by one factor and accelerations by its square, while all lengths (a known height, the floor) are right."
    )
    confused_with = ("clock_offset",)
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

    offset: float = parameter(
        0.0,
        unit="s",
        low=-0.3,
        high=0.3,
        null=0.0,
        about="from the stamp of the release to the release",
        typical=((0.033, "one frame at 30 frames a second"),),
    )
    plain = "a release that is stamped too early or too late"
    formula = "seen(t) = true(t - offset)"
    looks_like = (
        "The whole motion comes too late or too early by the same time: the gap to the model is offset times speed, "
        "largest where it is fast."
    )
    confused_with = ("tracker_smoothing",)
    group = "measurement"
    by_session = True
    by_person = True
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
    """The scale of height is not uniform.

    u runs from -1 at the lowest to 1 at the highest recorded height, so c_1 .. c_5 are amplitudes in metres.
    """

    c_1: float = parameter(
        0.0, unit="m", low=-0.05, high=0.05, null=0.0, bounds_in="extent", about="amplitude of the polynomial of degree 1"
    )
    c_2: float = parameter(
        0.0, unit="m", low=-0.05, high=0.05, null=0.0, bounds_in="extent", about="amplitude of the polynomial of degree 2"
    )
    c_3: float = parameter(
        0.0, unit="m", low=-0.05, high=0.05, null=0.0, bounds_in="extent", about="amplitude of the polynomial of degree 3"
    )
    c_4: float = parameter(
        0.0, unit="m", low=-0.05, high=0.05, null=0.0, bounds_in="extent", about="amplitude of the polynomial of degree 4"
    )
    c_5: float = parameter(
        0.0, unit="m", low=-0.05, high=0.05, null=0.0, bounds_in="extent", about="amplitude of the polynomial of degree 5"
    )
    plain = "a scale of height that is not uniform"
    formula = "seen_z = z + c_1 T_1(u) + c_2 T_2(u) + .. + c_5 T_5(u)"
    symbols = {
        "seen_z": "height as recorded [m]",
        "u": "height from -1, lowest recorded, to 1, highest",
        "T_1": "Chebyshev polynomial of degree 1",
        "T_2": "Chebyshev polynomial of degree 2",
        "T_5": "Chebyshev polynomial of degree 5",
    }
    looks_like = (
        "The gap depends on height alone: the same at the same height on the way up and on the way down, in fast and slow throws."
    )
    confused_with = ("quadratic_drag",)
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
    """The tracker averages the motion over a window."""

    window: float = parameter(
        0.0,
        unit="s",
        low=0.0,
        high=0.2,
        null=0.0,
        about="time over which is averaged",
        typical=((0.17, "five frames at 30 frames a second"),),
    )
    plain = "a tracker that smooths the motion"
    formula = "seen(t) = integral(true, t - window/2, t + window/2)/window"
    looks_like = "Corners are rounded: at each bounce or stop the gap is a spike as wide as the window, with nothing between."
    confused_with = ("clock_offset", "restitution")
    group = "measurement"
    needs = (Need.FLOOR,)

    def look(self, look, scene):
        def seen(times):
            here, orientation = look(times)
            mean = sum(weight * look(times + node * self.window)[0] for node, weight in zip(_NODES, _WEIGHTS, strict=True))
            return (mean if self.window > 0 else here), orientation

        return seen


@dataclass(frozen=True)
class AccelerometerOffset(Change):
    """The accelerometer reads something where nothing is to be read."""

    x: float = parameter(
        0.0,
        unit="m/s2",
        low=-1.0,
        high=1.0,
        null=0.0,
        source="zero-g output of a cheap sensor: within 80 mg (data sheet of the MPU-6050); 0.8 m/s2 of a phone at rest "
        "(data of arXiv:2410.14172)",
        about="of readings along its x axis",
        typical=((0.2, "20 mg: a sensor of a phone at room temperature"),),
    )
    y: float = parameter(
        0.0, unit="m/s2", low=-1.0, high=1.0, null=0.0, source="as along x", about="of readings along its y axis"
    )
    z: float = parameter(
        0.0, unit="m/s2", low=-1.0, high=1.0, null=0.0, source="as along x", about="of readings along its z axis"
    )
    plain = "an accelerometer that is off by a constant"
    formula = "read = true + (x, y, z)"
    symbols = {
        "read": "what stands in the recording [m/s2]",
        "true": "acceleration less gravity, along the axes of the instrument",
    }
    looks_like = "Readings are off by the same all the time, however the body moves: also at rest, and in free fall."
    confused_with = ("friction", "linear_drag")
    group = "measurement"
    needs = (DataNeed.ACCELERATIONS,)

    def read(self, force):
        return force + np.array([self.x, self.y, self.z])
