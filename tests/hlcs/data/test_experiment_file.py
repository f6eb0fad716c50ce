"""Experiment files: wrong keys and values are refused by line and key, trials override what the file says."""

import numpy as np
import pytest
import trimesh
from boxes import MESH, SIZE, thrown
from experiments import TOML, experiment, refused

import hlcs
from hlcs.data.experiment_file import read_experiment_file
from minibullet.errors import InputError, InputWarning


@pytest.mark.parametrize(
    ("toml", "words"),
    [
        (TOML.replace("radius", "raduis"), ("line 4", "raduis", "radius")),
        (TOML.replace("[measurement]", "[measurment]"), ("measurment", "measurement", "line 6")),
        (TOML.replace("position = 0.01", "positon = 0.01"), ("positon", "position", "line 7")),
        (TOML.replace("0.05", "-1.0"), ("line 5", "mass", "greater than 0")),
        (TOML.replace("0.03", "30.0"), ("density", "kg and m")),
        (TOML.replace('"sphere"', '"spere"'), ("spere", "sphere")),
        (TOML.replace('"trajectory"', '"trajectories"'), ("trajectory",)),
        (TOML + "[model]\neffects = 3\n", ("effects", "list")),
        (TOML.replace("{ position = 0.01 }", "0.01"), ("line 7", "noise", "{ position = 0.01 }")),
        (TOML.replace("{ position", "{ outcome"), ("line 7", "outcome", "position [m]")),
        (TOML + "[surroundings]\nfloor = 0.0\n", ("line 9", "floor", "{ height = 0.0 }")),
        (TOML + "[placement]\nlayers = 5\n", ("line 8", "placement", "layers")),
        (TOML.replace("radius", "diameter"), ("line 4: body.diameter: unknown key; write radius, half of it",)),
        (TOML.replace("radius", "thickness"), ("line 4: body.thickness: unknown key; known are shape, radius, height",)),
        (TOML.replace("0.05", "0,05"), ("not valid TOML", "line 5", "'mass = 0,05'; decimals have a point")),
        (TOML.replace("position = 0.01", "position = 0,01"), ("not valid TOML", "decimals have a point")),
        (TOML.replace("position = 0.01", "position = 1e-300"), ("must be between",)),
        (TOML.replace('"sphere"', "sphere"), ("'shape = sphere'; texts stand between quotes",)),
        (TOML.replace('"sphere"', '"sphere'), ("a text ends with the quote that it begins with",)),
        (TOML.replace("0.05", "50 g"), ("'mass = 50 g'; numbers stand without units: kg, m, s, rad",)),
        (TOML.replace("0.05", "0.05 // weighed"), ("'mass = 0.05 // weighed'; a remark begins with #",)),
        (TOML + "[model]\nadded = True\n", ("'added = True'; write true or false",)),
        ('kind: "trajectory"\n', ("'kind: \"trajectory\"'; write key = value",)),
        (TOML + '[[trial]]\nfile = "C:\\Users\\a.csv"\n', ("line", "between folders write /")),
        (TOML + "[[trial]]\nfile = 'day\\a.csv'\n", ("trial.file: file 'day\\a.csv' is not there", "between folders write /")),
        (TOML + "[trial]\n[trial]\n", ("'[trial]'; a table stands once; [[trial]] begins one of several",)),
        (TOML + '[[trial]]\nfile = "a.csv"\ngroup = 2024-01-01\n', ("a name between quotes, such as", "got 2024-01-01")),
        ("gravty = 9.81\n" + TOML, ("line 1: gravty: unknown key here; 'gravity' stands under [surroundings]",)),
        (TOML + "[model]\ntime_step = 1.0\n", ("line 9: model.time_step: must be greater than 0 and at most 0.1, got 1",)),
    ],
)
def test_wrong_keys_and_values_are_named(tmp_path, toml, words):
    refused(experiment(tmp_path, toml=toml), *words)


@pytest.mark.parametrize(
    ("effects", "words"),
    [
        ('["quadratic_drag"]', "quadratic_drag stands without a number; give drag_coefficient = .. (0 to 2.5)"),
        ('[{ name = "quadratic_drag", fluid_density = 1.2 }]', "quadratic_drag stands without a number"),
        ('["clock_offset"]', "clock_offset stands without a number; give offset = .. [s]"),
        ('["friction"]', "friction stands without a number; give coefficient = .."),  # it has a default, which nobody measured
        ('[{ name = "linear_drag", rate = "fill in" }]', "linear_drag: rate = 'fill in' must be a finite number"),
    ],
)
def test_an_effect_without_its_numbers_is_refused(tmp_path, effects, words):
    path = experiment(tmp_path, toml=TOML + f"[model]\neffects = {effects}\n")
    with pytest.raises(InputError) as refusal:
        hlcs.compare(path)
    assert f"e.toml, line 9: model.effects: {words}" in str(refusal.value)


def test_a_number_beyond_what_is_plausible_is_told_also_where_its_range_depends_on_the_body(tmp_path):
    """A drag rate is plausible up to 25 times rho A / (2 m) = 0.034 /s for this ball in air: 0.85 /s."""
    path = experiment(tmp_path, toml=TOML + '[model]\neffects = [{ name = "linear_drag", rate = 2.0 }]\n')
    (note,) = (note for note in hlcs.compare(path).notes if "plausible" in note)
    assert "line 9: model.effects: linear_drag: rate = 2 lies above what is plausible (0 to 0.848" in note


def test_overrides_of_a_trial(tmp_path):
    file = read_experiment_file(experiment(tmp_path, trial='file = "a.csv"\nmass = 0.2\nradius = 0.05\ngravity = 9.8\n'))
    assert file.trials[0].body.mass == 0.2 and file.trials[0].surroundings.gravity == 9.8 and file.body.mass == 0.05


def test_a_noise_in_millimetres_is_told(tmp_path):
    with pytest.warns(InputWarning, match=r"measurement.noise.position: 2 m is hardly meant.*not in mm"):
        read_experiment_file(experiment(tmp_path, toml=TOML.replace("0.01", "2")))


BAD = {
    "missing": (None, 'shape = "mesh"\nmesh = "gone.stl"\n', "line 4: body.mesh: file 'gone.stl' is not there"),
    "open": (b"solid a\nendsolid a\n", MESH, "line 4: body.mesh: mesh 'box.stl': no triangles; the file is empty"),
    "not named": (None, 'shape = "mesh"\n', 'line 3: body.shape: "mesh" of which file. Add mesh = "unit.stl"'),
    "folder": ("folder", MESH, "line 4: body.mesh: 'box.stl' is a folder; name a file in it"),
    "millimetres": ("mm", MESH + "mass = 1.5\n", "line 5: body.mass: mass and size give a density of .*units are kg and m"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_mesh_is_refused_where_the_experiment_names_it(case, tmp_path):
    content, body, words = BAD[case]
    if content == "folder":
        (tmp_path / "box.stl").mkdir()
    elif content == "mm":
        trimesh.creation.box(1000 * np.array(SIZE)).export(tmp_path / "box.stl")
    elif content:
        (tmp_path / "box.stl").write_bytes(content)
    path = thrown(tmp_path, body)
    with pytest.raises(InputError, match=f"thrown.toml, {words}") as refusal:
        hlcs.compare(path)
    assert "\n" not in str(refusal.value)
