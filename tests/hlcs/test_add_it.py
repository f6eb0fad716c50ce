"""The loop: compare, diagnose, add what was found, compare again, and see the error fall to the noise."""

import json
import re
import shlex
import shutil
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from planted import EFFECT
from throws import drag_per_metre, write_throws

import hlcs
from hlcs.cli import commands, experiments
from hlcs.learning.laws import Ranges, one_law
from hlcs.learning.learned import Learned
from hlcs.report.diagnosis import report_page
from hlcs.report.diagnosis_figures import pictures
from hlcs.report.ranking import ranking_title
from hlcs.report.statistics import facts


@pytest.fixture(scope="module")
def dragged(tmp_path_factory):
    """(path of throws through air with C = 0.5, their Diagnosis)."""
    path = write_throws(tmp_path_factory.mktemp("throws"), drag_per_metre=drag_per_metre(0.5))
    return path, hlcs.diagnose(path, candidates=["quadratic_drag", "tilted_gravity"])


def test_what_was_found_takes_the_error_from_before_to_after(dragged):
    """The three lines of Python; the written number is a hundredth of its interval off, at most: 0.02 % of the error."""
    path, found = dragged
    experiment = hlcs.Experiment.read(path)
    mended = found.apply(experiment)
    seen = hlcs.compare(mended)
    assert experiment.file.effects == () and seen.added == ("quadratic_drag",)
    before, after, noise = (row["error"] for row in seen.errors)
    assert before == hlcs.compare(experiment).error["rms"] == seen.before.error["rms"]
    assert after < 1.05 * noise < before and seen.adequate and not seen.before.adequate
    for other in (hlcs.compare(experiment, found.model), hlcs.compare(path, effects=found.entries)):
        assert other.error["rms"] == pytest.approx(after, rel=2e-4) and other.before.error["rms"] == before


def test_a_wrong_number_of_the_model_is_corrected_in_its_place(tmp_path):
    """A drag coefficient of 0.47 is stated and 0.40 acts: both are told, and the error before is that of the stated one."""
    path = write_throws(tmp_path, drag_per_metre=drag_per_metre(0.40))
    stated = "[model]\neffects = [{ name = 'quadratic_drag', drag_coefficient = 0.47 }]  # from a book\n[measurement]"
    path.write_text(path.read_text().replace("[measurement]", stated))
    found = hlcs.diagnose(path, candidates=["quadratic_drag", "uniform_flow", "buoyancy"])
    number = found.parameters["quadratic_drag"]["drag_coefficient"]
    assert found.verdict == "effect" and found.effects == ("quadratic_drag",) and number["stated"] == 0.47
    assert number["low"] < 0.40 < number["high"]
    assert "Air resistance is not as stated: drag coefficient 0.40" in str(found) and "not 0.47." in str(found)
    found.apply(hlcs.Experiment.read(path)).save(tmp_path / "mended.toml")
    text = (tmp_path / "mended.toml").read_text()
    assert "# from a book" in text and 'replaced = [{ name = "quadratic_drag", drag_coefficient = 0.47 }]' in text
    seen = hlcs.compare(tmp_path / "mended.toml")
    assert "With quadratic drag corrected the error goes from" in str(seen)
    assert seen.adequate and seen.before.error == hlcs.compare(path).error


def test_before_after_and_noise_stand_in_one_table_and_one_picture(dragged):
    path, found = dragged
    seen = hlcs.compare(path, found.model)
    rows = [line.split() for line in str(seen).splitlines() if line.startswith(("  before", "  after", "  noise"))]
    assert [row[0] for row in rows] == ["before", "after", "noise"] and rows[0][-3:] == ["more", "than", "noise"]
    assert list(seen.to_dataframe("errors")["model"]) == ["before", "after", "noise"]
    assert seen.to_json()["before"]["error"]["rms"] == seen.before.error["rms"]
    assert all(len(axes.lines) >= 2 for axes in seen.plot())  # red and blue
    assert "quadratic drag added: error" in seen.plot()[0].figure.get_suptitle()


def test_a_diagnosis_ends_with_what_to_write_and_what_to_type(dragged):
    path, found = dragged
    add = found.to_json()["add"]
    (entry,) = tomllib.loads(f"effects = [{add['toml']}]")["effects"]
    value = found.parameters["quadratic_drag"]["drag_coefficient"]
    assert entry["name"] == "quadratic_drag" and value["low"] < entry["drag_coefficient"] < value["high"]
    assert add["next"] == f"hlcs compare {path}" and add["file"] == str(path) and add["fill_in"] == {}
    lines = [line.strip() for line in str(found).splitlines()]
    place = next(number for number, line in enumerate(lines) if line.startswith("To add it, write in"))
    effects, added, _, following = lines[place + 1 : place + 5]
    assert lines[place] == f"To add it, write in {path}, under [model]:" and following == f"hlcs compare {path}"
    text = path.read_text() + "\n[model]\n" + effects + "\n" + added  # as the reader is told to
    (path.parent / "typed.toml").write_text(text)
    assert hlcs.compare(path.parent / "typed.toml").added == ("quadratic_drag",)


