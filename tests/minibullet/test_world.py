"""The World as its user sees it: overlaps, separation, freezing, groups, margins, effects through the step, determinism."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import minibullet as mb

ROOT = Path(__file__).resolve().parents[2]
SCENE = """
import sys, hashlib
import numpy as np
import minibullet as mb
generator = np.random.default_rng(5)
world = mb.World([mb.Gravity(9.81)], mb.Settings(friction=0.5))
world.add_plane()
rows = [(0.1 * (k % 2), 0.1 * (k % 3), 0.3 + 0.35 * k) for k in range(5)]
turns, order = mb.rotations.random(generator, 5), eval(sys.argv[1])
bodies = {k: world.add(mb.Box(0.4, 0.3, 0.2), density=1000.0, position=rows[k], orientation=turns[k]) for k in order}
world.step(int(sys.argv[2]))
state = [np.concatenate([bodies[k].position, bodies[k].orientation, bodies[k].velocity]) for k in range(5)]
print(" ".join(x.hex() for x in np.concatenate(state).tolist()))
"""


def elsewhere(order=(0, 1, 2, 3, 4), steps=120, **environment):
    """State of SCENE in a process of its own, its bodies added in ``order``, (50,)."""
    finished = subprocess.run([sys.executable, "-c", SCENE, str(order), str(steps)], cwd=ROOT, capture_output=True, text=True,
                              env={**os.environ, **environment}, timeout=120)  # fmt: skip
    assert finished.returncode == 0, finished.stderr
    return np.array([float.fromhex(x) for x in finished.stdout.split()])


def test_another_process_and_another_order_of_adding_change_no_bit():
    """Five blocks that fall on each other: half a second, every bit of every body."""
    first = elsewhere()
    assert hashlib.sha256(first.tobytes()).digest() == hashlib.sha256(elsewhere((3, 0, 4, 2, 1)).tobytes()).digest()


def test_without_numba_the_same_step():
    """NUMBA_DISABLE_JIT=1 walks through the same formulas in Python; compilers may fuse a product and a sum, so to 1e-10."""
    np.testing.assert_allclose(elsewhere(steps=6, NUMBA_DISABLE_JIT="1"), elsewhere(steps=6), atol=1e-10)


def overlapping():
    """Two boxes 0.1 m into each other, a third that only touches, a sphere 0.05 m in the floor."""
    world = mb.World()
    world.add_plane(name="floor")
    world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 0, 3.0), name="one")
    world.add(mb.Box(1, 1, 1), mass=1.0, position=(0.9, 0, 3.2), name="two")
    world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 1.0, 3.0), name="beside")
    world.add(mb.Sphere(0.5), mass=1.0, position=(5, 0, 0.45), name="sunk")
    return world


def test_overlaps_are_listed_by_name_and_depth_before_any_step():
    """Deepest first, touch left out; depths of hand."""
    found = [({a.name, b.name}, depth) for a, b, depth in overlapping().overlaps()]
    assert [names for names, _ in found] == [{"one", "two"}, {"floor", "sunk"}]
    assert [depth for _, depth in found] == pytest.approx([0.1, 0.05], abs=1e-12)


def test_separate_moves_apart_and_gives_no_velocity():
    """Afterwards nothing overlaps, nothing has turned or has speed, and the largest move is what was said: two equal boxes share
    0.1 m, the sphere rises by 0.05 m."""
    world = overlapping()
    before = [body.position for body in world.bodies]
    largest = world.separate()
    assert world.overlaps() == []
    moves = [np.linalg.norm(body.position - place) for body, place in zip(world.bodies, before, strict=True)]
    assert largest == pytest.approx(max(moves), abs=1e-12) and largest == pytest.approx(0.05, abs=2e-3)
    for body in world.bodies:
        assert not body.velocity.any() and not body.angular_velocity.any()
        np.testing.assert_array_equal(body.orientation, (1, 0, 0, 0))
    world.step(10)
    assert max(np.abs(body.velocity).max() for body in world.bodies) < 1e-12


def test_coincident_bodies_are_parted_without_a_blow():
    """Two equal boxes in one place: separated by their whole edge, at rest after 10 steps."""
    world = mb.World()
    one, two = (world.add(mb.Box(1, 1, 1), mass=1.0) for _ in range(2))
    world.separate()
    assert np.abs(one.position - two.position).max() == pytest.approx(1.0, abs=1e-6)
    world.step(10)
    assert np.abs(one.velocity).max() < 1e-12


def test_separate_moves_only_the_bodies_named():
    """The box that is not named stays; the other goes the whole way."""
    world = overlapping()
    one, two = world.bodies[:2]
    place = one.position
    world.separate([two])
    np.testing.assert_array_equal(one.position, place)
    assert two.position[0] == pytest.approx(1.0, abs=1e-3)


def test_frozen_bodies_carry_and_never_move_again():
    """A box frozen in the air holds another that falls on it."""
    world = mb.World([mb.Gravity()])
    shelf = world.add(mb.Box(2, 2, 1), mass=1.0, position=(0, 0, 5), velocity=(1, 0, 0))
    load = world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 0, 6.2))
    world.freeze([shelf])
    place = shelf.position
    assert world.settle(5.0) == "at_rest"
    np.testing.assert_array_equal(shelf.position, place)
    assert not shelf.velocity.any() and shelf.fixed
    assert load.position[2] == pytest.approx(6.0, abs=1e-8)


def test_freezing_what_lies_in_a_heap_keeps_its_contacts():
    """The lower box of a stack is frozen: the upper one feels nothing, its load stays its weight at every step; between floor and
    frozen box, both fixed now, there is no force."""
    world = mb.World([mb.Gravity(10.0)])
    world.add_plane()
    lower, upper = (world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 0, 0.5 + k)) for k in range(2))
    world.step(60)
    world.freeze([lower])
    for _ in range(20):
        world.step()
        assert world.contacts.to_dataframe().normal_force.sum() == pytest.approx(10.0, rel=1e-6)
    assert upper.position[2] == pytest.approx(1.5, abs=1e-9)


def test_groups_never_touch_each_other_but_all_touch_the_floor():
    """Two boxes of different groups in one place rest on the floor and in each other; those without a group touch everybody."""
    world = mb.World([mb.Gravity()])
    world.add_plane()
    pair = [world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 0, 0.6), group=k) for k in (1, 2)]
    common = world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 0, 1.7))
    world.step(240)
    assert world.contacts.to_dataframe().groupby(["body_a", "body_b"]).ngroups == 4
    assert [body.position[2] for body in pair] == pytest.approx([0.5, 0.5], abs=1e-8)
    assert common.position[2] == pytest.approx(1.5, abs=1e-8)


def test_margins_add_and_a_plane_has_none():
    """A box with 0.02 m on the floor stands 0.02 m up, one with the world's 0.01 m on it 0.03 m above that."""
    world = mb.World([mb.Gravity()], mb.Settings(margin=0.01))
    world.add_plane()
    lower = world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 0, 0.6), margin=0.02)
    upper = world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 0, 1.7))
    world.step(240)
    assert (lower.position[2], upper.position[2]) == pytest.approx((0.52, 1.55), abs=1e-8)


