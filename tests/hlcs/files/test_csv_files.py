"""CSV files: what is said of one that cannot be used."""

import pytest

import hlcs
from hlcs.data.outcome_tables import read_table
from hlcs.files.csv_files import CsvText


def test_a_complaint_on_an_empty_table_is_one_short_line():
    """A table may have dozens of columns: the first, the last and their number are enough."""
    with pytest.raises(
        hlcs.InputError, match=r"is empty; the first row names the columns height_m, \.\., rebound_speed_m_s"
    ) as told:
        read_table(CsvText("t.csv", ""))
    assert len(str(told.value)) < 130
