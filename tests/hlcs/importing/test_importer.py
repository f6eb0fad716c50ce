"""From export to experiment: what is to be filled in, by line; accepted once it is; options; the command."""

import json

import numpy as np
import pytest

import hlcs

from .test_phyphox import ALL
from .test_spreadsheet import GERMAN
from .test_tracker import TWO

RADIUS, MASS, SIGMA = 0.033, 0.057, 0.002


def fall(seed, height=2.0, seconds=0.6, rate=50):
    """Tracker's export of a fall in a vacuum, z = h - g t^2 / 2, with white noise of 2 mm."""
    t = np.arange(0.0, seconds, 1 / rate)
    noise = SIGMA * np.random.default_rng(seed).standard_normal((2, len(t)))
    x, y = 0.3 * t + noise[0], height - 0.5 * 9.81 * t**2 + noise[1]
    rows = "".join(f"{a:.6E}\t{b:.6E}\t{c:.6E}\t\n" for a, b, c in zip(t, x, y, strict=True))
    return f"\tball\t\t\nt\tx\ty\t\n{rows}"


def at_rest(count=40):
    noise = SIGMA * np.random.default_rng(9).standard_normal((2, count))
    return "\tball\t\t\nt\tx\ty\t\n" + "".join(f"{k / 50}\t{a:.5f}\t{b:.5f}\t\n" for k, (a, b) in enumerate(noise.T))


def filled(path, **numbers):
    """Fill numbers in at the keys that say "fill in"; a key whose number is None is deleted."""
    lines = path.read_text().split("\n")
    for key, number in numbers.items():
        (place,) = [k for k, line in enumerate(lines) if line.startswith(f"{key} = ") or line.startswith(f"noise.{key} = ")]
        lines[place] = lines[place].replace('"fill in"', repr(number)) if number is not None else ""
    path.write_text("\n".join(lines))
    return path


def test_each_place_is_asked_for_by_its_line_until_it_is_filled_in(imported):
    """The complaint names the line in which "fill in" stands, and what its comment says; then the next; then none."""
    found, _ = imported({"a.txt": fall(1), "b.txt": fall(2)}, "tracker")
    assert [place.key for place in found.fill_in] == ["body.radius", "body.mass", "measurement.noise.position"]
    lines = found.experiment.read_text().split("\n")
    assert all('"fill in"' in lines[place.line - 1] for place in found.fill_in)
    for place, number in zip(found.fill_in, (RADIUS, MASS, SIGMA), strict=True):
        with pytest.raises(hlcs.InputError) as problem:
            hlcs.compare(found.experiment)
        message = str(problem.value)
        assert message.startswith(f'{found.experiment}, line {place.line}: {place.key}: still says "fill in"; write its value')
        assert all(f"line {other.line} ({other.key})" in message for other in found.fill_in if other.line > place.line)
        filled(found.experiment, **{place.key.rsplit(".", 1)[1]: number})
    assert hlcs.compare(found.experiment).kind == "trajectory"


def test_an_imported_fall_is_compared_like_any_other(imported):
    """In a vacuum the model lacks nothing: the error that is left is the noise that was put in, 2 mm."""
    found, _ = imported({f"{k}.txt": fall(k) for k in range(3)}, "tracker")
    path = filled(found.experiment, radius=RADIUS, mass=MASS, position=SIGMA)
    path.write_text(path.read_text().replace("# fluid_density = 1.2 ", "fluid_density = 0.0 "))
    comparison = hlcs.compare(path)
    assert comparison.adequate and comparison.error["rms"] == pytest.approx(SIGMA, rel=0.2)  # 180 readings: 5 %, and the starts


def test_a_body_at_rest_gives_the_noise(imported):
    found, tables = imported({"a.txt": fall(1), "rest.txt": at_rest()}, "tracker", only=("ball",))
    assert "rest.csv" not in tables  # here it is a recording like another
    with open("still.txt", "w") as file:
        file.write(at_rest())
    found = hlcs.import_measurements("a.txt", "tracker", "other", static="still.txt")
    assert [place.key for place in found.fill_in] == ["body.radius", "body.mass"]
    path = filled(found.experiment, radius=RADIUS, mass=MASS)
    assert hlcs.compare(path).noise["position"] == pytest.approx(SIGMA, rel=0.3)  # from 80 readings: 8 %
    with pytest.raises(hlcs.InputError, match="still.txt: 19 samples at rest; at least 20 are needed"):
        with open("still.txt", "w") as file:
            file.write(at_rest(19))
        hlcs.import_measurements("a.txt", "tracker", "third", static="still.txt")