def test_a_motion_that_is_not_finite_stops_and_leaves_the_last_good_state(tmp_path):
    """An effect that fails at t = 0.02 s: the message names step, time and culprit; the world stays at the step before, whole,
    and its rescue file holds that step."""

    class Broken(mb.Effect):
        def forces(self, bodies, time):
            return np.full((len(bodies.mass), 6), 0.0 if time < 0.02 else 1e308) * 1e10

    world = mb.World([Broken()], rescue=tmp_path / "run.chk")
    body = world.add(mb.Sphere(1.0), mass=1.0, name="u17", velocity=(1, 0, 0))
    with np.errstate(all="ignore"), pytest.raises(mb.InputError) as refusal:
        world.step(10)
    assert all(word in str(refusal.value) for word in ("step 6, t = 0.025 s", "Broken", "not finite", "state of step 5 saved in"))
    assert world.steps == 5
    np.testing.assert_allclose(body.position, (5 / 240, 0, 0), rtol=1e-12)
    again = mb.World.load(tmp_path / "run.chk", effects=[])
    assert again.steps == 5
    np.testing.assert_array_equal(again.bodies[0].position, body.position)
    with np.load(tmp_path / "run.chk.past.npz") as past:
        np.testing.assert_allclose(past["time"], np.arange(1, 6) / 240, rtol=1e-12)
        np.testing.assert_allclose(past["position"][:, 0, 0], np.arange(1, 6) / 240, rtol=1e-12)


@pytest.mark.parametrize("call", [lambda w: w.run(-1.0), lambda w: w.run(np.inf), lambda w: w.run("1"), lambda w: w.settle(0.0),
                                  lambda w: w.settle(np.nan), lambda w: w.step(-1), lambda w: w.step(1.5)])  # fmt: skip
def test_times_that_are_none_are_refused(call):
    """Negative, infinite or no durations; steps that cannot be counted."""
    with pytest.raises(mb.InputError, match="must be"):
        call(mb.World())


