"""A world on disk: one file that holds everything a step reads, so that a resumed run continues bit for bit.

NumPy's npz with a JSON header; no pickle. Written beside its place and renamed: a run killed at any moment leaves the old
file or the new one.
"""

import dataclasses
import io
import json
import zipfile

import numpy as np

from minibullet import shapes
from minibullet.convex import ConvexPiece
from minibullet.effects import library
from minibullet.effects.contract import name_of, parameters
from minibullet.errors import InputError
from minibullet.geometry import Pieces
from minibullet.registry import Body, Plane
from minibullet.settings import Settings
from minibullet.whole_files import refused, whole

FORMAT = 1
SCENE = ("friction", "restitution", "reach", "margin", "moved", "group", "piece_ranges", "frame")
COLLISION = ("rows", "answers", "numbers", "contact_range", "travel", "allowance")
KEPT = ("kept_point", "kept_normal", "kept_impulse")
RECORD = ("position", "orientation", "velocity", "angular_velocity", "inertia", "frame", "normal")
SIMPLE = {"sphere": shapes.Sphere, "box": shapes.Box, "capsule": shapes.Capsule, "cylinder": shapes.Cylinder}


def shape_to_dict(shape):
    """A shape as plain numbers."""
    for kind, cls in SIMPLE.items():
        if type(shape) is cls:
            return {"kind": kind, **dataclasses.asdict(shape)}
    if isinstance(shape, ConvexPiece):
        return {"kind": "convex", "vertices": shape.vertices.tolist(), "radius": shape.radius}
    return {"kind": "compound", "parts": [shape_to_dict(part) for part in shape.parts]}


def shape_from_dict(data):
    """The shape that ``shape_to_dict`` described."""
    data = dict(data)
    kind = data.pop("kind")
    if kind == "convex":
        return ConvexPiece(np.array(data["vertices"]), data["radius"])
    if kind == "compound":
        return shapes.Compound(tuple(shape_from_dict(part) for part in data["parts"]))
    return SIMPLE[kind](**data)


def save(world, path):
    """Write the world to ``path`` whole or not at all."""
    scene = world.registry.enrol()
    distinct, records = [], []
    for handle in world.registry.handles:
        record = dict(handle._record)
        shape = record.pop("shape")
        if shape is not None and shape not in distinct:
            distinct.append(shape)
        records.append(
            {
                **{key: (np.asarray(value).tolist() if key in RECORD else value) for key, value in record.items()},
                "shape": None if shape is None else distinct.index(shape),
                "row": handle._row,
                "plane": handle.is_plane,
            }
        )
    header = {
        "format": FORMAT,
        "settings": dataclasses.asdict(world.settings),
        "time": world.time,
        "steps": world.steps,
        "unsolved_steps": world.unsolved_steps,
        "worst_residual": world.worst_residual,
        "names": scene.names,
        "shapes": [shape_to_dict(shape) for shape in distinct],
        "records": records,
        "calls": scene.collision.calls,
        "effects": [{"name": name_of(e), **{key: getattr(e, key) for key in _numbers(e)}} for e in world.effects],
    }
    arrays = {f"bodies_{key}": value for key, value in scene.bodies._asdict().items()}
    arrays |= {f"scene_{key}": getattr(scene, key) for key in SCENE} | {
        f"collision_{key}": getattr(scene.collision, key) for key in COLLISION
    }
    arrays |= {f"pieces_{key}": value for key, value in scene.collision.pieces._asdict().items()}
    buffer = io.BytesIO()
    np.savez(buffer, header=np.array(json.dumps(header)), **arrays, **dict(zip(KEPT, world._kept, strict=True)))
    replace_file(path, buffer.getvalue())


def save_past(past, path):
    """Write the states a world went through, oldest first, as npz: time (k,), position (k, n, 3), orientation (k, n, 4), twist
    (k, n, 6). past: (time, Bodies) each; those of other numbers of bodies than the last are left out."""
    last = past[-1][1]
    kept = [(time, bodies) for time, bodies in past if len(bodies.mass) == len(last.mass)]
    columns = {key: np.array([getattr(bodies, key) for _, bodies in kept]) for key in ("position", "orientation", "twist")}
    buffer = io.BytesIO()
    np.savez(buffer, time=np.array([time for time, _ in kept]), **columns)
    replace_file(path, buffer.getvalue())


def replace_file(path, content):
    """Bytes into a file, whole or not at all; InputError or RunError where it cannot be written."""
    try:
        with whole(path) as partial:
            partial.write_bytes(content)
    except OSError as error:
        raise refused(error, f"world: cannot be saved as {str(path)!r}") from None


def _numbers(effect):
    """Names of an effect's fields that are numbers or tuples of numbers."""
    return [
        field.name
        for field in dataclasses.fields(effect)
        if field.name in parameters(effect) or isinstance(getattr(effect, field.name), tuple)
    ]


def load(world_class, path, effects=None):
    """The world saved at ``path``. effects: the values it was saved with, needed only where some are a user's own."""
    try:
        with np.load(path, allow_pickle=False) as file:
            data = {key: file[key] for key in file.files}
        header = json.loads(str(data["header"]))
    except FileNotFoundError:
        raise InputError(f"world file {str(path)!r}: there is no such file") from None
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise InputError(f"world file {str(path)!r}: not a file that World.save wrote ({error})") from None
    if header.get("format") != FORMAT:
        raise InputError(f"world file {str(path)!r}: format {header.get('format')!r}; this version reads format {FORMAT}")
    world = world_class(_effects(header, path) if effects is None else effects, Settings(**header["settings"]))
    for name in ("time", "steps", "unsolved_steps", "worst_residual"):
        setattr(world, name, header[name])
    registry = world.registry
    scene = registry.scene
    distinct = [shape_from_dict(item) for item in header["shapes"]]
    for item in header["records"]:
        record = {key: (np.array(value, dtype=float) if key in RECORD else value) for key, value in item.items()}
        row, plane, shape = record.pop("row"), record.pop("plane"), record.pop("shape")
        record["shape"] = None if shape is None else distinct[shape]
        record["mass"] = float(record["mass"])
        handle = (Plane if plane else Body)(registry, record)
        handle._row = row
        registry.handles.append(handle)
    for handle in sorted(registry.handles, key=lambda handle: handle._row):
        registry.pieces_of(handle)  # pieces come back in the order in which they first entered
    scene.bodies = type(scene.bodies)(*(data[f"bodies_{key}"] for key in scene.bodies._fields))
    for key in SCENE:
        setattr(scene, key, data[f"scene_{key}"])
    for key in COLLISION:
        setattr(scene.collision, key, data[f"collision_{key}"])
    scene.collision.pieces = Pieces(*(data[f"pieces_{key}"] for key in Pieces._fields))
    scene.collision.calls, scene.names = header["calls"], list(header["names"])
    world._kept = tuple(data[key] for key in KEPT)
    return world


def _effects(header, path):
    known, result = library(), []
    for item in header["effects"]:
        item = dict(item)
        name = item.pop("name")
        if name not in known:
            raise InputError(
                f"world file {str(path)!r}: effect {name!r} is not one of minibullet's; give the effects to World.load"
            )
        result.append(known[name](**{key: tuple(value) if isinstance(value, list) else value for key, value in item.items()}))
    return result
