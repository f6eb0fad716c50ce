"""Exports of phyphox: sets of data as its own experiments name them, in every CSV flavour, as file, zip and folder."""

import io
import tomllib
import zipfile

import numpy as np
import pytest

import hlcs

RAW = '"Time (s)","{0}Acceleration x (m/s^2)","{0}Acceleration y (m/s^2)",'
RAW += '"{0}Acceleration z (m/s^2)","Absolute acceleration (m/s^2)"\n'
ROWS = "5.000000000E-3,1.000000000E-1,-2.000000000E-1,9.800000000E0,9.8E0\n1.500000000E-2,NaN,NaN,NaN,NaN\n"
ROWS += "2.500000000E-2,0.0E0,0.0E0,-1.0E0,1.0E0\n"
ALL = '"Event time (s)","Interval (s)"\n1.250000000E0,4.000000000E-1\n1.650000000E0,6.400000000E-1\n2.290000000E0,0.0E0\n'
MULTIPLE = '"Start (s)","Stop 1 (s)","Stop 2 (s)","Stop 3 (s)"\n1.25E0,1.65E0,2.29E0,NaN\n'
SIMPLE = '"Start (s)","Stop (s)","Difference (s)"\n1.25E0,1.65E0,4.0E-1\n'
COLLISION = '"Bounce 0 (s)","Height 0 (m)","Bounce 1 (s)","Height 1 (m)","Energy 1"\n2.5E0,8.0E-1,3.1E0,4.5E-1,5.6E1\n'


