"""Pictures of a world: a still image, a GLB scene for other programs, and one page that turns in a browser.

What is drawn is a World, or a list of (shape, position, orientation, colour): position of the centre of mass [m],
orientation (w, x, y, z), colour any that matplotlib knows, or a number that picks one of LAYER_COLOURS. A shape of None
is the plane through that position whose normal is the turned z axis.
"""

import io
import json
from importlib.resources import files
from typing import NamedTuple

import numpy as np

from minibullet import rotations
from minibullet.errors import InputError
from minibullet.files.writing import whole
from minibullet.report.rendering import FAR, FILLED, Solid, extent_seen, render
from minibullet.shapes import polyhedra
from minibullet.shapes.convex import ConvexPiece

LAYER_COLOURS = ("#6a8caf", "#dda63f", "#86b07c", "#cf6f54", "#9683bf", "#b8ad9c")
FIXED_COLOUR, FLOOR_COLOUR = "#b9b5ac", "#e6e2d8"
STEPS = 17  # colours of a scale that a page mixes between
MOST_SHOWN = 0.98  # share of the values that a scale covers: one unit that rolled away must not make all others alike


class Item(NamedTuple):
    """One thing to draw."""

    key: object  # equal for things of the same form: their vertices are stored once
    parts: tuple  # of (vertices (v, 3), faces): convex, body frame
    position: np.ndarray  # (3,) m
    orientation: np.ndarray  # (4,)
    colour: tuple  # red, green, blue from 0 to 1


class Motion(NamedTuple):
    """How some things of a scene move."""

    first: int  # number in the scene of the first that moves; the others follow it
    times: np.ndarray  # (f,) s
    poses: np.ndarray  # (f, n, 7) positions of the centres of mass [m] and orientations


class Shades(NamedTuple):
    """Values that the first things of a scene are coloured by, where a button of the page asks for it."""

    name: str  # what they are, in words
    unit: str  # "" for a pure number
    values: np.ndarray  # (n,), one a thing; NaN where there is none


def draw_scene(scene, path=None, ax=None, *, colours=None, azimuth=-60.0, elevation=28.0, width=1200, height=800):
    """A still image of the scene from azimuth, elevation [degrees]: into a PNG file, onto matplotlib Axes, or both. -> Axes.

    colours: one for each body of a World, in the order they were added (such as the layer it belongs to).
    """
    import matplotlib

    image = render(_solids(_items(scene, colours)), width, height, azimuth, elevation)
    if path is not None:
        import matplotlib.image

        with whole(path) as partial:
            matplotlib.image.imsave(partial, image, format="png")
    if ax is None:
        from matplotlib.figure import Figure

        ax = Figure(figsize=(width / 100, height / 100)).add_axes((0, 0, 1, 1))
    ax.imshow(image, interpolation="lanczos")
    ax.set_axis_off()
    return ax


def parallel_view(scene, azimuth, elevation, *, colours=None, width=1200, supersample=2):
    """A view without perspective, in which lengths can be measured, from azimuth, elevation [degrees].

    Returns the image (height, width, 4), as high as the scene asks for, and the (left, right, bottom, top) of its edges, to the
    right and upwards in the view [m], the world's origin at (0, 0). From azimuth -90 it is x to the right, from 0 it is y; from
    elevation 0 z is upwards, from 90 (above, azimuth -90) y is.
    """
    solids = _solids(_items(scene, colours))
    left, right, bottom, top = extent_seen(solids, azimuth, elevation)
    height = max(1, round(width * (top - bottom) / (right - left)))
    image = render(solids, width, height, azimuth, elevation, supersample, FAR)
    metre = max((right - left) / width, (top - bottom) / height) / FILLED  # of one pixel
    x, y, half_x, half_y = 0.5 * (left + right), 0.5 * (bottom + top), 0.5 * width * metre, 0.5 * height * metre
    return image, (x - half_x, x + half_x, y - half_y, y + half_y)


def moving_views(scenes, *, azimuth=-60.0, elevation=28.0, width=480, height=340):
    """Images (height, width, 4) of scenes that follow each other, such as units that fall, all seen by the same eye."""
    moments = [_solids(_items(scene, None)) for scene in scenes]
    around = moments[0] + moments[-1]
    return [render(solids, width, height, azimuth, elevation, 1, around=around) for solids in moments]


def gif_bytes(images, seconds):
    """An endless GIF of images (f, height, width, 4) from 0 to 1, on white; seconds (f,): how long each stands."""
    from PIL import Image

    frames = []
    for image in images:
        solid = image[..., :3] * image[..., 3:] + (1.0 - image[..., 3:])
        frames.append(Image.fromarray(np.round(255.0 * np.clip(solid, 0.0, 1.0)).astype(np.uint8)).quantize(48))
    buffer, last = io.BytesIO(), [max(20, round(1000.0 * one)) for one in seconds]
    frames[0].save(buffer, format="GIF", save_all=True, append_images=frames[1:], duration=last, loop=0, optimize=True)
    return buffer.getvalue()


