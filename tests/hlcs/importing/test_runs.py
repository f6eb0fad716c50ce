"""Runs beside one another, named as Vernier's and PASCO's programs name them: each is a recording of its own."""

import pytest

FALL = [("0.0", "1.5"), ("0.1", "1.451"), ("0.2", "1.304"), ("0.3", "1.059")]
WANTED = {"t_s": [t for t, _ in FALL], "z_m": [z for _, z in FALL]}


def beside(name, rows=FALL, shorter=FALL[:3]):
    """Two runs beside one another, the second one sample shorter; name: of a column, from its run and what it holds."""
    head = [name(run, what) for run in (1, 2) for what in ("Time (s)", "Height (m)", "Velocity (m/s)")]
    below = [",".join([*row, "0", *(shorter[k] if k < len(shorter) else ("", "")), ""]) for k, row in enumerate(rows)]
    return ",".join(head) + "\n" + "\n".join(below) + "\n"


@pytest.mark.parametrize(
    "name", [lambda run, what: f"Run {run}: {what}", lambda run, what: f'"{what} Run #{run}"'], ids=["Logger Pro", "Capstone"]
)
def test_each_run_is_a_recording(imported, name):
    found, tables = imported(beside(name), "csv")
    first, second = tables.values()
    assert len(tables) == 2 and first == WANTED and second == {key: cells[:3] for key, cells in WANTED.items()}
    told = str(found)
    assert "2 runs stand beside one another, a recording each" in told and told.count("'Velocity (m/s)' is left out") == 1


def test_one_run_is_called_as_its_file(imported):
    text = "Latest: Time (s),Latest: Height (m)\n" + "\n".join(map(",".join, FALL))
    found, tables = imported(text, "csv")
    assert tables == {"drop.csv": WANTED} and "beside one another" not in str(found)


def test_what_the_user_says_of_a_bare_name_holds_in_every_run(imported, refused):
    """A motion detector reads distances: whether these are heights no file says."""
    text = beside(lambda run, what: f"Run {run}: {what.replace('Height', 'Position')}")
    refused(text, "csv", '--column "Position (m)=z_m"')
    assert list(imported(text, "csv", column={"Position (m)": "z_m"})[1].values())[0] == WANTED
    said = {f"Run {run}: Position (m)": "z_m" for run in (1, 2)}
    assert list(imported(text, "csv", column=said)[1].values())[0] == WANTED
    refused(text, "csv", "no column 'Position'", column={"Position": "z_m"})


def test_outcomes_of_several_runs_are_refused(refused):
    refused("Run 1: fall time (s),Run 2: fall time (s)\n0.4,0.5\n0.4,0.5\n", "csv", "drop.csv, row 1", "below one another")


def test_a_text_export_has_short_names_between_names_and_units(imported, refused):
    """As the manual of Logger Pro 3 describes it: names, short names, units, an empty line, numbers."""
    text = "Vernier Format 2\nball.cmbl 28/11/2026\nRun 1\nTime\tHeight\nt\tz\ns\tm\n\n" + "\n".join(map("\t".join, FALL))
    assert imported(text, "csv")[1]["drop.csv"] == WANTED
    refused(f"{text}\n{text}", "csv", "row 12: another data set begins")


def test_a_run_without_numbers_is_left_out_and_told(imported, refused):
    text = beside(lambda run, what: f"Run {run}: {what}", shorter=FALL[:1])
    found, tables = imported(text, "csv")
    assert list(tables) == ["drop_Run_1.csv"] and "Run 2 is left out, it has fewer than two rows of numbers" in str(found)
    refused("Run 1: Time (s),Run 1: Height (m)\n0.0,1.5\n", "csv", "drop.csv, row 1", "fewer than two rows of numbers")


def test_what_cannot_be_of_any_run_is_refused(refused):
    text = beside(lambda run, what: f"Run {run}: {what}")
    refused(text, "csv", "no column 'Run 3: Height (m)'", column={"Run 3: Height (m)": "z_m"})
    rows = [line.split(",") for line in text.strip().split("\n")]
    beyond = "\n".join(",".join([*row[:3], "" if k == 0 else "7", *row[3:]]) for k, row in enumerate(rows))
    refused(beyond, "csv", "column 4 has numbers and no name")


def test_bodies_seen_by_viana_share_a_time_and_are_a_recording_each(imported):
    """Semicolons with blanks, decimal commas with exponents, blank where a body was not marked; "(in s)" names a unit."""
    head = "Frame; Zeit (in s); " + "; ".join(f"Objekt {k} {axis}-Koordinate" for k in (1, 2) for axis in "xy")
    rows = "1; 0,000E0; ; ; 1,0E0; 2,00E0\n2; 1,0E-1; 5,0E-1; 1,0E0; 1,1E0; 1,95E0\n3; 2,0E-1; 6,0E-1; 9,5E-1; 1,2E0; 1,80E0\n"
    found, tables = imported(f"{head}\n{rows}", "csv")
    first, second = tables.values()
    assert first == {"t_s": ["0.1", "0.2"], "x_m": ["0.5", "0.6"], "z_m": ["1.0", "0.95"]}
    assert second == {"t_s": ["0.0", "0.1", "0.2"], "x_m": ["1.0", "1.1", "1.2"], "z_m": ["2.0", "1.95", "1.8"]}
    assert "2 runs stand beside one another" in str(found)


def test_a_body_that_was_never_marked_is_left_out(imported):
    """The time of all fills its rows, and nothing of its own."""
    text = "Frame; Zeit (in s); Objekt 1 x-Koordinate; Objekt 2 x-Koordinate\n1; 0,0; 1,0; \n2; 0,1; 1,1; \n3; 0,2; 1,2; 5,0\n"
    found, tables = imported(text, "csv")
    assert len(tables) == 1 and "Objekt 2 is left out, it has fewer than two rows of numbers" in str(found)


def test_columns_named_after_objects_that_are_no_recordings_stay_as_they_are(imported, refused):
    """Heights beside times of two objects are outcomes; positions beside those of another object are of a body of their own."""
    refused("height (m);Object 1 time (s);Object 2 time (s)\n0.2;0.20;0.21\n0.4;0.29;0.30\n", "csv", "outcome")
    assert imported("t;x;y;Object 2 x;Object 2 y\n0;1;2;3;4\n1;2;3;4;5\n", "csv")[1]["drop.csv"]["x_m"] == ["1.0", "2.0"]
