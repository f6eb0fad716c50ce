"""The generator's physics against closed forms, its noise and strengths against their definitions, its files against the
contract."""

import ast
import hashlib
import subprocess
import tomllib
from collections import Counter
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from numba import config as numba_config
from scipy.optimize import least_squares

from .generate import generate
from .generator import bounce, deck, flight, motion, noise, observe, plane, seal, slide, stack, strength, tables, tilting, topple
from .generator.build import Deal, balanced, judge
from .generator.case import Setup, toml_text
from .generator.noise import REGIMES
from .generator.observe import film, shifted, unknowns, with_errors

FOLDER = Path(__file__).resolve().parent
BALL = {"mass": 0.0577, "radius": 0.0335, "gravity": 9.81, "fluid_density": 1.2, "v_ref": 6.0}
FLOOR = {"floor_height": 0.0, "floor_normal": (0.0, 0.0, 1.0), "restitution": 0.75, "friction": 0.1}
compiled = pytest.mark.skipif(bool(numba_config.DISABLE_JIT), reason="millions of steps: only with compiled kernels")


def thrown(position, velocity, spin=(0.0, 0.0, 0.0)):
    return {
        "position": np.array(position, float),
        "velocity": np.array(velocity, float),
        "angular_velocity": np.array(spin, float),
    }


def test_free_flight_is_a_parabola():
    """x0 + v0 t + g t^2 / 2; Runge-Kutta is exact for a quadratic, so only rounding remains."""
    times = np.linspace(0, 1, 11)
    seen, _ = motion.simulate(None, BALL, {}, thrown([0, 0, 2], [3, 1, 4]), times, 1e-2)
    expected = np.array([0, 0, 2]) + times[:, None] * [3, 1, 4] - 0.5 * 9.81 * times[:, None] ** 2 * [0, 0, 1]
    np.testing.assert_allclose(seen, expected, atol=1e-12)


def test_quadratic_drag_follows_the_logarithm_of_cosh():
    """z = -(V^2 / g) ln cosh(g t / V), V^2 = 2 m g / (rho C A): fall from rest; fourth order at 2 ms leaves less than a
    micrometre."""
    terminal = np.sqrt(2 * BALL["mass"] * 9.81 / (1.2 * 0.5 * np.pi * BALL["radius"] ** 2))
    times = np.linspace(0, 3, 13)
    seen, _ = motion.simulate(
        None, BALL, {"quadratic_drag": {"drag_coefficient": 0.5}}, thrown([0, 0, 0], [0, 0, 0]), times, 2e-3
    )
    np.testing.assert_allclose(seen[:, 2], -(terminal**2) / 9.81 * np.log(np.cosh(9.81 * times / terminal)), atol=1e-6)


def test_linear_drag_decays_exponentially():
    """x = (v0 / rate)(1 - exp(-rate t))."""
    times = np.linspace(0, 2, 9)
    seen, _ = motion.simulate(None, BALL, {"linear_drag": {"rate": 0.7}}, thrown([0, 0, 0], [5, 0, 0]), times, 2e-3)
    np.testing.assert_allclose(seen[:, 0], 5 / 0.7 * (1 - np.exp(-0.7 * times)), atol=1e-9)


def test_sinking_starts_with_the_reduced_acceleration():
    """a = g (rho_s - rho_f) / (rho_s + C_a rho_f) just after the release; 1 % of the drag has not yet grown in 2 ms."""
    inputs = {"mass": 2500 * 4 / 3 * np.pi * 1e-6, "radius": 0.01, "gravity": 9.81, "fluid_density": 998.0, "v_ref": 0.7}
    laws = {
        "buoyancy": {"fluid_density": 998.0},
        "added_mass": {"coefficient": 0.5},
        "quadratic_drag": {"drag_coefficient": 0.45},
    }
    seen, _ = motion.simulate(None, inputs, laws, thrown([0, 0, 0], [0, 0, 0]), np.array([2e-3]), 1e-4)
    assert seen[0, 2] == pytest.approx(-0.5 * 9.81 * (2500 - 998) / (2500 + 499) * 4e-6, rel=1e-3)


