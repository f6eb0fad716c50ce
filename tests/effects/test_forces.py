"""Each force against the closed formula of its law.

Algebraic formulas are met to a few roundings (1e-12 relative); motions are integrated by scipy's DOP853 at 1e-11 and met to 1e-8.
"""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from minibullet import effects
from minibullet.bodies import Bodies
from minibullet.effects.samples import sample_bodies
from minibullet.errors import InputError
from minibullet.rotations import exponential, rotate

G = 9.81


def ball(position=(0, 0, 0), velocity=(0, 0, 0), spin=(0, 0, 0), radius=0.1, density=2000.0, orientation=(1, 0, 0, 0)):
    """One sphere as Bodies."""
    volume = 4 / 3 * np.pi * radius**3
    mass = density * volume
    one = (position, orientation, (*velocity, *spin), mass, [0.4 * mass * radius**2] * 3, volume, np.pi * radius**2, radius)
    return Bodies(*(np.array([value], dtype=float) for value in one))


def acceleration(model, bodies, time=0.0):
    """Linear acceleration of one body under effects: (m + added mass)^-1 force, (3,)."""
    model = effects.compose(model)
    mass = bodies.mass[0] * np.eye(3)
    added = effects.added_mass(model, bodies)
    if added is not None:
        mass = mass + added[0, :3, :3]
    return np.linalg.solve(mass, sum(effects.wrench(effect, bodies, time)[0, :3] for effect in model))


def fall(model, duration, body=None, velocity=(0, 0, 0)):
    """Velocity after a free flight, integrated far below the tolerance of the tests, (3,)."""
    body = body or ball()

    def rate(time, state):
        bodies = body._replace(position=state[None, :3], twist=np.concatenate([state[3:], body.twist[0, 3:]])[None])
        return np.concatenate([state[3:], acceleration(model, bodies, time)])

    start = np.concatenate([body.position[0], velocity])
    return solve_ivp(rate, (0, duration), start, method="DOP853", rtol=1e-11, atol=1e-12).y[3:, -1]


def test_gravity_is_weight():
    assert np.allclose(acceleration([effects.Gravity(G)], ball()), [0, 0, -G], rtol=1e-15)
    assert np.allclose(acceleration([effects.Gravity(2.0, direction=(3, 0, 4))], ball()), [1.2, 0, 1.6], rtol=1e-15)


def test_linear_drag_ends_at_g_over_rate():
    """v(t) = -(g/k) (1 - exp(-k t))."""
    rate, duration = 2.0, 0.8
    v = fall([effects.Gravity(G), effects.LinearDrag(rate)], duration)
    assert v[2] == pytest.approx(-G / rate * (1 - np.exp(-rate * duration)), rel=1e-8)


def test_quadratic_drag_ends_at_terminal_speed():
    """v(t) = -V tanh(g t/V), V = sqrt(2 m g/(rho C A)); after 10 V/g it is V within exp(-20)."""
    body, drag = ball(), effects.QuadraticDrag(drag_coefficient=0.47, fluid_density=1000.0)
    terminal = np.sqrt(2 * body.mass[0] * G / (1000.0 * 0.47 * body.area[0]))
    for duration in (0.3, 10 * terminal / G):
        v = fall([effects.Gravity(G), drag], duration)
        assert v[2] == pytest.approx(-terminal * np.tanh(G * duration / terminal), rel=1e-8)


def test_drag_per_metre_needs_no_size():
    """a = -k |v| v whatever the body."""
    found = acceleration([effects.QuadraticDrag(drag_per_metre=0.3)], ball(velocity=(3, 0, 4)))
    assert np.allclose(found, [-4.5, 0, -6], rtol=1e-14)


