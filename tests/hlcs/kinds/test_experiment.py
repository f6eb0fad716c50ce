"""An experiment in hand: the same from a file and from frames, changed only into another one, written so that it can be read."""

import re
from dataclasses import dataclass

import numpy as np
import pandas as pd
import pytest
from layer_tables import experiment as layer_experiment
from layer_tables import measured
from throws import drag_per_metre, write_throws

import hlcs
import minibullet as mb
from hlcs.kinds.protocol import Options
from minibullet.effects.contract import Effect, parameter

BALL = {"shape": "sphere", "radius": 0.0335, "mass": 0.0577}
HEIGHTS = np.repeat(np.linspace(0.5, 9.0, 8), 4)
FALLS = {"height_m": HEIGHTS, "fall_time_s": np.sqrt(2 * HEIGHTS / 9.81) + 0.002 * np.tile([-1.0, 1.0, 1.0, -1.0], 8)}
DRAG = mb.QuadraticDrag(drag_coefficient=0.47)


@dataclass(frozen=True)
class Breeze(Effect):
    """A law of the user's own that does nothing."""

    rate: float = parameter(0.0, unit="1/s", low=0.0, high=5.0, null=0.0)


def thrown(folder, **law):
    """(path of an experiment file of throws, the same measurement as the arguments of `from_frames`)."""
    path = write_throws(folder, count=4, **law)
    frames = [pd.read_csv(folder / f"throw_{k}.csv") for k in range(4)]
    given = {"static": pd.read_csv(folder / "rest.csv"), "trials": [{"group": f"day {k % 2 + 1}"} for k in range(4)]}
    return path, {"frames": frames, "body": BALL, "surroundings": {"fluid_density": 1.2, "fluid_viscosity": 1.8e-5}, **given}


def test_recordings_in_frames_are_compared_as_those_in_files(tmp_path):
    path, given = thrown(tmp_path, drag_per_metre=drag_per_metre(0.5))
    of_file, of_frames = hlcs.compare(path), hlcs.compare(hlcs.Experiment.from_frames(**given))
    assert of_frames.error == of_file.error and of_frames.p == of_file.p
    assert of_frames.trials == ("frame 1", "frame 2", "frame 3", "frame 4")


def test_a_table_of_outcomes_may_be_a_dictionary_of_arrays():
    falls = hlcs.Experiment.from_frames(FALLS, kind="outcomes", body=BALL, surroundings={"fluid_density": 0.0})
    seen = hlcs.compare(falls)
    assert seen.adequate and seen.error["noise"] == pytest.approx(0.002, rel=0.2)  # 24 degrees of freedom: 15 %


def test_a_table_of_layers_may_be_a_frame(tmp_path):
    table = measured("TPG", 1, "a")
    of_file = layer_experiment(tmp_path, [table], "friction = 0.4")
    in_hand = hlcs.Experiment.from_frames(table, kind="layers", placement={"friction": 0.4})
    opened = in_hand.opened(Options())
    assert opened.model.placement == hlcs.Experiment(of_file).opened(Options()).model.placement
    np.testing.assert_array_equal(opened.sets[0].sample.mean, table["mean"])


def test_what_cannot_be_an_experiment_is_refused_by_what_was_given():
    good = {"t_s": [0.0, 0.1, 0.2, 0.3, 0.4], "z_m": [1.0, 0.9, 0.8, 0.7, 0.6]}
    for given, words in (
        ({"frames": good, "body": {"raduis": 1.0}}, "frames: body.raduis: unknown key; the nearest known key is 'radius'"),
        ({"frames": good, "boddy": BALL}, "frames: boddy: unknown key; the nearest known key is 'body'"),
        ({"frames": [good], "trials": [{}, {}]}, "frames: 2 trials for 1 frames"),
        ({"frames": [good, good], "kind": "outcomes"}, 'frames: 2 frames; kind = "outcomes" takes one'),
        ({"frames": [good], "kind": "outcomes", "trials": [{}]}, 'kind = "outcomes" takes columns of its one frame'),
        ({"frames": good, "body": {"mass": {1.0}}}, "frames: body.mass is a set"),
        ({"frames": []}, "frames: got \\[\\]; give a pandas frame"),
    ):
        with pytest.raises(hlcs.InputError, match=words):
            hlcs.Experiment.from_frames(**given)


def test_a_change_makes_another_experiment(tmp_path):
    first = hlcs.Experiment.read(write_throws(tmp_path, count=4))
    second = first.with_effects([DRAG])
    third = second.with_effects([mb.QuadraticDrag(drag_coefficient=0.5), Breeze(0.1)])  # a second drag would count twice
    assert first.file.effects == () and first.before() is None
    assert second.file.effects == ({"name": "quadratic_drag", "drag_coefficient": 0.47},) and second.before().file.effects == ()
    assert [entry.get("drag_coefficient") for entry in third.file.effects] == [0.5, None]
    assert third.file.added == ("quadratic_drag", "breeze") and third.user_effects == (Breeze,)
    assert third.before().file.effects == second.file.effects == third.file.replaced


def test_a_model_takes_the_place_of_the_other(tmp_path):
    path = write_throws(tmp_path, drag_per_metre=drag_per_metre(0.5))
    found = hlcs.diagnose(path, candidates=["quadratic_drag"])
    bare = hlcs.Experiment.read(path).with_effects([mb.LinearDrag(0.1)])
    assert bare.with_model(found.model).file.effects == found.model.entries
    with pytest.raises(hlcs.InputError, match="dict is no model of an experiment; give diagnosis.model"):
        hlcs.compare(bare, found.error)