def test_magnus_force_has_the_textbook_size():
    """F = C pi rho r^3 omega x w; over 10 ms the side way is F t^2 / 2 m to a promille."""
    seen, _ = motion.simulate(
        None, BALL, {"magnus": {"coefficient": 0.8}}, thrown([0, 0, 0], [10, 0, 0], [0, 0, 20]), np.array([0.01]), 1e-3
    )
    assert seen[0, 1] == pytest.approx(0.8 * np.pi * 1.2 * 0.0335**3 * 20 * 10 / 0.0577 * 0.5e-4, rel=2e-3)


def test_rebound_regains_the_square_of_the_restitution():
    """Apex above the floor e^2 h; the event is located to rounding, so nanometres are asked."""
    inputs = {**BALL, **FLOOR}
    fall = np.sqrt(2 * 1.0 / 9.81)
    seen, _ = motion.simulate(None, inputs, {}, thrown([0, 0, 1.0335], [0, 0, 0]), np.array([fall * 1.75]), 1e-2)
    assert seen[0, 2] - 0.0335 == pytest.approx(0.75**2, abs=1e-9)


@pytest.mark.parametrize("friction, left", [(1.0, 5 / 7 * 2.0), (0.05, 2.0 - 0.05 * 1.75 * 4.0)])
def test_oblique_bounce_sticks_or_slips(friction, left):
    """Sticking leaves 5/7 of the tangential speed of a solid sphere; slipping takes mu (1 + e) v_n."""
    state = np.array([0, 0, 0.0335, 2.0, 0, -4.0, 0, 0, 0])
    after = motion.impact(state, motion.parameters({**BALL, **FLOOR, "friction": friction}, {}))
    np.testing.assert_allclose(after[[3, 5]], [left, 3.0], rtol=1e-12)


def test_block_stops_after_the_square_of_its_speed():
    """v^2 / (2 mu g), and then it stays; the stop is located to rounding."""
    inputs = {
        "mass": 1.0,
        "gravity": 9.81,
        "friction": 0.3,
        "clearance": 0.02,
        "floor_normal": (0, 0, 1.0),
        "nominal_diameter": 0.07,
    }
    seen, _ = plane.simulate(None, inputs, {}, thrown([0, 0, 0.02], [2, 0, 0]), np.array([0.5, 1.0, 2.0]), 2e-3)
    np.testing.assert_allclose(seen[1:, 0], 4 / (2 * 0.3 * 9.81), atol=1e-9)
    np.testing.assert_allclose(seen[:, 2], 0.02)


def test_block_slides_down_with_the_difference_of_slope_and_friction():
    """a = g (sin - mu cos); below the angle of friction nothing moves."""
    for degrees, moves in ((30, True), (15, False)):
        normal, _, turn = slide.floor_of(np.deg2rad(degrees), 0.0)
        inputs = {
            "mass": 1.0,
            "gravity": 9.81,
            "friction": 0.3,
            "clearance": 0.0,
            "floor_normal": normal,
            "nominal_diameter": 0.07,
        }
        seen, _ = plane.simulate(None, inputs, {}, thrown([0, 0, 0], [0, 0, 0]), np.array([0.8]), 2e-3)
        expected = 0.5 * 9.81 * (np.sin(np.deg2rad(degrees)) - 0.3 * np.cos(np.deg2rad(degrees))) * 0.64 if moves else 0.0
        assert np.linalg.norm(seen[0]) == pytest.approx(expected, abs=1e-7)
        np.testing.assert_allclose(np.linalg.norm(turn), 1.0)


def test_ball_rolls_with_five_sevenths_of_the_slope():
    """(5/7) g sin, less (5/7) g cos arm / r by rolling friction; turned by the way over the radius."""
    normal, tangents, _ = slide.floor_of(0.05, 0.0)
    inputs = {"mass": 0.1, "radius": 0.03, "gravity": 9.81, "clearance": 0.03, "floor_normal": normal, "nominal_diameter": 0.05}
    start = {**thrown(0.03 * normal, [0, 0, 0]), "orientation": np.array([1.0, 0, 0, 0])}
    times = np.linspace(0, 1, 21)
    seen, turns = plane.simulate(None, inputs, {"rolling_friction": {"arm": 2e-4}}, start, times, 2e-3, rolling=True)
    way = np.linalg.norm(seen[-1] - seen[0])
    assert way == pytest.approx(0.5 * 5 / 7 * 9.81 * (np.sin(0.05) - np.cos(0.05) * 2e-4 / 0.03), rel=1e-6)
    np.testing.assert_allclose(turns[-1], noise.small_turn(np.array([0, way / 0.03, 0])), atol=1e-9)