def test_the_model_in_a_folder_of_results_runs_as_it_is(dragged):
    path, found = dragged
    wanted = hlcs.compare(found.apply(hlcs.Experiment.read(path))).error
    for folder in (path.parent / "plots", path.parent.parent / "elsewhere"):
        found.save(folder)
        assert hlcs.compare(folder / "model.toml").error == wanted
    found.save(path.parent)  # where the data are, they are not copied
    assert hlcs.compare(path.parent / "model.toml").error == wanted


def test_frames_go_the_same_way_without_a_file(dragged, tmp_path):
    path, _ = dragged
    frames = [pd.read_csv(path.parent / f"throw_{k}.csv") for k in range(8)]
    trials = [{"group": f"day {k % 2}"} for k in range(8)]
    body = {"shape": "sphere", "radius": 0.0335, "mass": 0.0577}
    thrown = hlcs.Experiment.from_frames(frames, body=body, noise={"position": 0.004}, trials=trials)
    found = hlcs.diagnose(thrown, candidates=["quadratic_drag"])
    assert found.add["file"] is None and found.add["next"] == "hlcs.compare(diagnosis.apply(experiment))"
    assert hlcs.compare(found.apply(thrown)).adequate
    assert hlcs.compare(found.save(tmp_path / "out") / "model.toml").adequate


def test_what_was_withheld_must_be_filled_in(dragged):
    """A number that these data do not give is not written as if they did; the experiment with it is refused until it is."""
    path, found = dragged
    numbers = {"drag_coefficient": {"value": None, "low": None, "high": None, "unit": "1", "why": "one segment tells it"}}
    found = replace(found, parameters={"quadratic_drag": numbers})
    assert found.add["fill_in"] == {"quadratic_drag.drag_coefficient": "one segment tells it"}
    assert 'Fill in first: quadratic_drag.drag_coefficient ("fill in" stands for it): one segment tells it' in str(found)
    mended = found.apply(hlcs.Experiment.read(path)).save(path.parent / "withheld.toml")
    with pytest.raises(
        hlcs.InputError, match="withheld.toml, line .*quadratic_drag: drag_coefficient = 'fill in' must be a finite"
    ):
        hlcs.compare(mended)
    filled = (path.parent / "withheld.toml").read_text().replace('"fill in"', "0.5")
    (path.parent / "filled.toml").write_text(filled)
    assert hlcs.compare(path.parent / "filled.toml").adequate


@pytest.fixture(scope="module")
def learned_drag(dragged):
    """The Diagnosis of these throws where their drag, a force k v^2 against the velocity, is a law that was learned."""
    path, found = dragged
    law = one_law(
        "speed", "power", "velocity", np.linspace(0.5, 3.0, 20), Ranges(np.array([[0.0] * 3, [1.0] * 3]), 1.0, 1.5, 12.0)
    )
    (reference,) = law.given  # the speed at which the strength is that of the law
    law = law.at([-drag_per_metre(0.5) * reference.value**2], [2.0])
    grid = np.linspace(0.5, 3.0, 10)
    band = {"grid": grid, "value": -(grid**2), "low": -(grid**2) - 0.1, "high": 0.1 - grid**2, "places": grid, "law": -(grid**2)}
    remains = {"effects": ["learned_force"], "chi2_per_freedom": 1.01, "error": 2e-3, "foreseen": False}
    numbers = {"exponent": {"value": 2.0, "low": 1.9, "high": 2.1, "unit": "1"}}
    told = "speed", "power", numbers, "A force.", law.source("A force."), {"before": 1.0, "after": 0.1}, band, ()
    learned = Learned(*told, remains=remains)
    return path, replace(found, verdict="unexplained", effects=(), parameters={}, learned=learned)


