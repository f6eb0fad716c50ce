"""Winds that a camera sees badly: flights through still or moving air by scipy, the truth known."""

import numpy as np
from scipy.integrate import solve_ivp
from throws import G, csv

import hlcs
from hlcs.records import Reason

MASS, RADIUS, DRAG, SIGMA = 0.012, 0.035, 0.45, 0.002
DENSITY = 1.2
HEAD = (
    f'kind = "trajectory"\n[body]\nshape = "sphere"\nradius = {RADIUS}\nmass = {MASS}\n[surroundings]\ngravity = {G}\n'
    f"fluid_density = {DENSITY}\n[model]\neffects = [\n"
    f'  {{ name = "buoyancy", fluid_density = {DENSITY} }},\n'
    f'  {{ name = "added_mass", coefficient = 0.5, fluid_density = {DENSITY} }},\n'
    f'  {{ name = "quadratic_drag", drag_coefficient = {DRAG} }},\n]\n[measurement]\nnoise = {{ position = {SIGMA} }}\n'
)


def flown(start, velocity, wind, times):
    """Positions (n, 3) of the ball, its added mass and its lift included."""
    displaced, k = DENSITY * 4 / 3 * np.pi * RADIUS**3, 0.5 * DENSITY * np.pi * RADIUS**2 * DRAG

    def rates(_, state):
        through = state[3:] - wind
        force = [0.0, 0.0, -(MASS - displaced) * G] - k * np.linalg.norm(through) * through
        return [*state[3:], *(force / (MASS + displaced / 2))]

    found = solve_ivp(rates, (0, times[-1]), [*start, *velocity], t_eval=times, rtol=1e-10, atol=1e-12)
    return found.y[:3].T


def write(folder, runs, wind, columns):
    """The file of runs [(start, velocity)] in a wind, with the columns that the camera sees."""
    generator, text, times = np.random.default_rng(3), HEAD, np.arange(0, 0.9, 1 / 60)
    for k, run in enumerate(runs):
        path = flown(*run, np.array(wind), times)[:, columns]
        seen = path + SIGMA * generator.standard_normal(path.shape)
        (folder / f"r{k}.csv").write_text(csv(times, seen, np.array(("x_m", "y_m", "z_m"))[columns]))
        text += f'[[trial]]\nfile = "r{k}.csv"\ngroup = "day {k % 2}"\n'
    (folder / "e.toml").write_text(text)
    return folder / "e.toml"


def test_a_wind_across_the_picture_may_blow_either_way(tmp_path):
    """What is seen, x and z, depends on its square alone: the interval holds the truth and its mirror image."""
    throws = [((0.0, 0.0, 1.5), (4.0 * side, 0.0, 2.0 + rise)) for side in (1, -1) for rise in (0.0, 1.0, 2.0)]
    found = hlcs.diagnose(write(tmp_path, throws, (0.8, -1.2, 0.0), [0, 2]))
    flow = found.parameters["uniform_flow"]
    along, across = flow["velocity_x"], flow["velocity_y"]
    assert found.verdict == "effect" and abs(along["value"] - 0.8) < along["high"] - along["low"]  # three standard errors
    assert across["low"] < -1.2 < 1.2 < across["high"] and across["mirrored"] == -across["value"]
    assert "mirrored" not in flow["velocity_x"]


def test_an_updraught_is_found_where_heights_alone_are_measured(tmp_path):
    drops = [((0.0, 0.0, height), (0.0, 0.0, 0.0)) for height in (2.0, 2.5, 3.0, 3.5)]
    found = hlcs.diagnose(write(tmp_path, drops, (0.0, 0.0, 0.8), [2]))
    up = found.parameters["uniform_flow"]["velocity_z"]
    assert "uniform_flow" in {*found.effects, *(name for members in found.ambiguous for name in members)}
    assert found.adequate["after"] and abs(up["value"] - 0.8) < up["high"] - up["low"]
    assert found.parameters["uniform_flow"]["velocity_x"]["value"] is None  # nothing that is seen tells of it


def test_a_wind_has_nothing_to_act_on_before_a_drag_is_there_and_the_report_says_what_to_add_first(tmp_path):
    """Through nothing a wind moves no body, so that data show none, whatever they are: no start and no model takes it up."""
    generator, times, head = np.random.default_rng(5), np.arange(0, 0.6, 1 / 60), HEAD.split("[surroundings]")[0]
    text = head + f"[measurement]\nnoise = {{ position = {SIGMA} }}\n"
    for k in range(3):
        path = np.column_stack([(1.0 + k) * times, 0 * times, 3.0 * times - G * times**2 / 2])
        (tmp_path / f"r{k}.csv").write_text(csv(times, path + SIGMA * generator.standard_normal(path.shape)))
        text += f'[[trial]]\nfile = "r{k}.csv"\ngroup = "{k}"\n'
    (tmp_path / "thrown.toml").write_text(text)
    found = hlcs.diagnose(tmp_path / "thrown.toml", candidates=["uniform_flow"])
    (wind,) = (entry for entry in found.candidates if entry.effect == "uniform_flow")
    assert found.verdict == "complete" and wind.reason is Reason.NO_DRAG
    assert "uniform_flow: nothing for it to act on" in str(found) and "add that first" in " ".join(str(found).split())
