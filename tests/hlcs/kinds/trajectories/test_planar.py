"""Motion in a plane, its height not measured: a puck on a table of air."""

import numpy as np
import pytest

import hlcs
from hlcs.data.experiment_file import read_experiment_file
from hlcs.data.recordings import read_recordings
from minibullet.errors import InputError

BODY = {"shape": "sphere", "radius": 0.04, "mass": 0.02}
G, SIGMA = 9.81, 0.0005


def pucks(drag=0.0, tilt=0.0, count=6):
    """Frames of pucks sent off in all directions, slowed by drag [1/m] along their way, or drawn along x by a tilt [rad]."""
    draw, times, frames = np.random.default_rng(4), np.linspace(0.0, 2.0, 61), []
    for index in range(count):
        heading, speed = 2 * np.pi * index / count, 0.6 + 0.2 * index
        way = np.log1p(drag * speed * times) / drag if drag else speed * times  # v' = -k v^2 along a straight line
        x, y = way * np.cos(heading) + G * np.sin(tilt) * times**2 / 2, way * np.sin(heading)
        frames.append({"t_s": times, "x_m": x + SIGMA * draw.standard_normal(61), "y_m": y + SIGMA * draw.standard_normal(61)})
    return frames


def experiment(frames, planar=True):
    trials = [{"group": str(index % 2)} for index in range(len(frames))]
    measurement = {"planar": True} if planar else {}
    return hlcs.Experiment.from_frames(
        frames, BODY, {"fluid_density": 1.2}, noise={"position": SIGMA}, trials=trials, measurement=measurement
    )


def test_a_puck_that_nothing_slows_misses_nothing():
    found = hlcs.diagnose(experiment(pucks()), candidates=["linear_drag", "quadratic_drag", "tilted_gravity", "uniform_flow"])
    assert found.verdict == "complete"


def test_the_drag_of_a_puck_holds_no_fall():
    """Drag of C = 0.47; with a height to be fitted the body falls by 20 m in these 2 s, and its drag is that of the fall."""
    per_metre = 0.5 * 1.2 * 0.47 * np.pi * 0.04**2 / 0.02
    found = hlcs.diagnose(experiment(pucks(drag=per_metre)), candidates=["linear_drag", "quadratic_drag", "tilted_gravity"])
    assert (found.verdict, found.effects) == ("effect", ("quadratic_drag",))
    number = found.parameters["quadratic_drag"]["drag_coefficient"]
    assert number["low"] < 0.47 < number["high"] and number["high"] - number["low"] < 0.05


def test_a_table_that_leans_is_found():
    found = hlcs.diagnose(experiment(pucks(tilt=0.01)), candidates=["quadratic_drag", "tilted_gravity"])
    assert found.effects == ("tilted_gravity",)
    numbers = found.parameters["tilted_gravity"]
    assert np.hypot(*(number["value"] for number in numbers.values())) == pytest.approx(0.01, rel=0.02)


@pytest.mark.parametrize(
    ("columns", "planar", "message"),
    [
        ("t_s,x_m,z_m", "true", "a.csv, column z_m: a height, where measurement.planar = true; leave out the column, or planar"),
        ("t_s,qw,qx,qy,qz", "true", "a.csv: measurement.planar = true, but neither x_m nor y_m is recorded"),
        ("t_s,x_m,y_m", '"yes"', "e.toml, line 2: measurement.planar: must be true or false, got 'yes'"),
    ],
)
def test_what_is_no_motion_in_a_plane_is_refused(tmp_path, columns, planar, message):
    width = columns.count(",")
    rows = "".join(f"{0.1 * k:.1f}" + (",1,0,0,0" if width == 4 else ",0.5" * width) + "\n" for k in range(8))
    (tmp_path / "a.csv").write_text(columns + "\n" + rows)
    head = 'kind = "trajectory"\nmeasurement = { planar = ' + planar + ", noise = { position = 0.01, orientation = 0.01 } }\n"
    (tmp_path / "e.toml").write_text(head + '[[trial]]\nfile = "a.csv"\n')
    with pytest.raises(InputError) as problem:
        read_recordings(read_experiment_file(tmp_path / "e.toml"))
    assert message in str(problem.value)