def zipped(members):
    """A zip with these {name: text}."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in members.items():
            archive.writestr(name, text)
    return stream.getvalue()


META = {"meta/device.csv": '"property","value"\n"version","1.1"\n', "meta/time.csv": '"event","experiment time"\n"START",0\n'}


def test_what_an_accelerometer_reads_stays_in_the_axes_of_the_phone(imported):
    found, tables = imported(RAW.format("") + ROWS, "phyphox")
    assert tables["drop.csv"] == {
        "t_s": ["0.005", "0.015", "0.025"],
        "ax_m_s2": ["0.1", "", "0.0"],
        "ay_m_s2": ["-0.2", "", "0.0"],
        "az_m_s2": ["9.8", "", "-1.0"],
    }
    written = found.experiment.read_text()
    assert 'accelerometer = "body"' in written and "noise.acceleration = " in written and "axes of the phone" in str(found)


def test_a_linear_acceleration_gets_back_the_gravity_that_the_phone_took_out(imported):
    """9.80665 m/s2 is the standard gravity that both systems subtract; at rest an accelerometer reads it upwards."""
    found, tables = imported(RAW.format("Linear ") + ROWS, "phyphox")
    assert tables["drop.csv"]["az_m_s2"] == ["19.60665", "", "8.80665"] and tables["drop.csv"]["ax_m_s2"][0] == "0.1"
    assert 'accelerometer = "world"' in found.experiment.read_text() and "[--up]" in str(found)


def test_the_axis_of_the_phone_that_points_up_becomes_z(imported):
    """y up is the turn by +90 degrees about x: (x, y, z) -> (x, -z, y)."""
    _, tables = imported(RAW.format("Linear ") + ROWS, "phyphox", up="y")
    assert [tables["drop.csv"][name][0] for name in ("ax_m_s2", "ay_m_s2", "az_m_s2")] == ["0.1", "-9.8", "9.60665"]


@pytest.mark.parametrize(("separator", "decimal"), [(",", "."), ("\t", "."), (";", "."), ("\t", ","), (";", ",")])
def test_the_five_flavours_of_csv_are_the_same_recording(imported, separator, decimal):
    text = "\n".join(
        separator.join(cell.replace(".", decimal) for cell in line.split(",")) for line in (RAW.format("") + ROWS).split("\n")
    )
    _, tables = imported(text, "phyphox")
    assert tables["drop.csv"]["ay_m_s2"] == ["-0.2", "", "0.0"]


def test_sounds_of_a_stopwatch_are_bounces_since_the_first_sound(imported):
    """1.25 s is the release, 1.65 and 2.29 s are bounces: 0.40 and 1.04 s after it."""
    for text in (ALL, MULTIPLE):
        found, tables = imported(text, "phyphox", constant={"height_m": 0.8})
        assert tables == {
            "bounces.csv": {
                "height_m": ["0.8", "0.8"],
                "bounce": ["1.0", "2.0"],
                "bounce_time_s": ["0.4", "1.04"],
                "group": ["drop", "drop"],
            }
        }
        assert "first sound is the release" in str(found) and 'kind = "outcomes"' in found.experiment.read_text()
    assert "1 sounds were not heard" in str(found)


def test_a_height_nobody_stated_is_to_be_filled_in_row_by_row(imported):
    found, tables = imported(SIMPLE, "phyphox")
    assert tables["bounces.csv"]["height_m"] == ["fill in"]
    assert [(place.file, place.line, place.key) for place in found.fill_in][-1] == ("bounces.csv", 2, "height_m")


def test_impacts_alone_are_timed_from_one_to_the_next_or_from_a_release_that_is_stated(imported, refused):
    found, tables = imported(COLLISION, "phyphox", constant={"height_m": 1.25})
    assert tables["bounces.csv"]["bounce"] == ["1.0"] and tables["bounces.csv"]["bounce_interval_s"] == ["0.6"]
    assert "the release made none" in str(found) and "[--release-time]" in str(found)
    _, tables = imported(COLLISION, "phyphox", release_time=2.1)
    assert tables["bounces.csv"]["bounce_time_s"] == ["0.4", "1.0"]
    refused(COLLISION, "phyphox", "not in order after the release at 2.7 s; check --release-time", release_time=2.7)


def test_a_name_in_quotes_is_one_column_also_where_it_is_the_only_one(imported):
    """Nothing but the blanks in its name could separate columns then, and what is quoted separates nothing."""
    _, tables = imported('"Event time (s)"\n1.25E0\n1.65E0\n2.29E0\n', "phyphox", constant={"height_m": 0.8})
    assert tables["bounces.csv"]["bounce_time_s"] == ["0.4", "1.04"]


def test_several_drops_are_one_table_with_a_group_each(imported):
    _, tables = imported({"a.csv": ALL, "b.csv": ALL.replace("1.65", "1.66")}, "phyphox")
    assert tables["bounces.csv"]["group"] == ["a", "a", "b", "b"]
    assert tables["bounces.csv"]["bounce_time_s"] == ["0.4", "1.04", "0.41", "1.04"]


def test_a_zip_and_its_folder_are_read_without_their_metadata(imported, tmp_path):
    members = {"Simple.csv": SIMPLE, "Multiple.csv": MULTIPLE, "All.csv": ALL, **META}
    found, tables = imported({"drop.zip": zipped(members)}, "phyphox")
    assert tables["bounces.csv"]["bounce_time_s"] == ["0.4", "1.04"] and tables["bounces.csv"]["group"] == ["drop", "drop"]
    assert "drop.zip/All.csv is read; left out: drop.zip/Simple.csv, drop.zip/Multiple.csv" in str(found)
    (tmp_path / "unpacked" / "meta").mkdir(parents=True)
    for name, text in members.items():
        (tmp_path / "unpacked" / name).write_text(text)
    again = hlcs.import_measurements(tmp_path / "unpacked", "phyphox", tmp_path / "other")
    assert (tmp_path / "other" / "bounces.csv").read_text().replace("unpacked", "drop") == (
        tmp_path / "out" / "bounces.csv"
    ).read_text()
    assert again.files["bounces.csv"] == found.files["bounces.csv"]


@pytest.mark.parametrize(
    ("files", "words"),
    [
        ({"g.csv": '"Time (s)","Gyroscope x (rad/s)"\n0,1\n'},
         ["g.csv, row 1: Time (s), Gyroscope x (rad/s)", "nothing of phyphox that can be compared; expected Time (s) with"]),
        ({"d.zip": zipped(META)}, ["d.zip: holds no .csv"]),
        ({"d.zip": zipped({"xl/workbook.xml": "<x/>"})}, ["d.zip: is an Excel workbook; choose one of the CSV formats"]),
        ({"d.zip": zipped({"All.csv": ALL})[:60]}, ["d.zip: cannot be unpacked", "export it again as CSV"]),
        ({"d.xls": b"\xd0\xcf\x11\xe0\xa1\xb1"}, ["d.xls: is an old Excel workbook, not text"]),
        ({"d.csv": '"Event time (s)","Interval (s)"\n'}, ["d.csv: no sound of a bounce; at least two sounds are needed"]),
        ({"d.csv": '"Event time (s)","Interval (s)"\n1,0\nx,1\n'}, ["d.csv, row 3, column Event time (s): 'x' is not a number"]),
        ({"d.csv": '"Start (s)","Stop (s)"\n'}, ["d.csv, row 1: no row of times below it"]),
        ({"d.csv": '"Start (s)","Stop (s)"\n2.0,1.0\n'}, ["d.csv: the sounds are not in order after the release at 2 s"]),
        ({"d.csv": RAW.format("") + "0,1,2,3,4\n0,1,2,3,4\n"},
         ["d.csv, row 3, column Time (s): 0 s after 0 s: the same time twice"]),
        ({"d.csv": '"Start (s)","Stop (s)"\n1.0,2.0\n1.0,2.5\n'}, ["d.csv, row 3: a second row of times; give each drop a file"]),
        ({"d.csv": '"Time (s)","Acceleration x (m/s^2)"\n1,00,1,1\n2,00,3,3\n'}, ["d.csv, row 2: 4 cells below 2 names"]),
        ({"d.csv": '"Time (s)","Acceleration x (m/s^2)","Time (s)","Acceleration x (m/s^2)"\n0,1,0,2\n'},
         ["d.csv, row 1: column 'Time (s)' stands twice; give each recording a file of its own"]),
        ({"d.csv": '"Time (s)","Acceleration x (kn/h)"\n0,1\n'},
         ["column Acceleration x (kn/h): 'kn/h' is not known as a unit of acceleration"]),
    ],
)  # fmt: skip
def test_what_is_no_export_of_phyphox_is_refused(refused, files, words):
    refused(files, "phyphox", *words)


def test_a_zip_that_unpacks_to_more_than_a_csv_may_hold_is_refused_unread(refused, monkeypatch):
    monkeypatch.setattr("hlcs.importing.phyphox.MOST_BYTES", 1000)
    refused({"d.zip": zipped({"All.csv": ALL + "0,0\n" * 1000})}, "phyphox", "d.zip: unpacks to more than 100 files or 0.001 MB")


def readings(up, flight=0):
    """A raw export: gravity along a direction (3,) for 20 samples, then next to nothing for some."""
    rows = [[9.81 * part for part in up]] * 20 + [[-0.3, 0.1, 0.2]] * flight
    return RAW.format("") + "".join(f"{k / 100:.6E},{x:.6E},{y:.6E},{z:.6E},9.8E0\n" for k, (x, y, z) in enumerate(rows))


@pytest.mark.parametrize(
    ("up", "said", "turn"),
    [
        ((0.09, 0.0, 1.0), "the z axis", (1.0, 0.0, 0.0, 0.0)),
        ((0.0, 1.0, 0.0), "the y axis", (np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0)),
        ((-1.0, 0.0, 0.0), "the -x axis", (np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0)),
    ],
)
def test_the_axis_along_which_a_phone_reads_gravity_points_up(imported, up, said, turn):
    """The turn that brings that axis to z; 0.09 of gravity along another one are an offset, or 5 degrees."""
    found, _ = imported(readings(up), "phyphox")
    start = tomllib.loads(found.experiment.read_text())["trial"][0]["start"]
    assert f"{said} of the phone points up" in str(found) and start["angular_velocity"] == [0.0] * 3
    np.testing.assert_allclose(start["orientation"], turn, atol=1e-9)


def test_what_is_assumed_of_several_zips_is_told_once(imported):
    zips = {f"fall {k}.zip": zipped({"Raw Data.csv": readings((0.0, 0.0, 1.0), 60), **META}) for k in (1, 2)}
    told = str(imported(zips, "phyphox")[0])
    assert told.count("the phone flies") == told.count("points up at the start") == 1 and "all 2 files: the phone flies" in told


def test_where_no_axis_points_up_the_attitude_is_asked_for(imported):
    found, _ = imported(readings((0.6, 0.0, 0.8)), "phyphox")
    assert "of the phone points up" not in str(found) and "trial.start.orientation" in [place.key for place in found.fill_in]


@pytest.mark.parametrize(("flight", "said"), [(0, "lies or slides on a floor"), (8, "lies or slides"), (60, "the phone flies")])
def test_a_phone_tells_by_gravity_whether_it_lies_or_flies(imported, flight, said):
    """At 100 readings a second; what rattles over a floor jumps for some hundredths of a second."""
    found, _ = imported(readings((0.0, 0.0, 1.0), flight), "phyphox")
    floor = tomllib.loads(found.experiment.read_text())["surroundings"].get("floor")
    assert said in str(found) and floor == (None if flight == 60 else {"height": 0.0})
