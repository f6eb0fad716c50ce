"""Small experiments without noise: what an effect leaves in the data of one when the model lacks it.

Each effect belongs to one experiment. The motion is computed twice, with the effect and without; the difference is the residual
that a model without the effect would have, its start known exactly.
"""

from dataclasses import dataclass, field

import numpy as np

from hlcs.data.bodies import Body
from hlcs.data.experiment_file import Surroundings
from hlcs.data.recordings import Trial
from hlcs.effects import class_named
from hlcs.simulation.model import Model
from minibullet import rotations

BALL = Body("sphere", radius=0.0335, mass=0.0577)  # a tennis ball
STONE = Body("sphere", radius=0.05, mass=1.3)  # 2480 kg/m3
BOX = Body("box", size=(0.2, 0.15, 0.1), mass=2.0)
CUBE = Body("box", size=(0.1, 0.1, 0.1), mass=0.05)
FLOOR = Surroundings(floor_height=0.0)
DRAG = {"name": "quadratic_drag", "drag_coefficient": 0.5}
STILL = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class StandardExperiment:
    """One motion, told in a sentence."""

    told: str
    body: Body
    surroundings: Surroundings
    position: tuple  # at the start [m]
    velocity: tuple  # [m/s]
    duration: float  # [s]
    spin: tuple = STILL  # [rad/s]
    model: tuple = ()  # effects that both runs have
    effects: dict = field(default_factory=dict)  # {name: {number: value}}


EXPERIMENTS = (
    StandardExperiment(
        "a tennis ball falls 9 m in air",
        BALL,
        Surroundings(),
        (0.0, 0.0, 9.0),
        STILL,
        1.3,
        effects={
            "quadratic_drag": {"drag_coefficient": 0.47},
            "linear_drag": {"rate": 0.037},
            "buoyancy": {"fluid_density": 1.2},
            "length_scale": {"factor": 1.02},
            "time_scale": {"factor": 1.001},
            "clock_offset": {"offset": 0.033},
            "calibration_curve": {"c_2": 0.02},
        },
    ),
    StandardExperiment(
        "a tennis ball that is known to have drag falls 9 m in air",
        BALL,
        Surroundings(),
        (0.0, 0.0, 9.0),
        STILL,
        1.3,
        model=(DRAG,),
        effects={"mass_offset": {"relative": 0.01}, "size_error": {"relative": 0.005}},
    ),
    StandardExperiment(
        "a smooth ball of 0.2 m falls 200 m in air, through the crisis of its drag",
        Body("sphere", radius=0.1, mass=3.0),
        Surroundings(),
        (0.0, 0.0, 200.0),
        STILL,
        6.0,
        effects={"drag_crisis": {"subcritical": 0.47, "supercritical": 0.1, "critical_reynolds": 3e5}},
    ),
    StandardExperiment(
        "a tennis ball with drag is thrown at 12 m/s, 45 degrees upwards",
        BALL,
        Surroundings(),
        (0.0, 0.0, 1.0),
        (8.5, 0.0, 8.5),
        1.7,
        model=(DRAG,),
        effects={"tilted_gravity": {"angle_x": 0.0087}, "tilted_frame": {"angle_x": 0.0087}, "uniform_flow": {"velocity_y": 1.5}},
    ),
    StandardExperiment(
        "a ball that spins at 5 turns a second about the vertical is thrown at 12 m/s, 45 degrees upwards",
        BALL,
        Surroundings(),
        (0.0, 0.0, 1.0),
        (8.5, 0.0, 8.5),
        1.7,
        spin=(0.0, 0.0, 31.4),
        effects={"magnus": {"coefficient": 1.0}, "spin_decay": {"rate": 0.05}},
    ),
    StandardExperiment(
        "a light cube with drag tumbles while it falls 9 m",
        CUBE,
        Surroundings(),
        (0.0, 0.0, 9.0),
        (1.0, 0.0, 0.0),
        1.3,
        spin=(3.0, 6.0, 2.0),
        model=({"name": "quadratic_drag", "drag_coefficient": 1.05},),
        effects={"orientation_drag": {"face_edge_ratio": 1.31}},
    ),
    StandardExperiment(
        "a box tumbles while it is thrown",
        BOX,
        Surroundings(),
        (0.0, 0.0, 1.0),
        (2.0, 0.0, 5.0),
        1.0,
        spin=(2.0, 5.0, 1.0),
        effects={"inertia_error": {"factor_y": 1.2}, "centre_of_mass_offset": {"x": 0.05}},
    ),
    StandardExperiment(
        "a stone of 0.1 m sinks 2 m in water",
        STONE,
        Surroundings(fluid_density=1000.0, fluid_stated=True, fluid_viscosity=1e-3),
        (0.0, 0.0, 2.0),
        STILL,
        0.7,
        effects={"added_mass": {"coefficient": 0.5}, "history_force": {"multiplier": 1.0}},
    ),
    StandardExperiment(
        "a steel ball of 10 mm sinks in glycerine",
        Body("sphere", radius=0.005, mass=0.0041),
        Surroundings(fluid_density=1260.0, fluid_stated=True, fluid_viscosity=1.4),
        (0.0, 0.0, 0.5),
        STILL,
        0.3,
        effects={"sphere_drag": {"viscosity": 1.4}},
    ),
    StandardExperiment(
        "a steel bead of 2 mm sinks in glycerine",
        Body("sphere", radius=0.001, mass=3.27e-5),
        Surroundings(fluid_density=1260.0, fluid_stated=True, fluid_viscosity=1.4),
        (0.0, 0.0, 0.5),
        STILL,
        0.1,
        effects={"stokes_drag": {"viscosity": 1.4}},
    ),
    StandardExperiment(
        "a steel bead of 10 mm sinks in glycerine in a tube of 75 mm",
        Body("sphere", radius=0.005, mass=0.0041),
        Surroundings(fluid_density=1260.0, fluid_stated=True, fluid_viscosity=1.4),
        (0.0, 0.0, 0.5),
        STILL,
        0.3,
        model=({"name": "sphere_drag", "viscosity": 1.4},),
        effects={"tube_drag": {"inverse_radius": 27.0}},
    ),
    StandardExperiment(
        "a stone with drag sinks in water and comes near to the bottom",
        STONE,
        Surroundings(fluid_density=1000.0, fluid_stated=True, floor_height=0.0),
        (0.0, 0.0, 0.5),
        STILL,
        0.28,
        model=(DRAG,),
        effects={"wall_drag": {"multiplier": 1.0}, "ground_cushion": {"multiplier": 1.0}},
    ),
    StandardExperiment(
        "a box slides with 2 m/s over a floor",
        BOX,
        FLOOR,
        (0.0, 0.0, 0.05),
        (1.6, 1.2, 0.0),
        0.6,
        effects={
            "friction": {"coefficient": 0.6},
            "stribeck_friction": {"ratio": 1.3, "speed": 0.2},
            "viscous_friction": {"slope": 0.2},
            "load_dependent_friction": {"exponent": -0.1},
            "anisotropic_friction": {"ratio": 1.5, "angle": 0.0},
            "bottom_slope": {"grade_x": 0.02},
        },
    ),
    StandardExperiment(
        "a box stands on a floor that is moved to 29 degrees, beyond the angle of friction",
        BOX,
        Surroundings(floor_height=0.0, floor_normal=(0.4848, 0.0, 0.8746)),
        (0.02424, 0.0, 0.04373),
        STILL,
        0.6,
        effects={"static_friction": {"ratio": 1.3}},
    ),
    StandardExperiment(
        "a ball rolls with 1 m/s over a floor",
        BALL,
        FLOOR,
        (0.0, 0.0, 0.0335),
        (1.0, 0.0, 0.0),
        1.5,
        spin=(0.0, 29.85, 0.0),
        effects={"rolling_friction": {"arm": 0.0003}},
    ),
    StandardExperiment(
        "a ball spins on the spot, 1.6 turns a second",
        BALL,
        FLOOR,
        (0.0, 0.0, 0.0335),
        STILL,
        0.8,
        spin=(0.0, 0.0, 10.0),
        effects={"spinning_friction": {"arm": 0.0003}},
    ),
    StandardExperiment(
        "a box lighter than water, 600 kg/m3, is let go on the bottom of a tank",
        Body("box", size=(0.2, 0.15, 0.1), mass=1.8),
        Surroundings(fluid_density=1000.0, fluid_stated=True, floor_height=0.0),
        (0.0, 0.0, 0.05),
        STILL,
        0.6,
        model=({"name": "buoyancy", "fluid_density": 1000.0},),
        effects={"adhesion": {"pull_off_force": 1.0}},
    ),
    StandardExperiment(
        "a ball falls 1 m and bounces",
        BALL,
        Surroundings(floor_height=0.0, restitution=0.6),
        (0.0, 0.0, 1.0335),
        STILL,
        1.6,
        effects={
            "restitution": {"coefficient": 0.74},
            "velocity_dependent_restitution": {"exponent": 0.2},
            "tracker_smoothing": {"window": 0.17},
            "margin_offset": {"offset": 0.02},
            "accelerometer_offset": {"x": 0.2},
        },
    ),
)