def test_a_disc_that_turns_on_its_flat_side_is_not_cut_as_a_body_that_tumbles():
    """Its slide is steady, whatever its orientations scatter by: one start for each recording, and its height is not measured."""
    draw, times = np.random.default_rng(6), np.arange(40) / 40
    frames = []
    for spin in (8.0, -5.0):
        angle = spin * times - 2.5 * np.sign(spin) * times**2 + 0.01 * draw.standard_normal(40)
        place = np.outer(0.6 * times - 0.25 * times**2, (1.0, 0.0)) + SIGMA * draw.standard_normal((40, 2))
        turned = {"qw": np.cos(angle / 2), "qx": 0 * angle, "qy": 0 * angle, "qz": np.sin(angle / 2)}
        frames.append({"t_s": times, "x_m": place[:, 0], "y_m": place[:, 1], **turned})
    body = {"shape": "disc", "radius": 0.04, "height": 0.02, "mass": 0.17}
    around = {"floor": {"height": 0.0}, "friction": 0.05}
    noise = {"position": SIGMA, "orientation": 0.01}
    compared = hlcs.compare(hlcs.Experiment.from_frames(frames, body, around, noise=noise, measurement={"planar": True}))
    assert not any("split" in note for note in compared.notes)


def test_a_puck_that_stops_elsewhere_has_another_friction(tmp_path):
    """30 frames a second, each recording with a stop in it: no law in the place of the friction, no larger noise beside it. A
    length scale of 0.18/0.25 would do as well, and is no scale that a ruler has."""
    draw, times, frames = np.random.default_rng(5), np.arange(36) / 30, []
    for speed, heading in ((0.9, 0.2), (1.3, 1.1), (1.1, -2.5), (1.5, 0.7)):
        moving = np.minimum(times, speed / (0.18 * G))
        way = speed * moving - 0.18 * G * moving**2 / 2
        seen = np.outer(way, (np.cos(heading), np.sin(heading))) + 0.001 * draw.standard_normal((36, 2))
        frames.append({"t_s": times, "x_m": seen[:, 0].round(3), "y_m": seen[:, 1].round(3)})
    found = hlcs.diagnose(
        hlcs.Experiment.from_frames(
            frames,
            {"shape": "disc", "radius": 0.04, "height": 0.02, "mass": 0.17},
            {"floor": {"height": 0.0}, "friction": 0.25},
            noise={"position": 0.001},
            trials=[{"group": str(index % 2)} for index in range(4)],
            measurement={"planar": True},
        )
    )
    assert (found.verdict, found.effects) == ("effect", ("friction",)), (found.sets, found.notes)
    number = found.parameters["friction"]["coefficient"]
    assert number["low"] < 0.18 < number["high"] and number["high"] - number["low"] < 0.005


def test_a_ball_whose_spin_nobody_measured_rolls_to_a_stop():
    """v' = -5/7 g arm/r. A start that slides a little at first does the same, so steps of a fit along its spin lead far.

    Four balls tell the arm to 0.2 %; the engine's steps of 4 ms to half a per cent."""
    draw, times, arm, radius = np.random.default_rng(7), np.arange(60) / 30, 0.0012, 0.02
    slowing, frames = 5 / 7 * G * arm / radius, []
    for speed, heading in ((0.5, 0.0), (0.7, 0.8), (0.9, -2.0), (0.6, 2.5)):
        moving = np.minimum(times, speed / slowing)
        way = speed * moving - slowing * moving**2 / 2
        seen = np.outer(way, (np.cos(heading), np.sin(heading))) + 0.0015 * draw.standard_normal((60, 2))
        frames.append({"t_s": times, "x_m": seen[:, 0], "y_m": seen[:, 1]})
    found = hlcs.diagnose(
        hlcs.Experiment.from_frames(
            frames,
            {"shape": "sphere", "radius": radius, "mass": 0.04},
            {"floor": {"height": 0.0}, "friction": 0.4},
            noise={"position": 0.0015},
            trials=[{"group": str(index % 2)} for index in range(4)],
            measurement={"planar": True},
        ),
        candidates=["rolling_friction"],
    )
    assert (found.verdict, found.effects) == ("effect", ("rolling_friction",)), found.notes
    assert found.parameters["rolling_friction"]["arm"]["value"] == pytest.approx(arm, rel=0.01)
