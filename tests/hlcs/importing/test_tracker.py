"""Tracker's text export: one mass, several masses, every way to separate columns, and what is not of the format."""

import pytest

# as ExportDataDialog writes it: the row of names begins with the separator, rows of columns end with it
ONE = "\tmass A\t\n t\tx\ty\t\n0.000E0\t1.00E-1\t1.50E2\n1.000E-1\t1.10E-1\t1.451E2\n2.000E-1\t\t\n3.000E-1\t1.30E-1\t1.0585E2\n"
TWO = (
    "#multi:\n,cm A,,cm B,,\nt,x,y,x,y,\n0.0,0.1,1.5,,,\n0.1,0.1,1.45,0.2,1.5,\n"
    "0.2,,,0.2,1.45,\n0.3,0.1,1.06,0.2,1.30,\n0.4,,,0.2,1.06,\n"
)
OLD = (
    "cm_A\nt                x               y\n"
    "0.000000000E0    1.245986911E1   -1.328191643E1\n3.2E-2   1.164289057E1   -1.262051106E1\n"
)


def test_y_of_the_video_is_the_height_and_lengths_are_what_the_user_says(imported):
    """1.5e2 cm are 1.5 m, digit for digit; the frame without a mark stays blank; y, the way to the camera, is not invented."""
    found, tables = imported({"drop.txt": ONE}, "tracker", length_unit="cm")
    assert tables == {
        "drop.csv": {
            "t_s": ["0.0", "0.1", "0.2", "0.3"],
            "x_m": ["0.001", "0.0011", "", "0.0013"],
            "z_m": ["1.5", "1.451", "", "1.0585"],
        }
    }
    told = str(found)
    assert "1 sample of 'drop' was lost" in told and "[--up]" in told and "[--frame-rate]" in told


def test_without_a_word_lengths_are_metres_and_that_is_told(imported):
    found, tables = imported({"drop.txt": ONE}, "tracker")
    assert tables["drop.csv"]["z_m"][0] == "150.0"
    assert "lengths in m: the file names no unit  [--length-unit]" in str(found)
    assert "lengths in m: the file names no unit  [--length-unit]" in found.experiment.read_text()


def test_masses_side_by_side_are_recordings_each_from_its_first_mark_to_its_last(imported):
    found, tables = imported(TWO, "tracker")
    assert tables["drop_cm_A.csv"] == {
        "t_s": ["0.0", "0.1", "0.2", "0.3"],
        "x_m": ["0.1", "0.1", "", "0.1"],
        "z_m": ["1.5", "1.45", "", "1.06"],
    }
    assert tables["drop_cm_B.csv"]["t_s"] == ["0.1", "0.2", "0.3", "0.4"]
    assert tables["drop_cm_B.csv"]["z_m"] == ["1.5", "1.45", "1.3", "1.06"]
    assert "1 row before the first or after the last sample of 'drop cm B' is left out" in str(found)


def test_one_of_several_masses_can_be_taken(imported, refused):
    _, tables = imported(TWO, "tracker", only=("cm B",))
    assert list(tables) == ["drop_cm_B.csv"]
    refused(TWO, "tracker", "no 'cm C' in it", "'cm A', 'cm B'", only=("cm C",))


@pytest.mark.parametrize(
    "text",
    [
        ONE,
        ONE.replace("\t", ","),
        ONE.replace("\t", ";").replace(".", ","),
        ONE.replace("\n", "\r\n"),
        ONE.replace("\t", " ").replace(".", ",").replace("  ", " nan "),
        ONE.split("\n", 1)[1],  # the table copied without its row of names
        "\ufeff" + ONE,
    ],
    ids=["tabs", "commas", "semicolons and decimal commas", "Windows", "blanks and decimal commas", "copied", "marked UTF-8"],
)
def test_any_separator_any_decimals_any_line_end_are_the_same_recording(imported, text):
    _, tables = imported({"drop.txt": text}, "tracker")
    assert tables["drop.csv"]["t_s"] == ["0.0", "0.1", "0.2", "0.3"]
    assert tables["drop.csv"]["z_m"] == ["150.0", "145.1", "", "105.85"]


def test_columns_may_be_separated_by_blanks(imported):
    _, tables = imported({"drop.txt": OLD}, "tracker")
    assert tables["drop.csv"] == {
        "t_s": ["0.0", "0.032"],
        "x_m": ["12.45986911", "11.64289057"],
        "z_m": ["-13.28191643", "-12.62051106"],
    }