def test_drag_crisis_goes_from_sub_to_supercritical():
    """C = sub far below Re_c, their mean at Re_c, sup far above; (Re/Re_c)^4 = 1e-8 and 1e8 are the distances."""
    crisis = effects.DragCrisis(0.5, 0.1, critical_reynolds=2e5, fluid_density=1.2, fluid_viscosity=1.8e-5)
    critical_speed = 2e5 * 1.8e-5 / (1.2 * 0.2)
    for ratio, coefficient in ((0.01, 0.5), (1.0, 0.3), (100.0, 0.1)):
        body = ball(velocity=(ratio * critical_speed, 0, 0))
        force = effects.wrench(crisis, body, 0.0)[0, 0]
        found = -force / (0.5 * 1.2 * body.area[0] * (ratio * critical_speed) ** 2)
        assert found == pytest.approx(coefficient, rel=1e-7)


def test_buoyancy_and_added_mass_set_the_first_acceleration():
    """a = -g (s - 1)/(s + C), s = density of the body/of the fluid; here s = 2, C = 0.5: g/2.5."""
    model = [effects.Gravity(G), effects.Buoyancy(1000.0), effects.AddedMass(0.5, 1000.0)]
    assert acceleration(model, ball(density=2000.0))[2] == pytest.approx(-G / 2.5, rel=1e-14)


def test_neutral_body_floats():
    assert abs(acceleration([effects.Gravity(G), effects.Buoyancy(1000.0)], ball(density=1000.0))[2]) < 1e-14 * G


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
    ]
    still = acceleration(fluid, body._replace(twist=body.twist - np.concatenate([u, np.zeros(3)])))
    flow = effects.UniformFlow(*u)
    for model in ([*fluid, flow], [flow, *fluid], [flow, *fluid[::-1]]):
        assert np.allclose(acceleration(model, body), still, rtol=1e-13)
    two_flows = [effects.UniformFlow(*(0.25 * u)), *fluid, effects.UniformFlow(*(0.75 * u))]
    assert np.allclose(acceleration(two_flows, body), still, rtol=1e-13)


def test_modifier_without_a_drag_is_refused_by_name():
    for modifier in (effects.UniformFlow(1.0), effects.OrientationDrag(1.5), effects.WallDrag(1.0)):
        with pytest.raises(InputError, match=f"{effects.name_of(modifier)} changes a drag, but the model has none"):
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


def test_magnus_pushes_along_spin_cross_velocity():
    """F = C pi rho r3 omega x v; no power."""
    body = ball(velocity=(0, 3, 0), spin=(0, 0, 20), radius=0.1)
    force = effects.wrench(effects.Magnus(0.9, 1.2), body, 0.0)[0]
    assert np.allclose(force, [-0.9 * np.pi * 1.2 * 1e-3 * 60, 0, 0, 0, 0, 0], rtol=1e-13)
    bodies = sample_bodies()
    work = effects.Magnus(1.0).forces(bodies, 0.0)[:, :3] * bodies.twist[:, :3]
    assert np.all(np.abs(work.sum(axis=1)) <= 1e-13 * np.abs(work).sum(axis=1))


def test_spin_decays_with_its_rate_about_every_axis():
    """The moment is -rate times the angular momentum, so omega' = -rate omega without gyroscopic terms."""
    bodies = sample_bodies()
    moment = effects.SpinDecay(0.7).forces(bodies, 0.0)[:, 3:]
    for k in range(len(moment)):
        axes = rotate(bodies.orientation[k], np.eye(3)).T
        inertia = axes @ np.diag(bodies.inertia[k]) @ axes.T
        assert np.allclose(moment[k], -0.7 * inertia @ bodies.twist[k, 3:], rtol=1e-12, atol=1e-12 * np.abs(moment).max())


@pytest.mark.parametrize(("power", "factor"), [(1.0, 1.0), (0.5, np.pi / 4), (1e-9, 0.5)])
def test_history_force_is_bassets_integral_for_powers_of_time(power, factor):
    """6 r2 sqrt(pi rho eta) int_0^t w'(s)/sqrt(t - s) ds for w = s^p, by quadrature with the end singularities as weights."""
    t, r, rho, eta = 0.8, 0.1, 1000.0, 1e-3
    integral = power * quad(lambda s: 1.0, 0, t, weight="alg", wvar=(power - 1.0, -0.5))[0]
    basset = 6 * r**2 * np.sqrt(np.pi * rho * eta) * integral
    law = effects.HistoryForce(multiplier=factor, fluid_density=rho, fluid_viscosity=eta)
    force = effects.wrench(law, ball(velocity=(0, 0, t**power), radius=r), t)[0, 2]
    assert -force == pytest.approx(basset, rel=1e-6)  # quadrature of a singular integrand


