"""Recordings: what cannot be used is refused by file, row and column; lines may end in any way."""

import warnings

import numpy as np
import pytest
from experiments import TOML, experiment, measured, refused

from hlcs.data.recordings import read_recording
from minibullet.errors import InputError


def test_a_good_file_is_read(tmp_path):
    measurement = measured(experiment(tmp_path))
    assert measurement.trials[0].columns == ["z"] and measurement.file.body.mass == 0.05


@pytest.mark.parametrize(
    ("csv", "words"),
    [
        ("t_s,z_m\n0,1\n0.2,1\n0.1,1\n0.3,1\n", ("a.csv", "row 4", "t_s", "unsorted", "sort the rows")),
        ("t_s,z_m\n1,0\n0.9,0.1\n0.7,0.2\n0.3,0.3\n", ("row 3", "t_s", "z_m grows from row to row", "mixed up")),
        ("t_s,z_m\n0.3,0.3\n0.2,0.5\n0.1,0.6\n0,0.62\n", ("row 3", "t_s", "unsorted", "sort the rows")),
        ("t_s,z_m\n0,1\n0.1,1\n0.1,1\n0.3,1\n", ("row 4", "duplicate")),
        ("t_s,z_m\n0,1\n0.1,nan\n0.2,1\n", ("row 3", "z_m", "not finite", "blank")),
        ("t_s,z_m\n0,1\n0.1,inf\n0.2,1\n", ("row 3", "not finite")),
        ("t_s,z_m\n0,1\n0.1,one\n0.2,1\n", ("row 3", "not a number")),
        ("t_s,z_m\n0,1\n0.1\n", ("row 3: 1 cell for 2 columns (t_s, z_m); write what is missing",)),
        ("t_s,z_m\n0,1\n0.1,1,2\n", ("row 3: 3 cells for 2 columns (t_s, z_m); leave out what is too much",)),
        ("t_s,h_m\n0,1\n0.1,1\n", ("row 1", "h_m", "nearest")),
        ("t_s,z_m\n0,1\n0.1,1\n0.2,0.9\n", ("3 samples", "4 are needed")),
        ("t_s,qw,qx,qy,qz\n0,1,0,0,0\n0.1,0,0,0,0\n", ("row 3", "zero length")),
        ("t_s,qw,qx,qy\n0,1,0,0\n", ("qw, qx, qy, qz",)),
        ("t_s,z_m\n" + "".join(f"{0.1 * k},{1000 - 4905 * (0.1 * k) ** 2}\n" for k in range(9)), ("z_m", "units")),
        ("t_s;z_m\n0;1\n0,1;0,9\n", ("row 1", "semicolons", "commas", "or let hlcs import convert the file")),
        ("t_s,z_m\n0,1\n0.1,\x000.9\n", ("a.csv, line 3: a zero byte (NUL)", "UTF-8", "UTF-16")),
        ("t_s,z_m\n0,1\n", ("a.csv: 1 sample; a recording needs at least 2",)),
        ("t_s,z_m\n0,0,1,0\n0,1,0,9\n", ("row 2", "4 cells", "point")),
        ('t_s,z_m\n0,1\n"0,1",1\n', ("row 3", "t_s", "0,1", "point")),
        ("t_s,z_m,\n0,1,\n", ("row 1", "column 3", "comma")),
        ("t_s,z\n0,1\n", ("row 1", "'z'", "'z_m'")),
        ("t_s,z_m\n\0,1\n", ("line 2: a zero byte",)),
        ("t_s,y_m,z_m\n" + "".join(f"{0.1 * k},{9 - 0.049 * k * k},{0.2 * k}\n" for k in range(9)), ("y_m", "z_m", "mixed up")),
        ("t_s,z_m\n" + "".join(f"{0.1 * k},{4.9 * (0.1 * k) ** 2}\n" for k in range(9)), ("z_m", "falls upwards")),
        ("t_s,z_m\n" + "".join(f"{0.1 * k},{300 - 490 * (0.1 * k) ** 2}\n" for k in range(7)), ("z_m", "units")),
    ],
)
def test_bad_recordings_are_refused_by_row_and_column(tmp_path, csv, words):
    refused(experiment(tmp_path, csv=csv), *words)


@pytest.mark.parametrize(
    ("csv", "words"),
    [
        ('t_s,z_m\n0,1\n0.1,"1\n0.2,1\n', ("row 3", "quote", "not closed")),
        ("t_s,z_m\n0,1\n0.1," + "9" * 400 + "\n", ("row 3", "z_m", "not finite")),
        ("t_s,z_m\n0,1\n0.1," + "9" * 20_000 + "\n", ("row 3", "20,004 characters")),
        ("t_s,z_m" + ",x" * 3000 + "\n0,1\n", ("row 1", "unknown column 'x'")),
        ("t_s,height_m\n0,1\n", ("row 1", "unknown column 'height_m'", 'it stands in a table, kind = "outcomes"')),
        ("t_s,z_m\n0,1\n0.1,\x1b[31m1\n", ("row 3", r"'\x1b[31m1' is not a number")),
        ("\x1b[2Jt_s,z_m\n0,1\n", ("row 1", r"\x1b[2Jt_s")),
        ("t_s,z_m\n" + "0,1\n" * 200_001, ("200,002 lines", "200,000 rows")),
    ],
)
def test_what_is_no_table_is_refused_in_one_printable_line(tmp_path, csv, words):
    with pytest.raises(InputError) as problem:
        measured(experiment(tmp_path, csv=csv))
    message = str(problem.value)
    assert message.isprintable() and len(message) < 500 + len(str(tmp_path))
    for word in words:
        assert word in message, message


