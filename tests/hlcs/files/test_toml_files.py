"""TOML files with anything in them: refused in one line within moments, however long, deep or large what stands in them is."""

import signal

import pytest

from hlcs.data.experiment_file import read_experiment_file
from hlcs.files.toml_files import MOST_BYTES, MOST_DEPTH, TomlFile
from hlcs.placement.parameter_sweep import read_sweep_file
from hlcs.placement.placement_file import read_placement_file
from minibullet.errors import InputError, nearest

DEEP = 50_000
BODY = 'kind = "trajectory"\n[body]\nshape = "sphere"\n{line}\n[[trial]]\nfile = "a.csv"\n'


@pytest.fixture(autouse=True)
def soon():
    """A minute would be a hang; the slowest takes 2 s."""
    before = signal.signal(signal.SIGALRM, lambda *_: pytest.fail("it hangs"))
    signal.alarm(20)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def refusal(tmp_path, text, read=read_experiment_file):
    (tmp_path / "a.csv").write_text("t_s,z_m\n0,0\n1,1\n")
    path = tmp_path / "e.toml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read(path)
    assert "\n" not in str(caught.value) and str(path) in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        "x = " + "[" * DEEP + "]" * DEEP,
        "x = " + "{ a = " * 3000 + "1" + " }" * 3000,
        ".".join("a" * DEEP) + " = 1",
        "[" + ".".join("a" * DEEP) + "]",
        "x = { " + ".".join(["'a'"] * DEEP) + " = 1 }",
        " . ".join(['"a"'] * DEEP) + " = 1",
        "x = " + "[" * (MOST_DEPTH + 1) + "]" * (MOST_DEPTH + 1),
    ],
)
def test_what_stands_too_deep_is_refused(tmp_path, text):
    assert f"at most {MOST_DEPTH} deep" in refusal(tmp_path, text + "\n")


def test_lists_of_decimals_and_files_as_deep_as_ours_are_read(tmp_path):
    """The bound is of names of parts, not of points in numbers, and not of what experiments need."""
    path = tmp_path / "x.toml"
    path.write_text("x = [" + "0.5," * 1000 + "]\ny = { a = { b = [[1.0, 2.0]] } }\n# see a.b.c\nz = '" + "." * 9999 + "'\n")
    assert TomlFile(path, {}).values["y"]["a"]["b"] == [[1.0, 2.0]]


@pytest.mark.parametrize("number", ["1" + "0" * 400, "-1" + "0" * 400, "0x" + "f" * 20_000, "9223372036854775808", "1" * 5000])
@pytest.mark.parametrize(
    ("text", "read"),
    [
        (BODY.replace("{line}", "radius = {}"), read_experiment_file),
        ("[placement]\nside = {}\n", read_placement_file),
        ("[sweep]\nseed = [1, {}]\n", read_sweep_file),
        ("[placement]\neffects = [{ name = 'x', arm = {} }]\n", read_placement_file),
    ],
)
def test_whole_numbers_beyond_64_bits_are_refused(tmp_path, number, text, read):
    said = refusal(tmp_path, text.replace("{}", number), read)
    assert "64" in said and len(said) < 400


@pytest.mark.parametrize(
    "line",
    [
        "radius = 1e300",
        "radius = 1e-300",
        "mass = 1e300",
        "mass = 1e-300",
        "radius = nan",
        "inertia = [1e300, 1e300, 1e300]",
        "radius = " + "[1, " * 5 + "]" * 5,
    ],
)
def test_numbers_that_no_body_has_are_refused_by_line(tmp_path, line):
    assert "line 4" in refusal(tmp_path, BODY.format(line=line))


def test_a_key_a_value_or_a_word_of_a_million_letters_is_cut_in_the_complaint(tmp_path):
    long = "a" * 1_000_000
    for text in (
        f"{long} = 1\n",
        BODY.format(line=f'radius = "{long}"'),
        f'kind = "{long}"\n',
        BODY.format(line="radius = [" + "1," * 400_000 + "]"),
        BODY.replace("a.csv", long).format(line=""),
    ):
        assert len(refusal(tmp_path, text)) < 600


def test_a_text_made_to_slow_the_search_for_the_line_does_not(tmp_path):
    for filling in ("[" + " " * 1_900_000, "radiu " * 300_000, *(letter * 1_900_000 for letter in "[.a'")):
        refusal(tmp_path, BODY.format(line="radiu = 1") + f'title = """\n{filling}\n"""\n')


def test_a_file_beyond_the_limit_is_refused_unread(tmp_path):
    path = tmp_path / "e.toml"
    with open(path, "wb") as file:
        file.truncate(50 * MOST_BYTES)
    with pytest.raises(InputError, match="at most 2 MB are read"):
        read_experiment_file(path)


@pytest.mark.parametrize("name", ["a" * 300, "\\u0000", "\\u001b[2J", "a\\nb", "", "no.csv", "."])
@pytest.mark.parametrize("key", ["file", "mesh"])
def test_names_of_no_file_are_refused_by_line(tmp_path, name, key):
    text = (
        BODY.format(line="").replace("a.csv", name)
        if key == "file"
        else (BODY.replace('"sphere"', '"mesh"').format(line=f'mesh = "{name}"'))
    )
    said = refusal(tmp_path, text)
    assert ("line 6" if key == "file" else "line 4") in said and said.isprintable()


@pytest.mark.parametrize("value", ["{}", "{ slope = 1 }", "[]", "3", "1979-05-27", "true"])
def test_a_bottom_that_is_no_text_is_refused_by_line(tmp_path, value):
    assert "line 2" in refusal(tmp_path, f"[placement]\nbottom = {value}\n", read_placement_file)
    assert "e.toml" in refusal(tmp_path, f"[sweep]\nbottom = [{value}]\n", read_sweep_file)


def test_the_nearest_name_is_found_from_the_beginning_of_a_long_one():
    assert nearest("radius" + "s" * 1_000_000, ["mass", "radius"]) == "radius"


def test_a_thousand_equal_warnings_are_one(tmp_path, recwarn):
    (tmp_path / "a.csv").write_text("t_s,z_m\n0,0\n1,1\n")
    many = "[[trial]]\nfile = 'a.csv'\ngravity = 32.2\n" * 1000
    (tmp_path / "e.toml").write_text(BODY.format(line="") + many)
    read_experiment_file(tmp_path / "e.toml")
    assert len(recwarn) == 1 and "line 9: trial.gravity: 32.2 m/s2" in str(recwarn[0].message)


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("radius = 0.03\nradius = 0.04", "line 5, column 14): 'radius = 0.04'; radius stands twice, first in line 4: keep one"),
        ("radius = .03", "line 4, column 10): 'radius = .03'; a number has digits on both sides of its point, 0.1 or 1.0"),
        ("radius = 3.", "'radius = 3.'; a number has digits on both sides of its point, 0.1 or 1.0"),
        ("[surroundings]\ngravity = -9.81", "line 5: surroundings.gravity: got -9.81; it is counted downwards: write 9.81"),
    ],
)
def test_what_toml_or_the_format_does_not_have_is_told_with_what_to_write(tmp_path, line, told):
    assert told in refusal(tmp_path, BODY.replace("{line}", line))
