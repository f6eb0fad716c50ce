"""A ball let go in a liquid, with nothing in the model: lift, drag and set-in-motion liquid are all missing, and all are strong.

Closed forms. At rest at first, with the mass m + rho V/2 and the weight W = (m - rho V) g: with F = -k v^2 the way is
(v_e^2/a) ln cosh(a t/v_e), a = W/(m + rho V/2), v_e^2 = W/k; with F = -r v it is v_e (t - T (1 - exp(-t/T))), v_e = W/r,
T = v_e/a.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from hard_cases import ball, path_of, per_metre, write

import hlcs
import minibullet as mb
from hlcs.data.bodies import Body
from hlcs.data.experiment_file import Surroundings
from hlcs.data.rigid_body import rigid_body
from hlcs.effects.candidates import candidate
from hlcs.kinds.trajectories.sinking import drags_between_impacts, drags_shown

G = 9.81
RADIUS = 0.00635
VOLUME = 4 / 3 * np.pi * RADIUS**3
MADE = {"buoyancy": "fluid_density", "added_mass": "coefficient"}


def way(times, mass, fluid, drag=None, viscosity=None):
    """Heights below the place of release (n,) of a ball of RADIUS; drag: its coefficient, or the viscosity of Stokes's law."""
    weight, moved = (mass - fluid * VOLUME) * G, mass + fluid * VOLUME / 2
    start = abs(weight) / moved
    if viscosity is not None:
        final = abs(weight) / (6 * np.pi * viscosity * RADIUS)
        fallen = final * (times + final / start * np.expm1(-times * start / final))
    else:
        final = np.sqrt(2 * abs(weight) / (fluid * drag * np.pi * RADIUS**2))
        fallen = final**2 / start * np.log(np.cosh(start * times / final))
    return np.sign(weight) * fallen


def write_ball(folder, density, fluid, stated, **law):
    """Six recordings of 1.5 s at 60 Hz, noise 1 mm; [model] is empty, the viscosity that is stated may be another one."""
    generator, times = np.random.default_rng(3), np.arange(0, 1.5, 1 / 60)
    heights = -way(times, density * VOLUME, fluid, **law)
    recordings = [(times, heights[:, None] + 1e-3 * generator.standard_normal((len(times), 1))) for _ in range(6)]
    around = f"fluid_density = {fluid}\nfluid_viscosity = {stated}\n"
    settings = ball(RADIUS, density * VOLUME, around, "noise = { position = 0.001 }")
    return write(folder, recordings, settings, columns=["z_m"])


@pytest.mark.parametrize("density", [1140.0, 900.0])
def test_three_strong_effects_of_water_are_found_whether_a_ball_sinks_or_rises(tmp_path, density):
    """Where a ball is near its final speed at once nothing is foreseen of a drag from a model in which it falls freely."""
    diagnosis = hlcs.diagnose(write_ball(tmp_path, density, 998.0, 1e-3, drag=0.47))
    assert diagnosis.verdict == "effect" and set(diagnosis.effects) == {*MADE, "quadratic_drag"}
    for name, number, true in (("buoyancy", "fluid_density", 998.0), ("quadratic_drag", "drag_coefficient", 0.47)):
        told = diagnosis.parameters[name][number]
        assert told["low"] <= true <= told["high"]


def test_a_viscosity_that_is_not_the_stated_one_is_found_beside_the_lift(tmp_path):
    """1.6 Pa s where 2.2 is stated: water in the glycerine, or a warm room. The Reynolds number stays below 1."""
    diagnosis = hlcs.diagnose(write_ball(tmp_path, 2500.0, 1260.0, 2.2, viscosity=1.6))
    told = diagnosis.parameters["stokes_drag"]["viscosity"]
    assert diagnosis.verdict == "effect" and told["low"] <= 1.6 <= told["high"]


