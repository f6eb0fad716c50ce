"""A world on disk: it goes on bit for bit, a broken write leaves the old file, a foreign file is refused in one line."""

import copy
import io
import json
import os
import zipfile
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import minibullet as mb
from minibullet.scene import saving


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


# ---- files that somebody changed ---------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """A heap of ten bodies (rows 0 to 9) amid its fall, as header and arrays."""
    path = tmp_path_factory.mktemp("saved") / "run.npz"
    world = falling(np.random.default_rng(5))
    world.step(90)
    world.save(path)
    with np.load(path) as file:
        arrays = {key: file[key] for key in file.files}
    return json.loads(str(arrays.pop("header"))), arrays


def load_changed(saved, folder, edit_header=None, edit_arrays=None):
    """Load the saved world with a change that its checksum covers."""
    header, arrays = copy.deepcopy(saved)
    if edit_header:
        edit_header(header)
    if edit_arrays:
        edit_arrays(arrays)
    text = header if isinstance(header, str) else json.dumps(header)
    arrays["checksum"] = np.array(saving.checksum(text, {key: arrays[key] for key in saving.ARRAYS if key in arrays}))
    np.savez(folder / "changed.npz", header=np.array(text), **arrays)
    return mb.World.load(folder / "changed.npz")


def put(key, place, value):
    """An edit that puts a value at a place of an array."""

    def edit(arrays):
        arrays[key][place] = value

    return edit


def swap(key, make):
    """An edit that makes another array of one."""

    def edit(arrays):
        arrays[key] = make(arrays[key])

    return edit


CHANGED_ARRAYS = {
    "body that is not there": (put("collision_rows", (0, 0), 99), "collision_rows[0]"),
    "body of 2^61": (put("collision_rows", (0, 1), 2**61), "collision_rows[0]"),
    "negative body": (put("collision_rows", (0, 0), -1), "collision_rows[0, 0] = -1"),
    "body against itself": (lambda a: put("collision_rows", (0, 1), a["collision_rows"][0, 0])(a), "collision_rows[0]"),
    "piece of another body": (put("collision_rows", (0, 3), 0), "collision_rows[0]"),
    "kind of answer": (put("collision_answers", (0, 0), 7), "collision_answers[0]"),
    "face of another piece": (put("collision_answers", (slice(None), 1), 10**6), "collision_answers["),
    "best face": (put("collision_answers", (0, 3), 10**6), "collision_answers[0]"),
    "contacts beyond the end": (put("collision_contact_range", (0, 1), 10**6), "collision_contact_range[0]"),
    "contacts backwards": (put("collision_contact_range", (0, slice(None)), (2, 1)), "collision_contact_range[0]"),
    "contacts taken twice": (put("collision_contact_range", (slice(None), slice(None)), (0, 1)), "claim the same contact"),
    "gap that is none": (put("collision_numbers", (0, 0), np.nan), "collision_numbers[0, 0] = nan"),
    "normal of length 5": (put("collision_numbers", (0, slice(6, 9)), (0, 0, 5.0)), "collision_numbers[0]"),
    "position infinite": (put("bodies_position", (0, 0), np.inf), "bodies_position[0, 0] = inf"),
    "quaternion zero": (put("bodies_orientation", 0, 0.0), "bodies_orientation[0]"),
    "velocity none": (put("bodies_twist", (1, 4), np.nan), "body"),
    "motion negative": (put("scene_moved", 0, -1.0), "scene_moved[0] = -1.0"),
    "impulse none": (put("kept_impulse", (0, 0), np.nan), "kept_impulse[0, 0] = nan"),
    "a body more": (swap("bodies_position", lambda a: np.concatenate([a, a[:1]])), "bodies_orientation"),
    "kept contacts cut": (swap("kept_point", lambda a: a[:-1]), "kept_normal"),
    "other type": (swap("collision_rows", lambda a: a.astype(float)), "collision_rows is float64"),
    "other width": (swap("bodies_twist", lambda a: a[:, :5]), "bodies_twist is float64"),
    "missing": (lambda a: a.pop("kept_impulse"), "kept_impulse is missing"),
}  # fmt: skip


@pytest.mark.parametrize("what", CHANGED_ARRAYS)
def test_an_array_that_cannot_be_is_refused_by_name(saved, tmp_path, what):
    """Every array is checked in type, shape, range and against the others; the message names file, array and place."""
    edit, words = CHANGED_ARRAYS[what]
    with pytest.raises(mb.InputError) as refused:
        load_changed(saved, tmp_path, edit_arrays=edit)
    message = str(refused.value)
    assert "changed.npz" in message and words in message and "\n" not in message