def test_a_larger_ball_of_the_same_mass_displaces_more_fluid():
    """(5/7) g sin (1 - rho V / m) with V of the true radius (Archimedes)."""
    normal, _, _ = slide.floor_of(0.05, 0.0)
    volume = 4 / 3 * np.pi * 0.03**3
    inputs = {"mass": 0.2, "radius": 0.03, "gravity": 9.81, "volume": volume, "clearance": 0.03, "floor_normal": normal}
    laws = {"buoyancy": {"fluid_density": 998.0}, "size_error": {"relative": 0.02}}
    true = with_errors({**inputs, "nominal_diameter": volume ** (1 / 3)}, {}, {}, laws)
    start = {**thrown(0.03 * normal, [0, 0, 0]), "orientation": np.array([1.0, 0, 0, 0])}
    seen, _ = plane.simulate(None, true, laws, start, np.array([0.0, 1.0]), 2e-3, rolling=True)
    expected = 0.5 * 5 / 7 * 9.81 * np.sin(0.05) * (1 - 998.0 * volume * 1.02**3 / 0.2)
    assert np.linalg.norm(seen[1] - seen[0]) == pytest.approx(expected, rel=1e-6)


def test_toppling_block_keeps_its_energy():
    """I omega^2 / 2 + g z is constant without outside effects; fourth order at 1 ms leaves less than 1e-9 of it."""
    inputs = {"mass": 1.0, "gravity": 9.81, "width": 0.1, "block_height": 0.25, "nominal_diameter": 0.13}
    p = tilting.parameters(inputs, {}, 0.3)
    angle, rate, _ = tilting.turn(0.45, 0.0, np.linspace(0, 0.5, 6), 1e-3, p).T
    height = p[1] * np.cos(angle) - p[0] * np.sin(angle)
    energy = 0.5 * p[2] * rate**2 + 9.81 * height
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)
    assert p[2] == pytest.approx((0.1**2 + 0.25**2) / 3)  # about an edge of a homogeneous block


def test_no_block_is_filmed_beyond_the_slip_of_its_edge():
    """A clock that is 0.1 s late shows what comes after the last time of the file, where friction of 0.9 holds no edge."""
    rng = np.random.default_rng(7)
    block = topple.setup(rng, lambda duration: np.arange(0, duration, 1 / 60), "falls")
    assert all(observe.holds(block, trial, {}) for trial in block.trials)
    assert not all(observe.holds(block, trial, {"clock_offset": {"offset": -0.1}}) for trial in block.trials)


def test_unit_comes_to_rest_on_the_stack():
    """Free fall, then rest at half a side above the stack; with restitution e the first apex is e^2 h."""
    g = np.array([0.0, 0.0, -9.81])
    fall = np.sqrt(2 * 0.05 / 9.81)
    way = stack.drop(0.05, 0.0, 0.0, g, 0.4, np.array([0.0, 0.5 * fall, fall * 1.4, 3.0]))
    np.testing.assert_allclose(way[:, 2], [0.05, 0.05 * 0.75, 0.16 * 0.05, 0.0], atol=1e-9)


@pytest.mark.parametrize("family", ["flight", "bounce", "slide"])
def test_tables_follow_closed_forms(family):
    """Fall time with drag (V/g) arcosh exp(g h / V^2), rebound e^2 h, stopping way v^2 / (2 mu g); interpolation leaves 1e-6."""
    made, _ = tables.setup(np.random.default_rng(3), family, ("quadratic_drag",))
    settings = np.unique(made.trials)
    seen = tables.respond(made, {}, {}, settings)
    plain = {"flight": np.sqrt(2 * settings / 9.81), "bounce": 0.75**2 * settings, "slide": settings**2 / (2 * 0.3 * 9.81)}[
        family
    ]
    np.testing.assert_allclose(seen, plain, rtol=1e-6)
    if family == "flight":
        terminal = np.sqrt(2 * made.inputs["mass"] * 9.81 / (1.2 * 0.4 * np.pi * made.inputs["radius"] ** 2))
        seen = tables.respond(made, {"quadratic_drag": {"drag_coefficient": 0.4}}, {}, settings)
        np.testing.assert_allclose(seen, terminal / 9.81 * np.arccosh(np.exp(9.81 * settings / terminal**2)), rtol=1e-5)