AROUND = Surroundings(gravity=G, fluid_density=1000.0, fluid_viscosity=0.5, fluid_stated=True)
BODY = Body("sphere", radius=RADIUS, mass=2000.0 * VOLUME)


def shown(times, heights, aside=0.0):
    """What one recording of BODY shows of three drags; aside: its speed along x."""
    position = np.outer(heights, [0.0, 0.0, 1.0]) + np.outer(times, [aside, 0.0, 0.0])
    trial = SimpleNamespace(times=times, position=position, body=BODY, surroundings=AROUND)
    laws = [
        candidate(kind, AROUND, rigid_body(BODY), True)
        for kind in (mb.QuadraticDrag, mb.StokesDrag, mb.SphereDrag, mb.DragCrisis)
    ]
    return drags_shown(laws, [trial])


def test_at_the_final_speed_drag_is_the_weight_in_the_liquid():
    """There is no other force, so each law of one number is told exactly; a law of three is not read from one force."""
    times = np.linspace(3.0, 4.0, 60)  # a hundred times v_e/a at least
    read = shown(times, -way(times, BODY.mass, 1000.0, drag=0.5))
    assert set(read) == {"quadratic_drag", "stokes_drag", "sphere_drag"}
    assert read["quadratic_drag"]["drag_coefficient"] == pytest.approx(0.5, rel=1e-9)
    heights = -way(times, BODY.mass, 1000.0, viscosity=0.7)
    read = shown(times, heights)
    assert read["stokes_drag"]["viscosity"] == pytest.approx(0.7, rel=1e-9)
    thinner = read["sphere_drag"]["viscosity"]  # not in proportion to its number: less viscous, as fast and as much held back
    speed = (heights[0] - heights[-1]) / (times[-1] - times[0])
    assert thinner * (1 + 0.15 * (2 * RADIUS * 1000.0 * speed / thinner) ** 0.687) == pytest.approx(0.7, rel=1e-5)


def test_no_drag_is_read_where_a_body_falls_nearly_freely_or_is_thrown_up():
    times = np.linspace(0.0, 0.05, 60)
    assert shown(times, -way(times, BODY.mass, 1000.0, drag=0.5)) == {}
    times = np.linspace(1.0, 2.0, 60)
    assert shown(times, way(times, BODY.mass, 1000.0, drag=0.5)) == {}


@pytest.mark.parametrize(("aside", "read"), [(0.0, True), (0.5, True), (2.0, False)])
def test_no_drag_is_read_where_a_body_goes_farther_aside_than_down(aside, read):
    """The lift of a spin may carry it: a fast throw showed a thousand times its drag. This one sinks at 0.6 m/s."""
    times = np.linspace(1.0, 2.0, 60)
    assert bool(shown(times, -way(times, BODY.mass, 1000.0, drag=0.5), aside)) is read


def test_a_camera_that_leans_is_found_beside_gravity_that_leans(tmp_path):
    """Balls thrown into water, seen askew by 6 mrad: both do the same to a flight, so both are told, the angle by the camera."""
    generator, times, lean = np.random.default_rng(5), np.arange(0, 1.2, 1 / 60), 0.006
    turn = np.array([[np.cos(lean), 0, np.sin(lean)], [0, 1, 0], [-np.sin(lean), 0, np.cos(lean)]])
    speeds = generator.uniform((-0.8, -0.8, -0.3), (0.8, 0.8, 0.3), (6, 3))
    mass = 1.18 * 998.0 * VOLUME
    inertia = mass + 998.0 * VOLUME / 2

    def law(place, v):
        pull = np.array([0.0, 0.0, -G * (mass - 998.0 * VOLUME)])
        return (pull - per_metre(0.45, RADIUS, mass, 998.0) * mass * np.linalg.norm(v) * v) / inertia

    paths = [path_of(law, np.zeros(3), speed, times) @ turn.T for speed in speeds]
    recordings = [(times, path + 4e-4 * generator.standard_normal(path.shape)) for path in paths]
    effects = (
        '{ name = "buoyancy", fluid_density = 998.0 }, { name = "added_mass", coefficient = 0.5 }, '
        '{ name = "quadratic_drag", drag_coefficient = 0.45 }'
    )
    around = "fluid_density = 998.0\nfluid_viscosity = 0.001\n"
    settings = ball(RADIUS, mass, around, "noise = { position = 0.0004 }", effects)
    diagnosis = hlcs.diagnose(write(tmp_path, recordings, settings))
    assert diagnosis.verdict == "ambiguous" and {"tilted_frame", "tilted_gravity"} <= set(diagnosis.ambiguous[0])
    told = diagnosis.parameters["tilted_frame"]["angle_y"]
    assert told["low"] <= lean <= told["high"]


