"""What a tracker does to the truth: AR(1) noise, outliers, rounding, jittering stamps, dropped frames."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter

# name -> (AR coefficient, share of outliers, frame rates at which such noise is met [1/s]); correlated noise needs fast cameras
REGIMES = {
    "white": (0.0, 0.0, (15, 25, 30, 60, 120, 240)),
    "ar6": (0.6, 0.0, (60, 120, 240)),
    "ar8": (0.8, 0.005, (120, 240)),
    "outliers": (0.0, 0.03, (25, 30, 60, 120, 240)),
    "pixels": (0.0, 0.0, (25, 30, 60, 120, 240)),
}
PIXELS = (1.0, 2.0, 3.5)  # steps of the picture in sigmas of the rest of the noise: they show, and the third hides most of it


@dataclass(frozen=True)
class Noise:
    """A tracker. Deviations in m and rad as a moving body's samples have them, outliers apart; times relative to the frame."""

    position: float
    orientation: float
    rho: float
    outliers: float
    quantum: float  # rounding step of positions in sigmas of the AR(1) part, 0 = none
    jitter: float  # standard deviation of the frame spacing, relative
    dropped: float  # share of frames lost
    rate: float  # frames a second

    @staticmethod
    def draw(rng, regime, rate, position, orientation=0.01):
        """A tracker of the regime with the finer habits drawn at random."""
        rho, outliers, _ = REGIMES[regime]
        quantum = rng.choice(PIXELS if regime == "pixels" else [0.0, 0.0, 0.3])
        jitter, dropped = rng.choice([0.0, 0.01]), rng.choice([0.0, 0.01, 0.03])
        return Noise(position, orientation, rho, outliers, float(quantum), float(jitter), float(dropped), float(rate))

    @property
    def rounded(self):
        """Deviation of a moving body's samples over that of the noise before rounding: a step q adds q^2/12."""
        return float(np.sqrt(1 + self.quantum**2 / 12))


def correlated(rng, shape, sigma, rho):
    """AR(1) noise along the first axis: standard deviation sigma, lag-one correlation rho, stationary from the first sample."""
    white = rng.normal(size=shape) * sigma
    white[1:] *= np.sqrt(1 - rho**2)
    return lfilter([1.0], [1.0, -rho], white, axis=0)


def spoil(rng, noise, values, sigma):
    """Values (n, c) as the tracker reports them."""
    sigma = sigma / noise.rounded
    seen = values + correlated(rng, values.shape, sigma, noise.rho)
    wild = rng.random(values.shape) < noise.outliers
    seen = seen + wild * sigma * rng.uniform(5, 15, values.shape) * rng.choice([-1.0, 1.0], values.shape)
    if noise.quantum:
        step = float(f"{noise.quantum * sigma:.1e}")
        seen = np.round(seen / step) * step
    return seen


def spoil_orientation(rng, noise, quaternions):
    """Quaternions (n, 4) turned by small noisy rotation vectors (world frame); no picture rounds an angle."""
    turn = spoil(rng, replace(noise, quantum=0.0), np.zeros((len(quaternions), 3)), noise.orientation)
    return product(small_turn(turn), quaternions)


def frames(rng, noise, duration):
    """Time stamps (n,) of the frames kept between 0 and duration: jittering, some dropped, never the first."""
    count = int(np.floor(duration * noise.rate)) + 1
    stamps = np.arange(count) / noise.rate
    stamps[1:] += rng.normal(size=count - 1) * noise.jitter / noise.rate
    keep = rng.random(count) >= noise.dropped
    keep[0] = True
    return np.round(stamps[keep], 6)


def lean(inputs, effects):
    """Angles [rad] by which gravity leans towards x and y: tilted_gravity turns it about x, then y; wrong levelling adds."""
    tilt = effects.get("tilted_gravity", {})
    return inputs.get("tilt_x", 0.0) - tilt.get("angle_y", 0.0), inputs.get("tilt_y", 0.0) + tilt.get("angle_x", 0.0)


def product(a, b):
    """Hamilton product of quaternions (..., 4), scalar first."""
    aw, ax, ay, az = np.moveaxis(np.asarray(a, float), -1, 0)
    bw, bx, by, bz = np.moveaxis(np.asarray(b, float), -1, 0)
    return np.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ],
        axis=-1,
    )


def small_turn(vector):
    """Quaternion (..., 4) of a rotation vector (..., 3)."""
    angle = np.linalg.norm(vector, axis=-1, keepdims=True)
    return np.concatenate([np.cos(angle / 2), 0.5 * np.sinc(angle / (2 * np.pi)) * vector], axis=-1)


def gone_round(turns):
    """Rotation vectors (n, 3) of one sample after the other, with the whole turns about its axis that each has made by then."""
    turns = turns.copy()
    for k in range(1, len(turns)):
        size = np.linalg.norm(turns[k])
        if size > 0:
            short = turns[k - 1] @ turns[k] / size - size
            turns[k] *= 1 + 2 * np.pi * np.round(short / (2 * np.pi)) / size
    return turns


def turn_between(a, b):
    """Rotation vector (..., 3), world frame, that turns orientation a into b."""
    change = product(b, np.asarray(a) * [1, -1, -1, -1])
    change = np.where(change[..., :1] < 0, -change, change)
    length = np.linalg.norm(change[..., 1:], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(length, change[..., :1])
    return change[..., 1:] * np.where(length > 1e-12, angle / np.maximum(length, 1e-300), 2.0)
