"""Diagnoses and comparisons of layer tables from file to verdict, on a stand-in for the simulations (layer_tables.py)."""

from dataclasses import replace

import numpy as np
import pytest
from layer_tables import HEADER, PAPER, compare_layers, diagnose_layers, emulate, experiment, measured

import hlcs
from hlcs.data.experiment_file import read_experiment_file
from hlcs.kinds.experiment import Experiment
from hlcs.kinds.layers.data import read_layer_sets, read_layers
from hlcs.kinds.layers.model import PlacementSimulator
from hlcs.kinds.protocol import Options
from hlcs.placement.printed_tables import laboratory, paper_numerical
from minibullet.errors import InputError


def test_unknown_columns_keys_and_effects_are_refused_by_name(tmp_path, simulator):
    (tmp_path / "a.csv").write_text("grid,layer,mean,cv,tests,colour\nTPG,1,1.3,0.01,5,red\n")
    with pytest.raises(hlcs.InputError, match="colour"):
        read_layer_sets(tmp_path / "a.csv")
    with pytest.raises(hlcs.InputError, match="shap"):
        read_layers(experiment(tmp_path, [measured("TPG", 1, "a")], 'shap = "hull"'))
    misspelt = experiment(tmp_path, [measured("TPG", 1, "a")], diagnose='candidates = ["frction"]')
    with pytest.raises(hlcs.InputError, match=r"layers.toml, line \d+: diagnose.candidates: .*'frction'.*'friction'"):
        compare_layers(misspelt, simulator=simulator)
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


def paper_model(test):
    """The paper's own numerical columns: five values with the printed mean and scatter, one a seed."""
    pattern = np.array([-1.0, 1.0, 0.0, -1.0, 1.0])  # mean 0, standard deviation 1 about it
    table = paper_numerical("table3" if test.bottom.height(0.0, 1.0) else "table2", test.grid.name)
    return {"k": [float(k) for k in table.mean * (1.0 + table.cv * pattern[(test.seed - 1) % 5])], "lost": 0}


def test_gate_on_the_papers_own_columns(tmp_path):
    # discovery of the paper's misfits: RPG L2, TPG L1 and slope L2 stand out; with a campaign term of 1.25 % only slope L2 does
    simulator = PlacementSimulator(tmp_path / "s.sqlite", workers=1, function=paper_model)
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
    assert "convex_hull_shape" in found.effects and found.model.placement.shape == "pieces"
    held = [step["held_out"] for step in found.steps]
    assert all(later < 0.98 * held[0] for later in held[1:])  # rule: an effect takes 2 % at least
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
    # the mended model, written as a file, starts where this one ended, seen by the same tests, and is judged as it was
    mended = found.apply(Experiment(file)).save(tmp_path / "mended.toml")
    again = compare_layers(mended.file, simulator=simulator)
    assert again.error["rms"] == pytest.approx(found.error["fitted"]["after"], rel=0.1)  # its numbers are written in few digits
    assert again.adequate == found.adequate["after"]
    # and what is there already is not sought again
    ran = simulator.ran
    assert diagnose_layers(file, simulator=simulator).to_json()["effects"] == list(found.effects) and simulator.ran == ran


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
        simulator=PlacementSimulator(tmp_path / "runs.sqlite", workers=1, function=bent),
    )
    number = found.parameters["friction"]["coefficient"]
    assert found.effects == ("friction",) and number["low"] < 0.271 < number["high"] < 0.36


def test_five_layers_of_one_grid_pay_for_two_effects_at_most(tmp_path, simulator):
    """Without anything to hold out the odds against an effect are twice as high, and five numbers have little to say."""
    frame = measured("TPG", 3, "a", margin=0.0, placement_scatter=0.3)
    found = diagnose_layers(experiment(tmp_path, [frame], 'shape = "hull"\nmargin = 0.02'), simulator=simulator)
    assert len(found.effects) <= 2 and found.error["held_out"] is None


def test_nothing_missing_is_said_without_a_search(tmp_path, simulator):
    frames = [measured(grid, 5, campaign) for grid, campaign in (("TPG", "a"), ("RPG", "b"))]
    found = diagnose_layers(experiment(tmp_path, frames), simulator=simulator)
    assert found.verdict == "complete" and simulator.ran == 32  # sixteen tests a set: no candidate could have paid its price
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
    rows = {line.split()[0].lstrip("*") or line.split()[1] for line in found.summary(details=True).splitlines() if line}
    assert {finding.effect for finding in found.candidates if finding.evidence is not None} <= rows


