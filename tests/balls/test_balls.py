"""Real falling balls (de Silva et al. 2020): drag for the light ones, none claimed for the dense ones, the rest left open.

The data are not ours to ship: they lie in ../shared/data/balls of a developer's machine, and the tests are skipped without
them. Experiment files are written when the test runs. Protocol: t >= 0.3 s, tails that lost the ball cut, noise 0.045 m.
"""

import csv
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import hlcs

DATA = Path(__file__).resolve().parents[3] / "shared" / "data" / "balls"
pytestmark = pytest.mark.skipif(not (DATA / "ball_drops.csv").is_file(), reason="the balls' data are not on this machine")

DRAGGED = (
    "whiffle_ball_1",
    "whiffle_ball_2",
    "yellow_whiffle_ball",
    "orange_whiffle_ball",
    "tennis_ball",
    "volleyball",
    "blue_basketball",
    "green_basketball",
)
DENSE = ("baseball", "golf_ball", "bowling_ball")
DRAGS = {"linear_drag", "quadratic_drag", "drag_crisis"}
OF_AIR = {"buoyancy", "added_mass"}  # that the stated air implies, where the mass and the size of the ball are stated
HEAD = "[surroundings]\nfluid_density = 1.21\nfluid_viscosity = 1.8e-5\n[measurement]\nnoise = { position = 0.045 }\n"


def cut(times, heights):
    """Samples after 0.3 s, without a tail whose speed falls below 0.8 of the one before."""
    keep = times >= 0.3
    times, heights = times[keep], heights[keep]
    while True:
        speed = -np.diff(heights) / np.diff(times)
        if speed[-1] >= 0.8 * speed[-2]:
            return times, heights
        times, heights = times[:-1], heights[:-1]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """One experiment file per ball with its two drops as groups, and one for all balls whose mass is known."""
    folder = tmp_path_factory.mktemp("balls")
    drops = np.genfromtxt(DATA / "ball_drops.csv", delimiter=",", names=True, dtype=None, encoding="utf8")
    joint = ['kind = "trajectory"\ntitle = "all balls"\n[body]\nshape = "sphere"\n' + HEAD]
    with (DATA / "balls.csv").open(encoding="utf8") as file:
        balls = list(csv.DictReader(file))
    for ball in balls:
        name, body, trials = ball["ball"], "", ""
        if ball["mass_kg"]:
            body = f"mass = {ball['mass_kg']}\nradius = {float(ball['diameter_m']) / 2!r}\n"
        for drop in (1, 2):
            rows = drops[(drops["ball"] == name) & (drops["drop"] == drop)]
            times, heights = cut(rows["t_s"], rows["height_m"])
            lines = "".join(f"{t:.9f},{h:.9f}\n" for t, h in zip(times, heights, strict=True))
            (folder / f"{name}_{drop}.csv").write_text("t_s,z_m\n" + lines)
            entry = f'[[trial]]\nfile = "{name}_{drop}.csv"\ngroup = "drop {drop}"\n'
            trials += entry
            joint += [entry + body] if body else []
        head = f'kind = "trajectory"\ntitle = "{name}"\n[body]\nshape = "sphere"\n'
        (folder / f"{name}.toml").write_text(head + body + HEAD + trials)
    (folder / "joint.toml").write_text("".join(joint))
    return folder


@pytest.fixture(scope="module")
def diagnosed(folder):
    """Function: name of an experiment file -> its Diagnosis, made once (3 to 12 s each)."""
    return cache(lambda name: hlcs.diagnose(folder / f"{name}.toml"))


def quick_only(quick, names):
    """The names as parameters, all but one for the slow run."""
    return [name if name == quick else pytest.param(name, marks=pytest.mark.slow) for name in names]


