"""Layer data: the file, the comparison with the paper's tables, and the search, on a stand-in for the simulations.

The stand-in answers a PlacementTest in microseconds with layer coefficients like the laboratory's, moved by shape, margin,
friction and scatter of the aims as simulations move them (hull +10 %, two margins a layer), with scatter between seeds of 1.2 %.
"""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import hlcs
from hlcs.compare import comparison_of
from hlcs.data.experiment_file import read_experiment_file
from hlcs.diagnose import diagnosis_of
from hlcs.kinds.layers import Layers, experiment_design
from hlcs.kinds.layers.data import read_layer_sets, read_layers
from hlcs.kinds.layers.model import LayerModel, Simulator
from hlcs.kinds.protocol import Options
from hlcs.paper import ladder
from hlcs.paper.reproduce import Plan
from hlcs.placement import single_run
from hlcs.placement.printed_tables import laboratory, paper_numerical
from hlcs.placement.single_run import simulate
from minibullet.errors import InputError

PAPER = [("table2", "RPG"), ("table2", "TPG"), ("table3", "TPG")]
HEADER = "grid,spacing_x,spacing_y,bottom_slope,layer,mean,cv,tests,campaign"


def emulate(test):
    """Layer coefficients of a test without its physics."""
    layers = test.layers
    k = np.array([1.298, 1.08, 0.98, 0.97, 0.975] if test.grid.triangular else [1.298, 1.05, 0.96, 0.95, 0.94])[:layers]
    upper = np.arange(layers) > 0
    k = k * np.where(upper & (test.shape == "hull"), 1.10, 1.0) + 2.0 * test.margin
    k = k + upper * (0.1 * (test.friction - 0.36) - 0.3 * test.placement_scatter)
    case = [test.seed, int(test.grid.triangular), int(1e4 * test.bottom.height(0.0, 1.0))]
    shared = np.random.default_rng(case).standard_normal(layers)  # common random numbers: the same with and without an effect
    own = np.random.default_rng([*case, int(1e5 * test.margin), int(test.shape == "hull"), int(1e4 * test.friction)])
    return {"k": [float(v) for v in k + upper * (0.012 * shared + 0.006 * own.standard_normal(layers))], "lost": 0}


def experiment(folder, tables, placement="", diagnose=""):
    """An experiment file of tables (data frames with the columns of a layers file)."""
    pd.concat(tables).to_csv(folder / "layers.csv", index=False)
    parts = ['kind = "layers"', "[placement]", placement, "[measurement]", 'file = "layers.csv"', "[diagnose]", diagnose, ""]
    (folder / "layers.toml").write_text("\n".join(parts))
    return read_experiment_file(folder / "layers.toml")


def measured(grid, seed, campaign, tests=5, shift=0.0, **settings):
    """Repeated tests of the stand-in as a laboratory would report them, `shift` [Dn] added to the first layer."""
    runs = [emulate(hlcs.PlacementTest(grid=grid, seed=1000 * seed + number, **settings))["k"] for number in range(tests)]
    runs = np.array(runs)
    runs[:, 0] += shift
    mean = runs.mean(axis=0)
    test = hlcs.PlacementTest(grid=grid)
    return pd.DataFrame(
        {
            "grid": grid,
            "spacing_x": test.grid.spacing_x,
            "spacing_y": test.grid.spacing_y,
            "bottom_slope": 0.0,
            "layer": np.arange(1, 6),
            "mean": mean.round(3),
            "cv": (runs.std(axis=0, ddof=1) / mean).round(3),
            "tests": tests,
            "campaign": campaign,
        }
    )


def compare_layers(file, **settings):
    return comparison_of(Layers(file, Options(), **settings))


def diagnose_layers(file, candidates=None, **settings):
    return diagnosis_of(Layers(file, Options(), **settings), candidates)


@pytest.fixture
def simulator(tmp_path):
    return Simulator(tmp_path / "store" / "runs.sqlite", workers=1, function=emulate)


def test_papers_tables_are_read_as_three_sets(tmp_path):
    file = experiment(tmp_path, [laboratory(*names).to_dataframe() for names in PAPER], 'shape = "hull"')
    data = read_layers(file)
    assert [one.name for one in data.sets] == ["RPG flat", "TPG flat", "TPG 4 % slope"]
    assert [one.layers for one in data.sets] == [5, 5, 5] and data.hold_out == "campaign"
    assert data.test.shape == "hull" and data.sets[2].placed(data.test).bottom.grade == 0.04


