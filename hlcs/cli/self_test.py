"""`hlcs doctor`: versions, optional parts, and a self-test of the engine and of the collision library in some seconds."""

import importlib.util
import time
from typing import NamedTuple

import numpy as np

import minibullet as mb
from hlcs.files.versions import versions
from hlcs.placement.grids import TPG
from hlcs.placement.procedure import PlacementTest
from hlcs.placement.units import Cubipod

EXTRAS = {
    "sweep": ("distributed",),
    "units": ("coacd",),
    "notebook": ("jupyter_client", "ipykernel", "nbclient"),
    "docs": ("sphinx", "myst_nb"),
    "test": ("pytest", "hypothesis"),
    "oracle": ("pybullet",),
}


class Check(NamedTuple):
    """One part of the self-test."""

    name: str
    passed: bool
    found: str
    seconds: float


def examine():
    """The whole examination as a dictionary: versions, extras {name: missing modules}, checks, passed."""
    missing = {extra: [name for name in modules if importlib.util.find_spec(name) is None] for extra, modules in EXTRAS.items()}
    checks = [_timed(check) for check in (collision, free_fall, friction, rest, placement)]
    return {
        "format": 1,
        "versions": versions(),
        "extras": missing,
        "checks": [check._asdict() for check in checks],
        "passed": all(check.passed for check in checks),
    }


def collision():
    """Collision library: gap of two turned unit cubes, corner to face, against geometry."""
    import fcl

    half_diagonal = 0.5 * np.sqrt(3.0)
    upright = mb.rotations.matrix(mb.rotations.between(np.ones(3) / np.sqrt(3.0), np.array([0.0, 0.0, 1.0])))
    cube = fcl.CollisionObject(fcl.Box(1.0, 1.0, 1.0), fcl.Transform(np.eye(3), np.zeros(3)))
    turned = fcl.CollisionObject(fcl.Box(1.0, 1.0, 1.0), fcl.Transform(upright, np.array([0.1, 0.2, 1.6])))
    gap, expected = fcl.distance(cube, turned, fcl.DistanceRequest(), fcl.DistanceResult()), 1.6 - 0.5 - half_diagonal
    return abs(gap - expected) < 1e-5, f"gap {gap:.6f} m, exactly {expected:.6f} m"


def free_fall():
    """Engine: a body falls as the discrete law says, g n (n + 1) dt^2 / 2 or g t^2 / 2, whichever the engine integrates."""
    world = mb.World([mb.Gravity(9.81)], mb.Settings())
    ball = world.add(mb.Sphere(0.1), density=1000.0, position=(0.0, 0.0, 0.0))
    world.run(1.0)
    fallen, exact, step = -ball.position[2], 0.5 * 9.81, 0.5 * 9.81 / 240
    return min(abs(fallen - exact), abs(fallen - exact - step)) < 1e-9, f"{fallen:.6f} m in 1 s, exactly {exact:.6f} m"


def friction():
    """Engine: a box on a slope of 0.5 holds at friction 0.51 and slides at 0.49."""
    moved = []
    for coefficient in (0.51, 0.49):
        world = mb.World([mb.Gravity(9.81)], mb.Settings(friction=coefficient))
        normal = np.array([0.0, -0.5, 1.0]) / np.sqrt(1.25)
        world.add_plane(normal, 0.0)
        turned = mb.rotations.between(np.array([0.0, 0.0, 1.0]), normal)
        box = world.add(mb.Box(1.0, 1.0, 0.2), density=1000.0, position=0.1 * normal, orientation=turned)
        start = box.position.copy()
        world.run(1.0)
        moved.append(float(np.linalg.norm(box.position - start)))
    # with gravity along the slope g (0.5 - 0.49) / sqrt(1.25), half a second squared of it after 1 s
    slide = 0.5 * 9.81 * 0.01 / np.sqrt(1.25)
    good = moved[0] < 1e-6 and abs(moved[1] - slide) < 0.02 * slide
    return good, f"held to {moved[0]:.1e} m; slid {moved[1]:.4f} m of {slide:.4f} m"


def rest():
    """Engine and collision: a Cubipod stays on its edge, 1.298 Dn high."""
    unit = Cubipod(side=1.0)
    world = mb.World([mb.Gravity(9.81)], mb.Settings(friction=0.6))
    world.add_plane()
    handle = world.add(
        unit.shape(), density=2300.0, position=(0.0, 0.0, unit.rest_height), orientation=unit.first_layer_orientation(0.3)
    )
    world.run(1.0)
    sunk = abs(handle.position[2] - unit.rest_height) / unit.nominal_diameter
    return sunk < 1e-4, f"centre moved {sunk:.1e} Dn in 1 s; unit {unit.first_layer_coefficient:.3f} Dn high"


def placement():
    """Laboratory: two small layers settle, nothing overlaps, the first is 1.298 Dn thick."""
    result = PlacementTest(grid=TPG, layers=2, rows=3, columns=3).run()
    first = result.layer_coefficients[0]
    deep = max(record.penetration for record in result.records) / result.test.unit.nominal_diameter
    moving = sum(record.unsettled for record in result.records)
    good = abs(first - 1.298) < 1e-3 and deep < 5e-3 and moving == 0
    return good, f"k1 = {first:.4f}, deepest overlap {deep:.1e} Dn, {moving} moving"


def text_of(report):
    """What `hlcs doctor` prints."""
    lines = [f"{name:>12} {version or 'not installed'}" for name, version in report["versions"].items()]
    lines.append("")
    for extra, missing in report["extras"].items():
        state = f"absent ({', '.join(missing)}); python -m pip install -e '.[{extra}]'" if missing else "present"
        lines.append(f"{'extra ' + extra:>16}: {state}")
    lines.append("")
    for check in report["checks"]:
        lines.append(f"{'ok' if check['passed'] else 'FAILED':>8} {check['name']}: {check['found']} ({check['seconds']:.1f} s)")
    lines.append("everything works" if report["passed"] else "the self-test failed: install again; if it stays, report this")
    return "\n".join(lines)


def _timed(check):
    started = time.perf_counter()
    try:
        passed, found = check()
    except Exception as problem:  # whatever breaks is what the doctor is asked for
        passed, found = False, f"{type(problem).__name__}: {problem}"
    return Check(check.__name__.replace("_", " "), bool(passed), found, time.perf_counter() - started)