def test_a_block_displaces_its_own_volume():
    """Stopping way v^2 (m + C rho V) / (2 mu g (m - rho V)): that of the ball that stands in for its drag is 61 % larger."""
    made, _ = tables.setup(np.random.default_rng(3), "slide")
    made.inputs["fluid_density"] = 1.2
    settings, moved = np.unique(made.trials), 1.2 * 0.12 * 0.08 * 0.04
    air = {"buoyancy": {"fluid_density": 1.2}, "added_mass": {"coefficient": 0.68, "fluid_density": 1.2}}
    expected = settings**2 * (0.35 + 0.68 * moved) / (2 * 0.3 * 9.81 * (0.35 - moved))
    np.testing.assert_allclose(tables.respond(made, air, {}, settings), expected, rtol=1e-6)


@pytest.mark.parametrize("rho", [0.0, 0.6, 0.8])
def test_correlated_noise_has_its_deviation_and_its_memory(generator, rho):
    """sd and lag-one correlation of 200,000 samples: their standard errors are below 0.01 at rho = 0.8, four of them allowed."""
    values = noise.correlated(generator, (200_000, 1), 2.0, rho)[:, 0]
    assert values.std() == pytest.approx(2.0, rel=0.03)
    assert np.corrcoef(values[1:], values[:-1])[0, 1] == pytest.approx(rho, abs=0.01)


def test_rounding_and_outliers_are_as_declared(generator):
    """A step of one sigma, and half a percent of values beyond five sigmas."""
    tracker = noise.Noise(1e-3 * np.sqrt(13 / 12), 0.01, 0.0, 0.005, 1.0, 0.0, 0.0, 60)  # rounding adds a twelfth of the square
    seen = noise.spoil(generator, tracker, np.zeros((100_000, 1)), tracker.position)
    np.testing.assert_allclose(seen / 1e-3, np.round(seen / 1e-3), atol=1e-9)
    assert np.mean(np.abs(seen) > 4.9e-3) == pytest.approx(0.005, rel=0.2)


def test_dropped_frames_are_missing_rows(generator):
    """One frame in ten lost: the stamps still rise and the first is kept."""
    stamps = noise.frames(generator, noise.Noise(1e-3, 0.01, 0.0, 0.0, 0.0, 0.01, 0.1, 100), 20.0)
    assert stamps[0] == 0 and (np.diff(stamps) > 0).all() and len(stamps) == pytest.approx(1800, abs=60)


@compiled
def test_strength_is_the_rms_after_the_start_is_fitted(generator):
    """Against plain polynomials: in free flight the start absorbs a straight line per axis and recording, nothing else."""
    made = flight.setup(generator, lambda duration: np.linspace(0, duration, 30), "throws", ("linear_drag",))
    lens = strength.Lens(made, 2e-3, 0.01, 0.6)
    amplitude = strength.scaled(lens, lambda a: {"linear_drag": {"rate": a}}, 1.2, 0.01)
    left = []
    for trial, rows in zip(made.trials, lens.signal({"linear_drag": {"rate": amplitude}}), strict=True):
        for axis in range(3):
            left.append(rows[:, axis] - np.polyval(np.polyfit(trial.times, rows[:, axis], 1), trial.times))
    assert np.sqrt(np.mean(np.concatenate(left) ** 2)) == pytest.approx(1.2, rel=0.02)