def test_the_true_frame_rate_replaces_times_of_a_slow_motion_video(imported, refused):
    """Frames 10, 12, 14 of a video taken at 240 pictures a second are 1/120 s apart, whatever t says."""
    text = ",A,,,\nt,frame,x,y,\n" + "".join(f"{k / 15},{10 + 2 * k},0.1,{1 - 0.01 * k},\n" for k in range(3))
    _, tables = imported(text, "tracker", frame_rate=240.0)
    assert [float(t) for t in tables["drop.csv"]["t_s"]] == pytest.approx([10 / 240, 12 / 240, 14 / 240], rel=1e-11)
    refused({"a.txt": ONE}, "tracker", "a.txt, row 2", "no column 'frame', which --frame-rate needs", frame_rate=240.0)


def test_seen_from_above_y_is_not_the_height(imported):
    found, tables = imported({"drop.txt": ONE}, "tracker", up="none")
    assert list(tables["drop.csv"]) == ["t_s", "x_m", "y_m"]
    assert "planar = true" in found.experiment.read_text()


def test_other_columns_of_a_mass_are_not_mistaken_for_its_position(imported):
    text = "\tmass A\t\t\t\t\nt\tx\ty\tv\tpixelx\n0\t1\t2\t9\t500\n1\t1\t3\t9\t501\n"
    found, tables = imported(text, "tracker")
    assert tables["drop.csv"] == {"t_s": ["0.0", "1.0"], "x_m": ["1.0", "1.0"], "z_m": ["2.0", "3.0"]}
    assert "left out, t, x and y are read alone: v, pixelx" in str(found)


def test_a_mass_with_times_of_its_own_keeps_them(imported):
    """Tables put side by side by hand: the column t before a mass is its clock."""
    _, tables = imported(",A,,,B,,\nt,x,y,t,x,y,\n0,1,2,5,3,4,\n0.1,1,2,5.2,3,4,\n", "tracker")
    assert tables["drop_A.csv"]["t_s"] == ["0.0", "0.1"] and tables["drop_B.csv"]["t_s"] == ["5.0", "5.2"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("height,clock\n1,2\n", ["drop.csv, row 1: begins with 'height'", "row of columns: t, x, y"]),
        (",A,,\nt,x,y,\n1,0,1,1,2,1\n", ["drop.csv, row 3: 6 cells below 4 names; where decimals have a comma"]),
        (",A,,\nt,vx,vy,\n0,1,2,\n", ["drop.csv, row 2: columns t, vx, vy; x or y is needed"]),
        ("t,x,y,x,y\n0,1,2,3,4\n", ["drop.csv, row 1: column x stands twice", "names of the tracks"]),
        (",A,,\nt,x,y,\n0,1,2,\n0,1,3,\n", ["drop.csv, row 4, column t: 0 s after 0 s: the same time twice"]),
        (",A,,\nt,x,y,\n0,1,2,\n0.2,1,3,\n0.1,1,3,\n", ["drop.csv, row 5, column t: 0.1 s after 0.2 s: time goes backwards"]),
        (",A,,\nt,x,y,\n0,1,2,\n,1,3,\n", ["drop.csv, row 4, column t: blank; every sample needs its time"]),
        (
            ",A,,\nt,x,y,\n0,1,two,\n1,1,3,\n",
            ["drop.csv, row 3, column y of A: 'two' is not a number; write a number, or leave a missing sample blank"],
        ),
        (",A,,\nt,x,y,\n0,1,inf,\n1,1,3,\n", ["drop.csv, row 3, column y of A: 'inf' is not finite"]),
        (",A,,\nt,x,y,\n0,1,2,\n1,,,\n", ["drop.csv: 1 sample of 'drop'; a recording needs at least 2"]),
        (
            ",A,,\nt,x (furlong),y,\n0,1,2,\n1,1,2,\n",
            ["column x (furlong): 'furlong' is not known as a unit of length; known are m,"],
        ),
        ("", ["drop.csv: is empty"]),
        (",A,,\nt,x,y,\n", ["drop.csv: 0 rows of numbers below its names"]),
        (b"PK\x03\x04abc", ["drop.csv: is an Excel workbook or a zip archive, not text; export it as CSV"]),
        (b"\x81\x00\x02t,x,y", ["drop.csv: is not text"]),
    ],
)
def test_what_is_no_export_of_tracker_is_refused_with_its_row(refused, text, words):
    refused(text, "tracker", *words)


def test_times_of_a_clock_count_from_the_first_sample(imported):
    rows = "".join(f"{1717243200 + k / 60:.6f}\t0.1\t{1 - 0.01 * k}\n" for k in range(4))
    _, tables = imported({"drop.txt": ",A,,\n".replace(",", "\t") + "t\tx\ty\n" + rows}, "tracker")
    assert [float(t) for t in tables["drop.csv"]["t_s"]] == pytest.approx([k / 60 for k in range(4)], abs=2e-6)
