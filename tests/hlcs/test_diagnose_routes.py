"""Roads to a verdict that one step at a time misses: unseen axes, forms of a law, rulers, fluids that the file states."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import hlcs
from hlcs.data.experiment_file import read_experiment_file
from hlcs.simulation.model import build_entry
from minibullet.errors import InputError

G = 9.81
BALL = '[body]\nshape = "sphere"\nradius = 0.02\nmass = 0.0027\n[surroundings]\nfluid_density = 1.2\n'
PER_METRE = 0.5 * 0.5 * 1.2 * np.pi * 0.02**2 / 0.0027  # drag coefficient 0.5


def thrown(folder, columns, wind=0.0, count=6):
    """Throws in still air or in wind along x, drag coefficient 0.5, integrated to 1e-9; the path of the experiment file."""
    generator, entries = np.random.default_rng(8), []
    for k in range(count):
        start = [0, 0, 2, 3 * np.cos(2 * k), 3 * np.sin(2 * k), 4 + 0.2 * k]

        def rates(_, y):
            relative = y[3:] - [wind, 0, 0]
            return np.r_[y[3:], -PER_METRE * np.linalg.norm(relative) * relative - [0, 0, G]]

        times = np.arange(54) / 60
        track = solve_ivp(rates, (0, 1), start, t_eval=times, rtol=1e-9, atol=1e-11).y[:3].T
        seen = track + 0.004 * generator.standard_normal(track.shape)
        rows = "".join(
            f"{t:.6f}," + ",".join(f"{row['xyz'.index(c)]:.6f}" for c in columns) + "\n"
            for t, row in zip(times, seen, strict=True)
        )
        (folder / f"d{k}.csv").write_text("t_s," + ",".join(f"{c}_m" for c in columns) + "\n" + rows)
        entries.append(f'[[trial]]\nfile = "d{k}.csv"\ngroup = "{k % 2}"\n')
    path = folder / "e.toml"
    path.write_text(f'kind = "trajectory"\n{BALL}[measurement]\nnoise = {{ position = 0.004 }}\n' + "".join(entries))
    return path


def test_drag_is_found_in_throws_seen_from_above(tmp_path):
    """The rise and fall that the camera does not see drives the drag that it sees."""
    diagnosis = hlcs.diagnose(thrown(tmp_path, "xy", count=4), candidates=["linear_drag", "quadratic_drag"])
    assert diagnosis.verdict == "effect" and diagnosis.effects == ("quadratic_drag",)
    assert diagnosis.parameters["quadratic_drag"]["drag_coefficient"]["value"] == pytest.approx(0.5, abs=0.02)


def test_a_form_that_leaves_the_data_unexplained_is_no_rival(tmp_path):
    """Falls of a light ball: linear drag looks alike (cosine above 0.99) but leaves many times the noise of 0.1 ms."""
    rows = [
        (h, np.arccosh(np.exp(PER_METRE * h)) / np.sqrt(G * PER_METRE) + 1e-4 * noise)
        for h, noise in zip(
            np.repeat((0.5, 1.0, 1.5, 2.0, 2.5, 3.0), 4), np.random.default_rng(7).standard_normal(24), strict=True
        )
    ]
    diagnosis = hlcs.diagnose(table(tmp_path, "height_m,fall_time_s", rows), candidates=["linear_drag", "quadratic_drag"])
    assert diagnosis.verdict == "effect" and diagnosis.effects == ("quadratic_drag",)


def test_the_form_of_a_law_is_asked_again_once_the_rest_is_in(tmp_path):
    """In unknown wind the linear form fits best at first, and with it neither is ever adequate."""
    path = thrown(tmp_path, "xyz", wind=2.0)
    diagnosis = hlcs.diagnose(path, candidates=["linear_drag", "quadratic_drag", "uniform_flow"])
    assert diagnosis.verdict == "effect" and set(diagnosis.effects) == {"quadratic_drag", "uniform_flow"}
    assert diagnosis.parameters["uniform_flow"]["velocity_x"]["value"] == pytest.approx(2.0, abs=0.1)


def table(folder, head, rows, extra="", body=BALL):
    """An outcome table and the path of its experiment file."""
    (folder / "t.csv").write_text(head + "\n" + "".join(",".join(f"{x:.6g}" for x in row) + "\n" for row in rows))
    path = folder / "e.toml"
    path.write_text(f'kind = "outcomes"\n{body}[measurement]\nfile = "t.csv"\n{extra}')
    return path


def falls(scale=1.0, unit=1.0):
    """Rows (height [m], time [s] over unit) of free falls whose true height is scale times the stated, four of each."""
    generator = np.random.default_rng(4)
    return [
        (h, (np.sqrt(2 * h * scale / G) + 0.003 * generator.standard_normal()) / unit)
        for h in (0.25, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0)
        for _ in range(4)
    ]


def test_a_wrong_ruler_and_a_wrong_clock_say_the_same_in_fall_times(tmp_path):
    steel = BALL.replace("0.0027", "0.263")  # that air does not lift
    path = table(tmp_path, "height_m,fall_time_s", falls(scale=1.05), body=steel)
    diagnosis = hlcs.diagnose(path)
    assert diagnosis.verdict == "ambiguous" and len(diagnosis.effects) == 1
    assert {"time_scale", "length_scale"} <= set(diagnosis.ambiguous[0])


def test_a_number_that_contradicts_the_file_does_not_spare_another_effect(tmp_path):
    """Falls of a ball of 81 kg/m3 in stated air from heights 2.7 % larger: with the lift and half of the displaced air
    to be moved times are those of free falls from 5 % more. 2.3 times that air would do as well; of a sphere it is half."""
    path = table(tmp_path, "height_m,fall_time_s", falls(scale=1.05))
    diagnosis = hlcs.diagnose(path)
    assert diagnosis.verdict == "ambiguous" and {"time_scale", "length_scale"} <= set(diagnosis.ambiguous[0])
    assert diagnosis.parameters["added_mass"]["coefficient"]["value"] == pytest.approx(0.5, abs=0.1)


@pytest.mark.parametrize(
    ("rows", "extra", "words"),
    [
        (falls(unit=1e-3), "", ("t.csv, row", "fall_time_s", "units")),
        ([(100 * h, t) for h, t in falls()], "", ("fall_time_s", "units")),
        (falls(), "noise = { slide_time_s = 0.003 }\n", ("noise.slide_time_s", "fall_time_s = 0.003")),
        (falls(), "noise = { position = 0.003 }\n", ("line", "position", "noise = 0.003")),
        (falls(), '[[trial]]\nfile = "t.csv"\n', ("trial", "no place")),
        (falls(), '[diagnose]\ncandidates = ["air_drag"]\n', ("e.toml, line 11", "air_drag", "linear_drag")),
        (falls(), '[model]\neffects = [{ name = "linear_drag", rate = -1 }]\n', ("line 11", "rate = -1", "at least 0")),
    ],
)
def test_tables_that_cannot_be_right_are_refused(tmp_path, rows, extra, words):
    with pytest.raises(InputError) as problem:
        hlcs.diagnose(table(tmp_path, "height_m,fall_time_s", rows, extra))
    for word in words:
        assert word in str(problem.value)


def test_an_effect_of_the_file_acts_in_the_fluid_of_the_file(tmp_path):
    file = read_experiment_file(table(tmp_path, "height_m,fall_time_s", falls()))
    assert build_entry({"name": "buoyancy"}, file.surroundings).fluid_density == 1.2
    assert build_entry({"name": "buoyancy", "fluid_density": 1000.0}, file.surroundings).fluid_density == 1000.0


@pytest.mark.slow
@pytest.mark.xfail(reason="over 0.075 s/m a block stops much earlier: seen so, the two laws are not one, and drag is told")
def test_friction_that_rises_with_speed_and_drag_leave_the_same_on_a_level_floor(tmp_path):
    """Deceleration (0.3 + 0.06 v) g, closed form: both laws are this one. No fluid is stated, so it is air, in which a drag of
    0.06 g m/s per m/s = 0.59 /s is beyond all that is known: friction is named, and the drag is told to leave as little."""
    generator, entries = np.random.default_rng(6), []
    a, rate, times = 0.3 * G, 0.06 * G, np.arange(48) / 60
    for k, speed in enumerate((0.8, 1.05, 1.3, 1.55)):
        until = np.minimum(times, np.log(1 + rate * speed / a) / rate)
        way = (speed + a / rate) * (1 - np.exp(-rate * until)) / rate - a / rate * until
        heading = ((1, 0), (-1, 0), (0, 1), (0, -1))[k]
        seen = way[:, None] * heading + 0.001 * generator.standard_normal((48, 2))
        rows = "".join(f"{t:.6f},{x:.6f},{y:.6f}\n" for t, (x, y) in zip(times, seen, strict=True))
        (tmp_path / f"s{k}.csv").write_text("t_s,x_m,y_m\n" + rows)
        entries.append(f'[[trial]]\nfile = "s{k}.csv"\ngroup = "{k % 2}"\n')
    path = tmp_path / "e.toml"
    path.write_text(
        'kind = "trajectory"\n[body]\nshape = "box"\nsize = [0.1, 0.08, 0.04]\nmass = 0.25\n[surroundings]\n'
        "friction = 0.3\nfloor = { height = 0.0 }\n[measurement]\nnoise = { position = 0.001 }\n" + "".join(entries)
    )
    diagnosis = hlcs.diagnose(path, candidates=["friction", "viscous_friction", "linear_drag", "adhesion"])
    assert diagnosis.verdict == "effect" and diagnosis.effects == ("viscous_friction",)
    slope, (drag,) = (
        diagnosis.parameters["viscous_friction"]["slope"],
        [c for c in diagnosis.candidates if c.effect == "linear_drag"],
    )
    assert slope["low"] <= 0.06 <= slope["high"]
    (found,) = [c for c in diagnosis.candidates if c.effect == "viscous_friction"]
    assert not drag.remains["foreseen"]
    assert drag.remains["chi2_per_freedom"] == pytest.approx(found.remains["chi2_per_freedom"], rel=1e-3)  # the same motion


def test_a_model_that_forgot_its_liquid_misses_three_effects_and_no_clock(tmp_path):
    """Spheres of 2600 kg/m3 sink in water with buoyancy, added mass 1/2 and drag 1/2; the clock is right.

    Drag and a clock that starts late would fit the times as well, with fewer numbers; but the file states the water.
    """
    radius, water = 0.005, 1000.0
    volume = 4 / 3 * np.pi * radius**3
    mass = 2600 * volume
    moved = mass + 0.5 * water * volume
    pull, per_metre = (mass - water * volume) * G / moved, 0.25 * water * np.pi * radius**2 / moved
    noise = np.random.default_rng(5).standard_normal(40)
    rows = [
        (h, np.arccosh(np.exp(per_metre * h)) / np.sqrt(pull * per_metre) + 4e-3 * e)
        for h, e in zip(np.repeat((0.05, 0.1, 0.2, 0.4, 0.8), 8), noise, strict=True)
    ]
    path = table(tmp_path, "height_m,fall_time_s", rows)
    path.write_text(
        path.read_text().replace(
            BALL,
            f'[body]\nshape = "sphere"\nradius = {radius}\nmass = {mass}\n[surroundings]\n'
            f"fluid_density = {water}\nfluid_viscosity = 1e-3\n",
        )
    )
    diagnosis = hlcs.diagnose(path, candidates=["added_mass", "buoyancy", "clock_offset", "quadratic_drag"])
    assert set(diagnosis.effects) == {"buoyancy", "added_mass", "quadratic_drag"} and diagnosis.adequate["after"]
    numbers = diagnosis.parameters
    assert numbers["quadratic_drag"]["drag_coefficient"]["low"] < 0.5 < numbers["quadratic_drag"]["drag_coefficient"]["high"]


@pytest.mark.parametrize("late, seed", [(0.01, 2), (0.015, 1)])  # found as a pair on top of the slow clock, and in its place
def test_a_late_trigger_and_drag_are_told_from_the_slow_clock_that_imitates_both(tmp_path, late, seed):
    """Alone a clock 3 % slow explains fall times best; beside either of the two causes it is worth nothing."""
    generator, light = np.random.default_rng(seed), PER_METRE / 8
    rows = [
        (h, np.arccosh(np.exp(light * h)) / np.sqrt(G * light) + late + 0.003 * generator.standard_normal())
        for h in np.repeat((0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0), 8)
    ]
    path = table(tmp_path, "height_m,fall_time_s", rows, body=BALL.replace("0.0027", "0.0216"))
    alone = hlcs.diagnose(path, candidates=["time_scale"])
    assert alone.error["fitted"]["after"] < 0.3 * alone.error["fitted"]["before"]
    diagnosis = hlcs.diagnose(path, candidates=["quadratic_drag", "clock_offset", "time_scale"])
    assert diagnosis.verdict == "effect" and set(diagnosis.effects) == {"quadratic_drag", "clock_offset"}
    assert diagnosis.parameters["clock_offset"]["offset"]["value"] == pytest.approx(late, abs=0.002)  # 4 standard errors


def test_a_glider_with_a_brake_and_a_sail_has_both(generator):
    """v' = -a v - b v^2 on a level track, in closed form: u = e^(-at), v = a u/(a/v0 + b (1 - u)), x = log(1 + b v0 (1 - u)/a)/b.
    A stream of the air and a slope of the track, which nobody saw, made up for the part that could not stand beside the other."""
    brake, sail, times = 0.25, 0.3, np.arange(0.0, 2.5, 0.02)
    frames = []
    for speed in (0.4, 0.7, 1.0, 1.3, 1.6, 1.9):
        way = np.log1p(sail * speed * -np.expm1(-brake * times) / brake) / sail
        frames.append({"t_s": times, "x_m": way + 0.001 * generator.standard_normal(len(times))})
    glider = hlcs.Experiment.from_frames(
        frames,
        body={"mass": 0.3},
        noise={"position": 0.001},
        measurement={"planar": True},
        trials=[{"group": k} for k in "abcabc"],
    )
    diagnosis = hlcs.diagnose(glider)
    assert diagnosis.verdict == "effect" and set(diagnosis.effects) == {"linear_drag", "quadratic_drag"}
    numbers = diagnosis.parameters["linear_drag"]["rate"], diagnosis.parameters["quadratic_drag"]["drag_per_metre"]
    for number, true in zip(numbers, (brake, sail), strict=True):
        assert abs(number["value"] - true) < 4 / 1.645 * (number["high"] - number["low"]) / 2  # four standard errors