@compiled
def test_the_look_alikes_of_free_flight_are_known(generator):
    """Length scale and time scale are one effect in free flight (discovery page, rule 10)."""
    draws = (flight.setup(generator, lambda duration: np.linspace(0, duration, 40), "throws") for _ in range(100))
    made = next(made for made in draws if not made.model)  # in a vacuum, where buoyancy is none
    lens = strength.Lens(made, 2e-3, 0.01, 0.0)
    rows = lens.signal({"time_scale": {"factor": 0.995}})
    _, left = lens.fit(["time_scale"], rows)
    tied, _, cosine, nearest, _ = strength.look_alikes(lens, "time_scale", rows, left)
    assert {"length_scale"} <= set(tied) and cosine > 0.999 and nearest < strength.ALIKE


@compiled
@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.6, -0.64, 0.48)])
def test_a_body_that_spins_faster_is_told_by_all_its_turns(axis):
    """A start whose spin is fitted absorbs w t only where it goes on growing beyond half a turn: 20 rad are three of them."""
    times, still = np.linspace(0.0, 2.0, 60), np.array([1.0, 0.0, 0.0, 0.0])
    turned = [noise.small_turn(10.0 * t * np.array(axis)) for t in times]
    seen = noise.gone_round(noise.turn_between(np.tile(still, (60, 1)), np.array(turned)))
    np.testing.assert_allclose(seen, 10.0 * times[:, None] * axis, atol=1e-9)


def test_fit_returns_what_was_hidden(generator):
    """Two laws hidden in their textbook form come back to a promille from noiseless rows."""
    made = bounce.setup(generator, lambda duration: np.linspace(0, duration, 60), "drops")
    lens = strength.Lens(made, 1e-3, 0.01, 0.0)
    rows = lens.signal({"restitution": {"coefficient": 0.76}, "tilted_gravity": {"angle_x": 0.003, "angle_y": -0.002}})
    laws, _ = lens.fit(["restitution", "tilted_gravity"], rows, turns=8)
    assert laws["restitution"]["coefficient"] == pytest.approx(0.76, rel=1e-3)
    assert laws["tilted_gravity"]["angle_x"] == pytest.approx(0.003, rel=1e-2)


@compiled
def test_the_answer_is_what_the_film_shows(generator):
    """Friction that vanishes below s = 0.26 mm/s lets a block go with at most v = s ln 2 mu g cos / a more speed, which a
    coefficient smaller by at most 2 v / (t g cos) makes up for: the step of the sensitivities may not add to that."""
    made = slide.setup(generator, lambda duration: np.linspace(0, duration, 120), "incline")
    lens = strength.Lens(made, 3e-3, 0.01, 0.0)
    hidden, most = {"friction": {"coefficient": 0.2976, "form": 0.0256}}, 0.0
    for trial in made.trials:
        cosine = trial.overrides["floor"]["normal"][2]
        drive, brake = 9.81 * np.sqrt(1 - cosine**2), 0.2976 * 9.81 * cosine
        most = max(most, 2 * 2.56e-4 * np.log(2) * brake / (drive - brake) / (trial.times[-1] * 9.81 * cosine))
    answer, _, _ = judge(Deal("slide", "single", ("friction",), "incline", (3.0,), "white"), lens, hidden, {})
    assert 0 <= 0.2976 - answer["parameters"]["friction"]["coefficient"] <= most


@compiled
def test_the_ideal_number_is_that_of_a_fit_with_its_starts(generator):
    """A strong drag, of another form than the textbook's and of a body of another mass than stated: the coefficient that least
    squares find with all starts, to a hundredth of its standard error; starts of a flight without drag are 0.044 of it off."""
    made = flight.setup(generator, lambda duration: np.linspace(0, duration, 60), "throws", ("quadratic_drag",)).trimmed((0, 1))
    lens, laws = strength.Lens(made, 1.3e-3, 0.01, 0.0), {"quadratic_drag": {"drag_coefficient": 3.0, "form": 0.01}}
    errors = {"mass": 0.002, "size": -0.001}
    rows = lens.signal(laws, errors, step=strength.FINE)
    ideal = lens.beside(laws).fit(["quadratic_drag"], rows, near=laws)[0]["quadratic_drag"]["drag_coefficient"]

    def left(numbers):
        drag, moves, parts = {**made.base(), "quadratic_drag": {"drag_coefficient": numbers[0]}}, iter(numbers[1:]), []
        for trial, seen, base in zip(made.trials, rows, lens.base, strict=True):
            start = trial.start
            for key, direction, _ in unknowns(made, trial):
                start = shifted(start, key, direction, 1e-3 * next(moves))
            parts.append(seen - lens._rows(film(made, trial, drag, start=start), base))
        return np.concatenate(parts).ravel()

    count = sum(len(unknowns(made, trial)) for trial in made.trials)
    found = least_squares(left, np.r_[3.0, np.zeros(count)], x_scale="jac")
    error = np.sqrt(np.linalg.inv(found.jac.T @ found.jac)[0, 0])
    assert abs(ideal - found.x[0]) < 0.01 * error