def animation(images, seconds):
    """A matplotlib animation of images (f, height, width, 4); seconds: between two of them."""
    from matplotlib.animation import ArtistAnimation
    from matplotlib.figure import Figure

    height, width = images[0].shape[:2]
    figure = Figure(figsize=(width / 100, height / 100))
    ax = figure.add_axes((0, 0, 1, 1))
    ax.set_axis_off()
    frames = [[ax.imshow(image)] for image in images]
    return ArtistAnimation(figure, frames, interval=1000.0 * seconds)


def write_page(path, scene, *, title="minibullet", colours=None):
    """One HTML file with the scene inside that opens offline: drag to turn, wheel or pinch to zoom, double click to come back."""
    write_bytes(path, page(scene, title=title, colours=colours).encode())


def page(scene, *, title="minibullet", colours=None, motion=None, groups=(), shades=()):
    """The text of that HTML page, to be embedded elsewhere. With a `Motion` of the scene it has a slider for the time.

    groups: (name, first, end) of things that a button hides, by their numbers in the scene, `end` left out; shades: `Shades` that
    another button colours things by, one after the other.
    """
    items = _items(scene, colours)
    # Lengths in units of the smallest body: five digits are then enough for any size.
    unit = min(np.abs(vertices).max() for item in items for vertices, _ in item.parts)
    numbers, shapes, bodies = {}, [], []
    for item in items:
        if item.key not in numbers:
            numbers[item.key] = len(shapes)
            shapes.append([[_rounded(vertices / unit), [list(loop) for loop in faces]] for vertices, faces in item.parts])
        bodies.append([numbers[item.key], _rounded(item.position / unit), _rounded(item.orientation), _rounded(item.colour, 3)])
    # "<" cannot end the script early when it is written as an escape.
    content = {"title": title, "shapes": shapes, "bodies": bodies, "groups": [list(group) for group in groups]}
    if known := [shade for shade in shades if np.isfinite(shade.values).any()]:
        content["shades"], content["scale"] = [_shade(shade) for shade in known], _scale()
    if motion is not None:
        scaled = np.asarray(motion.poses, dtype=float) / np.array([*3 * [unit], *4 * [1.0]])
        content["motion"] = {
            "first": int(motion.first),
            "times": _rounded(motion.times, 3),
            "poses": [_rounded(frame, 4) for frame in scaled],
        }
    data = json.dumps(content, separators=(",", ":")).replace("<", "\\u003c")
    template = files("minibullet.report").joinpath("page.html").read_text(encoding="utf-8")
    return template.replace("/*DATA*/null", data)


def _shade(shade):
    """Shades as the page has them, from zero or the least value up to what all but 2 % of the values reach."""
    known = shade.values[np.isfinite(shade.values)]
    low, high = min(0.0, known.min()), np.quantile(known, MOST_SHOWN)
    return {
        "name": shade.name,
        "unit": shade.unit,
        "low": float(low),
        "high": float(high if high > low else low + 1.0),
        "beyond": bool(known.max() > high),
        "values": [float(f"{value:.4g}") if np.isfinite(value) else None for value in shade.values],
    }


def _scale():
    """Colours from low to high [0 to 255]: cividis, which grows lighter evenly for colour-blind readers too."""
    from matplotlib import colormaps

    return np.round(255.0 * colormaps["cividis"](np.linspace(0.0, 1.0, STEPS))[:, :3]).astype(int).tolist()


def write_glb(path, scene, *, colours=None):
    """A binary glTF file for Blender, three.js, slide shows: one node a body, y up as glTF wants it, flat faces."""
    import trimesh

    upright = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
    gltf, meshes = trimesh.Scene(), {}
    for number, item in enumerate(_items(scene, colours)):
        key = item.key, item.colour
        transform = np.eye(4)
        transform[:3, :3], transform[:3, 3] = rotations.matrix(item.orientation), item.position
        if key not in meshes:
            meshes[key] = f"shape {len(meshes)}"
            gltf.add_geometry(_flat_mesh(item), geom_name=meshes[key], node_name=f"body {number}", transform=upright @ transform)
        else:
            gltf.graph.update(frame_to=f"body {number}", matrix=upright @ transform, geometry=meshes[key])
    write_bytes(path, gltf.export(file_type="glb"))


