"""No world contradicts physics that its own file states: a fluid that moves the body is in the model, or is what is hidden."""

import io
import re
import tomllib

import numpy as np
import pytest
from numba import config as numba_config

from hlcs import mystery
from hlcs.mystery import making

from .generator import deck, tumble

compiled = pytest.mark.skipif(bool(numba_config.DISABLE_JIT), reason="millions of steps: only with compiled kernels")
AIR, SEEN = 1.2, 0.1  # kg/m3 where the file states nothing; sigmas
DRAG = {"linear_drag", "quadratic_drag", "drag_crisis"}


def size(body):
    """Volume [m3] and mean projected area [m2] (a quarter of the surface of a convex body)."""
    if body["shape"] == "sphere":
        return 4 / 3 * np.pi * body["radius"] ** 3, np.pi * body["radius"] ** 2
    a, b, c = body["size"]
    return a * b * c, (a * b + b * c + c * a) / 2


def contradictions(files, hidden, sigma):
    """{what the fluid does though nothing says so: the most it moves the body [sigmas]}, by closed forms of a constant
    acceleration a over a recording of T: rms a T^2/(2 sqrt 5) from a known start, a T^2/(2 sqrt 180) from a fitted one."""
    told = tomllib.loads(files["experiment.toml"])
    density = told["surroundings"].get("fluid_density", AIR)
    present = {entry["name"] for entry in told["model"]["effects"]} | set(hidden)
    volume, area = size(told["body"])
    lifted, pushed = density * volume / told["body"]["mass"], 0.5 * density * 0.47 * area / told["body"]["mass"]
    most = dict.fromkeys(("buoyancy", "added_mass", "drag"), 0.0)
    for trial in told["trial"]:
        rows = np.genfromtxt(io.StringIO(files[trial["file"]]), delimiter=",", names=True)
        t, place = rows["t_s"], np.column_stack([rows[name] for name in ("x_m", "y_m", "z_m")])
        span, moved = t[-1] - t[0], np.linalg.norm(np.ptp(place, axis=0))
        free = "floor" not in told["surroundings"]
        shown = (0.5 / np.sqrt(5) if "velocity" in trial.get("start", {}) else 0.5 / np.sqrt(180)) * span**2 / sigma
        pull = 9.81 if free else 2 * moved / span**2  # of a body that a floor carries: what its way shows
        most["buoyancy"] = max(most["buoyancy"], lifted * pull * shown)
        most["added_mass"] = max(most["added_mass"], 0.5 * lifted * pull * shown)
        most["drag"] = max(most["drag"], pushed * (moved / span) ** 2 * shown)
    absent = {name: strength for name, strength in most.items() if name not in present and strength > SEEN}
    if DRAG & present:
        absent.pop("drag", None)
    return absent


@compiled
@pytest.mark.parametrize("family", list(deck.ROOMS))
def test_no_case_contradicts_its_file(family):
    for turn, kind in enumerate(("null", "null", "placebo", "placebo", "placebo", "outside")):
        files, answer = deck.make(40 + turn, turn, deck.Dealt(kind, family, 4 * turn, False, "white", False))
        assert not contradictions(files, answer["effects"], answer["noise"]["position"]), (kind, answer["effects"])


@compiled
def test_a_ball_of_eleven_grams_without_its_drag_is_refused():
    """Planted: the model of a null in air is emptied; 11 g at 12 m/s are braked by more than gravity."""
    for seed in range(20):
        files, answer = deck.make(seed, 0, deck.Dealt("null", "flight", 0, False, "white", False))
        if "quadratic_drag" in files["experiment.toml"]:
            break
    files["experiment.toml"] = re.sub(r"^effects = .*$", "effects = []", files["experiment.toml"], flags=re.M)
    assert "drag" in contradictions(files, [], answer["noise"]["position"])


@pytest.mark.parametrize("name", [name for name in mystery.names() if name not in ("tall-tank", "quarry-yard")])
def test_no_mystery_contradicts_its_file(name):
    files = {file.name: file.read_text(encoding="utf-8") for file in (mystery.FOLDER / name).iterdir()}
    answer = mystery.answer(name)
    assert not contradictions(files, answer["effects"], answer["noise"]["position"])


def test_the_water_of_the_tall_tank_lifts_brakes_and_is_carried_along():
    told = tomllib.loads(mystery.experiment("tall-tank").read_text(encoding="utf-8"))
    assert {entry["name"] for entry in told["model"]["effects"]} == {"buoyancy", "added_mass", "quadratic_drag"}


@pytest.mark.parametrize("effect", ["quadratic_drag", "magnus", "friction", "restitution", "rolling_friction", "uniform_flow"])
def test_no_scene_of_a_new_mystery_contradicts_its_file(effect):
    """One effect of each scene; with nothing hidden everything that a fluid does must stand in the model."""
    files = making.made(effect, 0, 5)
    assert not contradictions(files, [], making.USUAL)


@pytest.mark.parametrize("restitution", [0.0, 0.3])
def test_a_foreign_cube_shows_the_friction_and_the_restitution_that_were_typed(restitution):
    """One throw: slips and blows of the engine itself, weighted by momentum. 0.01: what pushes it out of its floor."""
    pytest.importorskip("pybullet")
    start = tumble.thrown(np.random.default_rng(5), 0.08)
    *_, slips, hits = tumble.toss(start, 0.8, 0.08, 0.3, restitution, 0.9)
    assert hits
    assert tumble.median(slips)[0] == pytest.approx(0.3, rel=0.01)
    assert tumble.median(hits)[0] == pytest.approx(restitution, abs=0.01)
