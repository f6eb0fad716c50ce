"""What a world tells once: bodies put into each other, steps too long for a body or a force; it goes on well where it can."""

import warnings
from types import SimpleNamespace

import numpy as np
import pytest

import minibullet as mb

SHAPES = {
    "spheres": (mb.Sphere(0.5), mb.Sphere(0.5)),
    "boxes": (mb.Box(1, 1, 1), mb.Box(1, 1, 1)),
    "capsules": (mb.Capsule(0.3, 1.0), mb.Capsule(0.3, 1.0)),
    "cylinders": (mb.Cylinder(0.5, 1.0, 16), mb.Cylinder(0.5, 1.0, 16)),
    "sphere in box": (mb.Box(1, 1, 1), mb.Sphere(0.3)),
    "box around sphere": (mb.Sphere(0.3), mb.Box(1, 1, 1)),
    "sphere in capsule": (mb.Capsule(0.3, 1.0), mb.Sphere(0.3)),
    "capsule in box": (mb.Box(1, 1, 1), mb.Capsule(0.2, 0.5)),
    "compounds": (mb.Compound((mb.Box(1, 1, 1), mb.Box(1, 1, 1).pieces[0].moved((1, 0, 0)))),) * 2,
}


@pytest.mark.parametrize("fixed", [False, True])
@pytest.mark.parametrize("name", SHAPES)
def test_bodies_in_one_place_are_told_and_come_apart_without_a_blow(name, fixed):
    """No gravity: both names and the depth once; after two seconds (0.7^480 of the overlap would be left) they only touch, and
    none has ever had a velocity."""
    world = mb.World()
    one, two = (world.add(shape, **kind, name=f"u{k}")
                for k, (shape, kind) in enumerate(zip(SHAPES[name], ({"fixed": True} if fixed else {"mass": 1.0}, {"mass": 2.0}),
                                                      strict=True)))  # fmt: skip
    depth = world.overlaps()[0][2]
    with pytest.warns(mb.SceneWarning, match="'u0' and 'u1'|'u1' and 'u0'") as told:
        world.step(480)
    assert len(told) == len(world.notices) == 1 and f"by {depth:.3g} m" in world.notices[0] and "\n" not in world.notices[0]
    assert 0.2 < depth < 3.0
    assert all(depth < 1e-4 for _, _, depth in world.overlaps())
    assert not one.velocity.any() and not two.velocity.any() and not two.angular_velocity.any()
    assert not fixed or not one.position.any()


def test_a_body_below_the_floor_is_told_and_lifted():
    """Wholly inside a half-space, at rest: it comes up to rest on it."""
    world = mb.World([mb.Gravity()])
    world.add_plane(name="floor")
    box = world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 0, -3.0), name="sunk")
    with pytest.warns(mb.SceneWarning, match="'floor' and 'sunk' by 3.5 m"):
        world.step(240)
    assert box.position[2] == pytest.approx(0.5, abs=1e-6)


def test_a_body_put_into_another_while_running_is_told():
    """Set by its handle in the eleventh step; what was apart before it was told nothing of."""
    world = mb.World([mb.Gravity()])
    world.add_plane()
    one, two = (world.add(mb.Box(1, 1, 1), mass=1.0, position=(3 * k, 0, 0.5), name=f"u{k}") for k in range(2))
    world.step(10)
    assert not world.notices
    two.position = one.position + (0.2, 0, 0)
    with pytest.warns(mb.SceneWarning, match="step 11, .*'u0' and 'u1' by 0.8 m"):
        world.step()


def test_only_so_many_pairs_are_named():
    """Twenty boxes in one place are 190 pairs: one line names eight and counts the others."""
    world = mb.World()
    for _ in range(20):
        world.add(mb.Box(1, 1, 1), mass=1.0)
    with pytest.warns(mb.SceneWarning, match="and 182 more pairs"):
        world.step()
    assert world.notices[0].count(" by 1 m") == 8


def test_a_heap_tells_of_overlaps_again_only_where_they_are_twice_as_many_or_as_deep():
    """Pairs put into each other one after another, equally deep: the 1st, 2nd, 4th and 8th of ten are told, with how many there
    were; then one of twice the depth is."""
    world = mb.World()
    for k in range(22):
        world.add(mb.Box(1, 1, 1), mass=1.0, position=(3.0 * k, 0, 0), name=f"u{k}")

    def put(k, gap):
        world.bodies[2 * k + 1].position = world.bodies[2 * k].position + (gap, 0, 0)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            world.step()

    for k in range(10):
        put(k, 0.9)
    assert [text.split(", ")[0] for text in world.notices] == [f"step {step}" for step in (1, 2, 4, 8)]
    assert "'u14' and 'u15' by 0.1 m (8 pairs so far)" in world.notices[-1]
    put(10, 0.8)
    assert len(world.notices) == 5 and "'u20' and 'u21' by 0.2 m (11 pairs so far)" in world.notices[-1]