def test_a_drag_between_impacts_is_that_of_the_deceleration_it_gives():
    """k = 0.5 rho C A/(m + rho V/2), of a table tennis ball in air with C = 0.47; at a mean speed v a drag in proportion to it
    slows as much with the rate k v. A body that shows no drag, or is not known, shows no number."""
    radius, mass, density, speed = 0.02, 0.0027, 1.2, 3.0
    body, around = Body("sphere", radius=radius, mass=mass), Surroundings(fluid_density=density)
    trial, impacts = SimpleNamespace(body=body, surroundings=around), [SimpleNamespace(speed=speed + off) for off in (-1, 1)]
    inertia = mass + density * 4 / 3 * np.pi * radius**3 / 2
    k = 0.5 * density * 0.47 * np.pi * radius**2 / inertia
    known = rigid_body(body)
    laws = [candidate(law, around, known, True) for law in (mb.QuadraticDrag, mb.LinearDrag, mb.AddedMass)]
    shown = drags_between_impacts(laws, [trial], {(body, density): k}, impacts)
    assert shown["quadratic_drag"]["drag_coefficient"] == pytest.approx(0.47)
    assert shown["linear_drag"]["rate"] == pytest.approx(k * speed * inertia / mass)
    assert set(shown) == {"quadratic_drag", "linear_drag"}
    assert drags_between_impacts(laws, [trial], {(body, density): 0.0}, impacts) == {}


@pytest.mark.parametrize(("stated", "air"), [({}, True), ({"fluid_density": 0.0}, False)])
def test_a_file_that_states_no_fluid_means_air_and_0_means_a_vacuum(stated, air):
    """A table tennis ball, 2.7 g: its lift and the air that moves along take 1.8 % of g, as a wrong ruler would."""
    radius, mass, density, drag = 0.02, 0.0027, 1.2, 0.45
    generator, times, volume = np.random.default_rng(4), np.arange(0.0, 0.66, 0.02), 4 / 3 * np.pi * radius**3
    weight, moved = (mass - density * volume) * G, mass + density * volume / 2
    start, final = weight / moved, np.sqrt(2 * weight / (density * drag * np.pi * radius**2))
    heights = 2.0 - final**2 / start * np.log(np.cosh(start * times / final))
    frames = [{"t_s": times, "z_m": heights + 1e-3 * generator.standard_normal(len(times))} for _ in range(6)]
    body = {"shape": "sphere", "radius": radius, "mass": mass}
    experiment = hlcs.Experiment.from_frames(frames, body=body, surroundings=stated, noise={"position": 1e-3})
    found = hlcs.diagnose(experiment, candidates=["quadratic_drag", "added_mass", "buoyancy", "length_scale", "time_scale"])
    assert ({"quadratic_drag", "added_mass", "buoyancy"} == set(found.effects)) is air
    if air:
        told = found.parameters["quadratic_drag"]["drag_coefficient"]
        assert found.verdict in ("effect", "ambiguous") and told["low"] <= drag <= told["high"]
        assert found.sets[0]["parameters"]["buoyancy"]["fluid_density"] == pytest.approx(density, rel=0.05)
