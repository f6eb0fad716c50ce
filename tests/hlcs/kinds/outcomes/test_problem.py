"""Outcome tables as problems: what is held out, what their noise is, what is refused, where the model misses."""

import numpy as np
import pytest

from hlcs.data.experiment_file import read_experiment_file
from hlcs.data.outcome_tables import read_outcomes
from hlcs.kinds.outcomes.problem import TableProblem, judge_table, prepare_table, row_groups, table_candidates, where_in_table
from hlcs.kinds.outcomes.row_noise import table_noise
from hlcs.simulation.model import Model
from minibullet.errors import InputError, InputWarning

BALL = '[body]\nshape = "sphere"\nradius = 0.03\nmass = 0.05\n'
HEIGHTS = np.repeat([0.5, 1.0, 1.5, 2.0, 2.5, 3.0], 3)


def table(folder, columns, extra="", body=BALL):
    """(ExperimentFile, OutcomeTable) of columns name -> values."""
    rows = zip(*columns.values(), strict=True)
    lines = [",".join(columns), *(",".join(str(value) for value in row) for row in rows)]
    (folder / "t.csv").write_text("\n".join(lines) + "\n")
    (folder / "e.toml").write_text(f'kind = "outcomes"\n{body}[measurement]\nfile = "t.csv"\n{extra}')
    file = read_experiment_file(folder / "e.toml")
    return file, read_outcomes(file)


def falls(scale=1.0, scatter=0.002):
    """Times of free falls, in the lightest of airs none at all."""
    wave = scatter * np.tile([-1.0, 0.0, 1.0], 6)  # known scatter: standard deviation `scatter` in each triple
    return {"height_m": HEIGHTS, "fall_time_s": (np.sqrt(2 * scale * HEIGHTS / 9.81) + wave).round(9)}


def test_replicates_say_what_the_noise_is_and_a_stated_one_wins(tmp_path):
    file, read = table(tmp_path, falls())
    prepared = prepare_table(file, read)
    assert prepared.noise.position == pytest.approx(0.002, rel=1e-6) and prepared.noise.source == "replicates"
    file, read = table(tmp_path, falls(), "noise = { fall_time_s = 0.004 }\n")
    assert prepare_table(file, read).noise.position == 0.004
    single = {name: values[::3] for name, values in falls().items()}
    assert prepare_table(*table(tmp_path, single)).problem is None  # nothing was repeated and nothing is stated


def test_without_groups_contiguous_blocks_of_the_main_input_are_held_out(tmp_path):
    blocks = row_groups(*table(tmp_path, falls()))
    assert [len(block.rows) for block in blocks] == [3] * 6 and blocks[0].name == "block 1"
    assert all(len(set(HEIGHTS[block.rows])) == 1 for block in blocks)  # replicates stay together
    named = row_groups(*table(tmp_path, {**falls(), "group": ["a", "b"] * 9}))
    assert [group.name for group in named] == ["a", "b"] and list(named[0].rows) == list(range(0, 18, 2))


def test_a_model_that_agrees_is_adequate_and_the_worst_height_comes_first(tmp_path):
    prepared = prepare_table(*table(tmp_path, falls()))
    judged, observations = judge_table(prepared.problem, prepared.base)
    assert judged.adequate and observations["row"][0] == 2  # of the file, its header is row 1
    np.testing.assert_allclose(observations["measured"] - observations["model"], observations["residual"])
    prepared = prepare_table(*table(tmp_path, falls(scale=1.05)))
    judged, observations = judge_table(prepared.problem, prepared.base)
    where = where_in_table(prepared.problem, observations)
    assert not judged.adequate and where[0]["trial"] == "height_m = 3" and where[0]["sigma"] > where[-1]["sigma"]
    assert where[0]["mean"] == pytest.approx(np.sqrt(6 / 9.81) * (np.sqrt(1.05) - 1), rel=1e-3)