@pytest.mark.parametrize("seed", [5, 6])
def test_a_deck_fills_every_row(seed):
    """60 cases of every kind and, of what the library can explain, of every noise; numbers beyond their range; where pybullet is
    missing only its own cases are."""
    dealt = deck.deal_all(seed)
    count = Counter(one.kind for one in dealt)
    assert all(count[kind] >= 60 for kind in ("null", "outside", "placebo", "degenerate", "clear", "nested", "joint"))
    usual = [one for one in dealt if one.kind in deck.IN_LIBRARY and one.family not in ("layers", "tumble")]
    noise = Counter("white" if one.table else one.regime for one in usual)
    assert set(noise) == set(REGIMES) and min(noise.values()) >= 60 and sum(one.far for one in dealt) >= 60
    tumbles = sum(one.family == "tumble" for one in dealt)
    assert tumbles == (12 if find_spec("pybullet") else 0) and len(dealt) == deck.WHOLE - 12 + tumbles
    assert {one.family for one in dealt} >= set(deck.ROOMS) | {"layers"} and deck.deal_all(seed) == dealt


def test_at_least_twelve_library_effects_are_hidden():
    names = {name for room in deck.ROOMS.values() for name in room.HIDDEN}
    assert len(names) >= 12 and names <= set(strength.LIBRARY)


def test_generator_knows_nothing_of_the_analyst():
    """No inverse crime: neither the engine nor the laboratory is imported by the generator."""
    for file in [FOLDER / "generate.py", *(FOLDER / "generator").glob("*.py")]:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = (
                [alias.name for alias in node.names]
                if isinstance(node, ast.Import)
                else [node.module or ""]
                if isinstance(node, ast.ImportFrom)
                else []
            )
            assert not [name for name in names if name.split(".")[0] in ("hlcs", "minibullet")], file


def test_toml_text_is_read_back():
    tables_ = {
        "": {"kind": "trajectory", "title": 'a "quoted" \\ title'},
        "body": {"mass": 0.1, "size": [1.0, 2, 3]},
        "trial": [{"file": "a.csv", "start": {"velocity": [0.0, -0.0, 1e-9]}}, {"file": "b.csv"}],
    }
    back = tomllib.loads(toml_text(tables_))
    assert (
        back["title"] == 'a "quoted" \\ title'
        and back["trial"][0]["start"]["velocity"] == [0.0, 0.0, 1e-9]
        and len(back["trial"]) == 2
    )


def test_the_seed_of_a_judging_deck_is_that_of_its_frozen_commit(tmp_path):
    """Where a file is not committed no seed is given; each opened deck is registered once, others and open seeds never."""
    words = ["git", "-C", str(tmp_path)]
    for more in (["init", "-q"], ["config", "user.email", "a@b.c"], ["config", "user.name", "a"]):
        subprocess.run([*words, *more], check=True)
    (tmp_path / "a").write_text("1")
    with pytest.raises(SystemExit, match="not committed"):
        seal.frozen(tmp_path)
    subprocess.run([*words, "add", "a"], check=True)
    subprocess.run([*words, "commit", "-q", "-m", "a"], check=True)
    commit = seal.frozen(tmp_path)
    assert seal.seed_of(commit) == int(hashlib.sha256(commit.encode()).hexdigest()[:15], 16)
    record = {"commit": commit, "seed": seal.seed_of(commit), "family": None, "kind": None, "cases": {"a": {}}}
    register = tmp_path / "opened.txt"
    assert seal.opened(record, register) == seal.opened(record, register) == [f"{commit} 1"]
    assert seal.opened({**record, "seed": 5}, register) == [f"{commit} 1"] and not seal.judges({**record, "kind": "null"})