def _items(scene, colours):
    """What to draw, floors last."""
    rows = rows_of_world(scene, colours) if hasattr(scene, "bodies") else list(scene)
    rows = [
        (shape, np.asarray(position, dtype=float), np.asarray(orientation, dtype=float), colour)
        for shape, position, orientation, colour in rows
    ]
    solid = [row for row in rows if row[0] is not None]
    if not solid:
        raise InputError("drawing: nothing to draw; give at least one body")
    low = np.min([position - shape.bounding_radius for shape, position, _, _ in solid], axis=0)
    high = np.max([position + shape.bounding_radius for shape, position, _, _ in solid], axis=0)
    items = [Item(shape, _parts(shape), position, orientation, _rgb(colour)) for shape, position, orientation, colour in solid]
    for _, position, orientation, colour in (row for row in rows if row[0] is None):
        items.append(_floor(position, orientation, _rgb(colour), 0.5 * (low + high), 0.56 * np.max(high - low)))
    return items


def rows_of_world(world, colours=None):
    """Drawing rows (shape, position, orientation, colour) of a World, bodies in the order they were added, then planes."""
    bodies = world.bodies
    if colours is None:
        colours = [FIXED_COLOUR if body.fixed else 0 for body in bodies]
    if len(colours) != len(bodies):
        raise InputError(f"drawing: {len(colours)} colours for {len(bodies)} bodies; give one colour a body")
    rows = [(body.shape, body.position, body.orientation, colour) for body, colour in zip(bodies, colours, strict=True)]
    planes = [handle for handle in world.registry.handles if handle.is_plane]
    return rows + [(None, plane.position, plane.orientation, FLOOR_COLOUR) for plane in planes]


def _floor(position, orientation, colour, middle, reach):
    """The patch of a plane under the scene."""
    normal = rotations.rotate(orientation, [0.0, 0.0, 1.0])
    foot = middle - ((middle - position) @ normal) * normal
    corners = reach * np.array([(-1.0, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
    return Item(("floor", float(reach)), ((corners, ((0, 1, 2, 3),)),), foot, orientation, colour)


def _parts(shape):
    """The convex parts of a shape as polygons; round pieces become fine polyhedra."""
    return tuple((piece.vertices, piece.faces) if piece.faces else _round_part(piece) for piece in shape.pieces)


def _round_part(piece):
    """A ball or capsule as a polyhedron of rings about its axis, 32 faces round."""
    core = piece.vertices[-1] - piece.vertices[0]
    length = np.sqrt(core @ core)
    angle = np.pi * np.arange(33) / 32
    x = np.repeat(-piece.radius * np.cos(angle), 32)
    x += np.where(x > 0, 0.5, -0.5) * length
    ring = np.repeat(piece.radius * np.sin(angle), 32)
    turn = np.tile(2.0 * angle[:32], 33)
    hull = ConvexPiece(np.column_stack([x, ring * np.cos(turn), ring * np.sin(turn)]))
    along = rotations.between([1.0, 0.0, 0.0], core) if length else rotations.IDENTITY
    return rotations.rotate(along, hull.vertices) + piece.centre_of_mass, hull.faces


def _solids(items):
    return [
        Solid(rotations.rotate(item.orientation, vertices) + item.position, faces, item.colour)
        for item in items
        for vertices, faces in item.parts
    ]


def _flat_mesh(item):
    """The parts as one trimesh with unshared corners, so that faces stay flat, and a matt material."""
    from trimesh import Trimesh
    from trimesh.visual import TextureVisuals
    from trimesh.visual.material import PBRMaterial

    corners = np.concatenate([vertices[polyhedra.triangles_of(faces)] for vertices, faces in item.parts])
    mesh = Trimesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3), process=False)
    colour = [*(round(255 * channel) for channel in item.colour), 255]
    mesh.visual = TextureVisuals(material=PBRMaterial(baseColorFactor=colour, roughnessFactor=0.9, metallicFactor=0.0))
    return mesh


def _rgb(colour):
    """(red, green, blue) from 0 to 1 of a layer number or of any colour matplotlib knows."""
    from matplotlib.colors import to_rgb

    if isinstance(colour, int | np.integer):
        colour = LAYER_COLOURS[int(colour) % len(LAYER_COLOURS)]
    try:
        return to_rgb(colour)
    except ValueError:
        raise InputError(f"drawing: colour = {colour!r}; give a name, '#rrggbb', (r, g, b) or a layer number") from None


def _rounded(values, digits=5):
    """Nested lists of numbers with so many digits after the point: a page is looked at, not computed with."""
    return np.round(np.asarray(values, dtype=float), digits).tolist()


def write_bytes(path, data):
    """Write bytes to a file that is whole or not there."""
    with whole(path) as partial:
        partial.write_bytes(data)
