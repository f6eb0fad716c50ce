"""Small scenes and the hash of every bit of their state: `python -m tests.reliability.state_hash > tests/reliability/hashes.txt`.

A hash covers the raw bits of position, orientation and twist of every body, or of the readings and poses of a placement test.
Write the file anew only where a change is meant to move bits, and say so in the change log.
"""

import hashlib

import hlcs  # first: it asks the linear algebra library for one thread before NumPy is read  # isort: skip
import numpy as np

import minibullet as mb

UNIT = hlcs.Cubipod(side=0.4)
HULL, PIECES = UNIT.shape("hull"), UNIT.shape("pieces")


def bits(*arrays):
    """SHA-256 of the bits of arrays of double numbers."""
    found = hashlib.sha256()
    for array in arrays:
        found.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    return found.hexdigest()


def state(world):
    """Position, orientation and twist of every body, (n, 13)."""
    return np.array([np.concatenate([b.position, b.orientation, b.velocity, b.angular_velocity]) for b in world.bodies])


def turns(count):
    """Quaternions (n, 4) that point anywhere, from whole numbers."""
    return np.array([[(7 * k + 3 * i * i + 5 * i + 1) % 11 - 5.0 for i in range(4)] for k in range(count)])


def heap(shape, seconds=2.0, watch=None, **settings):
    """Twelve bodies that fall on each other and on the floor, and come nearly to rest."""
    world = mb.World([mb.Gravity(9.81)], mb.Settings(friction=0.4, **settings))
    world.add_plane()
    for k, turn in enumerate(turns(12)):
        world.add(shape, density=2300.0, position=(0.3 * (k % 2), 0.25 * (k % 3), 0.8 + 0.7 * k), orientation=turn)
    world.run(seconds, watch=watch)
    return world


def exact():
    """The exact solver where Gauss-Seidel reaches the tolerance: what needs Newton's method is `newton`'s affair."""

    def watch(world):
        assert not world.last_step.solution.outer, "a step of the scene needs Newton's method; choose another scene"

    return heap(HULL, tolerance=1e-6, iterations=500, watch=watch)


def newton():
    """Some steps here are beyond Gauss-Seidel: Newton's method factors a matrix, by the linear algebra library."""
    steps = []
    world = heap(mb.Box(0.5, 0.4, 0.3), 0.5, watch=lambda world: steps.append(world.last_step.solution.outer))
    assert any(steps), "no step of the scene needs Newton's method; choose another scene"
    return world


def mixed():
    """Every kind of shape, one without symmetry, on a tilted floor with a fixed wedge."""
    world = mb.World([mb.Gravity(9.81)], mb.Settings(friction=0.3, solver="gauss_seidel"))
    world.add_plane(normal=(0.1, -0.2, 1.0))
    wedge = mb.ConvexPiece([(0, 0, 0), (0.7, 0.1, 0), (0.2, 0.6, 0.1), (0.1, 0.2, 0.5), (0.5, 0.4, 0.3)])
    both = mb.Compound((mb.Box(0.4, 0.2, 0.2), mb.Box(0.2, 0.2, 0.4).pieces[0].moved((0.7, 0, 0.05), turns(2)[1] / 10.0)))
    shapes = mb.Box(0.4, 0.3, 0.2), mb.Capsule(0.1, 0.4), mb.Cylinder(0.2, 0.3, 12), mb.Sphere(0.2), wedge, both
    for k, turn in enumerate(turns(6)):
        world.add(shapes[k], density=1000.0, position=(0.1 * k, 0.05 * k, 0.6 + 0.5 * k), orientation=turn)
    world.add(wedge, density=1000.0, position=(0.3, 0.3, 0.5), fixed=True, friction=0.6)
    world.step(360)
    return world


def throw():
    """Four bodies in free flight in water: spin of unequal moments, drag, added mass."""
    effects = [mb.Gravity(9.81), mb.QuadraticDrag(drag_coefficient=1.05), mb.AddedMass(coefficient=0.5)]
    world = mb.World(effects, mb.Settings())
    for k, turn in enumerate(turns(4)):
        world.add(mb.Box(0.4, 0.3, 0.1 + 0.1 * k), density=2300.0, position=(2.0 * k, 0, 0), orientation=turn,
                  velocity=(1.0, -2.0, 3.0 + k), angular_velocity=(5.0, 0.1, -0.2 * k))  # fmt: skip
    world.step(480)
    return world


def placed(**settings):
    """Hash of the poses and readings of a placement test of two layers, 9 + 4 units."""
    result = hlcs.PlacementTest(layers=2, rows=3, columns=3, seed=3, **settings).run()
    return bits(*result.poses, *result.readings)


SCENES = {
    "heap of hulls, exact solver": lambda: bits(state(exact())),
    "heap of pieces with restitution, Gauss-Seidel": lambda: bits(state(heap(PIECES, restitution=0.3, solver="gauss_seidel"))),
    "heap of hulls, sequential impulse": lambda: bits(state(heap(HULL, solver="sequential_impulse", linear_damping=0.04))),
    "every kind of shape on a slope": lambda: bits(state(mixed())),
    "free flight in water": lambda: bits(state(throw())),
    "placement of pieces": placed,
    "placement of hulls": lambda: placed(shape="hull"),
    "placement on a slope": lambda: placed(bottom="slope:0.04", friction=0.3),
}

if __name__ == "__main__":
    for name, run in SCENES.items():
        print(f"{name}: {run()}", flush=True)
