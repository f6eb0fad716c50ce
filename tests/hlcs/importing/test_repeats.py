"""Repeats beside one another become rows; what is numbered and no repeat stays as it is."""

import pytest

FALLS = {"height_m": ["0.5", "0.5", "0.5", "1.0", "1.0"], "fall_time_s": ["0.33", "0.31", "0.32", "0.45", "0.46"]}


@pytest.mark.parametrize(
    "text",
    [
        "Height (m),Trial 1 (s),Trial 2 (s),Trial 3 (s),Average (s)\n0.5,0.33,0.31,0.32,0.32\n1.0,0.45,0.46,,0.46\n",
        "Fallhöhe [cm];Fallzeit 1 [s];Fallzeit 2 [s];Fallzeit 3 [s]\n50;0,33;0,31;0,32\n100;0,45;0,46\n",
        "height;Messung #1;Messung #2;Messung #3\ncm;ms;ms;ms\n50;330;310;320\n100;450;460;\n",
        "Fallhöhe;1. Messung;2. Messung;3. Messung;Mittelwert\n[cm];[s];[s];[s];[s]\n50;0,33;0,31;0,32;0,32\n100;0,45;0,46;;\n",
        "drop height (cm),run_1 fall time,run_2,run_3\n",
    ],
    ids=["trials", "an outcome", "units below", "numbers before", "unlike names"],
)
def test_repeats_of_a_fall_are_a_row_each(imported, refused, text):
    if "run_1" in text:
        refused(text + "50,0.33,0.31,0.32\n", "csv", "not understood")
        return
    found, tables = imported(text, "csv")
    assert tables["measurements.csv"] == FALLS
    assert "repeat one experiment: a row each" in str(found) and "1 row without fall_time_s left out" in str(found)


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


def test_numbered_times_that_do_not_always_rise_are_no_gates_but_repeats(imported):
    text = (
        "angle (deg),distance (cm),time 1 (s),time 2 (s),time 3 (s),mean (s)\n20,60,0.99,1.01,1.00,1.00\n30,60,0.63,,0.61,0.62\n"
    )
    found, tables = imported(text, "csv")
    assert tables["measurements.csv"] == {
        "angle_deg": ["20.0"] * 3 + ["30.0"] * 2,
        "distance_m": ["0.6"] * 5,
        "slide_time_s": ["0.99", "1.01", "1.0", "0.63", "0.61"],
    }
    assert "repeat one experiment" in str(found) and "'mean (s)' is left out" in str(found)


def test_rows_whose_times_fall_are_no_samples_but_experiments(imported, refused):
    _, tables = imported("angle (deg),distance (m),time (s)\n5,0.5,1.27\n5,1.0,1.79\n10,0.5,0.90\n", "csv")
    assert tables["measurements.csv"]["slide_time_s"] == ["1.27", "1.79", "0.9"]
    refused("distance (m),time (s)\n0.5,1.27\n1.0,1.79\n", "csv", "nothing of where the body is")


def test_what_is_computed_of_readings_is_offered_as_no_repeat_of_them(refused):
    told = refused(
        "height (cm),t mean (ms),st. dev. (ms)\n50,320,4\n100,452,5\n", "csv", 'state what each is with --column "t mean'
    )
    assert '"st. dev.' not in told


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Height [cm];Fall time [ms];;;Mean\n50;330;310;320;320\n", ("row 1: column 3 has numbers and no name",)),
        (";Fall time [ms];;Mean\nHeight [cm];1;2;[ms]\n50;330;310;320\n", ("row 2: 'Height [cm]' names a column", "in one row")),
        ("Height [cm];1;2;3\n50;330;310;320\n", ("a number names no column", "Trial 1 (s)")),
    ],
)
def test_readings_below_no_name_are_not_passed_over(refused, text, words):
    refused(text, "csv", *words)


def test_the_numbers_of_rows_and_remarks_may_have_no_name(imported):
    """As a program writes them in the first column, and a hand in the last."""
    found, tables = imported(",height_m,fall_time_s,\n0,0.5,0.32,\n1,0.5,0.31,late?\n", "csv")
    assert tables["measurements.csv"] == {"height_m": ["0.5", "0.5"], "fall_time_s": ["0.32", "0.31"]}
    assert "column 1 is left out, it has no name" in str(found) and "column 4 is left out" in str(found)