def test_groups_frozen_bodies_and_seated_ones_are_told_nothing_of():
    """Bodies of different groups never touch; two fixed bodies may share a place; a body 2 mm in the floor is measured so."""
    world = mb.World([mb.Gravity()])
    world.add_plane()
    for group in (1, 2):
        world.add(mb.Box(1, 1, 1), mass=1.0, position=(0, 0, 0.498), group=group)
    for _ in range(2):
        world.add(mb.Box(1, 1, 1), fixed=True, position=(5, 0, 0.2))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        world.step(20)
    assert not world.notices


def stack(side, time_step):
    """Three cubes at rest on each other."""
    world = mb.World([mb.Gravity(9.81)], mb.Settings(time_step=time_step))
    world.add_plane()
    for k in range(3):
        world.add(mb.Box(side, side, side), density=1000.0, position=(0, 0, (k + 0.5) * side), name=f"u{k}")
    return world


def test_a_step_too_long_for_a_body_is_told_once_with_the_step_that_would_do():
    """Cubes of a micrometre fall 170 of their sizes in 1/240 s: told at once; with the step that is named they stand."""
    world = stack(1e-6, 1 / 240)
    with pytest.warns(mb.SceneWarning, match="may move by 0.00017 m in one step"):
        world.step(3)
    assert len(world.notices) == 1
    named = float(world.notices[0].rsplit("a time_step of ", 1)[1].split()[0])
    world = stack(1e-6, named)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        world.step(1000)
    heights = [body.position[2] / 1e-6 for body in world.bodies]
    assert heights == pytest.approx([0.5, 1.5, 2.5], abs=1e-6)


def test_a_fast_body_is_told_where_another_is_in_its_way_only():
    """A ball of 2 cm at 30 m/s moves 125 mm a step: past nobody and onto a half-space, which cannot be passed, in silence."""

    def shot(*, wall):
        world = mb.World()
        world.add_plane((1.0, 0, 0), -2.0)
        if wall:
            world.add(mb.Box(0.01, 1, 1), fixed=True, position=(-1.5, 0, 0), name="wall")
        world.add(mb.Sphere(0.01), mass=1.0, velocity=(-30.0, 0, 0), name="ball")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            world.step(30)
        return world

    assert not shot(wall=False).notices
    (text,) = shot(wall=True).notices
    assert "'ball'" in text and "'wall'" in text and "a time_step of 0.00033 s" in text  # 0.01 m / 30 m/s


def test_a_journal_ends_with_what_was_told():
    """Its summary has the notices, and its last words too."""
    journal, world = mb.Journal(), stack(1e-6, 1 / 240)
    with pytest.warns(mb.SceneWarning):
        world.run(2 / 240, watch=journal)
    assert journal.summary()["notices"] == list(world.notices) and str(journal).splitlines()[1:] == list(world.notices)


def test_notices_come_along_in_a_saved_world(tmp_path):
    """What was told before the save belongs to the run."""
    world = stack(1e-6, 1 / 240)
    with pytest.warns(mb.SceneWarning):
        world.step(2)
    world.save(tmp_path / "run.npz")
    assert mb.World.load(tmp_path / "run.npz").notices == world.notices


@pytest.mark.parametrize("name", SHAPES)
def test_overlap_is_measured_as_it_grows_without_a_jump(name):
    """One body moved through the other's middle in steps of 1e-4 m: the depth is finite, and no depth changes faster than the
    body moves, there least of all. The library's own search may prefer an edge by 1e-3 of the size."""
    world = mb.World()
    one, two = SHAPES[name]
    world.add(one, fixed=True)
    other = world.add(two, mass=1.0)
    depths = []
    for x in np.arange(-5, 6) * 1e-4:
        other.position = (x, 0.0, 0.0)
        depths.append(world.overlaps()[0][2])
    assert np.isfinite(depths).all() and np.abs(np.diff(depths)).max() < 1.1e-4 + 2e-3


# ---- work has a bound --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("call", [lambda w: w.run(1.0), lambda w: w.settle(1.0), lambda w: w.step(10**12)])
@pytest.mark.parametrize("time_step", [1e-12, 5e-324])
def test_more_steps_than_anybody_waits_for_are_refused(call, time_step):
    """A million million steps: refused at once, with the step that makes them so many."""
    with pytest.raises(mb.InputError, match="more than 1,000,000,000 steps of .* give a longer time_step"):
        call(mb.World(settings=mb.Settings(time_step=time_step)))


@pytest.mark.parametrize(("masses", "most"), [((1.0, 1e8), 100), ((1.0, 1e4, 1.0, 1e8), 100)])
def test_a_mass_ratio_beyond_rounding_is_told_and_not_worked_at_for_long(masses, most):
    """1e8 times eps is 2e-8 of the velocity, more than the tolerance of 1e-8: steps count as not solved, after at most so many
    Newton steps; the stack still stands to 1e-4 of its size."""
    world = mb.World([mb.Gravity(9.81)], mb.Settings(friction=0.6))
    world.add_plane()
    for k, mass in enumerate(masses):
        world.add(mb.Box(1, 1, 1), mass=mass, position=(0, 0, k + 0.5))
    for _ in range(20):
        world.step()
        assert world.last_step.solution.outer <= most
    assert world.unsolved_steps > 0 and world.worst_residual > 1e-8
    assert [body.position[2] - k for k, body in enumerate(world.bodies)] == pytest.approx([0.5] * len(masses), abs=1e-4)


