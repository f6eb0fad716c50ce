"""A world on disk: one file that holds everything a step reads, so that a resumed run continues bit for bit.

NumPy's npz with a JSON header; no pickle. Written beside its place and renamed: a run killed at any moment leaves the old
file or the new one. What can be computed again (masses of the arrays, geometry, names) is not stored: the less a file says,
the less it can say wrongly. What it says is checked before any kernel reads it: a file may have been changed.
"""

import dataclasses
import hashlib
import io
import json

import numpy as np

from minibullet.collision.feature_cache import FeatureCache
from minibullet.collision.geometry import CAPSULE, DIRECTIONS, FACES, HALF_SPACE, SPHERE
from minibullet.collision.separation import DIRECTION, EDGE_EDGE, FACE_A, FACE_B, PLANE, ROUND, UNKNOWN
from minibullet.collision.warm_start import WarmStart
from minibullet.effects import library
from minibullet.effects.contract import name_of, parameters
from minibullet.errors import InputError, is_number, shown_value
from minibullet.files.arrays import ArrayFile
from minibullet.files.reading import path_of
from minibullet.files.writing import replace_file
from minibullet.scene import records
from minibullet.scene.registry import Body, Plane
from minibullet.settings import Settings
from minibullet.shapes import primitives
from minibullet.shapes.convex import ConvexPiece

FORMAT, READ = 2, (1, 2)  # what is written; what is read: format 1 had more arrays, which are ignored, and no checksum
MOST_BYTES = 4_000_000_000  # a million bodies in a heap make 2 GB
SIMPLE = {"sphere": primitives.Sphere, "box": primitives.Box, "capsule": primitives.Capsule, "cylinder": primitives.Cylinder}
COUNTS = ("steps", "unsolved_steps")
# name: (kind, shape, least, most); n bodies, p close pairs of pieces, c contacts of the last step, t bodies when the list of
# pairs was made. Unit vectors are checked by ``_check_arrays``, indices by ``_check_pairs``. None: not NaN, no more.
BIG = float(np.finfo(float).max)
ARRAYS = {
    "bodies_position": (float, ("n", 3), -BIG, BIG),
    "bodies_orientation": (float, ("n", 4), -2.0, 2.0),
    "bodies_twist": (float, ("n", 6), -BIG, BIG),
    "scene_moved": (float, ("n",), 0.0, np.inf),
    "collision_rows": (int, ("p", 4), 0, 2**62),
    "collision_answers": (int, ("p", 5), -1, 2**62),
    "collision_numbers": (float, ("p", 11), -np.inf, np.inf),
    "collision_contact_range": (int, ("p", 2), 0, 2**62),
    "collision_travel": (float, ("t",), 0.0, np.inf),
    "collision_allowance": (float, ("t",), 0.0, BIG),
    "kept_point": (float, ("c", 6), -BIG, BIG),
    "kept_normal": (float, ("c", 3), -2.0, 2.0),
    "kept_impulse": (float, ("c", 3), -BIG, BIG),
}


def shape_to_dict(shape):
    """A shape as plain numbers; InputError where it is of a kind of its own."""
    for kind, cls in SIMPLE.items():
        if type(shape) is cls:
            return {"kind": kind, **dataclasses.asdict(shape)}
    if isinstance(shape, ConvexPiece):
        return {"kind": "convex", "vertices": shape.vertices.tolist(), "radius": shape.radius}
    if not isinstance(shape, primitives.Compound):
        raise InputError(f"world: a shape of your own ({type(shape).__name__}) cannot be saved; use those of minibullet")
    return {"kind": "compound", "parts": [shape_to_dict(part) for part in shape.parts]}


def shape_from_dict(data):
    """The shape that ``shape_to_dict`` described; InputError where that describes none."""
    data = dict(data) if isinstance(data, dict) else {}
    kind = data.pop("kind", None)
    if kind == "convex" and set(data) == {"vertices", "radius"}:
        if not is_number(data["radius"]):
            raise InputError(f"hull: radius = {shown_value(data['radius'])}; it must be a number")
        return ConvexPiece(data["vertices"], data["radius"])
    if kind == "compound" and set(data) == {"parts"} and isinstance(data["parts"], list):
        return primitives.Compound(tuple(shape_from_dict(part) for part in data["parts"]))
    if isinstance(kind, str) and kind in SIMPLE and set(data) == {field.name for field in dataclasses.fields(SIMPLE[kind])}:
        if all(is_number(value) for value in data.values()):
            return SIMPLE[kind](**data)
    raise InputError(f"a shape of kind {shown_value(kind)} with {', '.join(data)[:80] or 'nothing'}; there is none such")


