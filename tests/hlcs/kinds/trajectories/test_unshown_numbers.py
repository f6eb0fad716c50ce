"""Numbers that a film does not show, though their effect is found: across its picture, by a fine integrator."""

from types import SimpleNamespace

import numpy as np
from scipy.integrate import solve_ivp
from throws import G, csv, drag_per_metre

import hlcs
from hlcs.effects import Free
from hlcs.selection import found_numbers

DRAG = drag_per_metre(0.47)
SIGMA = 0.001  # m


def film(folder, wind=(0.0, 0.0, 0.0), tilt=0.0):
    """Eight throws along x of a tennis ball, seen from the side: x and z are measured; the path of the experiment."""
    generator, times, text, gravity = (
        np.random.default_rng(1),
        np.arange(40) / 40,
        "",
        G * np.array([-np.sin(tilt), 0, -np.cos(tilt)]),
    )

    def slope(_, state):
        relative = state[3:] - wind
        return np.concatenate([state[3:], gravity - DRAG * np.linalg.norm(relative) * relative])

    for k in range(8):
        speed = (-1) ** k * (2.0 + k)
        start = [0.0, 0.0, 1.5, 0.8 * speed, 0.0, 0.6 * abs(speed)]
        seen = solve_ivp(slope, (0, times[-1]), start, t_eval=times, rtol=1e-9, atol=1e-11).y[[0, 2]].T
        seen = seen + SIGMA * generator.standard_normal((40, 2))
        (folder / f"{k}.csv").write_text(csv(times, seen, ("x_m", "z_m")))
        text += f'[[trial]]\nfile = "{k}.csv"\ngroup = "{k // 2 % 2}"\n'
    head = 'kind = "trajectory"\n[body]\nshape = "sphere"\nradius = 0.0335\nmass = 0.0577\n[surroundings]\nfluid_density = 1.2\n'
    head += '[model]\neffects = [{ name = "quadratic_drag", drag_coefficient = 0.47 }]\n'
    (folder / "e.toml").write_text(f"{head}[measurement]\nnoise = {{ position = {SIGMA} }}\n{text}")
    return folder / "e.toml"


def test_the_wind_across_a_film_is_withheld_and_left_out_of_the_model(tmp_path):
    found = hlcs.diagnose(film(tmp_path, wind=(3.0, 0.0, 0.0)), candidates=["uniform_flow"])
    told = found.to_json()
    across, along = (told["parameters"]["uniform_flow"][f"velocity_{axis}"] for axis in "yx")
    assert along["low"] < 3.0 < along["high"]
    assert across["value"] is across["low"] is across["high"] is None and "do not show it" in across["why"]
    assert told["sets"][0]["parameters"]["uniform_flow"]["velocity_y"] is None
    assert "velocity_y" not in told["add"]["toml"] and told["add"]["left_out"] == {"uniform_flow.velocity_y": across["why"]}
    assert f"# uniform_flow.velocity_y is left out: {across['why']}" in " ".join(str(found).split())
    assert hlcs.compare(found.apply(found.experiment)).adequate


def test_a_wind_across_a_film_that_shows_by_the_drag_is_told(tmp_path):
    """2.5 m/s across double the drag of the slow throws: the data show it, but for its sign."""
    found = hlcs.diagnose(film(tmp_path, wind=(2.0, 2.5, 0.0)), candidates=["uniform_flow"])
    across = found.parameters["uniform_flow"]["velocity_y"]
    assert across["low"] < -2.5 < 2.5 < across["high"] and across["mirrored"] == -across["value"]


def test_a_turn_about_the_line_of_sight_is_told_and_one_about_the_throw_is_not(tmp_path):
    """Gravity that is turned about y pulls along x, which was measured; turned about x it pulls along y, which was not."""
    found = hlcs.diagnose(film(tmp_path, tilt=0.03), candidates=["tilted_gravity"])
    numbers = found.parameters["tilted_gravity"]
    assert numbers["angle_y"]["low"] < 0.03 < numbers["angle_y"]["high"] and numbers["angle_x"]["value"] is None


def test_an_effect_keeps_a_number_though_the_data_show_none_of_them():
    """Without any it would be no effect, and its line in a model is refused: of two that are not shown both are told."""
    numbers = [Free("a", "1", -1.0, 1.0, 0.0, 0.0), Free("b", "1", -1.0, 1.0, 0.0, 0.0)]
    entry = SimpleNamespace(name="law", free=tuple(numbers), setting=False)
    known = [("law", free, 0.1) for free in numbers]
    for shown, left_out in ((0.5, [False, False]), (2.0, [False, True])):  # of a; of b as much as 0.5 prior measurements tell
        fit = SimpleNamespace(numbers=known, withheld={}, estimate=np.full(2, 0.1), information=np.diag([shown, 0.5]))
        assert [bool(found_numbers._withheld(fit, entry, free)) for free in numbers] == left_out