def test_a_mass_nobody_knows_may_be_deleted(imported):
    found, _ = imported({"a.txt": fall(1)}, "tracker")
    assert hlcs.compare(filled(found.experiment, radius=RADIUS, mass=None, position=SIGMA)).kind == "trajectory"


def test_a_table_of_falls_is_compared(imported):
    """t = sqrt(2 h / g) in a vacuum, two rows of each height: the rows tell the noise, 1 ms."""
    noise = np.random.default_rng(4).normal(0.0, 1e-3, 12)
    heights = np.repeat([0.5, 1.0, 1.5, 2.0], 3)
    rows = "".join(
        f"{100 * h:.1f};{1000 * (np.sqrt(2 * h / 9.81) + e):.1f}\n".replace(".", ",") for h, e in zip(heights, noise, strict=True)
    )
    found, _ = imported("Fallhöhe [cm];Fallzeit [ms]\n" + rows, "csv")
    path = filled(found.experiment, radius=0.01, mass=0.0326)
    path.write_text(path.read_text().replace("# fluid_density = 1.2 ", "fluid_density = 0.0 "))
    comparison = hlcs.compare(path)
    assert comparison.adequate and comparison.error["rms"] == pytest.approx(1e-3, rel=0.5)  # 12 readings: 20 %


def test_what_the_format_would_pass_over_is_refused(refused):
    refused(
        TWO, "tracker", "--rotation-order says nothing about a file --as tracker; it belongs to optitrack", rotation_order="XYZ"
    )
    refused(TWO, "tracker", "'lenght_unit' is no option of an import; the nearest is 'length_unit'", lenght_unit="m")
    refused(TWO, "tracker", "--up 'w': must be one of z, -z, y", up="w")
    refused(TWO, "tracker", "--length-unit 'ell': must be one of m, cm", length_unit="ell")
    refused(TWO, "tracker", "--frame-rate 0: must be a number of pictures a second", frame_rate=0)
    refused(ALL, "phyphox", "--constant heigth_m: no input of a table; the nearest is 'height_m'", constant={"heigth_m": 1.0})
    refused(GERMAN, "csv", "--column ..=z: no column of this project; the nearest is 'z_m'", column={"Höhe [cm]": "z"})
    refused(TWO, "excel", "'excel' is no format; one of tracker, phyphox, optitrack, csv")
    refused({}, "csv", "no file to import")
    mixed = {"a.csv": GERMAN, "b.csv": "fall time,drop height\n1,2\n"}
    refused(mixed, "csv", "some hold recordings, others one experiment a row; import them one by one")


def test_names_of_bodies_become_names_of_files_that_every_system_takes(imported):
    text = "#multi:\n,Ball/ä,,ball \u2028,,\nt,x,y,x,y,\n" + "".join(f"{k},1,{k},2,{k},\n" for k in range(3))
    found, _ = imported({"a b.csv": text}, "tracker")
    assert list(found.files) == ["a_b_Ball.csv", "a_b_ball_2.csv"]
    assert "\u2028" not in found.experiment.read_text()


def test_the_command_writes_the_same_experiment_and_says_what_it_assumed(hlcs, tmp_path):
    (tmp_path / "falls.csv").write_text("Höhe [cm];Zeit [s]\n50;0,319\n50;0,321\n100;0,452\n", encoding="utf-8")
    options = (
        "--as",
        "csv",
        "--column",
        "Zeit [s]=fall_time_s",
        "--constant",
        "mass_kg=0.0577",
        "--json",
        "r.json",
        "--out",
        "out",
    )
    status, text, errors = hlcs("import", "falls.csv", *options)
    assert (status, errors) == (0, "")
    result = json.loads((tmp_path / "r.json").read_text())
    assert result["kind"] == "outcomes" and result["next"] == "hlcs compare out/experiment.toml"
    assert text.rstrip().endswith("Then: hlcs compare out/experiment.toml")
    assert [place["key"] for place in result["fill_in"]] == ["body.radius"]
    assert all(
        one["text"] in text and one["text"] in (tmp_path / "out" / "experiment.toml").read_text() for one in result["assumed"]
    )
    status, _, errors = hlcs("compare", "out/experiment.toml")
    assert status == 2 and errors.startswith("hlcs: out/experiment.toml, line ") and errors.count("\n") == 1
    status, _, errors = hlcs("import", "falls.csv", *options)  # the same again may replace it
    assert (status, errors) == (0, "")
    filled(tmp_path / "out" / "experiment.toml", radius=RADIUS)
    status, _, errors = hlcs("import", "falls.csv", *options)
    assert status == 2 and "holds 'experiment.toml', which is no earlier result" in errors  # what was filled in is not lost