def test_a_learned_law_is_added_with_its_file(learned_drag, tmp_path):
    """With the law and nothing else the error is the noise."""
    path, found = learned_drag
    assert found.add["toml"] == '{ name = "learned_force" }' and found.to_json()["add"]["effect_file"] == "learned_effect.py"
    assert found.add["next"] == f"hlcs compare {path} --effects {path.parent / 'learned_effect.py'}"
    mended = found.apply(hlcs.Experiment.read(path))
    assert hlcs.compare(mended).adequate  # in Python no file is needed
    mended = mended.save(tmp_path / "mended.toml")
    assert mended.command.endswith(f"--allow-outside --effects {tmp_path / 'learned_effect.py'}")
    seen = hlcs.compare(tmp_path / "mended.toml", allow_outside=True, effects_file=tmp_path / "learned_effect.py")
    assert seen.adequate and seen.added == ("learned_force",) and not seen.before.adequate
    assert "stand in learned_effect.py, beside" in str(replace(found, mended=mended))
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "learned_effect.py").write_text("# the user's own\n")
    with pytest.raises(hlcs.InputError, match="learned_effect.py' is there already"):
        found.apply(hlcs.Experiment.read(path)).save(tmp_path / "sub" / "mended.toml")


def test_a_learned_law_stands_in_the_report_with_its_numbers_its_picture_and_what_it_leaves(learned_drag):
    _, found = learned_drag
    text, drawn = str(found), pictures(found)
    assert re.search(r"exponent +2\.00 \+- 0\.10 +1\.90 to 2\.10", text)
    assert re.search(r"learned_force +2 mm .* 1\.01", text) and "what was learned leaves 1.01" in ranking_title(found)
    assert ("error with what was learned, on recordings left out", "100 mm") in facts(found)
    (ax,), caption = drawn["law"]
    assert [line.get_label() for line in ax.lines[:2]] == ["as a table", "the law"] and "The line is the law." in caption
    page = report_page(found, {"law": (b"", caption)})
    assert page.index('id="law"') < page.index('alt="law:') < page.index('id="ranking"')  # beside its section


@pytest.mark.parametrize("option", ["--plots", "--out"])
def test_the_lines_printed_of_a_learned_law_work_as_they_are_typed(learned_drag, tmp_path, monkeypatch, capsys, option):
    """From where the user is, whose folder of results holds the file of the law: the report in it says the same lines."""
    path, found = learned_drag
    monkeypatch.chdir(tmp_path)
    shutil.copytree(path.parent, "throws")
    found = replace(found, experiment=hlcs.Experiment.read(f"throws/{path.name}"))
    monkeypatch.setattr(experiments, "diagnose_file", lambda *_, **__: found)
    assert commands.main(["diagnose", f"throws/{path.name}", option, "my results"]) == 0
    text = capsys.readouterr().out
    lines = [line.strip() for line in text.splitlines() if line.strip().startswith("hlcs compare")]
    assert [shlex.split(line)[2] for line in lines] == [f"throws/{path.name}", "my results/model.toml"]
    report = Path("my results/report.txt").read_text()
    assert all(line in report for line in lines)
    added = '[model]\neffects = [{ name = "learned_force" }]\nadded = ["learned_force"]\n'
    Path(f"throws/{path.name}").write_text(path.read_text().replace("[measurement]", f"{added}[measurement]"))
    for line in lines:
        assert commands.main(shlex.split(line)[1:]) == 0
        assert "With learned force added the error goes from" in capsys.readouterr().out


@pytest.mark.parametrize("verdict", ["ambiguous", "unexplained"])
def test_what_is_not_proved_is_added_with_that_word(dragged, verdict):
    _, found = dragged
    assert "Quadratic drag can be added, and is not proved: " in str(replace(found, verdict=verdict))
    assert replace(found, verdict=verdict).add["toml"] == found.add["toml"]


def test_the_others_of_an_ambiguous_set_are_written_out_too(tmp_path):
    """A leaning camera and a leaning world look alike in flight: whichever is added, the error falls to the noise.

    The lines that are printed for each, typed under [model], make a file that is read: `added` names what stands in `effects`."""
    path = write_throws(tmp_path, tilt=(0.01, 0.004))
    found = hlcs.diagnose(path, candidates=["tilted_gravity", "tilted_frame"])
    (instead,) = found.alternatives
    assert {found.effects[0], instead[0]["name"]} == {"tilted_gravity", "tilted_frame"}
    text = path.read_text()
    printed = [line.strip() for line in str(found).splitlines() if line.strip().startswith(("effects = ", "added = "))]
    for entries, lines in ((found.entries, printed[:2]), (instead, printed[2:])):
        (tmp_path / "typed.toml").write_text(text + "\n[model]\n" + "\n".join(lines) + "\n")
        typed = hlcs.Experiment.read(tmp_path / "typed.toml")
        assert typed.file.added == (entries[0]["name"],) and hlcs.compare(typed).adequate
    assert all(hlcs.compare(path, effects=entries).adequate for entries in (found.entries, instead))