def test_a_model_is_asked_once_for_rows_with_equal_inputs(tmp_path):
    file, read = table(tmp_path, falls())
    problem = TableProblem(file, read, table_noise(file, read))
    assert len(problem.setups) == 6 and problem.predict(Model()).shape == (18,)
    assert problem.predict(Model()) is problem.predict(Model())


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ({"heigth_m": [1.0, 2.0, 3.0], "fall_time_s": [0.45, 0.64, 0.78]}, "heigth_m"),
        ({"speed_m_s": [1.0, 2.0, 3.0], "fall_time_s": [0.45, 0.64, 0.78]}, "needs the column 'height_m'"),
        ({"friction": [0.1, 0.2, 0.3], "slide_time_s": [0.45, 0.64, 0.78]}, "'distance_m' .* or 'speed_m_s'"),
    ],
)
def test_a_table_without_the_inputs_of_its_outcome_is_refused(tmp_path, columns, words):
    with pytest.raises(InputError, match=words):
        prepare_table(*table(tmp_path, columns))


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        (
            {"height_m": [1.0] * 3, "start_speed_m_s": [1.0] * 3, "fall_time_s": [0.4] * 3},
            "start_speed_m_s: fall_time_s does not",
        ),
        ({"height_m": [1.0] * 3, "bounce": [1.0] * 3, "fall_time_s": [0.4] * 3}, "column bounce: fall_time_s does not depend"),
        ({"height_m": [3.0] * 3, "mark_2_m": [0.5] * 3, "passage_time_s": [0.3] * 3}, "start_speed_m_s, mark_1_m, mark_2_m"),
        ({"height_m": [3.0] * 3, "rest_height_m": [0.03] * 3}, "it depends on the body alone"),
        ({"speed_m_s": [1.0] * 3, "slope": [0.1] * 3, "angle_deg": [5.0] * 3, "stop_distance_m": [1.0] * 3}, "one of them out"),
    ],
)
def test_a_column_that_the_outcome_does_not_depend_on_is_refused(tmp_path, columns, words):
    with pytest.raises(InputError, match=words):
        prepare_table(*table(tmp_path, columns))


def test_no_way_takes_no_time(tmp_path):
    with pytest.raises(InputError, match="t.csv, row 3, column fall_time_s: 0 s over a way of 1 m; leave out"):
        prepare_table(*table(tmp_path, {"height_m": [0.5, 1.0, 1.0], "fall_time_s": [0.319, 0.0, 0.452]}))
    with pytest.raises(InputError, match="t.csv, row 2, column fall_time_s: 0 s over a way of 5 m"):
        prepare_table(*table(tmp_path, {"height_m": [5.0, 1.0, 2.0, 3.0], "fall_time_s": [0.0, 0.0, 0.64, 0.78]}))


def test_a_noise_above_every_outcome_is_told(tmp_path):
    with pytest.warns(InputWarning, match="line 8: measurement.noise: 3 s is more than every fall_time_s, at most 0.784"):
        prepare_table(*table(tmp_path, falls(), "noise = 3\n"))


def test_heights_in_centimetres_and_a_friction_beyond_rubber_are_told(tmp_path):
    """Falls from 150 m, of 5.5 s: nothing in them contradicts itself, and no laboratory is as high."""
    columns = {"height_m": [1.0, 150.0, 150.0], "friction": [0.6, 0.6, 3.1], "fall_time_s": [0.45, 5.5, 5.5]}
    with pytest.warns(InputWarning) as told:
        prepare_table(*table(tmp_path, columns))
    said = [str(each.message).split(" is hardly meant")[0].split("t.csv, ")[-1] for each in told]
    assert said == ["row 3, column height_m: 150 m", "row 4, column friction: 3.1"]


def test_columns_that_say_of_what_body_and_where_stay_allowed(tmp_path):
    beside = {"mass_kg": [0.05] * 18, "radius_m": [0.03] * 18, "friction": [0.4] * 18, "gravity_m_s2": [9.81] * 18}
    beside |= {"height_m_sd": [0.001] * 18, "group": ["a", "b"] * 9}
    assert prepare_table(*table(tmp_path, {**beside, **falls()})).problem is not None
    box = '[body]\nshape = "box"\nsize = [0.06, 0.06, 0.06]\nmass = 0.05\n'
    with pytest.raises(InputError, match='radius_m: a body of shape "box" has none'):
        prepare_table(*table(tmp_path, {"radius_m": [0.03] * 18, **falls()}, body=box))


