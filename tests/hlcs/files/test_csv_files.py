"""CSV files: what is said of one that cannot be used."""

import pytest

import hlcs
from hlcs.data.outcome_tables import read_table
from hlcs.files.csv_files import CsvText


def test_a_complaint_on_an_empty_table_is_one_short_line():
    """A table may have dozens of columns: the first, the last and their number are enough."""
    with pytest.raises(hlcs.InputError, match=r"is empty; the first row names the columns height_m, \.\., range_m") as told:
        read_table(CsvText("t.csv", ""))
    assert len(str(told.value)) < 130


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "1,0.45\n1.5,0.55\n",
            "t.csv, row 1: numbers, '1, 0.45', where the names of the columns stand: write above them height_m, ..",
        ),
        (
            "height_m,fall_time_s\n1,0.45\n1e300,0.55\n",
            "t.csv, row 3, column height_m: '1e300'; nothing that is measured is beyond 1e+12 in SI units: correct it",
        ),
    ],
)
def test_a_table_without_names_and_a_cell_that_cannot_be_are_told_by_their_row(text, told):
    with pytest.raises(hlcs.InputError) as problem:
        read_table(CsvText("t.csv", text))
    assert told in str(problem.value)


def test_a_workbook_that_is_called_a_table_is_told_to_be_one(tmp_path):
    (tmp_path / "t.csv").write_bytes(b"PK\x03\x04" + bytes(100))
    with pytest.raises(hlcs.InputError, match="is an Excel workbook or a zip archive, not text; export it as CSV"):
        read_table(tmp_path / "t.csv")