def test_what_all_sets_hold_is_written_out_with_the_number_that_it_has_in_each(dragged):
    _, found = dragged
    other = {**found.sets[0], "parameters": {"quadratic_drag": {"drag_coefficient": 0.61234567}}}
    ((entry,),) = replace(found, sets=(*found.sets[:1], other)).alternatives
    assert entry["drag_coefficient"] == pytest.approx(0.6123, abs=1e-4) and entry["drag_coefficient"] != 0.61234567


def test_where_no_effect_does_as_well_the_alternative_is_nothing(dragged):
    _, found = dragged
    alike = replace(found, verdict="ambiguous", sets=(*found.sets[:1], {**found.sets[0], "effects": []}))
    assert "Or nothing need be added.\n" in str(alike)


def test_where_nothing_was_found_nothing_is_added(tmp_path):
    path = write_throws(tmp_path)
    found = hlcs.diagnose(path, candidates=["quadratic_drag"])
    experiment = hlcs.Experiment.read(path)
    assert found.verdict == "complete" and found.to_json()["add"] is None and "To add it" not in str(found)
    assert found.apply(experiment) is experiment


def test_every_table_is_a_frame(dragged):
    path, found = dragged
    assert list(found.to_dataframe("numbers")["effect"]) == ["quadratic_drag"]
    assert len(found.to_dataframe("steps")) == 2 and len(found.to_dataframe("where")) == len(found.where)
    assert list(found.to_dataframe("sets")["effects"]) == [["quadratic_drag"]]
    seen = hlcs.compare(path)
    assert list(seen.to_dataframe("errors")["model"]) == ["model", "noise"] and len(seen.to_dataframe("impacts")) == 0
    with pytest.raises(
        hlcs.InputError, match="table 'wher' is none of candidates, steps, sets, where, numbers; did you mean 'where'"
    ):
        found.to_dataframe("wher")
    with pytest.raises(hlcs.InputError, match="table 'parameters' is none of .*; 'numbers' holds it"):
        found.to_dataframe("parameters")
    json.dumps(found.to_json())


@pytest.mark.parametrize("given", ["E.toml", None, 3, {"kind": "trajectory"}])
def test_what_was_found_is_applied_to_an_experiment_and_to_nothing_else(given):
    with pytest.raises(hlcs.InputError, match=r"apply: got .*; give an hlcs.Experiment, such as diagnosis.experiment"):
        EFFECT.apply(given)


def test_a_comparison_that_finds_a_misfit_names_the_command_to_type_next(dragged):
    """Where the model agrees, and where it was tried in Python alone, there is none to type."""
    path, found = dragged
    assert f"hlcs diagnose {path}" in " ".join(str(hlcs.compare(path)).split("How to go on")[1].split())
    assert "How to go on" not in str(hlcs.compare(path, found.model))
    assert "How to go on" not in str(hlcs.compare(path, effects=[{"name": "quadratic_drag", "drag_coefficient": 0.2}]))


def test_a_law_stands_without_the_effect_that_only_holds_a_part_of_it(tmp_path):
    """A fan that blows along x with 1.5 m/s2 from 0.35 s on: a camera that leans by 5 degrees takes half, and is not added."""
    generator, times, frames = np.random.default_rng(112), np.arange(80) / 100, []
    on = np.maximum(times - 0.35, 0.0)
    for speed, angle in ((3.2, 0.7), (4.1, 1.2), (5.0, 0.9), (3.6, 1.1), (5.6, 0.8), (4.5, 1.0)):
        x = speed * np.cos(angle) * times + 0.75 * on**2
        z = 1.2 + speed * np.sin(angle) * times - 9.81 * times**2 / 2
        noisy = np.column_stack([x, z]) + 0.002 * generator.standard_normal((80, 2))
        frames.append({"t_s": times, "x_m": noisy[:, 0], "z_m": noisy[:, 1]})
    trials, body = [{"group": f"g{k % 3}"} for k in range(6)], {"shape": "sphere", "radius": 0.036, "mass": 0.2}
    thrown = hlcs.Experiment.from_frames(frames, body=body, noise={"position": 0.002}, trials=trials)
    found = hlcs.diagnose(thrown, candidates=["tilted_frame"])
    assert found.verdict == "unexplained" and found.effects == ("tilted_frame",)
    assert [entry["name"] for entry in found.additions] == ["learned_force"] and found.learned.form == "switch"
    assert "In place of what was found one law explains more" in str(found)
    seen = hlcs.compare(found.apply(thrown))
    assert seen.adequate and seen.error["rms"] == pytest.approx(0.002, rel=0.1)  # of 960 readings: a standard error of 2 %
