"""Errors that the rows of one setting share: propagated, told from effects, and refused where they cannot be right."""

import numpy as np
import pytest

import hlcs
from hlcs.data.experiment_file import read_experiment_file
from hlcs.data.frames import csv_of
from hlcs.data.outcome_tables import read_outcomes, read_table
from hlcs.kinds.outcomes.problem import prepare_table
from hlcs.kinds.outcomes.setting_errors import Scatter, between_settings, of_inputs
from hlcs.simulation.model import Model
from minibullet.errors import InputError

HEIGHTS = np.linspace(0.3, 2.0, 8)
RESTITUTION = 0.75


def write(folder, columns, measurement="", surroundings=""):
    """The experiment file of a ball of 50 g and 3 cm; columns: name -> values."""
    rows = zip(*columns.values(), strict=True)
    (folder / "t.csv").write_text("\n".join([",".join(columns), *(",".join(f"{v:.6g}" for v in row) for row in rows)]) + "\n")
    file = folder / "e.toml"
    file.write_text(
        'kind = "outcomes"\n[body]\nshape = "sphere"\nradius = 0.03\nmass = 0.05\n'
        f'[surroundings]\nfluid_density = 1.2\n{surroundings}[measurement]\nfile = "t.csv"\n{measurement}'
    )
    return file


def rebounds(seed, error=0.01, repeats=5, scatter=0.002):
    """Rebounds e^2 h without air, each height set once with an error [m] that all its repeats share."""
    draw = np.random.default_rng(seed)
    heights = np.repeat(HEIGHTS, repeats)
    true = heights + np.repeat(error * draw.standard_normal(len(HEIGHTS)), repeats)
    return {"height_m": heights, "rebound_height_m": RESTITUTION**2 * true + scatter * draw.standard_normal(len(heights))}


@pytest.mark.parametrize("measurement", ["input_sd = { height_m = 0.01 }\n", ""], ids=["stated", "seen"])
@pytest.mark.parametrize("seed", [1, 3])
def test_a_height_error_that_repeats_share_is_no_effect(tmp_path, measurement, seed):
    """The model has the right restitution: nothing is missing, whether the error is stated or shows between the settings."""
    found = hlcs.diagnose(write(tmp_path, rebounds(seed), measurement, f"restitution = {RESTITUTION}\n"))
    assert found.verdict == "complete", (found.effects, found.notes)
    assert measurement or any("settings scatter by" in note for note in found.notes)
    for result in (found, hlcs.compare(tmp_path / "e.toml")):  # what nobody stated is told with its condition
        assert ("settings can be" in " ".join(str(result).split())) == (not measurement)


def test_the_scatter_that_is_told_is_that_beside_what_was_found(tmp_path):
    """Heights set to 1 cm are 0.56 cm in the rebound."""
    found = hlcs.diagnose(write(tmp_path, rebounds(1), surroundings="restitution = 0.7\n"))
    (note,) = [note for note in found.notes if "settings scatter by" in note]
    assert f"settings scatter by {found.noise['between_settings']:.2g} m" in note and "restitution" in found.effects
    assert found.noise["between_settings"] == pytest.approx(0.01 * RESTITUTION**2, rel=0.6)  # of eight, less four of a cubic


def test_beside_a_shared_height_error_restitution_is_found_and_no_drag(tmp_path):
    """The model says that nothing rebounds, so the error of a height reaches the outcome only beside the law that is found."""
    found = hlcs.diagnose(write(tmp_path, rebounds(1), "input_sd = { height_m = 0.01 }\n"))
    assert found.verdict == "effect" and found.effects == ("restitution",)
    number = found.parameters["restitution"]["coefficient"]
    # each height tells e to 0.01 m / (2 h), eight of them, 0.3 to 2 m, to 0.003 at best: the interval is no narrower than that
    assert number["low"] < RESTITUTION < number["high"] and number["high"] - number["low"] > 0.002


def test_the_error_of_a_height_reaches_a_fall_by_its_derivative(tmp_path):
    """dt/dh = 1 / sqrt(2 g h); over plus and minus 1 % of h the fall bends by less than 1e-4 of that."""
    columns = {"height_m": HEIGHTS, "fall_time_s": np.sqrt(2 * HEIGHTS / 9.81)}
    file = read_experiment_file(write(tmp_path, columns | {"height_m_sd": 0.01 * HEIGHTS}))
    found = of_inputs(file, read_outcomes(file), Model())
    np.testing.assert_allclose(found, 0.01 * HEIGHTS / np.sqrt(2 * 9.81 * HEIGHTS), rtol=2e-4)


