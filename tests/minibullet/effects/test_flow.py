"""Effects that act through the drags of a model, each against the closed formula of its law (see test_fluid.py)."""

import numpy as np
import pytest
from one_ball import acceleration, ball, fall

from minibullet import effects
from minibullet.errors import InputError
from minibullet.rotations import exponential, rotate


def test_body_in_a_flow_takes_its_velocity():
    """With linear drag v = u (1 - exp(-k t))."""
    flow = effects.UniformFlow(1.0, -2.0, 0.5)
    v = fall([flow, effects.LinearDrag(3.0)], 0.7)
    assert np.allclose(v, np.array([1.0, -2.0, 0.5]) * (1 - np.exp(-2.1)), rtol=1e-8)


def test_flow_replaces_velocity_by_relative_velocity_in_every_force_of_the_fluid():
    """compose: the whole model with flow u at velocity v acts as the model without flow at v - u, in any order of the list."""
    u = np.array([1.0, -2.0, 0.5])
    body = ball(position=(0, 0, 0.15), velocity=(2, 1, -3), spin=(5, -4, 3), orientation=exponential([0.3, 0.5, -0.2]))
    fluid = [
        effects.QuadraticDrag(0.47, 1000.0),
        effects.LinearDrag(0.5),
        effects.Magnus(0.8, 1000.0),
        effects.OrientationDrag(1.4),
        effects.WallDrag(0.7),
        effects.TubeDrag(2.0),
    ]
    still = acceleration(fluid, body._replace(twist=body.twist - np.concatenate([u, np.zeros(3)])))
    flow = effects.UniformFlow(*u)
    for model in ([*fluid, flow], [flow, *fluid], [flow, *fluid[::-1]]):
        assert np.allclose(acceleration(model, body), still, rtol=1e-13)
    two_flows = [effects.UniformFlow(*(0.25 * u)), *fluid, effects.UniformFlow(*(0.75 * u))]
    assert np.allclose(acceleration(two_flows, body), still, rtol=1e-13)


def test_modifier_without_a_drag_is_refused_by_name():
    for modifier in (effects.UniformFlow(1.0), effects.OrientationDrag(1.5), effects.WallDrag(1.0), effects.TubeDrag(2.0)):
        with pytest.raises(InputError, match=f"{effects.name_of(modifier)} changes a drag.*, but the model has none"):
            effects.compose([effects.Gravity(), modifier])
    assert len(effects.compose([effects.UniformFlow()])) == 1
    with pytest.raises(ValueError, match="parentheses"):
        effects.compose([effects.Gravity])


def test_compose_keeps_what_it_was_told():
    bound = effects.UniformFlow(1.0, through=(effects.LinearDrag(1.0),))
    assert effects.compose([effects.QuadraticDrag(1.0), bound])[1] is bound


@pytest.mark.parametrize("ratio", [0.3, 0.8, 1.3, 3.0])
def test_orientation_drag_has_the_stated_face_edge_ratio_and_an_unchanged_mean(ratio):
    """Face on/edge on = ratio; the mean over directions, by the 26-point rule exact to degree 7, is the plain drag."""
    model = [effects.QuadraticDrag(1.0, 2.0), effects.OrientationDrag(ratio)]
    turn = exponential([0.4, -0.8, 0.3])

    def along(direction):
        direction = rotate(turn, np.array(direction) / np.linalg.norm(direction))
        return -acceleration(model, ball(velocity=direction, orientation=turn)) @ direction

    faces, edges, corners = along([1, 0, 0]), along([1, 1, 0]), along([1, 1, 1])
    assert faces / edges == pytest.approx(ratio, rel=1e-12)
    plain = -acceleration(model[:1], ball(velocity=(1, 0, 0)))[0]
    # weights of the 26-point rule: 1/21, 4/105, 9/280 (Abramowitz and Stegun 25.4.65)
    assert 6 / 21 * faces + 12 * 4 / 105 * edges + 8 * 9 / 280 * corners == pytest.approx(plain, rel=1e-12)
    assert min(faces, edges, corners) > 0.0


def test_orientation_drag_pushes_sideways_only_off_the_axes_of_symmetry():
    model = [effects.LinearDrag(1.0), effects.OrientationDrag(2.0)]
    assert np.allclose(acceleration(model, ball(velocity=(1, 1, 0)))[2], 0.0, atol=1e-15)
    askew = acceleration(model, ball(velocity=(2, 1, 0)))
    assert abs(askew[0] * 1 - askew[1] * 2) > 0.1


def test_wall_drag_is_faxens_first_order():
    """Touching the wall the drag is 1 + 9/16 along and 1 + 9/8 towards it; at h = 4 r a quarter of the additions."""
    drag, wall = effects.LinearDrag(1.0), effects.WallDrag(1.0, wall_height=-0.5)
    for h, share in ((0.1, 1.0), (0.4, 0.25)):
        a = acceleration([drag, wall], ball(position=(7, 8, h - 0.5), velocity=(1, 0, -1)))
        assert np.allclose(a, [-1 - 9 / 16 * share, 0, 1 + 9 / 8 * share], rtol=1e-13)


def test_a_tube_adds_to_the_drag_of_a_creeping_sphere_as_the_exact_solution_has_it():
    """1.263, 1.680, 2.371, 3.596 and 5.970 times at a tenth to five tenths of its radius: the table of W. L. Haberman and
    R. M. Sayre, David Taylor Model Basin Report 1143 (1958), whose closed form is in use; it is 1.7 % small at the last."""
    for ratio, times in ((0.1, 1.263), (0.2, 1.680), (0.3, 2.371), (0.4, 3.596), (0.5, 5.970)):
        found = acceleration([effects.LinearDrag(1.0), effects.TubeDrag(ratio / 0.1)], ball(velocity=(0, 0, -1)))
        assert np.allclose(found, [0, 0, times], rtol=0.001 if ratio < 0.4 else 0.02)


def test_a_tube_adds_to_what_is_in_proportion_to_speed_alone():
    """The inertia of the fluid feels no walls; to a drag that goes with the square of the speed alone nothing could be added."""
    body, tube, law = ball(velocity=(0, 0, -1)), effects.TubeDrag(1.0), effects.SphereDrag(1e-3, 1000.0)
    added = acceleration([law, tube], body) - acceleration([law], body)
    assert np.allclose(added, [0, 0, 0.263 * law.resistance(body)[0] / body.mass[0]], rtol=0.003, atol=1e-15)
    with pytest.raises(InputError, match="add sphere_drag, stokes_drag or linear_drag"):
        acceleration([effects.QuadraticDrag(0.5, 1000.0), tube], body)
