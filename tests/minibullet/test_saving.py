"""A world on disk: it goes on bit for bit, a broken write leaves the old file, a foreign file is refused in one line."""

import os
from dataclasses import dataclass

import numpy as np
import pytest

import minibullet as mb


@dataclass(frozen=True)
class Wind(mb.Effect):
    """A user's own effect: a force along x."""

    strength: float = mb.parameter(0.5, unit="N")

    def forces(self, bodies, time):
        wrench = np.zeros((len(bodies.mass), 6))
        wrench[:, 0] = self.strength
        return wrench


def falling(generator, *effects):
    """Some of every kind of shape, falling onto each other; a fixed body, a group, a body with an inertia of its own."""
    world = mb.World([mb.Gravity(9.81), *effects], mb.Settings(friction=0.4, restitution=0.3))
    world.add_plane((0.1, 0.0, 1.0), friction=0.7)
    wedge = mb.ConvexPiece(generator.normal(size=(10, 3)) * 0.2)
    both = mb.Compound((mb.Box(0.4, 0.2, 0.2), mb.Box(0.2, 0.2, 0.4).pieces[0].moved((0.3, 0, 0))))
    shapes = (mb.Sphere(0.2), mb.Box(0.4, 0.3, 0.2), mb.Capsule(0.1, 0.4), mb.Cylinder(0.2, 0.3), wedge, both)
    for k, (shape, turn) in enumerate(zip(shapes, mb.rotations.random(generator, 6), strict=True)):
        world.add(shape, density=1000.0, position=(0.1 * k, 0.05 * k, 0.6 + 0.45 * k), orientation=turn, name=f"unit {k}")
    world.add(mb.Box(1, 1, 0.2), fixed=True, position=(0, 0, 0.2), friction=0.9)
    world.add(mb.Sphere(0.1), mass=1.0, inertia=(0.01, 0.02, 0.02), position=(2, 0, 1.0), group=1, margin=0.01)
    return world


def state(world):
    return b"".join(np.concatenate([b.position, b.orientation, b.velocity, b.angular_velocity]).tobytes() for b in world.bodies)


def test_a_loaded_world_goes_on_bit_for_bit(generator, tmp_path):
    """Saved amid the fall, run on twice: the bits of every body agree, and names, time and counters came along."""
    world = falling(generator)
    world.step(90)
    world.save(tmp_path / "run.npz")
    twin = mb.World.load(tmp_path / "run.npz")
    assert state(twin) == state(world)
    assert (twin.time, twin.steps, twin.settings) == (world.time, world.steps, world.settings)
    assert [b.name for b in twin.bodies] == [b.name for b in world.bodies] and twin.effects == world.effects
    world.step(90)
    twin.step(90)
    assert state(twin) == state(world)


def test_a_killed_save_leaves_the_old_file_whole(generator, tmp_path, monkeypatch):
    """The process dies before the rename: the file of step 10 is still there, whole, and nothing lies beside it."""
    world = falling(generator)
    world.step(10)
    world.save(tmp_path / "run.npz")
    before = (tmp_path / "run.npz").read_bytes()
    world.step(10)

    def killed(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", killed)
    with pytest.raises(KeyboardInterrupt):
        world.save(tmp_path / "run.npz")
    monkeypatch.undo()
    assert (tmp_path / "run.npz").read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["run.npz"]
    assert mb.World.load(tmp_path / "run.npz").steps == 10


def test_a_users_own_effect_must_be_given_again(generator, tmp_path):
    """A file holds numbers and no code: without effects= the message says which one is missing; with it the run goes on."""
    world = falling(generator, Wind(0.7))
    world.step(20)
    world.save(tmp_path / "run.npz")
    with pytest.raises(mb.InputError, match="(?i)wind.*give the effects to World.load"):
        mb.World.load(tmp_path / "run.npz")
    twin = mb.World.load(tmp_path / "run.npz", effects=world.effects)
    world.step(20)
    twin.step(20)
    assert state(twin) == state(world)


@pytest.mark.parametrize("content", [b"", b"no world", b"PK\x03\x04 torn"])
def test_a_file_that_is_no_world_is_refused(tmp_path, content):
    """Empty, text, a torn archive: one line that names the file."""
    path = tmp_path / "other.npz"
    path.write_bytes(content)
    with pytest.raises(mb.InputError, match="other.npz.*not a file that World.save wrote") as refused:
        mb.World.load(path)
    assert "\n" not in str(refused.value)


def test_missing_places_are_named(tmp_path):
    """A file that is not there, a folder that is not there."""
    with pytest.raises(mb.InputError, match="there is no such file"):
        mb.World.load(tmp_path / "nowhere.npz")
    with pytest.raises(mb.InputError, match="cannot be saved"):
        mb.World().save(tmp_path / "no folder" / "run.npz")


def test_a_frozen_world_stays_frozen_on_disk(generator, tmp_path):
    """Frozen bodies come back fixed, at the same place, and stay while others fall on them."""
    world = falling(generator)
    world.step(60)
    world.freeze(world.bodies[:3])
    places = [body.position for body in world.bodies[:3]]
    world.save(tmp_path / "run.npz")
    twin = mb.World.load(tmp_path / "run.npz")
    twin.step(30)
    for body, place in zip(twin.bodies[:3], places, strict=True):
        assert body.fixed
        np.testing.assert_array_equal(body.position, place)
