"""Each force of a fluid against the closed formula of its law.

Algebraic formulas are met to a few roundings (1e-12 relative); motions are integrated by scipy's DOP853 at 1e-11 and met to 1e-8.
"""

import numpy as np
import pytest
from one_ball import G, acceleration, ball, fall
from scipy.integrate import quad

from minibullet import effects
from minibullet.effects.samples import sample_bodies
from minibullet.rotations import rotate


def test_a_sphere_in_glycerine_sinks_as_stokes_says():
    """v = 2/9 (rho - rho_f) g r^2 / eta, the lift beside the drag; a thousandth of a second is ten times its decay."""
    radius, eta, density, fluid = 0.001, 1.4, 7800.0, 1260.0
    sinks = effects.StokesDrag(eta)
    resistance = sinks.resistance(ball()._replace(radius=np.array([radius])))
    weight = 4 / 3 * np.pi * radius**3 * (density - fluid) * G
    assert weight / resistance[0] == pytest.approx(2 / 9 * (density - fluid) * G * radius**2 / eta, rel=1e-12)
    wrench = sinks.forces(ball(), 0.0)
    np.testing.assert_allclose(wrench, effects.LinearDrag(sinks.resistance(ball())[0] / ball().mass[0]).forces(ball(), 0.0))


def test_the_drag_of_a_sphere_is_stokes_s_law_where_the_flow_creeps_and_the_measured_one_up_to_a_reynolds_number_of_800():
    """C of C. E. Lapple and C. B. Shepherd, Ind. Eng. Chem. 32 (1940) 605, at Re = 2 r rho v/eta; the curve meets it to 5 %."""
    body, rho = ball(velocity=(3.0, 0.0, 0.0), radius=0.1), 870.0
    for reynolds, measured in ((0.1, 240.0), (1.0, 26.5), (10.0, 4.1), (100.0, 1.07), (500.0, 0.55)):
        law = effects.SphereDrag(viscosity=0.2 * rho * 3.0 / reynolds, fluid_density=rho)
        force = -effects.wrench(law, body, 0.0)[0, 0]
        assert force / (rho / 2 * np.pi * 0.01 * 9.0) == pytest.approx(measured, rel=0.05)
    thick = 1e9 * 0.2 * rho * 3.0  # Re = 1e-9: what inertia adds is 1e-7 of the drag
    creeping = effects.StokesDrag(thick).forces(body, 0.0)
    np.testing.assert_allclose(effects.SphereDrag(thick, rho).forces(body, 0.0), creeping, rtol=2e-7)
    assert not effects.SphereDrag(0.0, rho).forces(body, 0.0).any()


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


def test_ground_cushion_comes_from_lambs_kinetic_energy():
    """Force = v^2/2 times the slope of the fluid's mass M(h) = (m'/2)(1 + (3/8)(r/h)^3), by a central difference."""
    r, rho, h, v = 0.1, 1000.0, 0.17, 2.0

    def fluid_mass(h):
        return 0.5 * 4 / 3 * np.pi * r**3 * rho * (1 + 3 / 8 * (r / h) ** 3)

    law, step = effects.GroundCushion(1.0, rho), 1e-5 * h
    slope = (fluid_mass(h + step) - fluid_mass(h - step)) / (2 * step)
    assert law.forces(ball(position=(0, 0, h), velocity=(1, 0, -v)), 0.0)[0, 2] == pytest.approx(-0.5 * v**2 * slope, rel=1e-6)
    assert not law.forces(ball(position=(0, 0, h), velocity=(1, 0, v)), 0.0).any()
