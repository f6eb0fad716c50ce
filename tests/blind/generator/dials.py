"""Hidden laws with one amplitude to turn: amplitude -> {effect: parameters}. Shared by the families."""

from typing import NamedTuple

import numpy as np


class Dial(NamedTuple):
    """A hidden law. draw(rng) returns (amplitude -> {name: parameters}); low, high: amplitudes that a user would believe;
    styles: experiments of the family in which it shows."""

    draw: object
    low: float
    high: float
    styles: tuple[str, ...]


def one(name, key, low, high, styles, null=0.0, sign=1, form=None, **extra):
    """A law with one scalar parameter = null + sign * amplitude; sign 0 = either; form = name of its departure from the
    textbook."""

    def draw(rng):
        side = sign or rng.choice([-1.0, 1.0])
        shape = {"form": float(rng.uniform(0.5, 1.0))} if form else {}
        return lambda amplitude: {name: {key: null + side * amplitude, **shape, **extra}}

    return Dial(draw, low, high, tuple(styles))


def plane(name, keys, low, high, styles):
    """A law with a horizontal direction: two parameters amplitude * (cos, sin) of a random heading."""

    def draw(rng):
        heading = rng.uniform(0, 2 * np.pi)
        return lambda amplitude: {name: {keys[0]: amplitude * np.cos(heading), keys[1]: amplitude * np.sin(heading)}}

    return Dial(draw, low, high, tuple(styles))


def crisis(styles):
    """The drag crisis: subcritical coefficient as the amplitude, a third of it or less beyond a critical Reynolds number."""

    def draw(rng):
        share, reynolds, form = rng.uniform(0.15, 0.35), float(rng.uniform(0.7e5, 1.6e5)), float(rng.uniform(0.3, 1.0))
        return lambda amplitude: {
            "drag_crisis": {
                "subcritical": amplitude,
                "supercritical": share * amplitude,
                "critical_reynolds": reynolds,
                "form": form,
            }
        }

    return Dial(draw, 0.2, 0.6, tuple(styles))


def tilt(name, styles):
    """tilted_gravity or tilted_frame, up to 0.05 rad."""
    return plane(name, ("angle_x", "angle_y"), 5e-4, 0.045, styles)


def camera_shake(styles, low=2e-4, high=0.05):
    """The support of the camera vibrates; phase differs from trial to trial."""

    def draw(rng):
        frequency, heading = rng.uniform(2.5, 6.5), rng.uniform(0, 2 * np.pi)
        direction = [float(np.cos(heading) * 0.8), float(np.sin(heading) * 0.8), 0.6]
        return lambda amplitude: {"camera_shake": {"amplitude": amplitude, "frequency": frequency, "direction": direction}}

    return Dial(draw, low, high, tuple(styles))


def camera_drift(styles, low=1e-4, high=0.2):
    """The camera's support gives way with the cube of time since the release, to either side."""

    def draw(rng):
        heading = rng.uniform(0, 2 * np.pi)
        direction = [float(np.cos(heading) * 0.9), float(np.sin(heading) * 0.9), -0.4]
        return lambda amplitude: {"camera_drift": {"amplitude": amplitude, "direction": direction}}

    return Dial(draw, low, high, tuple(styles))


def gust(styles, low=0.02, high=20.0):
    """A gust of wind (or current) along one line, at a random moment of every recording and from either side."""

    def draw(rng):
        heading, width = rng.uniform(0, 2 * np.pi), rng.uniform(0.05, 0.12)
        return lambda amplitude: {
            "gust": {
                "gust_x": amplitude * np.cos(heading),
                "gust_y": amplitude * np.sin(heading),
                "gust_width": width,
                "gust_time": 0.3,
            }
        }

    return Dial(draw, low, high, tuple(styles))


def growing_lift(styles, low=0.01, high=8.0):
    """A side force on the moving body that grows with time since the release."""

    def draw(rng):
        side = rng.choice([-1.0, 1.0])
        return lambda amplitude: {"growing_lift": {"lift": side * amplitude}}

    return Dial(draw, low, high, tuple(styles))


def magnet(styles, centre, size, low=0.02, high=60.0):
    """An attraction towards a place, falling with the distance from it."""

    def draw(rng):
        place = np.asarray(centre) + rng.uniform(-0.3, 0.3, 3) * size
        return lambda amplitude: {
            "magnet": {"pull": amplitude, "pull_x": place[0], "pull_y": place[1], "pull_z": place[2], "pull_size": 0.6 * size}
        }

    return Dial(draw, low, high, tuple(styles))


def swirl(styles, low=0.02, high=10.0):
    """A whirl about the vertical axis through the origin: a horizontal force that grows with the distance from it."""

    def draw(rng):
        side = rng.choice([-1.0, 1.0])
        return lambda amplitude: {"swirl": {"swirl": side * amplitude}}

    return Dial(draw, low, high, tuple(styles))


def own_moments(rng, outside, duration):
    """What an outside effect does in one trial only."""
    if outside == "gust":
        return {"gust": {"gust_time": float(rng.uniform(0.3, 0.7) * duration), "side": float(rng.choice([-1.0, 1.0]))}}
    if outside == "camera_drift":
        return {"camera_drift": {"side": float(rng.choice([-1.0, 1.0]))}}
    if outside == "kick":
        return {"kick": {"kick_time": float(rng.uniform(0.3, 0.6) * duration), "side": float(rng.choice([-1.0, 1.0]))}}
    if outside in ("shaken_board", "shaken_floor"):
        return {outside: {"shake_phase": float(rng.uniform(0, 2 * np.pi)), "phase": float(rng.uniform(0, 2 * np.pi))}}
    if outside == "camera_shake":
        return {"camera_shake": {"phase": float(rng.uniform(0, 2 * np.pi))}}
    return {}


def groups(rng, count):
    """Group names for `count` trials: two to four days, sizes as equal as possible, in order."""
    number = min(int(rng.integers(2, 5)), count // 2)
    word = rng.choice(["day", "run", "series", "session"])
    return [f"{word} {1 + i * number // count}" for i in range(count)]