def test_lines_may_end_in_any_way_and_rows_are_lines_of_the_file(tmp_path):
    rows = ["# from the tracker", "t_s, z_m", "", '0,"1"', "0.1 , 1.1", "0.2,", ",", "0.3,0.9", "0.4,0.8"]
    found = []
    for end in ("\n", "\r\n", "\r"):
        (tmp_path / "a.csv").write_bytes(end.join(rows).encode())
        found.append(read_recording(tmp_path / "a.csv"))
    for times, position, _, _, places in found:
        assert times.tolist() == [0, 0.1, 0.2, 0.3, 0.4] and places.tolist() == [4, 5, 6, 8, 9]
        assert np.array_equal(position[:, 2], [1, 1.1, np.nan, 0.9, 0.8], equal_nan=True)


def test_an_experiment_holds_so_many_rows_in_all(tmp_path, monkeypatch):
    monkeypatch.setattr("hlcs.data.recordings.MOST_ROWS", 15)
    (tmp_path / "b.csv").write_text("t_s,z_m\n" + "".join(f"{0.1 * k:.1f},{1.1 - 0.05 * k * k:.4f}\n" for k in range(8)))
    refused(experiment(tmp_path, trial='file = "a.csv"\n[[trial]]\nfile = "b.csv"\n'), "more than 15 rows", "b.csv")


def test_a_number_with_an_underscore_is_not_another_number(tmp_path):
    """Python reads 0_95 as 95; a whole file of them would be one of another unit."""
    rows = "".join(f"{0.1 * k:.1f},{1 - 0.05 * k * k:.4f}\n" for k in range(8))
    refused(experiment(tmp_path, csv="t_s,z_m\n" + rows.replace("0.95", "0_95")), "row 3", "column z_m", "0_95")


def test_a_noise_of_nothing_that_was_recorded_is_refused(tmp_path):
    """Of heights alone a noise of the orientation says nothing; beside one of the position it may stand."""
    toml = 'kind = "trajectory"\n[body]\nshape = "sphere"\nradius = 0.03\nmass = 0.05\n[measurement]\nnoise = { %s }\n'
    words = ("line 7: measurement.noise: is of orientation", "hold position alone", "write noise = { position = .. [m] }")
    refused(experiment(tmp_path, toml=toml % "orientation = 0.01"), *words)
    assert measured(experiment(tmp_path, toml=toml % "orientation = 0.01, position = 0.01")).trials[0].columns == ["z"]


HEADER = "t_s,x_m,y_m,z_m,qw,qx,qy,qz\n"


def test_a_file_of_names_alone_is_one_line(tmp_path):
    """No column is told to be blank where there is no row: `warnings` turns every warning into an error."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        refused(experiment(tmp_path, csv=HEADER), "a.csv: 0 samples; a recording needs at least 2")


@pytest.mark.parametrize("count", [0, 1, 5, 19])
def test_a_body_at_rest_tells_at_once_how_many_samples_it_needs(tmp_path, count):
    path = experiment(tmp_path, toml=TOML.replace("noise = { position = 0.01 }", 'static = "rest.csv"'))
    (tmp_path / "rest.csv").write_text("t_s,z_m\n" + "".join(f"{k},1\n" for k in range(count)))
    refused(path, f"rest.csv: {count} sample{'s' * (count != 1)} at rest; at least 20 are needed to know the noise")


LIQUID = TOML.replace("0.03", "0.02") + "[surroundings]\nfluid_density = 1000.0\n"  # which weighs 0.0335 kg in its place


@pytest.mark.parametrize(
    ("mass", "speed", "pull", "told"),
    [
        (0.05, 0.1, 0.0, "rises"),  # at a steady speed, as one that sinks at its final speed does where depths are counted
        (0.05, -0.1, 0.0, ""),
        (0.05, 1.0, -2.4, ""),  # thrown upwards: slows down by its weight less the lift, and the water that it carries along
        (0.001, -0.1, 0.0, "sinks"),
        (0.001, 0.1, 0.0, ""),
    ],
)
def test_a_body_goes_the_way_of_its_weight_in_the_liquid(tmp_path, mass, speed, pull, told):
    rows = "".join(f"{0.01 * k},{speed * 0.01 * k + pull / 2 * (0.01 * k) ** 2:.6f}\n" for k in range(15))
    toml = LIQUID.replace("mass = 0.05", f"mass = {mass}")
    assert f"mass = {mass}" in toml
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        measured(experiment(tmp_path, "t_s,z_m\n" + rows, toml))
    words = [str(one.message) for one in seen if "does not slow down" in str(one.message)]
    assert len(words) == bool(told) and all(told in one and "--up -z" in one for one in words)


@pytest.mark.parametrize(
    ("more", "column", "told"), [("", "x_m", 1), ("", "z_m", 0), ("[surroundings]\nfloor.height = 0.0\n", "x_m", 0)]
)
def test_a_body_without_a_height_or_a_floor_is_told_to_fall(tmp_path, more, column, told):
    """A ball on a track before a motion detector, 1.4 s: 4.905 1.4^2 = 9.61 m of fall that nobody saw."""
    rows = "".join(f"{0.1 * k:.1f},{0.3 * (0.1 * k) ** 2:.4f}\n" for k in range(15))
    if column == "z_m":
        rows = rows.replace(",0.", ",-0.")
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        measured(experiment(tmp_path, f"t_s,{column}\n" + rows, TOML + more))
    words = [str(one.message) for one in seen if "taken to fall freely, 9.61 m in 1.4 s" in str(one.message)]
    assert len(words) == told and all("surroundings.floor" in one and "name it z_m" in one for one in words)
