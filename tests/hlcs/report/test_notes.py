"""Notes on the data: what is said of many recordings stands once."""

from hlcs.report.notes import MOST, gathered


def test_notes_that_say_the_same_of_several_files_are_one():
    notes = [f"{name}.csv, column {axis}_m: 3 of 60 samples missing" for name in ("a", "b") for axis in "xz"]
    assert gathered(notes) == ["3 of 60 samples missing (in x_m, z_m of each of a.csv, b.csv)"]
    assert gathered([*notes, "c.csv, column z_m: 3 of 60 samples missing"]) == [
        "3 of 60 samples missing (in each of a.csv, x_m, z_m; b.csv, x_m, z_m; c.csv, z_m)"
    ]


def test_sizes_that_differ_are_told_as_a_range():
    notes = [f"frame {number}: time steps jitter by {size} % of 0.0667 s" for number, size in ((1, 8.0), (2, 0.6), (3, 2.1))]
    notes += [f"{name}.csv: up to {rows} rows" for name, rows in (("a", "950"), ("b", "12,000"))]
    assert gathered(notes) == [
        "time steps jitter by 0.6 to 8.0 % of 0.0667 s (in each of frame 1, frame 2, frame 3)",
        "a.csv: up to 950 rows",
        "b.csv: up to 12,000 rows",
    ]


def test_what_is_counted_in_each_file_is_not_read_as_the_count_of_all():
    """One sample of each of two recordings is two."""
    notes = [f"{name}.csv: 1 isolated sample set aside for all models: z row 2" for name in "ab"]
    assert gathered(notes) == ["1 isolated sample set aside for all models: z row 2 (in each of a.csv, b.csv)"]


def test_places_and_notes_of_no_file_stay_apart():
    """A row number is a place: "row 24 to 26" would name a row where nothing is."""
    notes = ["a.csv: set aside: z row 24", "b.csv: set aside: z row 26", "3 sets left out", "5 sets left out"]
    assert gathered(notes) == notes


def test_what_is_not_told_is_counted():
    assert gathered([f"word {'x' * k}" for k in range(MOST + 3)])[-1] == "and 3 more, all in the JSON result"
