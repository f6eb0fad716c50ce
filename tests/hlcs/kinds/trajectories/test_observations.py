"""Observations of recordings beside a fitted model: how they are judged, and where they miss."""

import numpy as np
import pytest
from experiments import TOML, experiment, measured

import hlcs
from hlcs.kinds.trajectories.observations import judge, observations, partitions, where_it_fails
from hlcs.kinds.trajectories.preparation import prepare

TIMES = np.arange(40) / 50


@pytest.fixture
def prepared(tmp_path, generator):
    """A ball in free fall whose camera leans: 1 cm per metre are added to its height below one metre."""

    def of(lean):
        z = 3.0 - 0.5 * 9.81 * TIMES**2
        z += 0.01 * generator.standard_normal(len(z)) + lean * np.maximum(1.0 - z, 0.0)
        lines = "".join(f"{t:.3f},{height:.6f}\n" for t, height in zip(TIMES, z, strict=True))
        return prepare(measured(experiment(tmp_path, "t_s,z_m\n" + lines, TOML)))

    return of


def test_the_table_holds_measured_and_model_and_their_difference(prepared):
    ready = prepared(0.0)
    adequacy, table = judge(ready.problem, ready.base)
    assert adequacy.adequate and {len(values) for values in table.values()} == {len(TIMES)}
    np.testing.assert_allclose(table["measured"] - table["model"], table["residual"], atol=1e-12)
    np.testing.assert_allclose(table["residual"] / table["sigmas"], 0.01)
    assert set(partitions(table)) == {f"blocks of {length} samples" for length in (4, 12, 36)}  # one recording is no crowd


def test_where_it_fails_names_the_worst_sample(prepared):
    ready = prepared(0.5)
    adequacy, table = judge(ready.problem, ready.base)
    worst, *_ = where_it_fails(ready.problem, table)
    assert not adequacy.adequate
    assert worst["sigma"] == pytest.approx(np.sqrt(np.mean(table["sigmas"] ** 2)))
    assert worst["time"] == table["time"][np.argmax(np.abs(table["sigmas"]))] and worst["rms"] == pytest.approx(
        0.01 * worst["sigma"]
    )
    assert observations(ready.problem, ready.base)["trial"].tolist() == table["trial"].tolist()


def test_a_recording_whose_readings_are_not_judged_leaves_those_of_others_in_their_places(generator):
    """The first has orientations alone, of unknown noise; heights of the others are rounded, so what the model expects counts."""
    half = 1.5 * TIMES
    turned = {"t_s": TIMES, "qw": np.cos(half), "qx": 0 * half, "qy": 0 * half, "qz": np.sin(half)}
    fallen = [{"t_s": TIMES, "z_m": np.round(2 - 4.905 * TIMES**2 + 0.003 * generator.standard_normal(40), 2)} for _ in range(2)]
    ball = {"shape": "sphere", "radius": 0.03, "mass": 0.05}
    seen = hlcs.Experiment.from_frames(
        [turned, *fallen], body=ball, surroundings={"fluid_density": 0.0}, noise={"position": 0.003}
    )
    assert hlcs.compare(seen).adequate


def test_throws_seen_in_coarse_pixels_miss_nothing():
    """Twelve nulls in steps of 16 sigma, starts fitted: of good models one in a hundred fails."""

    def seen(seed):
        draw, times, frames = np.random.default_rng(seed), np.arange(0.0, 0.95, 1 / 30), []
        for _ in range(6):
            along, up = draw.uniform(-3, 3), draw.uniform(2, 4.5)
            true = {"x_m": along * times, "z_m": 1.3 + up * times - 9.81 * times**2 / 2}
            read = {name: np.round((path + 5e-4 * draw.standard_normal(len(times))) / 8e-3) * 8e-3 for name, path in true.items()}
            frames.append({"t_s": times, **read})
        body = {"shape": "sphere", "radius": 0.02, "mass": 0.28}
        return hlcs.Experiment.from_frames(frames, body, {"fluid_density": 0.0}, noise={"position": 5e-4})

    assert all(hlcs.compare(seen(seed)).adequate for seed in range(12))