def test_effects_that_cannot_be_written_are_refused(tmp_path):
    experiment = hlcs.Experiment.read(write_throws(tmp_path, count=2))
    for effect, words in (
        (mb.QuadraticDrag, "is no effect; give values such as"),
        (mb.Buoyancy(1.2, direction=(1.0, 0.0, 0.0)), "buoyancy: direction = .* is no number"),
        ({"name": "quadratic_drag"}, "throws.toml: model.effects: quadratic_drag stands without a number; give drag_coefficient"),
    ):
        with pytest.raises(hlcs.InputError, match=words):
            hlcs.compare(experiment.with_effects([effect]))
    with pytest.raises(hlcs.InputError, match="one model, or effects"):
        hlcs.compare(experiment, experiment, effects=[DRAG])


def test_a_saved_experiment_finds_its_data_from_there(tmp_path):
    """Beside the first file, in another folder, and of frames: the same comparison, and the command says what it needs."""
    path, given = thrown(tmp_path)
    wanted = hlcs.compare(path).error
    beside = hlcs.Experiment.read(path).save(tmp_path / "again.toml")
    below = hlcs.Experiment.read(path).save(tmp_path / "sub" / "again.toml")
    of_frames = hlcs.Experiment.from_frames(**given).save(tmp_path / "frames" / "again.toml")
    assert hlcs.compare(tmp_path / "again.toml").error == wanted and beside.command.endswith("again.toml")
    assert below.command.endswith("sub/again.toml --allow-outside") and hlcs.compare(below).error == wanted
    assert hlcs.compare(tmp_path / "frames" / "again.toml").error == wanted and "--allow" not in of_frames.command
    with pytest.raises(hlcs.InputError, match="lies outside the folder of this file"):
        hlcs.compare(tmp_path / "sub" / "again.toml")


def test_comments_of_the_user_are_kept(tmp_path):
    """All of them, in order, and all other lines; the file says what the values say, there and in another folder."""
    path = write_throws(tmp_path, count=2)
    model = "[model]  # as bought\ntime_step = 0.004  # s\neffects = [  # none yet\n]\n"
    path.write_text(
        "# My throws, Tuesday.\n" + path.read_text().replace("[measurement]", model + "# a good camera\n[measurement]")
    )
    wanted = [line.partition("#")[1:] for line in path.read_text().splitlines() if "#" in line]
    mended = hlcs.Experiment.read(path).with_effects([DRAG])
    for name in ("mended.toml", "sub/mended.toml"):
        again = mended.save(tmp_path / name)
        text = (tmp_path / name).read_text()
        assert re.match(r"# Written by hlcs from throws.toml \(mark [0-9a-f]{16}\)\n# My throws, Tuesday\.\n", text)
        assert [line.partition("#")[1:] for line in text.splitlines()[1:] if "#" in line] == wanted
        assert again.file.effects == mended.file.effects and again.file.added == ("quadratic_drag",)
        assert hlcs.compare(again).error == hlcs.compare(mended).error
    kept = again.save(tmp_path / "sub" / "third.toml")  # what was written is not told of twice
    assert (tmp_path / "sub" / "third.toml").read_text().count("# Written by") == 1 and kept.file.effects == again.file.effects


def test_a_file_of_the_user_is_never_written_over(tmp_path):
    experiment = hlcs.Experiment.read(write_throws(tmp_path, count=2))
    experiment.save(tmp_path / "mended.toml").save(tmp_path / "mended.toml")  # our own may be
    with pytest.raises(hlcs.InputError, match="throws.toml' is there already and was not written by this program"):
        experiment.save(tmp_path / "throws.toml")
    with pytest.raises(hlcs.InputError, match="is a folder; give the name of a file"):
        experiment.save(tmp_path)


def test_changes_in_a_file_that_was_written_are_not_lost(tmp_path):
    """To another name, or to itself, since it is kept there."""
    experiment = hlcs.Experiment.read(write_throws(tmp_path, count=2))
    experiment.save(tmp_path / "mended.toml")
    (tmp_path / "mended.toml").write_text((tmp_path / "mended.toml").read_text() + "# weighed on Friday\n")
    with pytest.raises(
        hlcs.InputError, match="mended.toml' is not as this program wrote it: what was changed in it would be lost"
    ):
        experiment.save(tmp_path / "mended.toml")
    hlcs.Experiment.read(tmp_path / "mended.toml").with_effects([DRAG]).save(tmp_path / "mended.toml")
    assert "# weighed on Friday" in (tmp_path / "mended.toml").read_text()
    mine = (
        (tmp_path / "mended.toml").read_text().replace("[model]", "model.effects = []  # mine\n[notes]").replace("[notes]", "", 1)
    )
    (tmp_path / "old.toml").write_text("# Written by hlcs from throws.toml\n" + mine.partition("\n")[2])
    with pytest.raises(hlcs.InputError, match="old.toml' is of an earlier version, or not as it was written"):
        experiment.save(tmp_path / "old.toml")


def test_an_effect_that_was_added_must_stand_in_the_model(tmp_path):
    path = write_throws(tmp_path, count=2)
    path.write_text(path.read_text() + '\n[model]\nadded = ["magnus"]\n')
    with pytest.raises(hlcs.InputError, match="line .*: model.added: 'magnus' stands not in effects"):
        hlcs.Experiment.read(path)
