"""Outcome tables: one outcome, inputs within their bounds, repeated rows told."""

import numpy as np
import pytest

import hlcs
from hlcs.data.outcome_tables import read_table
from minibullet.errors import InputError


def test_outcome_tables(tmp_path):
    path = tmp_path / "o.csv"
    path.write_text("height_m,fall_time_s\n1,0.45\n1,0.46\n2,0.64\n")
    table = read_table(path)
    assert table.outcome == "fall_time_s" and table.setting.tolist() == [0, 0, 1] and not table.notes
    path.write_text("height_m,fall_time_s\n1,0.45\n1,0.45\n2,0.64\n")
    assert "digit for digit" in read_table(path).notes[0]
    path.write_text("height_m\n1\n1\n2\n")
    with pytest.raises(InputError, match="0 outcome columns"):
        read_table(path)


def test_repeats_by_chance_are_not_told(tmp_path, generator):
    """Ten times to 0.01 s that scatter by 0.03 s agree here and there; to 1e-6 s they do not, and one that does is a copy."""
    path, heights = tmp_path / "o.csv", np.repeat([1.0, 2.0], 10)
    times = np.sqrt(heights / 4.905) + 0.03 * generator.standard_normal(20)
    for digits in (2, 6):
        times[3] = times[4]
        path.write_text("height_m,fall_time_s\n" + "".join(f"{h},{t:.{digits}f}\n" for h, t in zip(heights, times, strict=True)))
        assert len(read_table(path).notes) == (digits == 6)


@pytest.mark.parametrize(
    ("columns", "values", "words"),
    [
        ("gravity_m_s2", -9.81, ("column gravity_m_s2", "between 0 and 300")),
        ("gravity_m_s2", 0, ("gravity is 0", "9.81")),
        ("restitution", 5, ("column restitution", "between 0 and 1")),
        ("friction", 31, ("column friction", "between 0 and 10")),
        ("fluid_viscosity_pa_s", 1e300, ("fluid_viscosity_pa_s",)),
        ("spin_rad_s", 1e12, ("spin_rad_s",)),
        ("slope", 20, ("column slope", "rise over run")),
        ("mass_kg", 1200, ("density", "units are kg and m")),
    ],
)
def test_an_input_of_a_table_has_the_bounds_of_the_file(tmp_path, columns, values, words):
    """The third row of the file is the wrong one: a comment stands above the header."""
    rows = "".join(f"{values},{fall}\n" for fall in ("1,0.45", "1,0.452", "2,0.64"))
    (tmp_path / "o.csv").write_text(f"# drops\n{columns},height_m,fall_time_s\n{rows}")
    (tmp_path / "o.toml").write_text(
        'kind = "outcomes"\n[body]\nshape = "sphere"\nradius = 0.05\nmass = 1.2\n[measurement]\nnoise = 0.003\nfile = "o.csv"\n'
    )
    with pytest.raises(InputError) as problem:
        hlcs.compare(tmp_path / "o.toml")
    for word in (*words, "o.csv, row 3"):
        assert word in str(problem.value)


def test_a_column_of_recordings_in_a_table_is_told_to_be_one(tmp_path):
    (tmp_path / "o.csv").write_text("z_m,fall_time_s\n1,0.45\n1,0.46\n2,0.64\n")
    with pytest.raises(InputError, match="unknown column 'z_m'; it stands in a recording, kind = .trajectory."):
        read_table(tmp_path / "o.csv")
