"""Groups of a table that differ at equal inputs, as two persons with a stopwatch: each has a clock offset of its own."""

import numpy as np
import pytest

import hlcs

G, SIGMA, LATE = 9.81, 0.015, {"": 0.02, "Ben B.": 0.1}  # who wrote no name is a person, too


@pytest.fixture(scope="module")
def falls():
    """Falls of a dense ball from five heights, four times each by both: t = sqrt(2 h / g), and what each is late by."""
    height, person = np.tile(np.repeat([0.5, 1.0, 1.5, 2.0, 2.5], 4), 2), np.repeat(list(LATE), 20)
    late = np.array([LATE[name] for name in person])
    times = np.sqrt(2 * height / G) + late + SIGMA * np.random.default_rng(2).standard_normal(40)
    columns = {"height_m": height, "fall_time_s": times, "group": person}
    body, around = {"shape": "sphere", "radius": 0.02, "mass": 0.26}, {"fluid_density": 0.0}
    return hlcs.Experiment.from_frames(columns, body, around, kind="outcomes")


def test_each_person_has_a_reaction_time(falls):
    """20 rows each: a standard error of 15 ms / sqrt(20) = 3.4 ms and more, where the rows tell a scale as well."""
    found = hlcs.diagnose(falls)
    assert (found.verdict, found.effects) == ("effect", ("clock_offset",))
    for name, late in LATE.items():
        assert found.parameters["clock_offset"][f"offset {name or 'no name'}"]["value"] == pytest.approx(late, abs=0.012)
    mended = found.apply(falls)
    assert hlcs.compare(mended).adequate
    there = hlcs.predict(mended, {"height_m": [1.0]})["fall_time_s"][0]  # of nobody who would be late
    assert there == pytest.approx(np.sqrt(2 / G), rel=1e-4)


def test_persons_that_agree_have_one_clock():
    height, names = np.tile(np.repeat([0.5, 1.0, 1.5, 2.0, 2.5], 4), 2), np.repeat(["a", "b"], 20)
    times = np.sqrt(2 * height / G) + 0.06 + SIGMA * np.random.default_rng(3).standard_normal(40)
    columns = {"height_m": height, "fall_time_s": times, "group": names}
    body, around = {"shape": "sphere", "radius": 0.02, "mass": 0.26}, {"fluid_density": 0.0}
    found = hlcs.diagnose(hlcs.Experiment.from_frames(columns, body, around, kind="outcomes"), candidates=["clock_offset"])
    assert list(found.parameters["clock_offset"]) == ["offset"]


def test_bounces_of_drops_whose_release_was_heard_too_early_or_too_late():
    """No drop repeats a row of its own: what groups differ by at every setting is theirs, and what is left beside that is noise.

    t = sqrt(2 h / g) (1 + 2 e + .. + 2 e^(n - 1)) with e = 0.8, where 0.75 is stated.
    """
    drops, bounce = np.repeat(np.arange(6), 6), np.tile(np.arange(1, 7), 6)
    height, generator = np.where(drops % 2, 0.5, 0.3), np.random.default_rng(1)
    late = 0.02 * generator.standard_normal(6)
    flights = np.cumsum([1.0, *(2 * 0.8 ** np.arange(1, 6))])
    noise = 5e-4
    times = np.sqrt(2 * height / G) * flights[bounce - 1] + late[drops] + noise * generator.standard_normal(36)
    columns = {"height_m": height, "bounce": bounce, "bounce_time_s": times, "group": [f"drop {k}" for k in drops]}
    body, around = {"shape": "sphere", "radius": 0.02, "mass": 0.26}, {"fluid_density": 0.0, "restitution": 0.75}
    experiment = hlcs.Experiment.from_frames(columns, body, around, kind="outcomes")
    seen = hlcs.compare(experiment)
    assert seen.noise["position"] == pytest.approx(noise, rel=0.5)  # 20 degrees of freedom: 16 %, three times that
    found = hlcs.diagnose(experiment, candidates=["restitution", "clock_offset", "quadratic_drag"])
    assert found.verdict == "effect" and set(found.effects) == {"restitution", "clock_offset"}
    assert found.parameters["restitution"]["coefficient"]["value"] == pytest.approx(0.8, abs=0.001)
    offsets = [found.parameters["clock_offset"][f"offset drop {k}"]["value"] for k in range(6)]
    np.testing.assert_allclose(offsets, late, atol=0.002)


def test_the_clocks_of_a_class_are_listed_and_not_read_out():
    """Twelve persons, each late by 10 ms more than the one before: a sentence names two of them, the table all."""
    height, person = np.tile([0.5, 1.0, 1.5, 2.0], 12), np.repeat(np.arange(12), 4)
    times = np.sqrt(2 * height / G) + 0.01 * person + 0.002 * np.random.default_rng(6).standard_normal(48)
    columns = {"height_m": height, "fall_time_s": times, "group": [f"s{k:02d}" for k in person]}
    body, around = {"shape": "sphere", "radius": 0.02, "mass": 0.26}, {"fluid_density": 0.0}
    found = hlcs.diagnose(hlcs.Experiment.from_frames(columns, body, around, kind="outcomes"), candidates=["clock_offset"])
    opening, _, rest = " ".join(str(found).split()).partition("The numbers")
    assert "and 10 more, listed below" in opening and "s05" not in opening and "offset s05" in rest