@pytest.mark.parametrize(
    "given",
    [
        {"mass": 10**400},
        {"position": (10**400, 0, 0)},
        {"group": 10**400},
        {"friction": 10**400},
        {"margin": 10**5000},
        {"density": 1e300, "mass": None},
        {"inertia": (1e308, 1e308, 10**400)},
    ],
)
def test_numbers_that_double_precision_cannot_hold_are_refused(given):
    """Whole numbers of hundreds and thousands of digits, masses that overflow: one line that names the field."""
    with pytest.raises(mb.InputError, match="u17.*(mass|position|group|friction|margin|density|inertia)"):
        mb.World().add(mb.Sphere(1e5), **{"mass": 1.0, "name": "u17", **given})
    for field in ("time_step", "friction", "iterations", "tolerance"):
        with pytest.raises(mb.InputError, match=field):
            mb.Settings(**{field: 10**400})


@pytest.mark.parametrize(("volume", "inertia"), [(np.inf, np.eye(3)), (0.0, np.eye(3)), (1.0, np.full((3, 3), np.inf))])
def test_solids_without_a_volume_that_double_precision_holds_are_refused(volume, inertia):
    """Infinite and vanishing volumes of a shape of somebody's own, fixed or not."""
    shape = SimpleNamespace(pieces=(), volume=volume, inertia=inertia)
    for given in ({"mass": 1.0}, {"density": 1.0}, {"fixed": True}):
        with np.errstate(all="ignore"), pytest.raises(mb.InputError, match="volume"):
            mb.World().add(shape, name="u17", **given)


def test_a_body_too_light_for_its_contact_is_named_and_not_the_floor():
    """1e-300 kg on a plane overflows: the message names what moves."""
    world = mb.World([mb.Gravity()])
    world.add_plane(name="floor")
    world.add(mb.Box(1, 1, 1), mass=1e-300, position=(0, 0, 0.5), name="feather")
    with np.errstate(all="ignore"), pytest.raises(mb.InputError, match="'feather' is not finite"):
        world.step()


def test_a_cylinder_has_sides_that_somebody_can_wait_for():
    """A thousand sides differ from a round one by 5e-6 of the radius; more are refused at once."""
    with pytest.raises(mb.InputError, match="sides = 1000000000; .* 3 to 1000"):
        mb.Cylinder(1.0, 1.0, 10**9)


def braked(law, time_step, steps):
    """The speed and the spin of a ball of 1 kg that only this law acts on, from 2 m/s and 12 rad/s."""
    world = mb.World([law], settings=mb.Settings(time_step=time_step))
    ball = world.add(mb.Sphere(0.1), mass=1.0, velocity=(2.0, 0, 0), angular_velocity=(0, 0, 12.0), name="ball")
    world.step(steps)
    return world, np.linalg.norm(ball.velocity), np.linalg.norm(ball.angular_velocity)


DRAG_OF_2_M_S = 2 * 500 / (1.2 * np.pi * 0.1**2)  # C with which drag slows a ball of 2 m/s in air by 500 /s: F = rho C A v2 / 2


@pytest.mark.parametrize("law", [mb.LinearDrag(500.0), mb.SpinDecay(500.0), mb.QuadraticDrag(DRAG_OF_2_M_S, fluid_density=1.2)])
def test_a_drag_too_strong_for_the_step_is_told_with_a_step_that_does(law):
    """Explicit steps multiply by 1 - rate h: of 500 /s by -1.08 at 1/240 s, which grows, and by 0 at the 2 ms advised."""
    with pytest.warns(mb.SceneWarning, match=r"step 1, .*turns body 'ball' round .* a time_step of 0\.00[12] s would do") as told:
        world, *_ = braked(law, 1 / 240, 3)
    assert len(told) == len(world.notices) == 1
    world, speed, spin = braked(law, 0.001, 100)
    assert not world.notices and min(speed / 2.0, spin / 12.0) < 0.1


@pytest.mark.parametrize("rate", [1.0, 230.0, 400.0])
def test_a_drag_that_dies_out_in_the_step_is_no_notice(rate):
    """|1 - rate h| < 1: also where it swings."""
    world, speed, _ = braked(mb.LinearDrag(rate), 1 / 240, 10)
    assert not world.notices and speed < 2.0


@pytest.mark.parametrize("law", [mb.LinearDrag(1e4), mb.SpinDecay(1e4)])
def test_a_motion_that_grows_without_end_stops_with_its_name_before_numbers_overflow(law):
    """On a floor too, where the contact problem multiplies what is large."""
    world = mb.World([mb.Gravity(), law])
    world.add_plane()
    world.add(mb.Sphere(0.1), mass=1.0, position=(0, 0, 0.1), velocity=(2.0, 0, 0), angular_velocity=(0, 1.0, 12.0), name="ball")
    with pytest.warns(mb.SceneWarning, match="'ball'"), pytest.raises(mb.InputError, match="motion of body 'ball' is not finite"):
        world.step(1000)