def record(key, value):
    """An edit of the first record that is no plane."""

    def edit(header):
        next(r for r in header["records"] if r["shape"] is not None and not r["fixed"])[key] = value

    return edit


CHANGED_HEADERS = {
    "time as text": (lambda h: h.update(time="now"), "time"),
    "steps of 400 digits": (lambda h: h.update(steps=10**400), "steps"),
    "steps negative": (lambda h: h.update(steps=-1), "steps"),
    "no settings": (lambda h: h.pop("settings"), "settings"),
    "setting unknown": (lambda h: h["settings"].update(other=1), "settings"),
    "setting impossible": (lambda h: h["settings"].update(time_step=-1.0), "time_step = -1.0"),
    "mass negative": (record("mass", -3.0), "mass = -3.0"),
    "mass missing": (record("mass", None), "mass"),
    "mass infinite": (record("mass", np.inf), "mass = inf"),
    "inertia impossible": (record("inertia", [1.0, 1.0, 3.0]), "exceeds the sum"),
    "frame zero": (record("frame", [0.0] * 4), "frame"),
    "friction as list": (record("friction", [1]), "friction"),
    "group of 400 digits": (record("group", 10**400), "group"),
    "shape number": (record("shape", 77), "there are 8 shapes"),
    "row twice": (record("row", 0), "row"),
    "name a number": (record("name", 5), "name"),
    "record no dictionary": (lambda h: h["records"].__setitem__(0, 3), "record 3"),
    "a record less": (lambda h: h["records"].pop(), "records"),
    "shape unknown": (lambda h: h["shapes"].__setitem__(0, {"kind": "torus"}), "torus"),
    "shape of a list": (lambda h: h["shapes"].__setitem__(0, {"kind": [], "radius": 1.0}), "shape of kind"),
    "shape with a NaN": (lambda h: h["shapes"].__setitem__(0, {"kind": "sphere", "radius": np.nan}), "shape of kind"),
    "sphere of 1e300 m": (lambda h: h["shapes"].__setitem__(0, {"kind": "sphere", "radius": 1e300}), "volume"),
    "vertices of text": (lambda h: h["shapes"].__setitem__(0, {"kind": "convex", "vertices": "x", "radius": 0}), "vertices"),
    "effect with a wrong number": (lambda h: h["effects"][0].update(acceleration="x"), "gravity"),
    "effects no list": (lambda h: h.update(effects=4), "effects"),
}


@pytest.mark.parametrize("what", CHANGED_HEADERS)
def test_a_header_that_cannot_be_is_refused_by_name(saved, tmp_path, what):
    """Types, ranges, missing and strange keys, records that disagree with the arrays."""
    edit, words = CHANGED_HEADERS[what]
    with pytest.raises(mb.InputError) as refused:
        load_changed(saved, tmp_path, edit_header=edit)
    message = str(refused.value)
    assert "changed.npz" in message and words in message and "\n" not in message


@pytest.mark.parametrize("text", ["[" * 100_000, "5", "null", '{"format": 99}', '{"format": 1' + "0" * 5000 + "}"])
def test_json_that_is_no_header_is_refused(saved, tmp_path, text):
    """Nested beyond any stack, no dictionary, another format, a number of 5001 digits."""
    _, arrays = saved
    np.savez(tmp_path / "changed.npz", header=np.array(text), **arrays)
    with pytest.raises(mb.InputError, match="changed.npz"):
        mb.World.load(tmp_path / "changed.npz")


def test_compounds_of_compounds_without_end_are_refused(saved, tmp_path):
    """Deeper than Python follows."""
    header, arrays = copy.deepcopy(saved)
    deep = '{"kind": "compound", "parts": [' * 800 + '{"kind": "sphere", "radius": 1.0}' + "]}" * 800
    text = json.dumps(header | {"shapes": ["here"] * 8}).replace('"here"', deep)
    arrays["checksum"] = np.array(saving.checksum(text, {key: arrays[key] for key in saving.ARRAYS}))
    np.savez(tmp_path / "changed.npz", header=np.array(text), **arrays)
    with pytest.raises(mb.InputError, match="changed.npz"):
        mb.World.load(tmp_path / "changed.npz")


def test_a_change_without_a_new_checksum_is_noticed(saved, tmp_path):
    """A velocity that could be, but was not: only the checksum knows."""
    header, arrays = copy.deepcopy(saved)
    arrays["bodies_twist"][arrays["bodies_twist"][:, 0] != 0.0, 0] += 0.1
    np.savez(tmp_path / "changed.npz", header=np.array(json.dumps(header)), **arrays)
    with pytest.raises(mb.InputError, match="checksum"):
        mb.World.load(tmp_path / "changed.npz")