@pytest.mark.parametrize(
    ("row", "what"),
    [
        ("TPG,1.58,1.27,0,1,1.3,0.01,5,a\nTPG,1.58,1.27,0,1,1.3,0.01,5,a", "row 3, column layer"),
        ("TPG,1.58,1.27,0,1,1.3,0.01,5,a\nTPG,1.58,1.27,0,3,1.0,0.01,5,a", "has no layer 2"),
        ("TPG,1.58,1.27,0,1,x,0.01,5,a", "row 2, column mean: 'x'"),
        ("TPG,1.58,1.27,0,1,131.9,0.01,5,a", "row 2, column mean"),
        ("TPG,1.58,1.27,0,1,1.3,1.4,5,a", "row 2, column cv: '1.4'"),
        ("TPG,1.58,1.27,0,1,nan,0.01,5,a", "row 2, column mean"),
        ("TPG,1.58,1.27,0,1,1.3,0.01,4.5,a", "row 2, column tests"),
        ("TPG,1.58,1.27,4,1,1.3,0.01,5,a", "row 2, column bottom_slope"),
        ("new,,1.27,0,1,1.3,0.01,5,a", "row 2, column spacing_x"),
        (",1.58,1.27,0,1,1.3,0.01,5,a", "row 2, column grid"),
        ("TPG,1.58,1.27,0,1,1.3,0.01,5,a,extra", "row 2"),
        ("", "has no rows"),
    ],
)
def test_bad_tables_are_refused_by_file_row_and_column(tmp_path, row, what):
    path = tmp_path / "bad.csv"
    path.write_text(f"{HEADER}\n{row}\n")
    with pytest.raises(hlcs.InputError, match=what) as complaint:
        read_layer_sets(path)
    assert "bad.csv" in str(complaint.value) and "\n" not in str(complaint.value)


def test_unknown_columns_keys_and_effects_are_refused_by_name(tmp_path, simulator):
    (tmp_path / "a.csv").write_text("grid,layer,mean,cv,tests,colour\nTPG,1,1.3,0.01,5,red\n")
    with pytest.raises(hlcs.InputError, match="colour"):
        read_layer_sets(tmp_path / "a.csv")
    with pytest.raises(hlcs.InputError, match="shap"):
        read_layers(experiment(tmp_path, [measured("TPG", 1, "a")], 'shap = "hull"'))
    with pytest.raises(hlcs.InputError, match="margin_offset"):
        diagnose_layers(experiment(tmp_path, [measured("TPG", 1, "a")]), candidates=["margin_offse"], simulator=simulator)


def test_without_numbers_of_tests_there_is_no_verdict(tmp_path, simulator):
    frame = measured("TPG", 1, "a")
    frame["tests"] = ""
    found = diagnose_layers(experiment(tmp_path, [frame]), simulator=simulator)
    assert found.verdict == "cannot_judge" and "tests" in found.next_experiment.text and simulator.ran == 0
    assert "cannot_judge" in str(found) and found.to_json()["adequate"]["after"] is None


def test_scatter_of_zero_in_every_layer_is_no_scatter_that_was_seen(tmp_path, simulator):
    frame = measured("TPG", 1, "a")
    frame["cv"] = 0.0
    found = diagnose_layers(experiment(tmp_path, [frame]), simulator=simulator)
    assert found.verdict == "cannot_judge" and simulator.ran == 0
    frame.loc[1:, "cv"] = 0.02  # as printed where the first layer is geometry: 0.000
    assert np.isfinite([row["z"] for row in compare_layers(experiment(tmp_path, [frame]), simulator=simulator).where]).all()


def test_quick_settings_scale_with_the_unit(tmp_path):
    large, small = (
        read_layers(experiment(tmp_path, [measured("TPG", 1, "a")], f"nominal_diameter = {size}")).test for size in (1.0, 0.038)
    )
    assert large.time_step == pytest.approx(1 / 120) and small.time_step == pytest.approx(np.sqrt(0.038) / 120)
    stated = read_layers(experiment(tmp_path, [measured("TPG", 1, "a")], "nominal_diameter = 0.038\ntime_step = 0.001")).test
    assert stated.time_step == 0.001 and stated.settle_time == small.settle_time


