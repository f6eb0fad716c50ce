"""Groups of a table that differ at equal inputs, two persons with a stopwatch: each has an error of measurement of its own."""

import numpy as np
import pytest

import hlcs

G, SIGMA, LATE = 9.81, 0.015, {"Anna": 0.02, "Ben B.": 0.1}


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
        assert found.parameters["clock_offset"][f"offset {name}"]["value"] == pytest.approx(late, abs=0.012)
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
