"""What a reveal says: true numbers beside those that the data give, and nothing where there is nothing."""

from types import SimpleNamespace

import pytest
from matplotlib.figure import Figure

import hlcs
from hlcs import mystery
from hlcs.data.notes import Stopped
from hlcs.report import reveal

GIVEN = {"value": 0.46, "low": 0.44, "high": 0.48, "unit": "1"}


def diagnosis(parameters, effects=("quadratic_drag",)):
    error = {"unit": "m", "fitted": {"before": 1.5, "after": 0.03, "noise": 0.02}}
    return SimpleNamespace(parameters=parameters, effects=effects, error=error, notes=())


def answer(**more):
    law = {"quadratic_drag": {"drag_coefficient": 0.45}}
    plain = {"effects": ["quadratic_drag"], "parameters": law, "hidden_laws": law, "tied": [], "text": "a ball.\n"}
    return plain | more


def test_a_hidden_number_stands_beside_the_number_of_the_data():
    found = diagnosis({"quadratic_drag": {"drag_coefficient": GIVEN}})
    (row,) = reveal.rows_of(answer(), found)
    assert row == ("quadratic_drag", "drag_coefficient", "0.45", "0.460 +- 0.020", "0.440 to 0.480")
    text = reveal.told(answer(), {"quadratic_drag": "F = -k |w| w."}, found)
    assert "quadratic_drag: F = -k |w| w." in text and "1.5 m before, 30 mm with quadratic_drag; the noise is 20 mm." in text


def test_a_fit_that_was_stopped_is_not_said_to_give_nothing():
    stopped = diagnosis({}, ())
    stopped.notes = (Stopped("whatever it says"),)
    text = reveal.told(answer(), {"quadratic_drag": "F = -k |w| w."}, stopped)
    assert "Stopped by Ctrl-C" in text and "not fitted" in text and "not to be had" not in text


def test_what_no_library_has_is_told_as_it_was_hidden():
    hidden = {"camera_shake": {"amplitude": 0.008, "direction": [0, 0, 1], "form": 0.4}}
    rows = reveal.rows_of(answer(effects=["camera_shake"], parameters={}, hidden_laws=hidden), diagnosis({}, ()))
    assert rows == (("camera_shake", "amplitude", "0.008", "not to be had", "-"),)


def test_look_alikes_have_a_number_of_the_data_and_no_true_one():
    found = diagnosis({"quadratic_drag": {"drag_coefficient": GIVEN}, "time_scale": {"factor": GIVEN}})
    rows = reveal.rows_of(answer(tied=["time_scale"]), found)
    assert rows[1] == ("time_scale", "factor", "-", "0.460 +- 0.020", "0.440 to 0.480")


@pytest.mark.parametrize(("name", "candidate", "panels"), [("empty-gallery", "mass_offset", 2), ("tall-tank", "length_scale", 3)])
def test_before_and_after_are_drawn_and_after_only_where_something_is_added(name, candidate, panels):
    found = hlcs.diagnose(mystery.experiment(name), candidates=candidate)
    axes = reveal.before_and_after(found)
    assert len(axes) == panels and all(ax.has_data() and ax.get_title(loc="left") for ax in axes)
    assert bool(reveal.rows_of(mystery.answer(name), found)) == bool(found.effects) == (panels == 3)


def test_a_reveal_draws_into_axes_that_are_given_and_tells_that_without_a_fit_there_is_no_picture(tmp_path):
    told = hlcs.reveal("tower-drop")
    axes = Figure(figsize=(12, 4)).subplots(1, 3)
    assert all(ours is given and given.has_data() for ours, given in zip(told.plot(axes), axes, strict=True))
    with pytest.raises(hlcs.InputError, match="ax holds 1 Axes; this picture has 3"):
        told.plot(axes[0])
    assert len(hlcs.reveal("empty-gallery").plot()) == 2  # before alone: nothing is hidden, so nothing is fitted
    told.save(tmp_path / "answer")
    names = {file.name for file in (tmp_path / "answer").iterdir()}
    assert {"reveal.json", "reveal.txt", "before_and_after.png"} <= names
    with pytest.raises(hlcs.InputError, match="nothing was fitted"):
        hlcs.reveal("tower-drop", fit=False).plot()
