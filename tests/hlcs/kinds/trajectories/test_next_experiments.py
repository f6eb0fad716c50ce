"""What is offered as the next experiment, by what moves and where: each can be done by whoever made the recordings."""

import numpy as np
import pytest
from throws import G, csv

from hlcs.data.experiment_file import read_experiment_file
from hlcs.data.recordings import read_recordings
from hlcs.kinds.trajectories.preparation import prepare

TIMES = np.arange(0, 0.6, 1 / 60)
SPHERE = '[body]\nshape = "sphere"\nradius = {radius}\nmass = {mass}\n'
BOX = '[body]\nshape = "box"\nsize = [0.12, 0.08, 0.04]\nmass = 0.4\n'
FLOOR = "[surroundings]\nfriction = 0.3\nfloor = { height = 0.0 }\n"
CARRIED = (
    '{ name = "buoyancy" }, { name = "added_mass", coefficient = 0.5 }, { name = "quadratic_drag", drag_coefficient = 0.45 }'
)
WATER = f"[surroundings]\nfluid_density = 998.0\n[model]\neffects = [{CARRIED}]\n"
AT_REST = "start = { velocity = [0.0, 0.0, 0.0], angular_velocity = [0.0, 0.0, 0.0] }\n"
STANDING = AT_REST.replace(
    "start = {", "start = { position = [0.0, 0.0, 0.04], orientation = [0.70710678, 0.70710678, 0.0, 0.0],"
)


def flown(velocity):
    return [0, 0, 1.5] + np.outer(TIMES, velocity) - np.outer(G / 2 * TIMES**2, [0, 0, 1])


def sunk(speed):
    return [0, 0, 1.0] - np.outer(speed * TIMES, [0, 0, 1])


def slid(speed, height):
    stop = speed / (0.3 * G)
    way = np.where(stop > TIMES, speed * TIMES - 0.15 * G * TIMES**2, speed * stop / 2)
    return np.column_stack([way, 0 * TIMES, 0 * TIMES + height])


def bounced(gap, radius):
    """A ball let fall by `gap` that stays where it lands."""
    return np.column_stack([0 * TIMES, 0 * TIMES, radius + np.maximum(gap - G / 2 * TIMES**2, 0.0)])


def rolled(angle):
    """A ball of 2 cm let go on a board that falls along x."""
    normal, down = np.array([np.sin(angle), 0, np.cos(angle)]), np.array([np.cos(angle), 0, -np.sin(angle)])
    return 0.02 * normal + np.outer(5 / 14 * G * np.sin(angle) * TIMES**2, down)


def board(angle):
    normal = [float(np.sin(angle)), 0.0, float(np.cos(angle))]
    place = [0.02 * part for part in normal]
    start = AT_REST.replace("start = {", f"start = {{ position = {place}, orientation = [1.0, 0.0, 0.0, 0.0],")
    return f"floor = {{ height = 0.0, normal = {normal} }}\n{start}"


# where 0.45 of rho v^2/2 pi r^2 carries the weight less the buoyancy [m/s]
SINKING = float(np.sqrt((0.0012 - 998 * 4 / 3 * np.pi * 0.006**3) * G / (0.5 * 998 * 0.45 * np.pi * 0.006**2)))
BALL, BEAD = SPHERE.format(radius=0.03, mass=0.1), SPHERE.format(radius=0.006, mass=0.0012)
SCENES = {  # what moves -> (settings, recordings, columns, what stands beside each recording, inputs that may be changed)
    "a throw": (BALL, [flown([2, 1, 3]), flown([3, 0, 2])], "xyz", "", {"speed_m_s", "heading_deg", "duration", "mass_kg"}),
    "a throw seen from aside": (BALL, [flown([2, 0, 3])], "xz", "", {"speed_m_s", "heading_deg", "duration", "mass_kg"}),
    "a fall": (BALL, [flown([0, 0, 0])], "z", AT_REST, {"duration", "mass_kg"}),
    "a bead in water": (BEAD + WATER, [sunk(SINKING)], "xyz", "", {"duration", "mass_kg"}),
    "a bounce": (BALL + FLOOR, [bounced(1.0, 0.03)], "xyz", AT_REST, {"raise_m", "mass_kg"}),
    "a block on a floor": (BOX + FLOOR, [slid(1.2, 0.02)], "xyz", "", {"speed_m_s", "heading_deg", "mass_kg"}),
    "a puck seen from above": (BOX + FLOOR, [slid(1.2, 0.02)], "xy", "", {"speed_m_s", "heading_deg", "mass_kg"}),
    "a ball on a board": (
        SPHERE.format(radius=0.02, mass=0.26) + FLOOR,
        [rolled(0.07)],
        "xyz",
        board(0.07),
        {"angle_deg", "mass_kg"},
    ),
    "a slab on its edge": (BOX + FLOOR, [0 * flown([0, 0, 0]) + [0, 0, 0.04]], "xyz", STANDING, {"mass_kg"}),
}