def test_history_force_starts_at_the_start():
    law = effects.HistoryForce(1.0, start=0.5)
    body = ball(velocity=(1, 0, 0))
    assert not law.forces(body, 0.5).any() and law.forces(body, 0.6)[0, 0] < 0.0


def test_wall_drag_is_faxens_first_order():
    """Touching the wall the drag is 1 + 9/16 along and 1 + 9/8 towards it; at h = 4 r a quarter of the additions."""
    drag, wall = effects.LinearDrag(1.0), effects.WallDrag(1.0, wall_height=-0.5)
    for h, share in ((0.1, 1.0), (0.4, 0.25)):
        a = acceleration([drag, wall], ball(position=(7, 8, h - 0.5), velocity=(1, 0, -1)))
        assert np.allclose(a, [-1 - 9 / 16 * share, 0, 1 + 9 / 8 * share], rtol=1e-13)


def test_ground_cushion_comes_from_lambs_kinetic_energy():
    """Force = v^2/2 times the slope of the fluid's mass M(h) = (m'/2)(1 + (3/8)(r/h)^3), by a central difference."""
    r, rho, h, v = 0.1, 1000.0, 0.17, 2.0

    def fluid_mass(h):
        return 0.5 * 4 / 3 * np.pi * r**3 * rho * (1 + 3 / 8 * (r / h) ** 3)

    law, step = effects.GroundCushion(1.0, rho), 1e-5 * h
    slope = (fluid_mass(h + step) - fluid_mass(h - step)) / (2 * step)
    assert law.forces(ball(position=(0, 0, h), velocity=(1, 0, -v)), 0.0)[0, 2] == pytest.approx(-0.5 * v**2 * slope, rel=1e-6)
    assert not law.forces(ball(position=(0, 0, h), velocity=(1, 0, v)), 0.0).any()


def test_tilted_gravity_turns_gravity_and_keeps_its_size():
    """About x by +a: towards +y; about y by +b: towards -x; |g| unchanged."""
    level = effects.Gravity(G)
    sine, cosine = G * np.sin(0.03), G * np.cos(0.03)
    assert np.allclose(acceleration([level, effects.TiltedGravity(angle_x=0.03)], ball()), [0, sine, -cosine], rtol=1e-13)
    assert np.allclose(acceleration([level, effects.TiltedGravity(angle_y=0.03)], ball()), [-sine, 0, -cosine], rtol=1e-13)
    both = acceleration([level, effects.TiltedGravity(0.04, -0.03)], ball())
    assert np.linalg.norm(both) == pytest.approx(G, rel=1e-14)


@pytest.mark.parametrize("fixed", [[1, 4], [0, 1, 6]], ids=["scattered", "at the ends"])
def test_fixed_bodies_feel_nothing_and_ask_nothing(fixed):
    """wrench and added_mass: rows of fixed bodies are 0, those of moving ones as without the fixed."""
    bodies = sample_bodies()
    mass = bodies.mass.copy()
    mass[fixed] = np.inf
    some = bodies._replace(mass=mass)
    moving = np.isfinite(mass)
    for effect in (effects.Gravity(), effects.LinearDrag(1.0)):
        wrench = effects.wrench(effect, some, 0.0)
        assert not wrench[~moving].any() and np.array_equal(wrench[moving], effect.forces(bodies, 0.0)[moving])
    added = effects.added_mass([effects.AddedMass(0.5)], some)
    assert not added[~moving].any() and added[2, 0, 0] == 0.5 * 1000.0 * bodies.volume[2]
    assert effects.added_mass([effects.Gravity()], some) is None
    nothing = Bodies(*(array[:0] for array in bodies))
    assert effects.wrench(effects.Gravity(), nothing, 0.0).shape == (0, 6)
