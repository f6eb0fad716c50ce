"""From export to experiment: what is to be filled in, by line; accepted once it is; options; the command."""

import json
import tomllib

import numpy as np
import pytest

import hlcs

from .test_phyphox import ALL, RAW
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
    path.write_text(path.read_text().replace("fluid_density = 1.2 ", "fluid_density = 0.0 "))
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
    path.write_text(path.read_text().replace("fluid_density = 1.2 ", "fluid_density = 0.0 "))
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


@pytest.mark.parametrize(
    ("outcome", "asked"),
    [
        ("rebound_height_m", "restitution"),
        ("bounce_time_s", "restitution"),
        ("rebound_speed_m_s", "restitution"),
        ("stop_distance_m", "friction"),
        ("slide_time_s", "friction"),
        ("fall_time_s", None),
    ],
)
def test_a_contact_that_the_outcome_rests_on_is_asked_for_and_no_other(imported, outcome, asked):
    """A default that acts in silence would be told as if somebody had measured it."""
    text = f"height_m,bounce,{outcome}\n1,1,0.5\n1,1,0.6\n2,1,0.9\n"
    found, _ = imported(text, "csv")
    contacts = [place.key for place in found.fill_in if place.key.startswith("surroundings")]
    assert contacts == [f"surroundings.{asked}"] * bool(asked)
    if asked:
        known, _ = imported({"b.csv": text}, "csv", constant={asked: 0.5})
        assert not [place for place in known.fill_in if place.key.startswith("surroundings")]


PATH = "t,x,y\n" + "".join(f"{k / 10},{k * 0.1},{1 - k * k * 0.05}\n" for k in range(12))


def test_constants_of_recordings_stand_in_the_experiment_file(imported):
    """In place of "fill in" and of what is assumed; a phone of which a radius is stated is a sphere."""
    around = {"gravity_m_s2": 9.79, "fluid_density_kg_m3": 998.0, "fluid_viscosity_pa_s": 1e-3, "tube_radius_m": 0.2}
    given = {"mass_kg": 0.0577, "radius_m": 0.0335, "friction": 0.4, "restitution": 0.7} | around
    found, _ = imported(PATH, "csv", constant=given)
    values = tomllib.loads(found.experiment.read_text())
    assert values["body"] == {"shape": "sphere", "radius": 0.0335, "mass": 0.0577}
    numbers = (9.79, 998.0, 1e-3, 0.2, 0.4, 0.7)
    names = ("gravity", "fluid_density", "fluid_viscosity", "tube_radius", "friction", "restitution")
    assert values["surroundings"] == dict(zip(names, numbers, strict=True))
    assert [place.key for place in found.fill_in] == ["measurement.noise.position"] and "in air" not in str(found)
    rows = "".join(f"{k / 50},0,0,9.8,9.8\n" for k in range(40))
    phone, _ = imported(RAW.format("") + rows, "phyphox", constant={"mass_kg": 0.2, "radius_m": 0.05})
    assert tomllib.loads(phone.experiment.read_text())["body"] == {"shape": "sphere", "radius": 0.05, "mass": 0.2}


def test_a_constant_that_says_nothing_is_refused(refused):
    refused(PATH, "csv", "--constant height_m: says nothing about recordings", "mass_kg, radius_m", constant={"height_m": 1.0})
    table = "height_m,fall_time_s\n1,0.45\n"
    refused(table, "csv", "--constant height_m: is a column of the table already", constant={"height_m": 2.0})


@pytest.mark.parametrize("linear", ["Linear ", ""])
def test_what_is_filled_in_of_a_phone_is_all_that_a_comparison_needs(imported, linear):
    """A phone that lies on a table, which its readings tell."""
    rest = 0.0 if linear else 9.80665
    rows = "".join(f"{k / 50:.6E},{1e-3 * (-1) ** k:.6E},0.0E0,{rest + 1e-3 * (-1) ** (k // 2):.9E},9.8E0\n" for k in range(40))
    found, _ = imported(RAW.format(linear) + rows, "phyphox")
    keys = ["body.size", "body.mass", "measurement.noise.acceleration"]
    assert [place.key for place in found.fill_in] == keys
    text = found.experiment.read_text()
    numbers = {"size": "[0.075, 0.16, 0.008]"}
    for key in keys:
        text = text.replace(
            f'{key.split(".")[-1]} = "fill in"', f"{key.split('.')[-1]} = {numbers.get(key.split('.')[-1], '0.05')}"
        )
    found.experiment.write_text(text)
    assert hlcs.compare(found.experiment).adequate is not None


def test_every_column_of_the_project_can_be_named(imported):
    """Pixels, errors of inputs and accelerations stand in the page of the format like all others."""
    pixels = "t [s],x [px],h [px]\n0,1,10\n0.1,2,20\n0.2,3,25\n"
    found, tables = imported(pixels, "csv", column={"x [px]": "x_px", "h [px]": "z_px"})
    assert tables["drop.csv"] == {"t_s": ["0.0", "0.1", "0.2"], "x_px": ["1.0", "2.0", "3.0"], "z_px": ["10.0", "20.0", "25.0"]}
    assert [place.key for place in found.fill_in][2:] == ["measurement.metres_per_pixel", "measurement.noise.position"]
    assert imported({"p.csv": pixels}, "csv")[1]["p.csv"] == tables["drop.csv"]  # the unit says what they are
    text = "drop height [cm],height sd [mm],fall time [s]\n50,5,0.31\n50,5,0.32\n90,5,0.43\n"
    _, tables = imported({"d.csv": text}, "csv", column={"height sd [mm]": "height_m_sd"})
    assert tables["measurements.csv"]["height_m_sd"] == ["0.005"] * 3
    found, tables = imported({"a.csv": "t_s,ax_m_s2\n0,1\n0.1,2\n"}, "csv")
    assert tables["a.csv"]["ax_m_s2"] == ["1.0", "2.0"] and "measurement.accelerometer" in [one.key for one in found.fill_in]


def test_a_column_that_is_not_understood_is_named_with_the_option_that_says_what_it_is(imported, refused):
    refused("Dauer [s];Winkel [°]\n1,2;20\n1,1;21\n", "csv", "not understood: 'Dauer [s]'", '--column "Dauer [s]=t_s"')
    assert "slide_time_s" in imported("Gleitzeit [s];Winkel [°]\n1,2;20\n1,1;21\n", "csv")[1]["measurements.csv"]
    assert "bounce_time_s" in imported("height [cm],bounce,bounce time [s]\n50,1,0.3\n50,2,0.8\n", "csv")[1]["bounces.csv"]


def test_what_is_no_second_measurement_is_refused_at_once(refused, tmp_path):
    """A file that is named twice, also as the body at rest, and a body at rest that moves."""
    one = fall(1, seconds=1.0)
    refused({"a.txt": one, "./a.txt": one}, "tracker", "./a.txt: it is 'a.txt' again; name each file once")
    refused({"a.txt": one}, "tracker", "a.txt: it is among the files that are imported", static="a.txt")
    (tmp_path / "rest.txt").write_text(fall(2, seconds=1.0))
    refused({"a.txt": one}, "tracker", "rest.txt, column x_m: moves by 0.152 m", "must show a body at rest", static="rest.txt")