def paper_model(test):
    """The paper's own numerical columns: five values with the printed mean and scatter, one a seed."""
    pattern = np.array([-1.0, 1.0, 0.0, -1.0, 1.0])  # mean 0, standard deviation 1 about it
    table = paper_numerical("table3" if test.bottom.height(0.0, 1.0) else "table2", test.grid.name)
    return {"k": [float(k) for k in table.mean * (1.0 + table.cv * pattern[(test.seed - 1) % 5])], "lost": 0}


def test_gate_on_the_papers_own_columns(tmp_path):
    # discovery of the paper's misfits: RPG L2, TPG L1 and slope L2 stand out; with a campaign term of 1.25 % only slope L2 does
    simulator = Simulator(tmp_path / "s.sqlite", workers=1, function=paper_model)
    file = experiment(tmp_path, [laboratory(*names).to_dataframe() for names in PAPER])
    found = compare_layers(file, simulator=simulator, seeds=5)
    rows = {(row["trial"], row["layer"]): row for row in found.where}
    before = {key for key, row in rows.items() if row["holm p"] < 0.05}
    assert before == {("RPG flat", 2), ("TPG flat", 1), ("TPG 4 % slope", 2)}
    assert rows["RPG flat", 2]["z"] == pytest.approx(3.9, abs=0.05)  # Welch's t from the printed digits
    assert rows["TPG flat", 1]["z"] == pytest.approx(5.0, abs=0.05)
    assert rows["TPG 4 % slope", 2]["z"] == pytest.approx(3.5, abs=0.05)
    after = {key for key, row in rows.items() if abs(row["sigma"]) > 1.96}
    assert ("TPG 4 % slope", 2) in after and ("TPG flat", 1) not in after and after <= {("TPG 4 % slope", 2), ("RPG flat", 2)}
    notes = " ".join(found.notes)
    assert "1.9 % apart" in notes and "a perfect model" in notes
    assert found.error["rms"] == pytest.approx((1.38 + 1.00 + 2.775) / 300, abs=2e-4)


def test_naive_hull_model_is_led_to_the_true_shape(tmp_path, simulator):
    tables = [laboratory(*names).to_dataframe() for names in PAPER]
    file = experiment(tmp_path, tables, 'shape = "hull"\nfriction = 0.6\nmargin = 0.008')
    found = diagnose_layers(file, simulator=simulator)
    assert found.effects[0] == "convex_hull_shape" and found.model.placement.shape == "pieces"
    held = [step["held_out"] for step in found.steps]
    assert all(later < 0.98 * earlier for earlier, later in zip(held, held[1:], strict=False))  # rule: each step 2 % at least
    assert found.error["held_out"]["before"] == held[0] and found.error["held_out"]["after"] == held[-1]
    assert set(found.to_json()) >= {
        "verdict",
        "effects",
        "parameters",
        "ambiguous",
        "error",
        "steps",
        "adequate",
        "candidates",
        "where",
        "next_experiment",
    }
    # the mended model, written as a file, starts where this one ended
    (tmp_path / "mended.toml").write_text(found.model.to_toml())
    again = compare_layers(read_experiment_file(tmp_path / "mended.toml"), simulator=simulator)
    assert again.error["rms"] == pytest.approx(found.error["fitted"]["after"], rel=1e-6)
    # and what is there already is not sought again
    ran = simulator.ran
    assert diagnose_layers(file, simulator=simulator).to_json()["effects"] == list(found.effects) and simulator.ran == ran


def test_the_ladder_leads_from_the_naive_model_and_holds_the_slope_out(tmp_path, simulator):
    document, diagnosis = ladder.ladder(Plan({}, repeats=4), tmp_path, simulator=simulator)
    steps = document["steps"]
    assert diagnosis.title == "Table 2 against the naive model" and set(steps[0]["by_table"]) == {"RPG flat", "TPG flat"}
    assert steps[1]["effects"] == ["convex_hull_shape"]
    assert all(later["fitted"] < earlier["fitted"] for earlier, later in zip(steps, steps[1:], strict=False))
    assert steps[-1]["held_out"] < steps[0]["held_out"]  # the stand-in is 10 % too thick on the slope as well
    # the files it leaves are a case of their own: naive model, three tables
    assert [one.name for one in read_layers(read_experiment_file(tmp_path / "all.toml")).sets][-1] == "TPG 4 % slope"
    diagnosis.save(tmp_path / "moved")
    (tmp_path / "moved" / "flat.csv").write_text((tmp_path / "flat.csv").read_text())
    again = compare_layers(read_experiment_file(tmp_path / "moved" / "model.toml"), simulator=simulator, seeds=4)
    assert again.error["rms"] == pytest.approx(steps[-1]["fitted"], rel=1e-6)
    text = ladder.ladder_text(document)
    assert "the naive model" in text and "+ convex_hull_shape" in text and "a perfect model" in text