def opened(folder, name, times=None):
    """The problem of a scene, and the fit of its model; times: of a fall from rest, where it is not as long as the others."""
    settings, recordings, axes, beside, _ = SCENES[name]
    if times is None:
        times = TIMES
    else:
        recordings = [np.outer(3.0 - G / 2 * times**2, [0, 0, 1])]
    text = 'kind = "trajectory"\n' + settings + "[measurement]\nnoise = { position = 0.002 }\n"
    for k, positions in enumerate(recordings * 2):
        seen = positions + 0.002 * np.random.default_rng(k).standard_normal(positions.shape)
        columns = ["xyz".index(axis) for axis in axes]
        (folder / f"r{k}.csv").write_text(csv(times, seen[:, columns], [f"{axis}_m" for axis in axes]))
        text += f'[[trial]]\nfile = "r{k}.csv"\ngroup = "day {k % 2}"\n{beside}'
    (folder / "e.toml").write_text(text)
    prepared = prepare(read_recordings(read_experiment_file(folder / "e.toml")))
    return prepared.problem, prepared.base


@pytest.mark.parametrize("name", SCENES)
def test_what_is_offered_can_be_done_with_this_body_in_this_place(tmp_path, name):
    problem, fit = opened(tmp_path, name)
    new = problem.designs(fit, fit)
    assert {key for design in new.options for key in design.what} == SCENES[name][-1] | {"repeat"}
    assert len(new.options) == len(new.initial_states) == len(new.problem.trials)


def test_a_fall_is_not_made_longer_than_a_stairwell_is_high(tmp_path):
    """0.6 s is 1.7 m, twice that time 6.9 m; 0.9 s is 3.9 m, twice that 15 m: a longer recording is kept only of the first."""
    for seconds, offered in ((0.6, True), (0.9, False)):
        problem, fit = opened(tmp_path, "a fall", np.arange(0, seconds, 1 / 60))
        told = [design.text for design in problem.designs(fit, fit).options if "duration" in design.what]
        assert [text.endswith("m higher") for text in told] == [True] * offered


def test_a_block_is_not_sent_further_than_its_camera_sees(tmp_path):
    """A way goes with the square of the speed: twice as fast is four times as far, four times as fast 16 times."""
    problem, fit = opened(tmp_path, "a block on a floor")
    speeds = sorted(design.what["speed_m_s"] for design in problem.designs(fit, fit).options if "speed_m_s" in design.what)
    assert np.allclose(speeds, [0.3, 0.6, 2.4], rtol=0.05)  # the start is fitted: 2 mm of noise in 12 cm


@pytest.mark.parametrize(
    ("name", "scene"),
    [
        ("a throw", {"upright": True, "touching": False, "liquid": False}),
        ("a bead in water", {"upright": True, "touching": False, "liquid": True}),
        ("a bounce", {"upright": True, "touching": False, "level": True}),
        ("a puck seen from above", {"upright": False, "touching": True, "level": True}),
        ("a ball on a board", {"upright": True, "touching": True, "level": False}),
    ],
)
def test_a_direct_reading_knows_the_scene_it_is_made_in(tmp_path, name, scene):
    camera = opened(tmp_path, name)[0].camera
    assert {key: getattr(camera, key) for key in scene} == scene and camera.filmed
