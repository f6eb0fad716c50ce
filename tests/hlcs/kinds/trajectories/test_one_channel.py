"""Recordings of one channel, against the whole library: heights alone, an angle alone."""

import numpy as np
import pytest

import hlcs

BALL = {"shape": "sphere", "radius": 0.0335, "mass": 0.0577}
AIR = {"fluid_density": 1.2, "fluid_viscosity": 1.8e-5}


def diagnosed(frames, noise):
    trials = [{"group": str(index % 2)} for index in range(len(frames))]
    return hlcs.diagnose(hlcs.Experiment.from_frames(frames, BALL, AIR, noise=noise, trials=trials))


@pytest.mark.parametrize("duration", [1.2, 5.0])
def test_an_angle_alone_shows_how_a_spin_decays(duration):
    """angle = w / k (1 - e^-kt) about one axis, k = 0.8, read to 5 mrad: the rate to 0.5 %. In 5 s the model without it, fitted
    to the first second, is up to eight turns ahead."""
    draw, times, frames = np.random.default_rng(1), np.arange(0.0, duration, 1 / 60), []
    for spin in (5.0, 8.0, 11.0, 14.0):
        angle = spin / 0.8 * -np.expm1(-0.8 * times) + 0.005 * draw.standard_normal(len(times))
        frames.append({"t_s": times, "qw": np.cos(angle / 2), "qx": 0 * times, "qy": 0 * times, "qz": np.sin(angle / 2)})
    found = diagnosed(frames, {"orientation": 0.005})
    assert (found.verdict, found.effects) == ("effect", ("spin_decay",))
    assert found.parameters["spin_decay"]["rate"]["value"] == pytest.approx(0.8, rel=0.02)


def test_heights_alone_show_the_drag_of_a_tennis_ball():
    """z = h - ln cosh(sqrt(g k) t) / k, C = 0.55, read to 2 mm: no drag but that which mass, size and air allow."""
    per_metre = 0.5 * 1.2 * 0.55 * np.pi * 0.0335**2 / 0.0577
    draw, frames = np.random.default_rng(1), []
    for height in (4.0, 5.0, 6.0, 7.0):
        times = np.arange(0.0, np.sqrt(2 * height / 9.81), 1 / 60)
        heights = height - np.log(np.cosh(np.sqrt(9.81 * per_metre) * times)) / per_metre
        frames.append({"t_s": times, "z_m": heights + 0.002 * draw.standard_normal(len(times))})
    found = diagnosed(frames, {"position": 0.002})
    assert (found.verdict, found.effects) == ("effect", ("quadratic_drag",))
    number = found.parameters["quadratic_drag"]["drag_coefficient"]
    assert number["low"] < 0.55 < number["high"] and number["high"] - number["low"] < 0.1


def test_angles_that_nothing_explains_are_told_without_a_force_or_a_height():
    """A spin that swings, which no effect makes: no law of a force is read from angles, and no height or speed is told of."""
    draw, times, frames = np.random.default_rng(2), np.arange(0.0, 1.2, 1 / 60), []
    for spin in (5.0, 8.0, 11.0, 14.0):
        angle = spin * times + 0.2 * np.sin(9.0 * times) + 0.005 * draw.standard_normal(len(times))
        frames.append({"t_s": times, "qw": np.cos(angle / 2), "qx": 0 * times, "qy": 0 * times, "qz": np.sin(angle / 2)})
    found = diagnosed(frames, {"orientation": 0.005})
    assert (found.verdict, found.learned) == ("unexplained", None)
    assert found.where[0]["height"] is None and found.where[0]["speed"] is None and found.where[0]["time"] > 0
    told = " ".join(str(found).split())
    assert "m high" not in told and "goes with height" not in told and "goes with speed" not in told and "e+0" not in told
