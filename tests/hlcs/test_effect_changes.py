"""Candidates that are not forces, each against its own definition: what they make of a set-up, a motion and a table."""

import numpy as np
import pytest

from hlcs.data.experiment_file import Body, Surroundings
from hlcs.data.recordings import Trial
from hlcs.effects.body import InertiaError
from hlcs.effects.contract import Change, Scene, Setup
from hlcs.effects.ground import BottomSlope
from hlcs.effects.measurement import ClockOffset, TiltedFrame, TrackerSmoothing
from hlcs.simulation.model import Model
from minibullet import rotations

BOX = Body(shape="box", size=(0.1, 0.2, 0.4), mass=2.0)
STILL = Scene(np.zeros((1, 3)), np.array([True]), None, 0.0, 1.0)
TIMES = np.linspace(0, 1, 7)[None]


def parabola(times):
    """A throw, seen exactly: positions and a steady turn about z."""
    position = np.stack([2 * times, 0 * times, 3 * times - 4.905 * times**2], axis=-1)
    return position, rotations.exponential(times[..., None] * np.array([0, 0, 2.0]))


def test_a_change_that_overrides_nothing_changes_nothing():
    setup, inputs = Setup(BOX, Surroundings()), {"height_m": np.ones(3)}
    assert Change().setup(setup) is setup and Change().look(parabola, STILL) is parabola
    assert Change().inputs(inputs, "s") is inputs and Change().outcome(3.0, "m") == 3.0


def test_a_tilted_frame_turns_what_is_seen():
    """Rotated by both angles: lengths stay, and gravity seems to lean by -9.81 sin(angle) along x."""
    position, orientation = TiltedFrame(angle_x=0.0, angle_y=0.03).look(parabola, STILL)(TIMES)
    true, turned = parabola(TIMES)
    np.testing.assert_allclose(np.linalg.norm(position, axis=-1), np.linalg.norm(true, axis=-1), rtol=1e-12)
    assert 2 * np.polyfit(TIMES[0], position[0, :, 0], 2)[0] == pytest.approx(-9.81 * np.sin(0.03), rel=1e-9)
    lean = rotations.product(orientation, rotations.conjugate(turned))
    np.testing.assert_allclose(rotations.logarithm(lean)[0], np.tile([0, 0.03, 0], (7, 1)), atol=1e-12)


def test_a_smoothing_tracker_lowers_a_parabola_by_its_curvature():
    """The mean of a t^2 / 2 over a window w lies a w^2 / 24 beside it; a window of zero is none."""
    true = parabola(TIMES)[0]
    seen = TrackerSmoothing(window=0.1).look(parabola, STILL)(TIMES)[0]
    np.testing.assert_allclose(seen - true, np.broadcast_to([0, 0, -9.81 * 0.1**2 / 24], true.shape), atol=1e-13)
    np.testing.assert_array_equal(TrackerSmoothing(window=0.0).look(parabola, STILL)(TIMES)[0], true)


def test_a_bottom_slope_leans_the_floor_and_needs_one():
    setup = Setup(BOX, Surroundings(floor_height=0.0))
    normal = np.array(BottomSlope(grade_x=0.02, grade_y=-0.05).setup(setup).surroundings.floor_normal)
    np.testing.assert_allclose(normal, np.array([-0.02, 0.05, 1]) / np.linalg.norm([0.02, 0.05, 1]), rtol=1e-14)
    nowhere = Setup(BOX, Surroundings())
    assert BottomSlope(grade_x=0.02).setup(nowhere) is nowhere


def test_inertia_errors_are_factors_within_what_a_solid_can_have():
    """m/12 (b2 + c2) ...; the largest moment of a solid is at most the sum of the others."""
    own = 2.0 / 12 * np.array([0.2**2 + 0.4**2, 0.1**2 + 0.4**2, 0.1**2 + 0.2**2])
    setup = Setup(BOX, Surroundings())
    np.testing.assert_allclose(InertiaError(factor_x=1.1).setup(setup).body.inertia, own * (1.1, 1, 1), rtol=1e-12)
    beyond = InertiaError(factor_x=4.0).setup(setup).body.inertia
    assert beyond[0] == pytest.approx(beyond[1] + beyond[2], rel=1e-12) and beyond[1:] == pytest.approx(own[1:], rel=1e-12)


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


def test_a_late_clock_shows_the_motion_later_and_a_body_at_rest_until_then():
    position, _ = ClockOffset(0.25).look(parabola, STILL)(TIMES)
    expected, _ = parabola(np.maximum(TIMES - 0.25, 0.0))
    np.testing.assert_array_equal(position, expected)