def save(world, path):
    """Write the world to ``path`` whole or not at all."""
    scene = world.registry.commit()
    if world.registry.aside:
        raise InputError(f"world: {len(world.registry.aside)} bodies are set aside and would be lost; bring them back to save it")
    distinct, items = {}, []
    for handle in world.registry.handles:
        shape = handle._record["shape"]
        number = None if shape is None else distinct.setdefault(shape, len(distinct))
        items.append(records.to_plain(handle._record) | {"shape": number, "row": handle._row})
    header = {
        "format": FORMAT,
        "settings": dataclasses.asdict(world.settings),
        "time": world.time,
        "steps": world.steps,
        "unsolved_steps": int(world.unsolved_steps),
        "worst_residual": float(world.worst_residual),
        "notices": world.notices,
        "shapes": [shape_to_dict(shape) for shape in distinct],
        "records": items,
        "calls": scene.collision.calls,
        "effects": [{"name": name_of(e), **{key: getattr(e, key) for key in _numbers(e)}} for e in world.effects],
    }
    text = json.dumps(header)
    arrays = {key: np.ascontiguousarray(value) for key, value in zip(ARRAYS, _arrays(world), strict=True)}
    buffer = io.BytesIO()
    np.savez(buffer, header=np.array(text), checksum=np.array(checksum(text, arrays)), **arrays)
    replace_file(path, buffer.getvalue())


def _arrays(world):
    """What the file keeps of a world's arrays, in the order of ARRAYS."""
    scene, bodies, collision = world.registry.scene, world.registry.scene.bodies, world.registry.scene.collision
    cache, last = collision.cache, world._warm_start
    return (
        bodies.position, bodies.orientation, bodies.twist, scene.past_motion,
        np.column_stack([cache.bodies, cache.pieces]), np.column_stack([cache.kind, cache.features, cache.best_faces]),
        np.column_stack([cache.gap, cache.since_search, cache.lead, cache.direction, cache.normal, cache.since_query,
                         cache.since_points]),
        cache.contacts, collision.travel, collision.allowance, np.column_stack([last.on_a, last.on_b]), last.normal, last.impulse,
    )  # fmt: skip


def _feature_cache(rows, answers, numbers, contacts):
    """The feature cache that ``_arrays`` took apart."""
    columns = (rows[:, :2], rows[:, 2:], answers[:, 0], answers[:, 1:3], answers[:, 3:], numbers[:, 0], numbers[:, 2],
               numbers[:, 3:6], numbers[:, 6:9], numbers[:, 1], numbers[:, 9], numbers[:, 10], contacts)  # fmt: skip
    return FeatureCache(*map(np.ascontiguousarray, columns))


def checksum(text, arrays):
    """SHA-256 of a header and arrays: it finds what was changed unawares, not what was changed with intent."""
    whole_content = hashlib.sha256(text.encode("utf-8", "surrogatepass"))
    for key, array in arrays.items():
        whole_content.update(f"{key} {array.shape}".encode())
        whole_content.update(array.tobytes())
    return whole_content.hexdigest()


def save_past(past, path):
    """Write the states a world went through, oldest first, as npz: time (k,), position (k, n, 3), orientation (k, n, 4), twist
    (k, n, 6). past: (time, Bodies) each; those of other numbers of bodies than the last are left out."""
    last = past[-1][1]
    kept = [(time, bodies) for time, bodies in past if len(bodies.mass) == len(last.mass)]
    columns = {key: np.array([getattr(bodies, key) for _, bodies in kept]) for key in ("position", "orientation", "twist")}
    buffer = io.BytesIO()
    np.savez(buffer, time=np.array([time for time, _ in kept]), **columns)
    replace_file(path, buffer.getvalue())


def _numbers(effect):
    """Names of an effect's fields that are numbers or tuples of numbers."""
    return [
        field.name
        for field in dataclasses.fields(effect)
        if field.name in parameters(effect) or isinstance(getattr(effect, field.name), tuple)
    ]


