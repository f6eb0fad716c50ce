"""A body that is not what the file says: inertia and centre of mass, alone and in a run of the model."""

import numpy as np
import pytest

from hlcs.data.experiment_file import Body, Surroundings
from hlcs.data.recordings import Trial
from hlcs.effects.body import InertiaError
from hlcs.effects.contract import Setup
from hlcs.simulation.model import Model

BOX = Body(shape="box", size=(0.1, 0.2, 0.4), mass=2.0)


def test_inertia_errors_are_factors_within_what_a_solid_can_have():
    """m/12 (b2 + c2) ...; the largest moment of a solid is at most the sum of the others."""
    own = 2.0 / 12 * np.array([0.2**2 + 0.4**2, 0.1**2 + 0.4**2, 0.1**2 + 0.2**2])
    setup = Setup(BOX, Surroundings())
    np.testing.assert_allclose(InertiaError(factor_x=1.1).setup(setup).body.inertia, own * (1.1, 1, 1), rtol=1e-12)
    wanted = own * (4.0, 1.0, 1.0)
    nearest = np.array(InertiaError(factor_x=4.0).setup(setup).body.inertia)
    assert nearest[0] == pytest.approx(nearest[1] + nearest[2], rel=1e-12)
    np.testing.assert_allclose(np.cross(nearest - wanted, (-1.0, 1.0, 1.0)), 0.0, atol=1e-15)  # at right angles to that plane


def model(**offset):
    """The model with a centre of mass beside the tracked centre, in sides of the cube of equal volume (0.2 m)."""
    return Model(fixed=({"name": "centre_of_mass_offset", **offset},))


def trial(**surroundings):
    """A recording without samples: what a run of the model needs to know of one."""
    return Trial(
        name="run",
        group="",
        body=BOX,
        surroundings=Surroundings(fluid_density=0.0, **surroundings),
        start={},
        times=np.zeros(1),
        position=np.zeros((1, 3)),
        orientation=np.zeros((1, 4)),
    )


def test_in_flight_the_tracked_centre_circles_the_centre_of_mass():
    """Spin 5 rad/s about the principal axis z, arm 0.01 m along x: tracked = parabola of the centre of mass - R(t) arm."""
    start = np.array([0, 0, 1, 1, 0, 2, 1, 0, 0, 0, 0, 0, 5.0], dtype=float)
    times = np.linspace(0, 0.5, 6)
    position, _ = model(x=0.05).run(trial(), start, times)
    arm = 0.01 * np.column_stack([np.cos(5 * times), np.sin(5 * times), 0 * times])
    own = np.array([0.01, 0, 1]) + np.outer(times, [1, 0.05, 2]) + np.outer(-9.81 * times**2 / 2, [0, 0, 1])
    np.testing.assert_allclose(position, own - arm, atol=1e-9)


def test_on_a_floor_a_lower_centre_of_mass_slides_as_far():
    """Coulomb's law knows no height: v^2 / (2 mu g), and the tracked centre stays half a box above the floor."""
    start = np.array([0, 0, 0.2, 1.0, 0, 0, 1, 0, 0, 0, 0, 0, 0], dtype=float)
    ground = trial(floor_height=0.0, friction=0.2)
    position, _ = model(z=-0.05).run(ground, start, np.array([0.0, 1.0]))
    assert position[-1] == pytest.approx([1 / (2 * 0.2 * 9.81), 0, 0.2], abs=1e-3)  # rest is found to a step, v/240 m