def experiment_of(name):
    """The StandardExperiment of an effect."""
    return next(experiment for experiment in EXPERIMENTS if name in experiment.effects)


def motion(experiment, entries, count=161):
    """Times (n,), positions (n, 3) and orientations (n, 4) of an experiment with these effects of [model]."""
    times = np.linspace(0.0, experiment.duration, count)
    blank = np.full((count, 3), np.nan)
    blank[:, 2] = np.linspace(experiment.position[2], 0.0, count)  # from which the range of heights is taken
    orientation = rotations.exponential(np.zeros(3))
    if experiment.surroundings.floor_normal != (0.0, 0.0, 1.0):
        orientation = rotations.between(np.array([0.0, 0.0, 1.0]), np.array(experiment.surroundings.floor_normal))
    start = {"position": experiment.position, "velocity": experiment.velocity, "angular_velocity": experiment.spin}
    trial = Trial("", "", times, blank, np.full((count, 4), np.nan), start, experiment.body, experiment.surroundings)
    state = np.concatenate([experiment.position, experiment.velocity, orientation, experiment.spin])
    return (times, *Model(fixed=(*experiment.model, *entries)).run(trial, state, times))


def residual(name):
    """(times (n,), residual (n,), what it is with its unit): with the effect less without, along the axis where it is largest."""
    experiment = experiment_of(name)
    times, position, orientation = motion(experiment, [{"name": name, **experiment.effects[name]}])
    _, without, level = motion(experiment, [])
    moved = position - without
    turned = rotations.logarithm(rotations.product(orientation, rotations.conjugate(level)))
    axis = int(np.abs(moved).max(axis=0).argmax())
    if np.abs(moved).max() > 1e-9:
        return times, moved[:, axis], f"{'xyz'[axis]}: measured - model [m]"
    if np.abs(turned).max() < 1e-9:
        read = class_named(name)(**experiment.effects[name]).read(np.zeros_like(moved))
        axis = int(np.abs(read).max(axis=0).argmax())
        return times, read[:, axis], f"acceleration along {'xyz'[axis]}: measured - model [m/s2]"
    axis = int(np.abs(turned).max(axis=0).argmax())
    return times, turned[:, axis], f"turn about {'xyz'[axis]}: measured - model [rad]"