def load(world_class, path, effects=None):
    """The world saved at ``path``. effects: the values it was saved with, needed only where some are a user's own."""
    name = f"world file {str(path)!r}"
    if not path_of(path, "world file").exists():
        raise InputError(f"{name}: there is no such file")
    file = ArrayFile(path, name, MOST_BYTES, "it is not a file that World.save wrote, or it was changed: save the world again")
    text = str(file.take("header", str, ()))
    try:
        header = json.loads(text)
    except (ValueError, RecursionError) as error:
        file.fail(f"its header cannot be read ({' '.join(str(error).split())[:80]})")
    if not isinstance(header, dict) or header.get("format") not in READ:
        found = header.get("format") if isinstance(header, dict) else header
        file.fail(f"format {shown_value(found)}; this version reads format {' and '.join(map(str, READ))}")
    arrays = {key: file.take(key, kind, shape) for key, (kind, shape, _, _) in ARRAYS.items()}
    if header["format"] > 1 and str(file.take("checksum", str, ())) != checksum(text, arrays):
        file.fail("its content is not what its checksum was taken of")
    try:
        world = world_class(_effects(header.get("effects")) if effects is None else effects, _settings(header.get("settings")))
        _restore(world, header, arrays)
    except InputError as error:
        file.fail(str(error))
    except RecursionError:
        file.fail("its compounds of compounds are too deep")
    return world


def _settings(given):
    """The Settings of the header."""
    if not isinstance(given, dict) or set(given) != {field.name for field in dataclasses.fields(Settings)}:
        raise InputError(f"settings = {shown_value(given)}; every field of Settings must be there, and no other")
    return Settings(**given)


def _effects(items):
    """The effects of the header."""
    known, result = library(), []
    for item in _list("effects", items):
        name = item.get("name") if isinstance(item, dict) else None
        if not isinstance(name, str) or name not in known:
            raise InputError(f"effect {shown_value(name)} is not one of minibullet's; give the effects to World.load")
        usual, given = known[name](), {key: value for key, value in item.items() if key != "name"}
        for key, value in given.items():
            length = len(getattr(usual, key)) if key in _numbers(usual) and isinstance(getattr(usual, key), tuple) else None
            fits = isinstance(value, list) and len(value) == length and all(map(is_number, value)) if length else is_number(value)
            if key not in _numbers(usual) or not fits:
                raise InputError(f"effect {name!r}: {key[:40]} = {shown_value(value)} is no number that it has")
        result.append(known[name](**{key: tuple(value) if isinstance(value, list) else value for key, value in given.items()}))
    return result


def _restore(world, header, arrays):
    """Bring what was saved into a new world. InputError where any of it cannot be, or where its parts disagree."""
    for name in ("time", "worst_residual", "steps", "unsolved_steps", "calls"):
        value = header.get(name)
        if not is_number(value) and not (name == "worst_residual" and value == np.inf) or value < 0:
            raise InputError(f"{name} = {shown_value(value)}; it must be a number >= 0")
        if name in COUNTS and not (isinstance(value, int) and value < 2**62):
            raise InputError(f"{name} = {shown_value(value)}; it must be a whole number")
    world.time, world.worst_residual = float(header["time"]), float(header["worst_residual"])
    world.steps, world.unsolved_steps = header["steps"], header["unsolved_steps"]
    world._notices.texts = [text for text in _list("notices", header.get("notices", [])) if isinstance(text, str)]
    registry, scene = world.registry, world.registry.scene
    for handle, row in _handles(registry, header, arrays):
        registry.wait(handle)
        handle._row = row
    registry.commit(sorted(registry.handles, key=lambda handle: handle._row))
    _check_arrays(arrays, scene)
    _check_pairs(arrays, scene)
    position, orientation, twist, scene.past_motion, *cached, travel, allowance, points, normal, impulse = map(arrays.get, ARRAYS)
    scene.bodies = scene.bodies._replace(position=position, orientation=orientation, twist=twist)
    collision, (on_a, on_b) = scene.collision, map(np.ascontiguousarray, np.split(points, 2, axis=1))
    collision.cache, collision.travel, collision.allowance = _feature_cache(*cached), travel, allowance
    collision.calls, world._warm_start = header["calls"], WarmStart(on_a, on_b, normal, impulse)


def _list(name, value):
    """The value, or InputError where it is no list."""
    if not isinstance(value, list):
        raise InputError(f"{name} = {shown_value(value)}; it must be a list")
    return value


def _handles(registry, header, arrays):
    """Handle and row of every body, in the order in which they were added."""
    items, distinct = _list("records", header.get("records")), [shape_from_dict(d) for d in _list("shapes", header.get("shapes"))]
    count = len(items)
    for key in ("bodies_position", "bodies_orientation", "bodies_twist"):
        if len(arrays[key]) != count:
            raise InputError(f"{key} is about {len(arrays[key])} bodies, the records are {count}")
    free = set(range(count))
    for item in items:
        if not isinstance(item, dict):
            raise InputError(f"record {shown_value(item)}; it must hold what a body is")
        row, number = item.get("row"), item.get("shape")
        if type(row) is not int or row not in free:
            raise InputError(f"a body's row = {shown_value(row)}; the rows of {count} bodies are 0 to {count - 1}, each once")
        free.remove(row)
        if number is not None and (type(number) is not int or not 0 <= number < len(distinct)):
            raise InputError(f"a body's shape = {shown_value(number)}; there are {len(distinct)} shapes")
        twist = arrays["bodies_twist"][row]
        state = arrays["bodies_position"][row], arrays["bodies_orientation"][row], twist[:3], twist[3:]
        record = records.from_plain(item, None if number is None else distinct[number], state)
        yield (Plane if number is None else Body)(registry, record), row