def test_settings_whose_error_is_shared_are_held_out_whole(tmp_path):
    groups = {"group": np.tile([1, 2, 1, 2, 1], len(HEIGHTS))}
    file = read_experiment_file(write(tmp_path, rebounds(1) | groups, "input_sd = { height_m = 0.01 }\n", "restitution = 0.75\n"))
    prepared = prepare_table(file, read_outcomes(file))
    table = prepared.problem.table
    assert all(len(set(table.setting[trial.rows])) * 5 == len(trial.rows) for trial in prepared.problem.trials)
    assert any("blocks of settings are held out" in note for note in prepared.notes)


def scatter_found(x, means, draw, slope=1000.0):
    """What `between_settings` finds in four repeats of these means (d,) of unit noise, off a line of this slope."""
    rows = np.repeat(slope * x + means, 4) + draw.standard_normal(4 * len(x))
    table = read_table(csv_of({"height_m": np.repeat(x, 4), "rebound_height_m": 100 + rows}, "frame"))
    return between_settings(table, 1.0, np.zeros(len(x)), slope * x)


@pytest.mark.parametrize(("settings", "degree"), [(6, 2), (8, 3), (20, 3)])
def test_scatter_between_settings_is_found_and_a_bend_is_not_taken_for_it(settings, degree):
    """Scatter of 5 sigma is seen in most draws, and right by chi2 on average; a bend of 72 sigma is not taken for it."""
    draw, x = np.random.default_rng(5), np.linspace(0.3, 2.0, settings)
    bend = 50.0 * (x - 0.8) ** 2
    found = [scatter_found(x, bend + 5.0 * draw.standard_normal(settings), draw) for _ in range(40)]
    seen = [each.size for each in found if each.freedom == settings - degree - 1]
    # one in twenty looks ordered; with three degrees of freedom one in ten is small, and one in ten most in one setting: 30 +- 3
    assert len(seen) >= 24
    assert np.mean(np.square(seen)) == pytest.approx(25.0, rel=0.5)  # sqrt(2 / 3 / 30) = 0.15, three of them
    assert sum(scatter_found(x, bend, draw).size > 0 for _ in range(40)) <= 2


def test_what_would_take_settings_for_each_other_is_no_error_of_them():
    """Scatter of 5 where settings are 0.24 apart: at a slope of 100 that is a fifth of the way to the next, at 50 two."""
    x = np.linspace(0.3, 2.0, 8)
    means = 5.0 * np.random.default_rng(8).standard_normal(8)
    small, large, other = (scatter_found(x, means, np.random.default_rng(9), slope) for slope in (100.0, 50.0, 0.0))
    assert 3.0 < small.size < 0.25 * 100 * 0.243 and not large.size and large.too_large == pytest.approx(small.size)
    assert other.size == pytest.approx(small.size)  # where the input does nothing it is something else that differs


def test_a_misfit_that_hangs_together_is_not_taken_for_scatter():
    """A step half way is followed by no polynomial of third degree, yet neighbours are alike: it may be an effect."""
    x, draw = np.linspace(0.3, 2.0, 20), np.random.default_rng(5)
    assert scatter_found(x, np.where(x > 1.2, 20.0, 0.0), draw) == Scatter()


@pytest.mark.parametrize("settings", [6, 8, 12])
def test_one_wrong_setting_is_told_from_scatter_that_all_share(settings):
    """Sixty tables each way: 20 sigma of a mean at one setting, or 5 at all, on a bend that a curve takes up.

    With six settings three numbers are left of six: one in ten of true scatters stands mostly in one setting, and one in five by
    chance is small or ordered. A wrong setting at an end of the range half hides in the curve.
    """
    draw, x = np.random.default_rng(7), np.linspace(0.3, 2.0, settings)
    bend, wrong = 50.0 * (x - 0.8) ** 2, draw.integers(settings, size=60)
    planted = [scatter_found(x, bend + 10.0 * np.eye(settings)[k], draw) for k in wrong]  # four repeats: a mean knows 0.5
    shared = [scatter_found(x, bend + 2.5 * draw.standard_normal(settings), draw) for _ in range(60)]
    assert sum(found.alone == k for found, k in zip(planted, wrong, strict=True)) >= 50
    assert sum(found.size > 0 for found in planted) <= 6 and sum(found.size > 0 for found in shared) >= 36
    assert sum(found.alone is not None for found in shared) <= 12


@pytest.mark.parametrize("stated", [True, False])
def test_the_label_of_the_noise_says_what_of_it_inputs_are(tmp_path, stated):
    """Heights off by 1 cm are 0.56 cm in the rebound, of which rows that repeat each other show nothing."""
    measurement = "input_sd = { height_m = 0.01 }\n" if stated else ""
    seen = hlcs.compare(write(tmp_path, rebounds(1, error=0.0), measurement, f"restitution = {RESTITUTION}\n"))
    part = seen.noise.get("inputs", 0.0)
    assert part == pytest.approx(0.01 * RESTITUTION**2 * stated, rel=0.05)  # less what the air takes
    more = f", and what inputs are stated to be off by ({1e3 * part:.3g} mm of it)" if stated else ""
    assert f"Noise: replicates{more}. Bias" in " ".join(str(seen).split())


