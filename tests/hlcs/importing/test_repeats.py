"""Repeats beside one another become rows; what is numbered and no repeat stays as it is."""

import pytest

FALLS = {"height_m": ["0.5", "0.5", "0.5", "1.0", "1.0"], "fall_time_s": ["0.33", "0.31", "0.32", "0.45", "0.46"]}


@pytest.mark.parametrize(
    "text",
    [
        "Height (m),Trial 1 (s),Trial 2 (s),Trial 3 (s),Average (s)\n0.5,0.33,0.31,0.32,0.32\n1.0,0.45,0.46,,0.46\n",
        "Fallhöhe [cm];Fallzeit 1 [s];Fallzeit 2 [s];Fallzeit 3 [s]\n50;0,33;0,31;0,32\n100;0,45;0,46\n",
        "height;Messung #1;Messung #2;Messung #3\ncm;ms;ms;ms\n50;330;310;320\n100;450;460;\n",
        "drop height (cm),run_1 fall time,run_2,run_3\n",
    ],
    ids=["trials", "an outcome", "units below", "unlike names"],
)
def test_repeats_of_a_fall_are_a_row_each(imported, refused, text):
    if "run_1" in text:
        refused(text + "50,0.33,0.31,0.32\n", "csv", "not understood")
        return
    found, tables = imported(text, "csv")
    assert tables["measurements.csv"] == FALLS
    assert "repeat one experiment: a row each" in str(found) and "1 rows without fall_time_s are left out" in str(found)


def test_columns_that_are_said_to_be_one_outcome_repeat_it(imported):
    """With the unit of the first; a way beside makes a time that of a slide only where nothing else is said."""
    text = "distance (cm),Anna (s),Ben (s)\n50,1.2,1.3\n100,1.7,1.8\n"
    said = {"Anna (s)": "slide_time_s", "Ben (s)": "slide_time_s"}
    _, tables = imported(text, "csv", column=said, constant={"angle_deg": 5})
    assert tables["measurements.csv"]["slide_time_s"] == ["1.2", "1.3", "1.7", "1.8"]
    assert tables["measurements.csv"]["distance_m"] == ["0.5", "0.5", "1.0", "1.0"]
    _, tables = imported(text.replace("Anna", "Trial 1").replace("Ben", "Trial 2"), "csv")
    assert tables["measurements.csv"]["slide_time_s"] == ["1.2", "1.3", "1.7", "1.8"]


def test_bodies_and_gates_that_are_numbered_are_no_repeats(refused):
    refused("t,x1,x2\n0,1,2\n1,2,3\n", "csv", "columns 't', 'x1', 'x2'")
    words = ("time 1 (s)=t_s", "=fall_time_s", "the same outcome of each", "time 2 (s)=..")
    refused("height (m),time 1 (s),time 2 (s)\n0.5,0.33,0.41\n1.0,0.45,0.52\n", "csv", *words)