def _check_arrays(arrays, scene):
    """InputError where a value is none that its array can hold."""
    for key, (_, _, least, most) in ARRAYS.items():
        wrong = ~((arrays[key] >= least) & (arrays[key] <= most))
        if wrong.any():
            place = np.unravel_index(wrong.argmax(), wrong.shape)
            where = ", ".join(map(str, place))
            raise InputError(f"{key}[{where}] = {arrays[key][place]}; it must lie between {least:g} and {most:g}")
    for key, first, end, zero in (
        ("bodies_orientation", 0, 4, False),
        ("collision_numbers", 3, 6, True),
        ("collision_numbers", 6, 9, True),
        ("kept_normal", 0, 3, False),
    ):
        square = (arrays[key][:, first:end] ** 2).sum(axis=1)
        wrong = ~((np.abs(square - 1.0) < 1e-6) | (zero & (square == 0.0)))
        if wrong.any():
            raise InputError(f"{key}[{wrong.argmax()}] = {arrays[key][wrong.argmax(), first:end].tolist()}; its length must be 1")
    if len(arrays["collision_travel"]) > len(scene.names):
        raise InputError(f"collision_travel is about {len(arrays['collision_travel'])} bodies, there are {len(scene.names)}")


def _check_pairs(arrays, scene):
    """InputError where a pair of pieces, the feature that parts it, or its contacts are none that this scene has."""
    rows, answers, contacts = (arrays[f"collision_{key}"] for key in ("rows", "answers", "contact_range"))
    pieces, own = scene.collision.pieces, scene.piece_ranges

    def refuse(key, right, rule):
        if not right.all():
            row = int(np.argmin(right))
            raise InputError(f"collision_{key}[{row}] = {arrays[f'collision_{key}'][row].tolist()}; {rule}")

    a, b, i, j = rows.T
    refuse("rows", (a < len(own)) & (b < len(own)) & (a != b), f"a and b must be two of {len(own)} bodies")
    refuse("rows", (own[a, 0] <= i) & (i < own[a, 1]) & (own[b, 0] <= j) & (j < own[b, 1]), "no such pieces of these bodies")
    refuse("rows", pieces.kind[j] != HALF_SPACE, "a plane stands first in its pair")

    kind, first, second = answers[:, 0], answers[:, 1], answers[:, 2]
    within = lambda index, piece, what: (pieces.ranges[piece, what, 0] <= index) & (index < pieces.ranges[piece, what, 1])  # noqa: E731
    kind_a, kind_b = pieces.kind[i], pieces.kind[j]
    plane = kind_a == HALF_SPACE
    closed = ~plane & ((kind_a == SPHERE) | (kind_b == SPHERE) | ((kind_a <= CAPSULE) & (kind_b <= CAPSULE)))
    flat = ~plane & ~closed
    refuse(
        "answers",
        (kind == UNKNOWN)
        | (plane & (kind == PLANE) & within(first, i, FACES))
        | (closed & (kind == ROUND))
        | (flat & (kind == DIRECTION))
        | (flat & (kind == FACE_A) & within(first, i, FACES))
        | (flat & (kind == FACE_B) & within(first, j, FACES))
        | (flat & (kind == EDGE_EDGE) & within(first, i, DIRECTIONS) & within(second, j, DIRECTIONS)),
        "no such face or edge of these pieces",
    )
    for column, piece in ((3, i), (4, j)):  # 0: not looked for yet
        refuse("answers", (answers[:, column] <= 0) | within(answers[:, column], piece, FACES), "no such face of these pieces")

    count = len(arrays["kept_point"])
    refuse("contact_range", (contacts[:, 0] <= contacts[:, 1]) & (contacts[:, 1] <= count), f"there are {count} contacts")
    order = np.argsort(contacts[:, 0], kind="stable")
    order = order[contacts[order, 0] < contacts[order, 1]]
    alone = np.ones(len(rows), dtype=bool)
    alone[order[1:]] = contacts[order[1:], 0] >= contacts[order[:-1], 1]
    refuse("contact_range", alone, "two pairs claim the same contact")