def test_what_was_found_is_added_to_the_model_and_taken_off_again(tmp_path, simulator):
    frames = [measured(grid, 3, campaign) for grid, campaign in (("TPG", "a"), ("RPG", "b"))]
    file = experiment(tmp_path, frames, 'shape = "hull"')
    found = diagnose_layers(file, candidates=["convex_hull_shape", "settlement"], simulator=simulator)
    mended = found.apply(found.experiment)
    assert found.effects == ("convex_hull_shape",) and mended.file.added == found.effects
    assert mended.opened(Options()).model.placement.shape == "pieces" and mended.before().file.effects == ()
    assert str(found.model).splitlines()[1].strip() == "convex_hull_shape"
    assert found.add["toml"] == '{ name = "convex_hull_shape", switch = 1.0 }'


def test_what_an_effect_does_is_as_little_known_once_it_stands_in_the_file(tmp_path, simulator):
    """Engines differ by 30 % in what an effect does to a layer, whoever wrote it into the model. Layers that are thinner by half
    as much are told apart from a model that always had the true shape, and from one that was mended by it they are not."""
    frames = [measured(grid, 3, campaign) for grid, campaign in (("TPG", "a"), ("RPG", "b"))]
    for frame in frames:
        frame.loc[1:, "mean"] -= 0.05  # of 0.10 by which hulls are thicker
    plain = compare_layers(experiment(tmp_path, frames), simulator=simulator)
    hull = experiment(tmp_path, frames, 'shape = "hull"')
    found = diagnose_layers(hull, candidates=["convex_hull_shape"], simulator=simulator)
    mended = found.apply(Experiment(hull)).file
    again = compare_layers(mended, simulator=simulator)
    assert found.effects == ("convex_hull_shape",) and again.error["rms"] == pytest.approx(plain.error["rms"])
    assert found.adequate["after"] and again.adequate and not plain.adequate
    assert again.statistic == pytest.approx(found.adequate["statistic"], rel=0.05)  # of the scatter of the runs before, and after
    told = " ".join(str(again).split())  # without the breaks of lines
    assert "what campaigns and engines differ by make together" in told and "nothing but noise" not in told


@pytest.mark.slow
def test_small_real_simulation(tmp_path):
    # 16 units, two layers, laid by the engine itself: the first layer of a margin-free model stands 1.298 Dn high
    simulator = PlacementSimulator(tmp_path / "s.sqlite", workers=1)
    frame = measured("TPG", 2, "a").iloc[:2]
    found = compare_layers(experiment(tmp_path, [frame], "rows = 4\ncolumns = 4"), simulator=simulator)
    first = next(row for row in found.where if row["layer"] == 1)
    assert first["model"] == pytest.approx(1.298, abs=2e-3) and simulator.ran == 16


def test_a_model_that_cannot_be_placed_on_a_measured_grid_says_why(tmp_path):
    (tmp_path / "layers.csv").write_text(f"{HEADER}\nA,0.6,0.6,0,1,1.3,0.01,5,a\nA,0.6,0.6,0,2,1.1,0.01,5,a\n")
    (tmp_path / "e.toml").write_text(
        'kind = "layers"\n[placement]\nrows = 3\ncolumns = 3\nlayers = 2\n[measurement]\nfile = "layers.csv"\n'
    )
    with pytest.raises(InputError, match="smallest feasible spacing"):
        compare_layers(read_experiment_file(tmp_path / "e.toml"), simulator=PlacementSimulator(tmp_path / "s.sqlite", workers=1))


def test_an_effect_of_layers_alone_that_was_added_is_compared_with_and_without(tmp_path):
    """The library of recordings does not know a plate: one of 0.05 Dn makes the first layer as much thicker."""
    (tmp_path / "layers.csv").write_text("grid,layer,mean,cv,tests\nTPG,1,1.35,0.01,5\n")
    model = '[model]\neffects = [{ name = "plate_bias", offset = 0.05 }]\nadded = ["plate_bias"]\n'
    placed = '[placement]\nshape = "hull"\nlayers = 1\nrows = 3\ncolumns = 3\n'
    path = tmp_path / "e.toml"
    path.write_text(f'kind = "layers"\n{placed}{model}[measurement]\nfile = "layers.csv"\n')
    found = hlcs.compare(path, workers=1)
    assert (found.added, found.replaced) == (("plate_bias",), ()) and "plate bias added" in str(found)
    assert found.error["rms"] < found.before.error["rms"]
