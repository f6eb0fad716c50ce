"""The peers see what they should in recordings of closed form, and their table counts as `score.py` counts."""

import json

import numpy as np
import pytest

from tests.blind import peers

G, RATE = 9.81, 0.4


def slowed(start, velocity, times, rate):
    """Positions (n, 3) under gravity and linear drag, closed form."""
    fall = np.array([0.0, 0.0, -G]) / rate
    lasted = -np.expm1(-rate * times) / rate
    return start + np.outer(lasted, np.asarray(velocity) - fall) + np.outer(times, fall)


def write_case(folder, rate=1e-6, shake=0.0, seed=1):
    """Six throws with linear drag and a shaking camera, sigma 2 mm, with a static recording; a deck of one case."""
    case, generator = folder / "cases" / "case_0001", np.random.default_rng(seed)
    case.mkdir(parents=True)
    text = 'kind = "trajectory"\n[body]\nshape = "sphere"\nradius = 0.03\nmass = 0.05\n[surroundings]\nfluid_density = 1.2\n'
    text += '[measurement]\nstatic = "rest.csv"\n'

    def table(name, times, rows):
        seen = rows + 0.002 * generator.standard_normal((len(times), 3))
        np.savetxt(case / name, np.column_stack([times, seen]), delimiter=",", header="t_s,x_m,y_m,z_m", comments="", fmt="%.6f")

    for k in range(6):
        times, heading = np.arange(50) / 60, k * np.pi / 3
        velocity = (2 + k) * np.array([0.8 * np.cos(heading), 0.8 * np.sin(heading), 0.6])
        swing = shake * np.sin(2 * np.pi * 4 * times + k)
        table(f"r{k}.csv", times, slowed(np.array([0, 0, 1.5]), velocity, times, rate) + swing[:, None])
        text += f'[[trial]]\nfile = "r{k}.csv"\ngroup = "run {k % 3}"\n'
    table("rest.csv", np.arange(600) / 60, np.ones((600, 3)))
    (case / "experiment.toml").write_text(text)
    return case


def test_trajectories_are_those_of_the_closed_form():
    """Linear drag at 0.4 /s for a second: the fourth-order error of steps of 10 ms is below 1e-10 m."""
    times, number = np.linspace(0, 1, 7), peers.NULL.copy()
    number[peers.NUMBERS.index(("linear_drag", "rate"))] = RATE
    body = np.array([0.05, 0.03, G, 1.2])
    found = peers.fly(times, np.array([0, 0, 1.5]), np.array([3.0, 1.0, 4.0]), np.zeros(3), number, body)
    np.testing.assert_allclose(found, slowed(np.array([0, 0, 1.5]), [3, 1, 4], times, RATE), atol=1e-9)


@pytest.mark.parametrize(
    ("hidden", "verdict", "effects"),
    [({}, "complete", []), ({"rate": RATE}, "effect", ["linear_drag"]), ({"shake": 0.004}, "unexplained", None)],
)
def test_the_plain_script_says_what_is_there(tmp_path, hidden, verdict, effects):
    """A drag of fifty sigma is named alone with its rate; a shake of two sigma is in no law; noise alone is complete."""
    case = peers.Case(write_case(tmp_path, **hidden))
    case.laws = ["linear_drag", "quadratic_drag", "tilted_gravity", "length_scale"]  # what the test needs, for its time
    said = case.verdict(case.fits(case.rho), np.log, True)
    assert said["verdict"] == verdict and (effects is None or said["effects"] == effects)
    if effects:
        rate = said["parameters"]["linear_drag"]["rate"]
        assert rate["low"] < RATE < rate["high"]


def test_the_table_counts_as_the_score_does(tmp_path):
    """Two peers on one hidden drag: one names it, one names another; ours comes first where its verdicts are given."""
    write_case(tmp_path, RATE)
    answer = {"family": "flight", "kind": "single", "kind_of_data": "trajectory", "effects": ["linear_drag"], "tied": []}
    answer |= {"strengths": {"linear_drag": 3.0}, "largest_cosine": 0.5, "parameters": {}, "outside": False}
    answer |= {
        "beyond": [],
        "nearest": 100.0,
        "pair_cosine": 0.0,
        "possible": [],
        "hidden_laws": {},
        "noise": {"regime": "white"},
    }
    said = {"right": {"effects": ["linear_drag"]}, "wrong": {"effects": ["magnus"]}}
    said = {name: {"case_0001": {"verdict": "effect", "ambiguous": [], "seconds": 1.0, **v}} for name, v in said.items()}
    rows = peers.table(said, {"case_0001": answer})
    assert rows["unique but wrong"] == {"right": "0/1", "wrong": "1/1"}
    assert rows["seconds a case (CPU; ours by the clock): median, worst"]["right"] == "1.0, 1.0"


@pytest.mark.slow
def test_a_deck_is_judged_and_written(tmp_path):
    write_case(tmp_path, RATE)
    answer = {"family": "flight", "kind": "single", "kind_of_data": "trajectory", "effects": ["linear_drag"], "tied": []}
    answer |= {"strengths": {"linear_drag": 3.0}, "largest_cosine": 0.5, "parameters": {}, "outside": False}
    answer |= {
        "beyond": [],
        "nearest": 100.0,
        "pair_cosine": 0.0,
        "possible": [],
        "hidden_laws": {},
        "noise": {"regime": "white"},
    }
    (tmp_path / "answers.json").write_text(json.dumps({"cases": {"case_0001": answer}}))
    peers.main(["--cases", str(tmp_path), "--out", str(tmp_path / "peers.json"), "--markdown"])
    told = json.loads((tmp_path / "peers.json").read_text())
    assert told["rows"]["unique but wrong"]["BIC, AR(1), ties"] == "0/1" and set(peers.VARIANTS) <= set(told["verdicts"])
