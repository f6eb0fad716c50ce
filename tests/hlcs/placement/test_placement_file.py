"""Placement tests as TOML: every key, and every complaint with its line and remedy."""

import pytest

from hlcs import InputError, PlacementTest
from hlcs.placement.placement_file import make_placement, read_placement_file
from hlcs.placement.settings_table import placement_table


def read(tmp_path, text, **overrides):
    path = tmp_path / "test.toml"
    path.write_text(text)
    return read_placement_file(path, **overrides)


def test_every_key_of_the_contract_is_understood(tmp_path):
    test = read(
        tmp_path,
        """
title = "all keys"
[placement]
grid = "RPG"
shape = "hull"
nominal_diameter = 1.07
friction = 0.6
restitution = 0
margin = 0.008
falling_distance = 0.25
reference = "blind"
layers = 5
rows = 8
columns = 9
bottom = "slope:4%"
""",
    )
    assert (test.grid.name, test.shape, test.friction, test.reference) == ("RPG", "hull", 0.6, "blind")
    assert (test.rows, test.columns, test.restitution, test.bottom.grade) == (8, 9, 0.0, 0.04)
    assert test.unit.nominal_diameter == pytest.approx(1.07, rel=1e-15)


def test_what_is_left_out_has_its_default_and_options_win(tmp_path):
    assert read(tmp_path, "[placement]\n") == PlacementTest()
    assert read(tmp_path, "[placement]\nfriction = 0.1\nside = 2.0\n", friction=0.7, nominal_diameter=1.0).friction == 0.7


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[placement]\nfalling_distanse = 0.2\n", ("line 2", "falling_distanse", "'falling_distance'")),
        ('[placement]\ngrid = "TPG"\nfriction = -1\n', ("line 3", "friction = -1", ">= 0")),
        ('[placement]\nfriction = "rough"\n', ("line 2", "friction = 'rough'", "number")),
        ("[placement]\nlayers = 2.0\n", ("line 2", "layers = 2.0", "whole number")),
        ("[placement]\nrows = 3\nlayers = 5\n", ("line 3", "at most 3 layers")),
        ("[placement]\nside = 1\nnominal_diameter = 1\n", ("both side and nominal_diameter",)),
        ("[placement]\nnominal_diameter = 0\n", ("line 2", "nominal_diameter = 0", "> 0")),
        ('[placement]\nstacking = "ABBA"\n', ("line 2", "ABBA", "ABC, ABA")),
        ('[placement]\nbottom = "no.csv"\n', ("line 2", "no.csv")),
        ("[placement]\ngrid = 3\n", ("line 2", "grid = 3", "text")),
        ("[placement]\nshape = [1]\n", ("line 2", "shape", "text")),
        ("[placment]\n", ("line 1", "placment", "'placement'")),
        ('title = "x"\n', ("[placement] is missing",)),
        ('kind = "trajectory"\n[body]\n', ("is an experiment file", "hlcs compare")),
        ("[placement\n", ("not valid TOML",)),
    ],
)
def test_complaints_name_file_line_key_and_remedy(tmp_path, text, words):
    with pytest.raises(InputError) as refusal:
        read(tmp_path, text)
    message = str(refusal.value)
    assert "\n" not in message and "test.toml" in message
    for word in words:
        assert word in message


@pytest.mark.parametrize(
    "table",
    [
        {},
        {"grid": "RPG", "bottom": "slope:0.04"},
        {"grid": "1.5,1.3"},
        {"grid": "1.5,1.3,triangular", "stacking": "ABA"},
        {"stacking": "ABA", "side": 0.1, "friction": 1 / 3, "seed": 12345678901234567},
    ],
)
def test_a_test_written_and_read_is_the_same_test(table):
    test = make_placement(table)
    assert make_placement(placement_table(test)) == test


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('effects = [{ name = "roling_friction" }]', ("roling_friction", "'rolling_friction'")),
        ('effects = [{ name = "rolling_friction", arms = 1 }]', ("arms", "'arm'")),
        ("effects = [{ arm = 1.0 }]", ("no name",)),
        ('effects = "rolling_friction"', ("must be a list",)),
        ('effects = [{ name = "rolling_friction", arm = "big" }]', ("arm must be a finite number",)),
        ("vibration = -1", ("vibration = -1", ">= 0")),
        ("loose_lower_layers = 1", ("loose_lower_layers = 1", "true or false")),
        ('armour = "tetrapod"', ("tetrapod", "cubipod, cube")),
    ],
)
def test_bad_values_are_refused_by_line_and_name(tmp_path, line, words):
    (tmp_path / "test.toml").write_text(f"[placement]\n{line}\n")
    with pytest.raises(InputError) as refusal:
        read_placement_file(tmp_path / "test.toml")
    for word in ("line 2", *words):
        assert word in str(refusal.value)