@pytest.mark.parametrize("wrong", [1, 3])
def test_one_wrong_mark_leaves_a_table_unexplained_and_is_named(tmp_path, wrong):
    """Six heights, one of them set 5 cm off, in all its repeats: no law does that, and the other five are right."""
    columns, heights = rebounds(1, error=0.0), np.repeat(HEIGHTS[:6], 5)
    columns = {name: values[: len(heights)] for name, values in columns.items()}
    columns["rebound_height_m"] = columns["rebound_height_m"] + np.where(heights == HEIGHTS[wrong], RESTITUTION**2 * 0.05, 0.0)
    file = write(tmp_path, columns, "", f"restitution = {RESTITUTION}\n")
    found = hlcs.diagnose(file, candidates=["restitution", "length_scale"])
    assert found.verdict == "unexplained"
    assert any(f"the rows at height_m = {HEIGHTS[wrong]:g} lie off" in note for note in found.notes), found.notes


def test_drag_stays_found_beside_shared_errors(tmp_path):
    """A fall in air a hundred times as dense: late by 3 % and more, where the clock scatters by 1 ms."""
    heights = np.repeat(HEIGHTS, 5)
    k = 0.5 * 120.0 * 0.47 * np.pi * 0.03**2 / 0.05  # 1/m
    times = np.arccosh(np.exp(k * heights)) / np.sqrt(9.81 * k)  # closed form of v' = g - k v^2 from rest
    times += np.repeat(0.001 * np.random.default_rng(2).standard_normal(8), 5)
    times += 0.001 * np.random.default_rng(3).standard_normal(40)
    file = write(tmp_path, {"height_m": heights, "fall_time_s": times}, "input_sd = { height_m = 0.003 }\n")
    file.write_text(file.read_text().replace("fluid_density = 1.2", "fluid_density = 120"))
    found = hlcs.diagnose(file, candidates=["linear_drag", "quadratic_drag"])
    assert "quadratic_drag" in found.effects
    number = found.parameters["quadratic_drag"]["drag_coefficient"]
    assert number["low"] < 0.47 < number["high"]


@pytest.mark.parametrize(
    ("columns", "measurement", "message"),
    [
        ({"height_m_sd": -0.01}, "", "t.csv, row 2, column height_m_sd: -0.01; a standard deviation is zero or more"),
        ({"slope_sd": 0.01}, "", "t.csv, row 1: column 'slope_sd' without the column 'slope' that it belongs to"),
        ({}, "input_sd = { slope = 0.01 }\n", "measurement.input_sd.slope: the table has no column 'slope'; it has height_m"),
        ({"height_m_sd": 0.01}, "input_sd = { height_m = 0.01 }\n", "has a column 'height_m_sd' too; keep one of them"),
        ({}, "input_sd = { heigth_m = 0.01 }\n", "line 10: measurement.input_sd.heigth_m: unknown key; the nearest known "),
        ({}, "input_sd = { height_m = 0.0 }\n", "line 10: measurement.input_sd.height_m: must be greater than 0, got 0"),
        ({}, "input_sd = { height_m = 10 }\n", "line 10: measurement.input_sd.height_m: 10 cannot be right where height_m is at"),
        ({"height_m_sd": 10}, "", "t.csv, row 2, column height_m_sd: 10 cannot be right where height_m is at most"),
        ({}, "input_sd = 0.01\n", "input_sd: must be a table such as input_sd = { height_m = 0.01 }, got 0.01"),
    ],
)
def test_an_error_that_cannot_be_is_refused_by_its_place(tmp_path, columns, measurement, message):
    heights = np.repeat(HEIGHTS, 2)
    values = {"height_m": heights, "rebound_height_m": heights / 2} | {name: heights * 0 + v for name, v in columns.items()}
    with pytest.raises(InputError) as problem:
        read_outcomes(read_experiment_file(write(tmp_path, values, measurement)))
    assert message in str(problem.value)


def test_rows_of_one_setting_state_one_error(tmp_path):
    heights = np.repeat(HEIGHTS, 2)
    values = {"height_m": heights, "height_m_sd": np.tile([0.01, 0.02], 8), "rebound_height_m": heights / 2}
    with pytest.raises(InputError, match=r"row 3, column height_m_sd: 0.02 where a row of equal inputs has 0.01; they share one"):
        read_outcomes(read_experiment_file(write(tmp_path, values)))