def test_rebounds_that_fall_in_every_row_are_those_of_one_drop(imported):
    """Each by a tenth at least; repeats scatter by less, and in any order."""
    head = "drop height (cm),bounce height 1 (cm),bounce height 2 (cm),bounce height 3 (cm)\n"
    _, tables = imported(head + "80,51.5,33.0,21.0\n100,63.8,41.5,26.4\n120,76.3,49.4,31.7\n", "csv")
    (table,) = tables.values()
    assert table["bounce"] == ["1.0", "2.0", "3.0"] * 3 and table["rebound_height_m"][:3] == ["0.515", "0.33", "0.21"]
    _, tables = imported(head + "80,51.5,52.0,51.8\n100,63.8,64.5,63.4\n120,76.3,75.4,76.7\n", "csv")
    (table,) = tables.values()
    assert "bounce" not in table and len(table["rebound_height_m"]) == 9


def test_one_outcome_in_two_units_is_refused(refused):
    stated = {"Anna [cm]": "stop_distance_m", "Ben [m]": "stop_distance_m"}
    text = "speed_m_s,Anna [cm],Ben [m]\n1.0,17.2,0.171\n1.5,38.1,0.383\n2.0,68.2,0.679\n"
    refused(text, "csv", "row 1: 'Anna [cm]' and 'Ben [m]' are one outcome in two units", column=stated)


def test_rows_of_means_and_deviations_are_left_out(imported):
    text = "Person;Fallhöhe [m];Fallzeit [s]\nA;1,0;0,452\nB;1,0;0,458\nMittelwert;1,0;0,455\nStd.;1,0;0,004\nA;2,0;0,640\n"
    found, tables = imported(text, "csv")
    assert tables["measurements.csv"]["group"] == ["A", "B", "A"]
    assert any("2 rows computed of others, not read: left out (row 4, 5)" in str(each) for each in found.assumptions)


@pytest.mark.parametrize("name", ["bounce {} time (s)", "bounce time {} (s)", "bounce {} (s)"])
def test_times_of_bounces_are_known_wherever_their_number_stands(imported, name):
    head = ",".join(["drop height (cm)", *(name.format(k) for k in (1, 2))])
    _, tables = imported(f"{head}\n80,.403,1.05\n100,.452,1.17\n120,.495,1.28\n150,.553,1.44\n", "csv")
    (table,) = tables.values()
    assert table["bounce"] == ["1.0", "2.0"] * 4 and table["bounce_time_s"][:2] == ["0.403", "1.05"]


@pytest.mark.parametrize("word", ["SD", "media", "Error"])
def test_initials_and_levels_are_no_rows_of_means(imported, word):
    _, tables = imported(f"height_m,fall_time_s,student\n0.5,0.32,{word}\n0.5,0.33,B\n1.0,0.45,{word}\n", "csv")
    assert len(tables["measurements.csv"]["height_m"]) == 3


def test_units_of_two_names_are_one_unit(imported):
    text = "t1 (s),t2 (sec),drop height (m)\n0.45,0.46,1.0\n0.55,0.56,1.5\n"
    _, tables = imported(text, "csv", column={"t1 (s)": "fall_time_s", "t2 (sec)": "fall_time_s"})
    assert len(tables["measurements.csv"]["fall_time_s"]) == 4


@pytest.mark.parametrize(
    "text",
    [
        "distance (m),time (s)\n0.2,0.41\n0.2,0.41\n0.4,0.58\n0.4,0.60\n0.6,0.71\n0.6,0.71\n",
        "height (m),time (s)\n0.5,0.32\n0.5,0.32\n0.5,0.32\n1.0,0.45\n1.0,0.45\n1.0,0.46\n1.5,0.55\n1.5,0.55\n",
    ],
)
def test_times_that_are_read_twice_are_those_of_experiments(imported, text):
    found, _ = imported(text, "csv")
    assert found.kind == "outcomes"