@compiled
def test_cases_are_valid_repeatable_and_tell_nothing(tmp_path):
    """One case a family: TOML with the contract's keys, rising finite times, unit quaternions, no hidden name in the file,
    same bytes again."""
    answers = {}
    for k, family in enumerate((*deck.ROOMS, "layers")):
        kind = "outside" if k % 2 else "null"
        answers |= {f"{family}/{name}": value for name, value in generate(tmp_path / family, 11 + k, 1, family, kind).items()}
    generate(tmp_path / "again", 11, 1, deck.FAMILIES[0], "null")
    for file in (tmp_path / "again" / "cases" / "case_0001").iterdir():
        assert file.read_bytes() == (tmp_path / deck.FAMILIES[0] / "cases" / "case_0001" / file.name).read_bytes()
    for key, answer in answers.items():
        folder = tmp_path / key.split("/")[0] / "cases" / "case_0001"
        text = (folder / "experiment.toml").read_text(encoding="utf-8")
        experiment = tomllib.loads(text)
        assert experiment["kind"] in ("trajectory", "outcomes", "layers") and not [
            name for name in answer["effects"] if f'"{name}"' in text
        ]
        for trial in experiment.get("trial", []):
            values = np.genfromtxt(folder / trial["file"], delimiter=",", names=True)
            assert (np.diff(values["t_s"]) > 0).all() and all(np.isfinite(values[name]).all() for name in values.dtype.names)
            if "qw" in values.dtype.names:
                np.testing.assert_allclose(sum(values[q] ** 2 for q in ("qw", "qx", "qy", "qz")), 1.0, atol=1e-5)


@compiled
def test_recommended_recordings_join_a_case_that_stays_as_it_was():
    """The first tenth of a second of a football shows the speed asked for, but for what gravity (2.9 %) and drag (1.9 %) take."""
    dealt = deck.Dealt("outside", "flight", 3, False, "white", False)
    first, answer = deck.make(5, 0, dealt)
    more, same = deck.make(5, 0, dealt, then=({"speed_m_s": 15.0}, 2))
    assert same == answer and all(more[name] == text for name, text in first.items() if name.endswith(".csv"))
    trials = tomllib.loads(more["experiment.toml"])["trial"][-2:]
    assert [trial["group"] for trial in trials] == ["recommended"] * 2
    for trial in trials:
        t, *x = np.loadtxt(more[trial["file"]].splitlines(), delimiter=",", skiprows=1, unpack=True)[:4]
        early = t < 0.1
        fitted = [np.polyfit(t[early], axis[early], 1)[0] for axis in x]
        assert np.linalg.norm(fitted) == pytest.approx(15.0, rel=0.05)


@pytest.mark.parametrize("groups", [["a"] * 3 + ["b"] * 3, ["a"] * 2 + ["b"] * 3 + ["c"] * 2, ["b", "a", "b", "a"]])
def test_signs_of_a_placebo_balance_over_all_and_to_one_in_every_group(groups):
    for seed in range(20):
        signs = balanced(np.random.default_rng(seed), groups)
        assert abs(signs.sum()) == len(groups) % 2
        assert all(abs(signs[np.array(groups) == group].sum()) <= 1 for group in groups)


def test_setup_lists_the_model():
    made = Setup("flight", "", {}, {}, {}, ({"name": "quadratic_drag", "drag_coefficient": 0.5},), (), (), None, ())
    assert made.base() == {"quadratic_drag": {"drag_coefficient": 0.5}}


def test_tilted_gravity_turns_about_the_axes_like_a_tilted_frame():
    """angle_y about y pushes to -x, angle_x about x to +y; a frame that leans by the opposite angles shows the same flight."""
    times = np.linspace(0, 1, 5)
    still = thrown([0, 0, 0], [0, 0, 0])
    seen, _ = motion.simulate(None, BALL, {"tilted_gravity": {"angle_x": 0.01, "angle_y": 0.02}}, still, times, 1e-2)
    np.testing.assert_allclose(seen[-1, :2], 0.5 * 9.81 * np.array([-np.sin(0.02), np.sin(0.01)]), atol=1e-12)