def test_a_number_far_from_the_first_guess_is_found_where_units_still_stand(tmp_path):
    """The law bends, and below 0.1 no unit stands: the straight line from 0.6 over the trial at 0.36 points at 0.04."""

    def bent(test):
        if test.friction < 0.1:
            return {"error": "no plate found a place"}
        shift = 0.25 * (test.friction - 0.36) if test.friction > 0.36 else 0.9 * (test.friction - 0.36)
        answer = emulate(replace(test, friction=0.36))
        return {**answer, "k": [k + shift * (layer > 0) for layer, k in enumerate(answer["k"])]}

    frames = []
    for grid, seed in (("TPG", 3), ("RPG", 4)):
        frame = measured(grid, seed, "a")
        frame.loc[1:, "mean"] -= 0.08  # what friction 0.271 gives: 0.14 below 0.6
        frames.append(frame)
    found = diagnose_layers(
        experiment(tmp_path, frames, "friction = 0.6"),
        candidates=["friction", "settlement"],
        simulator=Simulator(tmp_path / "runs.sqlite", workers=1, function=bent),
    )
    number = found.parameters["friction"]["coefficient"]
    assert found.effects == ("friction",) and number["low"] < 0.271 < number["high"] < 0.36


def test_one_grid_grants_one_effect_at_most(tmp_path, simulator):
    frame = measured("TPG", 3, "a", margin=0.0, placement_scatter=0.3)
    found = diagnose_layers(experiment(tmp_path, [frame], 'shape = "hull"\nmargin = 0.02'), simulator=simulator)
    assert len(found.effects) <= 1 and found.error["held_out"] is None


def test_nothing_missing_is_said_without_a_search(tmp_path, simulator):
    frames = [measured(grid, 5, campaign) for grid, campaign in (("TPG", "a"), ("RPG", "b"))]
    found = diagnose_layers(experiment(tmp_path, frames), simulator=simulator)
    assert found.verdict == "complete" and simulator.ran == 16  # eight tests a set: no candidate could have paid its price
    assert any("smallest shift of a layer that single sets show" in note for note in found.notes)


def test_a_shifted_first_layer_comes_back_as_a_set(tmp_path, simulator):
    # plate and settlement both lower the first layer only; 0.07 Dn is more than twice what two grids of five tests show
    frames = [measured(grid, 7, campaign, shift=-0.07) for grid, campaign in (("TPG", "a"), ("RPG", "b"))]
    names = ["plate_bias", "settlement", "friction", "convex_hull_shape"]
    found = diagnose_layers(experiment(tmp_path, frames), candidates=names, simulator=simulator)
    assert found.verdict in ("ambiguous", "unexplained") and "convex_hull_shape" not in found.effects
    assert not found.effects or set(found.ambiguous[0]) == {"plate_bias", "settlement"}


def test_stated_effects_are_part_of_the_model(tmp_path, simulator):
    frames = [measured("TPG", 9, "a"), measured("RPG", 9, "b")]
    bare = compare_layers(experiment(tmp_path, frames), simulator=simulator)
    file = experiment(tmp_path, frames)
    text = file.path.read_text() + '[model]\neffects = [{ name = "plate_bias", offset = 0.03 }]\n'
    file.path.write_text(text)
    biased = compare_layers(read_experiment_file(file.path), simulator=simulator)
    first = {row["trial"]: row["model"] for row in bare.where if row["layer"] == 1}
    assert all(row["model"] == pytest.approx(first[row["trial"]] + 0.03) for row in biased.where if row["layer"] == 1)


