"""Bodies that cannot be, and keys that make no sense together: refused or told by key."""

import pytest
from experiments import TOML, experiment, measured

from hlcs.data.experiment_file import read_experiment_file
from minibullet.errors import InputError, InputWarning

SPHERE = 'shape = "sphere"\nradius = 0.03\n'


def read(folder, old="", new="", **others):
    return read_experiment_file(experiment(folder, toml=TOML.replace(old, new), **others))


@pytest.mark.parametrize(
    ("body", "missing"),
    [
        ('shape = "box"\n', "size = [x, y, z]"),
        ('shape = "disc"\nradius = 0.03\n', "height = .."),
        ('shape = "cone"\nheight = 0.03\n', "radius = .."),
        ('shape = "cubipod"\n', "side = .."),
    ],
)
def test_a_shape_without_its_size_is_refused(tmp_path, body, missing):
    with pytest.raises(InputError) as problem:
        read(tmp_path, SPHERE, body)
    assert "line 3: body.shape" in str(problem.value) and f"of which size? Add {missing} (in m)" in str(problem.value)


def test_a_size_may_stand_in_each_trial(tmp_path):
    file = read(tmp_path, SPHERE, 'shape = "box"\n', trial='file = "a.csv"\nsize = [0.05, 0.05, 0.05]\n')
    assert file.trials[0].body.sized


def test_no_moment_of_inertia_exceeds_the_mass_at_the_bounding_radius(tmp_path):
    """m R^2 = 0.05 0.03^2 = 4.5e-5 kg m2: of a thin ring about its axis."""
    assert read(tmp_path, "mass =", "inertia = [2.25e-5, 2.25e-5, 4.5e-5]\nmass =").body.inertia[2] == 4.5e-5
    with pytest.raises(InputError, match="line 5: body.inertia: 4.6e-05 kg m2 is more than 0.05 kg within 0.03 m"):
        read(tmp_path, "mass =", "inertia = [2.3e-5, 2.3e-5, 4.6e-5]\nmass =")


def test_a_drag_area_far_beyond_the_outline_is_told(tmp_path):
    """Outline pi 0.03^2 = 0.00283 m2: 28 cm2."""
    assert read(tmp_path, "mass =", "drag_area = 0.0282\nmass =").body.drag_area == 0.0282
    with pytest.warns(InputWarning, match=r"line 5: body.drag_area: 28 m2 is hardly meant .* 0.00283 m2; .*not cm2"):
        read(tmp_path, "mass =", "drag_area = 28\nmass =")


def test_a_vacuum_has_no_viscosity_and_a_fluid_in_grams_is_told(tmp_path):
    around = "[surroundings]\nfluid_density = {}\nfluid_viscosity = 0.001\n[measurement]"
    with pytest.raises(InputError, match="line 8: surroundings.fluid_viscosity: a vacuum"):
        read(tmp_path, "[measurement]", around.format("0.0"))
    with pytest.warns(InputWarning, match="fluid_density: 0.001 kg/m3 is hardly meant.*not in g/cm3"):
        read(tmp_path, "[measurement]", around.format("0.001"))


def test_an_effect_acts_once(tmp_path):
    entry = '{ name = "linear_drag", rate = 0.1 }'
    with pytest.raises(InputError, match="line 7: model.effects: 'linear_drag' stands there twice"):
        read(tmp_path, "[measurement]", f"[model]\neffects = [{entry}, {entry}]\n[measurement]")


def test_a_candidate_named_twice_and_a_session_of_some_trials_are_told(tmp_path):
    with pytest.warns(InputWarning, match="line 7: diagnose.candidates: 'buoyancy' stands there twice"):
        read(tmp_path, "[measurement]", '[diagnose]\ncandidates = ["buoyancy", "buoyancy"]\n[measurement]')
    (tmp_path / "b.csv").write_text("t_s,z_m\n0,1\n0.1,0.95\n")
    with pytest.warns(
        InputWarning, match="trial.session: stands in 1 of 2 trials, and trial 2 has none: one session alone changes nothing"
    ):
        read(tmp_path, trial='file = "a.csv"\nsession = "A"\n[[trial]]\nfile = "b.csv"\n')


def test_a_start_out_of_reach_of_its_recording_is_told(tmp_path):
    """The ball falls from 1 m by 2.45 m in steps of 0.1 s: 50 m/s lead 5 m away within one, which may be; 200 do not."""
    for start in ("position = [0.0, 0.0, 1.0], velocity = [0.0, 0.0, 50.0]", "position = [0.0, 0.0, 8.0]"):
        measured(experiment(tmp_path, trial=f'file = "a.csv"\nstart = {{ {start} }}\n'))
    with pytest.warns(InputWarning, match=r"trial.start.position: is 999 m aside of the first sample, in a recording of 2.45 m"):
        measured(experiment(tmp_path, trial='file = "a.csv"\nstart = { position = [0.0, 0.0, 1000.0] }\n'))
    with pytest.warns(InputWarning, match=r"trial.start.velocity: 200 m/s lead 20 m away within one step of 0.1 s"):
        measured(experiment(tmp_path, trial='file = "a.csv"\nstart = { velocity = [0.0, 0.0, 200.0] }\n'))


def test_a_recording_at_rest_holds_what_the_others_hold(tmp_path):
    def at_rest(columns):
        value = "1,0,0,0" if "q" in columns else "0.5"
        (tmp_path / "rest.csv").write_text(f"t_s,{columns}\n" + "".join(f"{0.1 * k:.1f},{value}\n" for k in range(30)))
        toml = TOML.replace("noise = { position = 0.01 }", 'static = "rest.csv"')
        return experiment(tmp_path, toml=toml)

    measured(at_rest("z_m"))
    with pytest.warns(InputWarning, match="measurement.static: file 'rest.csv' holds y of a body at rest, and .* hold z"):
        measured(at_rest("y_m"))
    with pytest.raises(InputError, match="line 7: measurement.static: file 'rest.csv' holds rx, ry, rz of a body at rest"):
        measured(at_rest("qw,qx,qy,qz"))


def test_a_noise_of_nothing_that_was_recorded_is_refused_beside_a_recording_at_rest_too(tmp_path):
    (tmp_path / "rest.csv").write_text("t_s,z_m\n" + "".join(f"{0.1 * k:.1f},0.5\n" for k in range(30)))
    toml = TOML.replace("noise = { position = 0.01 }", 'noise = { orientation = 0.01 }\nstatic = "rest.csv"')
    with pytest.raises(InputError, match="line 7: measurement.noise: is of orientation, and the recordings hold position alone"):
        measured(experiment(tmp_path, toml=toml))


def test_a_column_that_is_wholly_blank_is_told(tmp_path):
    rows = "".join(f"{0.1 * k:.1f},{1 - 0.05 * k * k:.4f},\n" for k in range(8))
    with pytest.warns(InputWarning, match="a.csv, row 1: column 'x_m' is wholly blank: taken as not recorded"):
        measured(experiment(tmp_path, "t_s,z_m,x_m\n" + rows))
