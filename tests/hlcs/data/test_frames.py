"""A frame in memory is read as the CSV file of the same numbers, and refused in the same words."""

import numpy as np
import pandas as pd
import pytest

from hlcs.data.frames import csv_of, frames_in, is_frame
from hlcs.files.csv_files import CsvLayout, read_csv
from minibullet.errors import InputError

LAYOUT = CsvLayout(("t_s", "z_m", "group"), ("t_s",), words=("group",), blank=("z_m",))
TIMES, HEIGHTS, GROUPS = [0.1, 0.2, 1 / 3], [1.0, None, 3.0], ["a", "b, c", 'd "e"']
COLUMNS = {"t_s": TIMES, "z_m": HEIGHTS, "group": GROUPS}
RECORDS = np.array(
    [(0.1, 1.0, "a"), (0.2, np.nan, "b, c"), (1 / 3, 3.0, 'd "e"')], [("t_s", float), ("z_m", float), ("group", "U9")]
)


@pytest.mark.parametrize("frame", [COLUMNS, pd.DataFrame(COLUMNS), RECORDS], ids=["dictionary", "pandas", "structured array"])
def test_every_digit_word_and_gap_comes_back(frame):
    table = read_csv(csv_of(frame, "frame 1"), LAYOUT)
    np.testing.assert_array_equal(table.columns["t_s"], TIMES)
    np.testing.assert_array_equal(table.columns["z_m"], [1.0, np.nan, 3.0])
    assert list(table.columns["group"]) == GROUPS and table.place(2, "z_m") == "frame 1, row 2, column z_m"


@pytest.mark.parametrize(
    ("frame", "words"),
    [
        ([1.0, 2.0], "frame 1: list has no columns by name; give a pandas frame"),
        ({"t_s": [0.0, 1.0], "z_m": [1.0]}, "frame 1: columns of different lengths .t_s 2, z_m 1."),
        ({"t_s": [0.0, 1.0], "z_m": np.zeros((2, 3))}, r"frame 1, column z_m: has shape \(2, 3\)"),
        ({"t_s": [0.0, np.inf]}, "frame 1, row 1, column t_s: 'inf' is not finite"),
        ({"t_s": [0.0, None], "z_m": [1.0, 2.0]}, "frame 1, row 1, column t_s: blank"),
        ({"time": [0.0]}, "frame 1: unknown column 'time'"),
        ({"t_s": pd.to_datetime([0, 1], unit="s")}, "frame 1, column t_s: dates; give the seconds since the first"),
    ],
)
def test_what_is_no_table_is_refused(frame, words):
    with pytest.raises(InputError, match=words):
        read_csv(csv_of(frame, "frame 1"), LAYOUT)


def test_a_row_is_named_as_the_index_of_its_frame_names_it():
    """Whole numbers that differ; where they are none, or do not tell rows apart, rows count from 0. No names stand in a row."""
    bad = {"t_s": [0.0, 0.1, 0.2, "x"]}
    for frame, row in (
        (bad, 3),
        (pd.DataFrame(bad), 3),
        (pd.DataFrame(bad, index=[7, 5, 6, 40]), 40),
        (pd.DataFrame(bad, index=[0, 1, 0, 1]), 3),
        (pd.DataFrame(bad, index=["a", "b", "c", "d"]), 3),
    ):
        with pytest.raises(InputError, match=f"frame 1, row {row}, column t_s: 'x' is not a number"):
            read_csv(csv_of(frame, "frame 1"), LAYOUT)


def test_one_value_stands_in_every_row_and_values_alone_are_one_row():
    """A number or a word in place of a column is that column with the same in every row: the same text."""
    constant = csv_of({"t_s": TIMES, "z_m": 2.0, "group": "a"}, "frame 1")
    assert constant.text == csv_of({"t_s": TIMES, "z_m": [2.0] * 3, "group": ["a"] * 3}, "frame 1").text
    assert csv_of({"t_s": 0.5, "z_m": np.float64(2.0)}, "frame 1").text == "t_s,z_m\n0.5,2.0\n"
    with pytest.raises(InputError, match="frame 1: columns of different lengths .t_s 3, z_m 1."):  # a list of one is a column
        csv_of({"t_s": TIMES, "z_m": [2.0]}, "frame 1")


def test_a_list_of_frames_is_no_frame():
    assert is_frame(COLUMNS) and is_frame(RECORDS) and not is_frame([COLUMNS]) and not is_frame(np.zeros(3))


GAP = {  # a second height that was not measured, in the words of each library
    "nullable": pd.array([1.0, pd.NA, 3.0], dtype="Float64"),
    "whole": pd.array([1, pd.NA, 3], dtype="Int64"),
    "text": pd.array(["1.0", pd.NA, "3"], dtype="string"),
    "objects": [1.0, pd.NaT, 3.0],
    "masked": np.ma.array([1.0, 999.0, 3.0], mask=[False, True, False]),
}


@pytest.mark.parametrize("heights", GAP.values(), ids=GAP)
def test_every_mark_of_a_missing_value_is_a_blank(heights):
    for frame in ({"t_s": TIMES, "z_m": heights}, pd.DataFrame({"t_s": TIMES, "z_m": heights})):
        np.testing.assert_array_equal(read_csv(csv_of(frame, "frame 1"), LAYOUT).columns["z_m"], [1.0, np.nan, 3.0])


def test_durations_are_seconds():
    spans = pd.to_timedelta([100, 250], unit="ms")
    for times in (spans, spans.to_numpy(), spans.astype(object), [span.to_pytimedelta() for span in spans]):
        np.testing.assert_allclose(read_csv(csv_of({"t_s": times}, "frame 1"), LAYOUT).columns["t_s"], [0.1, 0.25], rtol=1e-12)


def test_a_frame_has_no_comments():
    """A name that begins with # does not hide its row, in memory and in the file that is written of it."""
    text = csv_of({"group": ["#1", "b"], "t_s": [0.0, 1.0]}, "frame 1")
    assert list(read_csv(text, LAYOUT).columns["group"]) == ["#1", "b"]


def test_a_dictionary_of_series_is_a_frame_and_groups_of_one_are_frames():
    frame = pd.DataFrame({"t_s": [0.0, 0.1, 0.0, 0.1], "z_m": [1.0, 0.95, 2.0, 1.95], "run": [1, 1, 2, 2]})
    assert len(frames_in({"t_s": frame["t_s"], "z_m": frame["z_m"]})) == 1
    assert len(frames_in(frame.groupby(lambda row: row // 2))) == 2
    first, second = frames_in(frame.groupby("run"))
    assert first["z_m"].tolist() == [1.0, 0.95] and second["z_m"].tolist() == [2.0, 1.95]


def test_days_and_years_may_be_groups():
    days = csv_of({"t_s": [0.0, 1.0], "group": pd.to_datetime(["2024-06-01", "2024-06-02"])}, "frame 1")
    assert [row.split(",")[1] for row in days.text.split()[1:]] == ["2024-06-01", "2024-06-02"]
    assert csv_of({"t_s": [0.5], "group": np.array([2024])}, "frame 1").text == "t_s,group\n0.5,2024\n"


def test_a_column_that_stands_twice_is_named():
    frame = pd.DataFrame([[0.0, 1.0, 1.0], [0.1, 0.9, 0.9]], columns=["t_s", "z_m", "z_m"])
    with pytest.raises(InputError, match="frame 1, column z_m: stands twice"):
        csv_of(frame, "frame 1")
