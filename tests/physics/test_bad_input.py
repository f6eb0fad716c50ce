"""Section 4: input that peers accept, crash on or answer with nonsense is refused in one line that names it, or is solved.

Mesh files by the thousand, and every message of every room, are in tests/minibullet; here are the rows of the list.
"""

import struct
import warnings

import numpy as np
import pytest
import small_worlds as sw

import minibullet as mb

CORNERS = np.array([(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
TETRAHEDRON = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
NAN, INF = float("nan"), float("inf")


def add(**given):
    """A 1 kg ball with one thing wrong."""
    sw.make().add(mb.Sphere(0.5), **{"mass": 1.0, "name": "u17", **given})


def mesh(folder, name, data):
    """Read a mesh file of these bytes."""
    (folder / name).write_bytes(data)
    mb.mesh_file(folder / name)


def stl(count, triangles):
    """A binary STL that announces `count` triangles."""
    return bytes(80) + struct.pack("<I", count) + b"".join(struct.pack("<12fH", *np.ravel(t), 0) for t in triangles)


REFUSED = {
    "position NaN": (lambda d: add(position=(0, NAN, 0)), ("u17", "position", "finite"), "neighbour turns NaN"),
    "velocity infinite": (lambda d: add(velocity=(INF, 0, 0)), ("u17", "velocity", "finite"), "neighbour turns NaN"),
    "friction NaN": (lambda d: add(friction=NAN), ("u17", "friction"), "accepted"),
    "friction negative": (lambda d: add(friction=-0.1), ("u17", "friction"), "accepted"),
    "restitution 1.5": (lambda d: add(restitution=1.5), ("u17", "restitution", "between 0 and 1"), "accepted"),
    "mass negative": (lambda d: add(mass=-3.0), ("u17", "mass = -3.0", "fixed=True"), "becomes a fixed body"),
    "mass zero": (lambda d: add(mass=0.0), ("u17", "mass", "fixed=True"), "becomes a fixed body"),
    "zero quaternion": (lambda d: add(orientation=(0, 0, 0, 0)), ("u17", "quaternion"), "NaN pose"),
    "inertia A + B < C": (lambda d: add(inertia=(1.0, 1.0, 3.0)), ("u17", "3. exceeds the sum"), "accepted; MuJoCo refuses"),
    "hull of one point": (lambda d: mb.ConvexPiece(np.zeros((1, 3))), ("point",), "accepted"),
    "hull of coplanar points": (lambda d: mb.ConvexPiece(CORNERS[:4]), ("coplanar",), "accepted"),
    "hull with a NaN vertex": (lambda d: mb.ConvexPiece(np.vstack([CORNERS, [(NAN, 0, 0)]])), ("finite", "8"), "accepted"),
    "dt = 0": (lambda d: mb.Settings(time_step=0.0), ("time_step = 0.0",), "time stands still"),
    "iterations = 0": (lambda d: mb.Settings(iterations=0), ("iterations = 0",), "accepted"),
    "radius negative": (lambda d: mb.Sphere(-1.0), ("radius",), "one generic exception"),
    "missing mesh file": (lambda d: mb.mesh_file(d / "none.stl"), ("none.stl", "No such file"), "one generic exception"),
    "OBJ face index 999999999": (
        lambda d: mesh(d, "unit.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 999999999\n"),
        ("unit.obj", "line 4", "999999999", "only 3"),
        "segmentation fault",
    ),
    "STL that announces 4e9 triangles": (
        lambda d: mesh(d, "unit.stl", stl(4294967280, [])),
        ("unit.stl", "4294967280", "84 bytes"),
        "segmentation fault",
    ),
    "empty STL": (lambda d: mesh(d, "unit.stl", stl(0, [])), ("unit.stl", "empty"), "accepted"),
    "open mesh": (
        lambda d: mesh(d, "unit.obj", TETRAHEDRON + b"f 1 3 2\nf 1 2 4\nf 2 3 4\n"),
        ("unit.obj", "not a closed surface"),
        "volume and centre wrong",
    ),
    "inside-out mesh": (
        lambda d: mesh(d, "unit.obj", TETRAHEDRON + b"f 1 2 3\nf 1 4 2\nf 2 4 3\nf 1 3 4\n"),
        ("unit.obj", "inside out"),
        "volume -1",
    ),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_cannot_be_used_is_refused_by_name_in_one_line(record_case, tmp_path, what):
    """One exception class; the message names element, value and rule."""
    call, words, peer = REFUSED[what]
    with pytest.raises(mb.InputError) as refusal:
        call(tmp_path)
    message = str(refusal.value)
    assert "\n" not in message and all(word in message for word in words), message
    record_case("input", what, True, claim="refused by name", peer=peer)


@pytest.mark.parametrize(
    ("name", "shape", "peer"), [("spheres", mb.Sphere(0.5), "9.6 m/s"), ("hulls", mb.ConvexPiece(CORNERS), "14.7 m/s")]
)
def test_coincident_bodies_are_listed_before_the_first_step_and_parted_without_a_blow(record_case, name, shape, peer):
    """Two bodies in one place: both names and the depth are told; separated they have no velocity, then or a second later."""
    world = sw.make(gravity=0)
    pair = [world.add(shape, mass=1.0, position=(0, 0, 1e-3 * k), name=f"u{k}") for k in range(2)]
    listed = world.overlaps()
    assert {body.name for body in listed[0][:2]} == {"u0", "u1"} and listed[0][2] > 0.5
    world.separate()
    assert not world.overlaps()
    world.run(1.0)
    speed = max(np.linalg.norm(body.velocity) for body in pair)
    record_case(
        "input", f"coincident {name}: speed a second after they were parted", speed, 1e-9, "m/s", peer=f"ejected at {peer}"
    )


def test_small_fast_box_does_not_pass_a_thin_floor(record_case):
    """0.038 m at 20 m/s, 83 mm a step, onto 20 mm: speculative contacts see what a step reaches; at 24 phases of the step."""
    lowest = INF
    for phase in range(24):
        world = sw.make(friction=0.5)
        world.add(mb.Box(2, 2, 0.02), fixed=True, mass=1.0, position=(0, 0, -0.01))
        box = world.add(
            mb.Box(0.038, 0.038, 0.038), density=2300.0, position=(0, 0, 0.5 + phase / 24 * 20 / 240), velocity=(0, 0, -20.0)
        )
        world.run(0.2)
        lowest = min(lowest, box.position[2])
    record_case(
        "input",
        "0.038 m box at 20 m/s on a 2 cm floor: how far it sinks",
        min(lowest - 0.019, 0.0),
        1e-6,
        "m",
        peer="caught by luck",
    )


def test_mass_ratio_of_a_million_is_solved_or_told(record_case):
    """1 000 t on 1 kg for two seconds: no step without its residual, no jump to the side."""
    world = sw.make(friction=0.6)
    world.add_plane()
    boxes = [world.add(mb.Box(1, 1, 1), mass=mass, position=(0, 0, 0.5 + k)) for k, mass in enumerate((1.0, 1e6))]
    world.run(2.0)
    moved = max(np.linalg.norm(box.position - (0, 0, 0.5 + k)) for k, box in enumerate(boxes))
    told = world.unsolved_steps > 0 or world.worst_residual <= 1e-8
    record_case(
        "input",
        f"mass ratio 1e6, {world.unsolved_steps} steps not solved: distance from rest",
        moved,
        1e-6,
        "m",
        peer="light box thrown 15 m",
    )
    record_case("input", "mass ratio 1e6: residual told", told, claim="solved or counted")


def test_a_step_that_is_not_finite_stops_and_the_last_good_state_can_be_saved(record_case, tmp_path):
    """A force that overflows from 0.02 s on: the message names step, time and body; the step before is kept, saved, goes on."""

    class Broken(mb.Effect):
        def forces(self, bodies, time):
            return np.full((len(bodies.mass), 6), 1e308 if time > 0.02 else 0.0)

    world = mb.World([Broken()])
    body = world.add(mb.Sphere(0.5), mass=1e-3, name="u17", velocity=(1.0, 0, 0))
    with warnings.catch_warnings(), pytest.raises(mb.InputError) as refusal:
        warnings.simplefilter("ignore")
        world.step(20)
    assert all(word in str(refusal.value) for word in ("step 6", "u17", "not finite", "step 5"))
    world.save(tmp_path / "run.chk")
    again = mb.World.load(tmp_path / "run.chk", effects=[mb.Gravity()])
    again.step()
    kept = world.steps == 5 and np.isfinite(body.position).all() and np.isfinite(again.bodies[0].position).all()
    record_case("input", "not finite: stopped, last good state kept, saved and resumed", kept, claim="stopped, kept")