def test_candidates_that_do_not_act_on_an_outcome_are_left_out_with_the_reason(tmp_path):
    chosen, absent = table_candidates(*table(tmp_path, falls()), None, ())
    assert {"quadratic_drag", "clock_offset"} <= {candidate.name for candidate in chosen}
    assert absent["friction"] == "not known to change fall_time_s"
    _, absent = table_candidates(*table(tmp_path, falls(), body='[body]\nshape = "sphere"\nradius = 0.03\n'), ["buoyancy"], ())
    assert absent == {"buoyancy": "the mass or the size of the body is not stated"}


@pytest.mark.parametrize("body", [BALL, '[body]\nshape = "sphere"\n'])
def test_in_a_stated_vacuum_nothing_of_a_fluid_acts(tmp_path, body):
    """No drag per metre of a body that nobody describes either. Rows that state a fluid of their own are in no vacuum."""
    drags = ["linear_drag", "stokes_drag", "quadratic_drag", "drag_crisis", "buoyancy", "added_mass"]
    vacuum = f"{body}[surroundings]\nfluid_density = 0.0\n"
    chosen, absent = table_candidates(*table(tmp_path, falls(), body=vacuum), [*drags, "clock_offset"], ())
    assert [candidate.name for candidate in chosen] == ["clock_offset"]
    assert absent == dict.fromkeys(drags, "the file states a vacuum (fluid_density = 0.0)")
    columns = {**falls(), "fluid_density_kg_m3": np.tile([0.0, 1.2, 0.0], 6)}
    assert table_candidates(*table(tmp_path, columns, body=vacuum), ["quadratic_drag"], ())[0]


def test_the_setting_that_is_missed_most_is_where_to_look_again(tmp_path):
    """The rows at 2 m are 6 ms late, 3 standard deviations of one and 3 sqrt(3) of the mean of three."""
    late = falls()
    late["fall_time_s"] = late["fall_time_s"] + 0.006 * (late["height_m"] == 2.0)
    prepared = prepare_table(*table(tmp_path, late))
    text, design = prepared.problem.worst(prepared.base)
    assert design == {"height_m": 2.0} and "by 5.2 standard errors" in text


def test_further_rows_are_within_reach_of_what_was_measured(tmp_path):
    prepared = prepare_table(*table(tmp_path, falls()))
    new = prepared.problem.designs(prepared.base, prepared.base)
    heights = [design.what["height_m"] for design in new.options if set(design.what) == {"height_m"}]
    assert min(heights) == 0.12 and max(heights) == 6.0  # a quarter and twice, in two digits; 12 m is higher than a stairwell
    assert any(design.what.get("mass_kg") == 0.1 for design in new.options)
    assert not any(design.what.get("mass_kg") == 0.05 for design in new.options)  # that of the ball that is used, in no column


SLIDES = '[body]\nshape = "box"\nsize = [0.1, 0.1, 0.05]\nmass = 0.4\n[surroundings]\nfriction = 0.3\n'


@pytest.mark.parametrize(("fastest", "tilted"), [(4.0, True), (8.0, False)])
def test_a_floor_is_tilted_only_where_it_may_be_a_board(tmp_path, fastest, tilted):
    """Stops after v^2 / (2 mu g) = 2.7 m and 10.9 m: a way of 3 m fits on a board, a longer one is a hallway."""
    speeds = np.repeat(np.linspace(1.0, fastest, 5), 3)
    spread = 0.002 * np.tile([-1.0, 0.0, 1.0], 5)
    rows = {"speed_m_s": speeds, "stop_distance_m": speeds**2 / (2 * 0.3 * 9.81) + spread}
    prepared = prepare_table(*table(tmp_path, rows, body=SLIDES))
    new = prepared.problem.designs(prepared.base, prepared.base)
    assert any("angle_deg" in design.what for design in new.options) == tilted
    assert max(design.what.get("speed_m_s", 0.0) for design in new.options) <= 20.0
    assert not tilted or any("angle_deg = -5 (upwards)" in design.text for design in new.options)
    assert prepared.problem.camera.touching and not prepared.problem.camera.filmed
    assert prepared.problem.camera.extent == pytest.approx(np.max(rows["stop_distance_m"]))