@pytest.mark.parametrize(("claim", "words"), [
    ("{'descr': '<f8', 'fortran_order': False, 'shape': (10**12, 3), }", "cannot be read"),
    ("{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000, 3), }", "claims"),
    ("{'descr': '|O', 'fortran_order': False, 'shape': (3, 3), }", "object"),
    ("{'descr': '<f8', 'fortran_order': False, 'shape': (-1, 3), }", "bodies_position"),
    ("(" * 5000, "bodies_position cannot be read"),
])  # fmt: skip
def test_what_an_array_claims_is_believed_only_where_its_bytes_are_there(saved, tmp_path, claim, words):
    """24 TB, Python objects, negative lengths, a header nested without end: refused before anything is set aside."""
    header, arrays = saved
    head = claim.encode() + b"\n"
    with zipfile.ZipFile(tmp_path / "changed.npz", "w") as file:
        for key, array in {"header": np.array(json.dumps(header)), **arrays}.items():
            buffer = io.BytesIO()
            np.save(buffer, array)
            lie = b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head
            file.writestr(f"{key}.npy", lie if key == "bodies_position" else buffer.getvalue())
    with pytest.raises(mb.InputError, match=words):
        mb.World.load(tmp_path / "changed.npz")


def test_a_small_file_that_unpacks_to_a_large_one_is_refused(saved, tmp_path):
    """80 MB of zeros in 80 kB: a world is never packed, so what it unpacks to is no larger than itself."""
    header, arrays = saved
    np.savez_compressed(
        tmp_path / "changed.npz", header=np.array(json.dumps(header)), **{**arrays, "bodies_position": np.zeros((10**7 // 3, 3))}
    )
    with pytest.raises(mb.InputError, match="claims .* bytes; there is room for"):
        mb.World.load(tmp_path / "changed.npz")


def test_a_file_of_format_1_still_loads_and_goes_on():
    """Written by an earlier version, which stored more and took no checksum: a block on the floor and a ball on it, at rest."""
    world = mb.World.load(Path(__file__).with_name("format_1.npz"))
    assert (world.steps, [body.name for body in world.bodies]) == (20, ["block", "ball"])
    world.step(50)
    assert [body.position[2] for body in world.bodies] == pytest.approx([0.1, 0.31], abs=1e-8)


def test_a_shape_of_the_users_own_cannot_be_saved(tmp_path):
    """A file holds numbers and no code: refused by name, nothing written."""

    class Strange(mb.Sphere):
        pass

    world = mb.World()
    world.add(Strange(1.0), mass=1.0)
    with pytest.raises(mb.InputError, match="Strange"):
        world.save(tmp_path / "run.npz")
    assert not list(tmp_path.iterdir())


# ---- steps that do not end ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "where",
    [
        "collision.manifolds.build",
        "contact.gauss_seidel.solve",
        "dynamics.depenetration.undo_overlap",
        "dynamics.integrate.integrate",
    ],
)
def test_an_interrupted_step_changes_nothing(generator, monkeypatch, where):
    """Ctrl-C between any two parts of a step: the world is that of the step before, and goes on bit for bit."""
    world, twin = falling(np.random.default_rng(3)), falling(np.random.default_rng(3))
    world.step(70)
    twin.step(70)
    room, name = where.rsplit(".", 1)
    room = import_module(f"minibullet.{room}")
    done = getattr(room, name)

    def interrupted(*given, **named):
        done(*given, **named)
        raise KeyboardInterrupt

    monkeypatch.setattr(room, name, interrupted)
    with pytest.raises(KeyboardInterrupt):
        world.step()
    monkeypatch.undo()
    assert world.steps == 70 and state(world) == state(twin)
    world.step(60)
    twin.step(60)
    assert state(world) == state(twin)


def test_a_world_rescued_amid_a_failed_step_goes_on_bit_for_bit(generator, tmp_path):
    """A contact law that fails at step 70: the rescue file is step 69 whole, contacts and all."""

    @dataclass(frozen=True)
    class Failing(mb.Effect):
        def contact_law(self, contacts, bodies, law):
            return law._replace(friction=law.friction * (np.nan if fail else 1.0))

    fail = False
    world, twin = falling(np.random.default_rng(3), Failing()), falling(np.random.default_rng(3), Failing())
    world.rescue = tmp_path / "run.chk"
    world.step(69)
    twin.step(69)
    fail = True
    with pytest.raises(mb.InputError, match="step 70.*Failing.*saved"):
        world.step()
    fail = False
    again = mb.World.load(tmp_path / "run.chk", effects=twin.effects)
    again.step(60)
    twin.step(60)
    assert state(again) == state(twin)