def test_effects_are_values_of_effect_and_bodies_belong_to_their_world():
    """One effect alone is a list of one; a number is refused; a body of another world cannot be frozen here."""
    world = mb.World(mb.Gravity(10.0))
    body = world.add(mb.Sphere(1.0), mass=1.0)
    world.step()
    assert body.velocity[2] == pytest.approx(-10.0 / 240)
    with pytest.raises(mb.InputError, match="not 3"):
        mb.World([3])
    with pytest.raises(mb.InputError, match="another world"):
        mb.World().freeze([body])


# ---- effects through the whole step ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("time_step", [1 / 60, 1 / 240, 1 / 960])
def test_rolling_friction_slows_a_rolling_sphere_by_5_7_g_arm_over_r(time_step):
    """Constant deceleration, so the discrete answer is the law's at any step, to the solver's tolerance over 60 steps."""
    world = mb.World([mb.Gravity(9.8), mb.RollingFriction(arm=0.01)], mb.Settings(friction=0.5, time_step=time_step))
    world.add_plane()
    ball = world.add(mb.Sphere(0.5), mass=3.0, position=(0, 0, 0.5), velocity=(2.0, 0, 0), angular_velocity=(0, 4.0, 0))
    world.run(1.0)
    assert ball.velocity[0] == pytest.approx(2.0 - 5 / 7 * 9.8 * 0.01 / 0.5, rel=1e-6)
    assert ball.angular_velocity[1] == pytest.approx(ball.velocity[0] / 0.5, rel=1e-6)


def test_spinning_friction_slows_a_spinning_sphere_by_its_moment():
    """I dw/dt = -arm m g with I = 2/5 m r^2: 5/2 arm g/r^2; it stops there and does not turn back."""
    world = mb.World([mb.Gravity(10.0), mb.SpinningFriction(arm=0.02)])
    world.add_plane()
    ball = world.add(mb.Sphere(0.5), mass=3.0, position=(0, 0, 0.5), angular_velocity=(0, 0, 3.0))
    world.run(0.5)
    assert ball.angular_velocity[2] == pytest.approx(3.0 - 2.5 * 0.02 * 10.0 / 0.25 * 0.5, rel=1e-6)
    world.run(2.0)
    assert abs(ball.angular_velocity[2]) < 1e-9


@pytest.mark.parametrize(("pull_off", "holds"), [(0.99, False), (1.01, True)])
def test_adhesion_bears_its_pull_off_force_and_no_more(pull_off, holds):
    """A box under a ceiling: it stays while the pull-off force exceeds its weight by 1 %, and falls 1 % below."""
    world = mb.World([mb.Gravity(9.80665), mb.Adhesion(pull_off_force=pull_off)])
    world.add_plane((0, 0, -1.0), -2.0)
    box = world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 0, 1.5))
    world.run(1.0)
    assert (abs(box.position[2] - 1.5) < 1e-9) == holds


def test_added_mass_slows_the_fall_in_water():
    """a = g (rho_s - rho_w)/(rho_s + C rho_w), constant: exact at any step."""
    world = mb.World([mb.Gravity(9.8), mb.Buoyancy(fluid_density=1000.0, acceleration=9.8),
                      mb.AddedMass(coefficient=0.5, fluid_density=1000.0)])  # fmt: skip
    ball = world.add(mb.Sphere(0.5), density=2300.0)
    world.run(1.0)
    assert ball.velocity[2] == pytest.approx(-9.8 * 1300.0 / 2800.0, rel=1e-12)


def test_linear_drag_ends_at_g_over_rate_from_either_side():
    """Terminal speed g/rate is a fixed point of the discrete step too; after 10/rate e^-10 of the difference is left."""
    for start in (0.0, -20.0):
        world = mb.World([mb.Gravity(10.0), mb.LinearDrag(rate=2.0)])
        ball = world.add(mb.Sphere(0.5), mass=1.0, velocity=(0, 0, start))
        world.run(5.0)
        assert ball.velocity[2] == pytest.approx(-5.0, abs=15.0 * np.exp(-10.0) * 1.1)


def test_a_disc_that_spins_on_its_face_is_braked_as_if_its_weight_stood_on_its_rim():
    """The corners of a face bear its load: M = mu m g R on I = m R^2 / 2, so it slows by 2 mu g / R; no sliding cancels it."""
    world = mb.World([mb.Gravity(9.81)], mb.Settings(friction=0.2, time_step=1 / 480))
    world.add_plane()
    disc = world.add(mb.Cylinder(radius=0.04, height=0.01), mass=0.1, position=(0, 0, 0.005), angular_velocity=(0, 0, 20.0))
    world.run(0.1)
    assert disc.angular_velocity[2] == pytest.approx(20.0 - 2 * 0.2 * 9.81 / 0.04 * 0.1, rel=1e-6)