def test_report_and_files(tmp_path, simulator):
    found = diagnose_layers(experiment(tmp_path, [measured("TPG", 3, "a")], 'shape = "hull"'), simulator=simulator)
    folder = found.save(tmp_path / "out")
    copied = read_experiment_file(folder / "model.toml").data_file  # beside it, so that the folder can be used as it is
    assert copied.read_bytes() == (tmp_path / "layers.csv").read_bytes() and copied.parent == folder
    found.save(tmp_path)
    assert read_experiment_file(tmp_path / "model.toml").data_file == tmp_path / "layers.csv"  # no copy where it is below already
    assert {path.name for path in folder.iterdir()} >= {"result.json", "report.html", "diagnosis.png", "model.toml"}
    assert "convex_hull_shape" in found.summary()


def test_a_refused_placement_leaves_a_complaint_not_a_crash():
    # 15 degrees of friction angle cannot hold five layers on a grid this wide: no plate finds a bed
    test = hlcs.PlacementTest(grid="3.5,3.5", layers=2, rows=2, columns=2, friction=0.0, time_step=1 / 60, settle_time=2.0)
    result = simulate(test)
    assert set(result) in ({"error"}, {"k", "lost"})


def test_a_simulation_that_stalls_is_given_up_with_a_complaint(monkeypatch):
    monkeypatch.setattr(single_run, "LIMIT", 0.05)
    result = simulate(hlcs.PlacementTest(layers=3, rows=6, columns=6, time_step=1 / 480))
    assert "processor time" in result["error"]
    monkeypatch.setattr(single_run, "LIMIT", 60.0)
    assert len(simulate(hlcs.PlacementTest(layers=1, rows=2, columns=2))["k"]) == 1  # no clock of the last one is running


@pytest.mark.slow
def test_small_real_simulation(tmp_path):
    # 16 units, two layers, laid by the engine itself: the first layer of a margin-free model stands 1.298 Dn high
    simulator = Simulator(tmp_path / "s.sqlite", workers=1)
    frame = measured("TPG", 2, "a").iloc[:2]
    found = compare_layers(experiment(tmp_path, [frame], "rows = 4\ncolumns = 4"), simulator=simulator)
    first = next(row for row in found.where if row["layer"] == 1)
    assert first["model"] == pytest.approx(1.298, abs=2e-3) and simulator.ran == 8


def test_a_limit_that_strikes_inside_compiled_code_is_the_same_complaint():
    """Compiled code hands on what a signal raised inside of it as SystemError; one that no limit caused stays what it is."""
    with pytest.raises(InputError, match="processor time"), single_run.at_most(0.01):
        try:
            while True:
                pass
        except InputError as problem:
            raise SystemError("returned a result with an exception set") from problem
    with pytest.raises(SystemError, match="another"), single_run.at_most(60.0):
        raise SystemError("another")


def test_a_limit_whose_complaint_was_lost_strikes_again():
    with pytest.raises(InputError, match="processor time"), single_run.at_most(0.01):
        try:
            while True:
                pass
        except InputError:
            pass  # as in a callback of a C library, which can only print it
        while True:
            pass


def test_tests_to_show_a_misfit_again_go_with_its_inverse_square():
    """z of five tests grows with the root of their number: 16.4 / (z^2 / 5) tests, at least 3 and at most 50."""
    assert [experiment_design._tests_for({"z": z}) for z in (0.0, 2.0, 4.0, 40.0)] == [50, 21, 6, 3]


def test_a_model_of_layers_runs_its_own_placement():
    model = LayerModel(hlcs.PlacementTest(layers=1, rows=2, columns=2))
    assert model.run(seed=4).test == replace(model.placement, seed=4)


def test_a_model_that_cannot_be_placed_on_a_measured_grid_says_why(tmp_path):
    (tmp_path / "layers.csv").write_text(f"{HEADER}\nA,0.6,0.6,0,1,1.3,0.01,5,a\nA,0.6,0.6,0,2,1.1,0.01,5,a\n")
    (tmp_path / "e.toml").write_text(
        'kind = "layers"\n[placement]\nrows = 3\ncolumns = 3\nlayers = 2\n[measurement]\nfile = "layers.csv"\n'
    )
    with pytest.raises(InputError, match="smallest feasible spacing"):
        compare_layers(read_experiment_file(tmp_path / "e.toml"), simulator=Simulator(tmp_path / "s.sqlite", workers=1))