@pytest.mark.parametrize("ball", quick_only("volleyball", DRAGGED))
def test_drag_for_a_light_ball_its_form_and_the_rest_left_open(diagnosed, ball):
    """Whatever form, the drag works against the motion, and nothing else is accepted beside what the stated air implies, which is
    as it was stated: no force depends on the height."""
    diagnosis = diagnosed(ball)
    assert diagnosis.verdict == "unexplained" and diagnosis.adequate["after"] is False
    assert len(DRAGS & {*diagnosis.effects}) == 1 and set(diagnosis.effects) <= DRAGS | OF_AIR
    assert all(entry["low"] >= 0 for name in diagnosis.effects for entry in diagnosis.parameters[name].values())
    air = diagnosis.parameters.get("buoyancy", {}).get("fluid_density", {"value": 1.21})["value"]
    assert air == pytest.approx(1.21, rel=0.1)  # plausible: a stated fluid holds to 5 %, twice that contradicts the file
    held = diagnosis.error["held_out"]
    assert held["after"] < 0.65 * held["before"]  # the basketballs gain least: 0.44 -> 0.17 m and 0.32 -> 0.09 m
    # where to look again; or at what rests, where smooth curves leave more than the stated noise (0.06 m of the blue basketball)
    assert ("at rest" if diagnosis.noise_shown else "the model misses") in diagnosis.next_experiment.text


def test_the_form_of_the_drag_is_left_open_for_a_ball_of_unknown_mass(diagnosed):
    """Two falls of 37 m do not tell a drag in proportion to the speed from one to its square, beside what the camera misses."""
    assert {"linear_drag", "quadratic_drag"} <= set(diagnosed("volleyball").ambiguous[0])


@pytest.mark.parametrize("ball", quick_only("bowling_ball", DENSE))
def test_no_drag_claimed_for_a_dense_ball(diagnosed, ball):
    diagnosis = diagnosed(ball)
    assert diagnosis.verdict == "unexplained" and diagnosis.adequate["after"] is False
    assert not DRAGS & {*diagnosis.effects, *(name for names in diagnosis.ambiguous for name in names)}


@pytest.mark.slow
def test_all_balls_together_share_a_drag_with_a_crisis_and_a_suspected_camera(diagnosed):
    """A drag that falls about a Reynolds number of 1.5e5 to 2.2e5, 0.33 m on what was held out, as in the pilot study, which left
    the lift of the air out; the residual against height is common to all, so the camera is suspected."""
    diagnosis = diagnosed("joint")
    assert diagnosis.verdict == "unexplained" and diagnosis.adequate["after"] is False
    assert diagnosis.effects[0] == "drag_crisis" and set(diagnosis.effects) == {"drag_crisis"} | OF_AIR
    crisis = diagnosis.parameters["drag_crisis"]
    assert 0.4 < crisis["subcritical"]["value"] < 0.6 and 1.5e5 < crisis["critical_reynolds"]["value"] < 2.2e5
    assert diagnosis.parameters["buoyancy"]["fluid_density"]["value"] == pytest.approx(1.21, rel=0.1)
    camera = next(finding for finding in diagnosis.candidates if finding.effect == "calibration_curve")
    assert camera.why.startswith("suspected:") and not camera.accepted
    assert diagnosis.error["held_out"]["after"] < 0.35


@pytest.mark.slow
def test_held_out_error_of_all_balls(diagnosed):
    """Root mean square over the balls of the error on the drop that was not used: at most 0.35 m (measured: 0.24 m)."""
    errors = [diagnosed(ball).error["held_out"]["after"] for ball in (*DRAGGED, *DENSE)]
    assert np.sqrt(np.mean(np.square(errors))) < 0.35


@pytest.mark.slow
def test_ten_lines_with_tables_in_memory_give_what_the_files_give(diagnosed):
    drops, balls = pd.read_csv(DATA / "ball_drops.csv"), pd.read_csv(DATA / "balls.csv").set_index("ball")
    ball, frames = balls.loc["tennis_ball"], []
    for _, rows in drops[drops.ball == "tennis_ball"].groupby("drop"):
        times, heights = cut(rows.t_s.to_numpy(), rows.height_m.to_numpy())
        frames.append({"t_s": times, "z_m": heights})
    body = {"shape": "sphere", "mass": ball.mass_kg, "radius": ball.diameter_m / 2}
    air, groups = {"fluid_density": 1.21, "fluid_viscosity": 1.8e-5}, [{"group": "drop 1"}, {"group": "drop 2"}]
    found = hlcs.diagnose(hlcs.Experiment.from_frames(frames, body, air, {"position": 0.045}, trials=groups))
    filed = diagnosed("tennis_ball")
    assert (found.verdict, found.effects, found.ambiguous) == (filed.verdict, filed.effects, filed.ambiguous)
    # files hold nine digits of a metre
    assert found.parameters["linear_drag"]["rate"]["value"] == pytest.approx(
        filed.parameters["linear_drag"]["rate"]["value"], rel=1e-5
    )
