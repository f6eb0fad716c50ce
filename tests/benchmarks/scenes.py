"""Scenes as plain arrays, built once from a seed and handed to every engine: no engine is imported here.

The unit is the Cubipod: cube of side L = 1 m with a frustum (height L/4, base L/2, top L/4) on each face, 2300 kg/m3.
Triangular grid of the paper: spacing 1.58 Dn in a row, rows 1.27 Dn apart and shifted by half a spacing.
"""

from typing import NamedTuple

import geometry
import numpy as np
from scipy.spatial import ConvexHull

NOMINAL_DIAMETER = (39 / 32) ** (1 / 3)  # m, cube of the same volume as the unit, side 1 m
UNIT_MASS = 2300.0 * 39 / 32  # kg
UNIT_INERTIA = 0.183440 * UNIT_MASS  # kg m2, the same about every axis
SPACING = (1.58 * NOMINAL_DIAMETER, 1.27 * NOMINAL_DIAMETER)  # m, in the row and between rows
FALLING_DISTANCE = 0.25 * NOMINAL_DIAMETER  # m
LOW_POSE_HEIGHT = 0.3125 / np.hypot(0.25, 0.375)  # m, centre of a unit that rests on a trapezoid of its hull


class Form(NamedTuple):
    """The solid that all bodies of a scene share."""

    pieces: tuple  # of (V, 3) vertices about the centre of mass [m]; empty for a sphere
    radius: float  # m, of a sphere; 0 for polyhedra
    mass: float  # kg
    inertia: tuple  # (3,) kg m2 about the body axes


class Scene(NamedTuple):
    """What an engine needs to know: bodies at the start, planes, settings; `layers` if bodies come in layers."""

    name: str
    form: Form
    position: np.ndarray  # (n, 3) m
    orientation: np.ndarray  # (n, 4) w, x, y, z
    fixed: np.ndarray  # (n,) bool
    planes: tuple  # of (unit normal, height [m])
    friction: float = 0.6  # of the contact
    margin: float = 0.001  # m, on every polyhedron
    time_step: float = 1 / 240  # s
    duration: float = 4.0  # s; the cap per layer where there are layers
    layers: tuple = ()  # of (n, 2) places [m], one array a layer
    seed: int = 0

    @property
    def size(self):
        """Length [m] that penetration is measured against."""
        return 2 * self.form.radius if self.form.radius > 0 else NOMINAL_DIAMETER


FLOOR = (((0.0, 0.0, 1.0), 0.0),)


def product(a, b):
    """Quaternion products (..., 4)."""
    scalar = a[..., 0] * b[..., 0] - np.sum(a[..., 1:] * b[..., 1:], axis=-1)
    vector = a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + np.cross(a[..., 1:], b[..., 1:])
    return np.concatenate([scalar[..., None], vector], axis=-1)


def about(axis, angle):
    """Quaternion of a turn by `angle` [rad] (scalar or array) about a unit axis."""
    angle = np.asarray(angle, float)[..., None] / 2
    return np.concatenate([np.cos(angle), np.sin(angle) * np.asarray(axis, float)], axis=-1)


def random_orientations(generator, count):
    """Uniform orientations (count, 4): normalised Gaussian quadruples."""
    quaternion = generator.normal(size=(count, 4))
    return quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True)


def low_pose(heading):
    """Unit lying on a trapezoid of its hull, horizontal tip axis turned by `heading` [rad] from x."""
    return product(about((0, 0, 1), np.asarray(heading) - np.pi / 2), about((0, 1, 0), np.arctan(2 / 3)))


def cubipod_pieces(side=1.0):
    """Cube and six frusta: seven arrays (8, 3) of vertices [m]."""
    signs = np.array([(x, y) for x in (-1.0, 1.0) for y in (-1.0, 1.0)])
    cube = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    base = np.column_stack([0.25 * signs, np.full(4, 0.5)])
    top = np.column_stack([0.125 * signs, np.full(4, 0.75)])
    tip = np.vstack([base, top])
    tips = [np.roll(tip * (1, 1, sign), turn, axis=1) for turn in range(3) for sign in (1, -1)]
    return tuple(side * piece for piece in [cube, *tips])


def cubipod(shape):
    """Form of the unit: `pieces` (seven) or `hull` (one, the same mass and inertia)."""
    pieces = cubipod_pieces()
    if shape == "hull":
        points = np.vstack(pieces)
        pieces = (points[ConvexHull(points).vertices],)
    return Form(pieces, 0.0, UNIT_MASS, (UNIT_INERTIA,) * 3)


def box_form(edges, density):
    """Box of full edge lengths [m]."""
    edges = np.asarray(edges, float)
    mass = density * edges.prod()
    inertia = tuple(mass / 12 * (edges**2).sum() - mass / 12 * edges**2)
    corners = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    return Form((corners * edges,), 0.0, mass, inertia)


def triangular_grid(rows, columns):
    """Places (rows * columns, 2) [m]: odd rows shifted by half a spacing."""
    return np.array(
        [((column + 0.5 * (row % 2)) * SPACING[0], row * SPACING[1]) for row in range(rows) for column in range(columns)]
    )


def hollows(places, rows, columns, upper):
    """Places over the triangles of a triangular layer of rows x columns: one row and one column fewer.

    The base of each triangle is in the lower row, its tip in the upper row, or the other way round with `upper`.
    """
    grid = places.reshape(rows, columns, 2)
    base = grid[1:] if upper else grid[:-1]
    shift = np.array([0.0, -SPACING[1] / 3 if upper else SPACING[1] / 3])
    return (0.5 * (base[:, 1:] + base[:, :-1]) + shift).reshape(-1, 2)


def redrawn(form, count, draw, place):
    """Positions and orientations of `count` bodies, drawn again one by one until no two overlap.

    draw(n) -> n random values; place(values) -> position (count, 3), orientation (count, 4).
    """
    pieces = [geometry.polyhedron(points) for points in form.pieces]
    values = draw(count)
    for _ in range(200):
        position, orientation = place(values)
        overlapping = geometry.pair_separations(pieces, position, orientation, 0.005)
        if not len(overlapping):
            return position, orientation
        again = np.unique(overlapping[:, 1].astype(int))
        values[again] = draw(len(again))
    raise RuntimeError("no orientations without overlap found in 200 rounds")


def bed(form, places, generator):
    """A layer lying in the low pose at `places` (n, 2), random headings."""
    position = np.column_stack([places, np.full(len(places), LOW_POSE_HEIGHT)])
    return redrawn(form, len(places), lambda n: generator.uniform(0, 2 * np.pi, n), lambda heading: (position, low_pose(heading)))


def layer_above(form, places, position, orientation, generator):
    """Random orientations at `places` (n, 2), lowest vertex one falling distance above the units within 1.5 Dn below."""
    pieces = [geometry.polyhedron(points) for points in form.pieces]
    top = position[:, 2] + geometry.highest(pieces, orientation)
    distance = np.linalg.norm(places[:, None] - position[None, :, :2], axis=2)
    below = np.where(distance < 1.5 * NOMINAL_DIAMETER, top, 0.0).max(axis=1)

    def place(turned):
        return np.column_stack([places, below + FALLING_DISTANCE - geometry.lowest(pieces, turned)]), turned

    return redrawn(form, len(places), lambda n: random_orientations(generator, n), place)


def one_layer(shape="pieces", rows=8, columns=8, seed=1, duration=4.0):
    """rows x columns units dropped at random orientations over a fixed layer of one row and one column more."""
    generator = np.random.default_rng(seed)
    form = cubipod(shape)
    places = triangular_grid(rows + 1, columns + 1)
    position, orientation = bed(form, places, generator)
    above = layer_above(form, hollows(places, rows + 1, columns + 1, False), position, orientation, generator)
    fixed = np.arange(len(places) + len(above[0])) < len(places)
    name = f"layer_{rows * columns}_{shape}"
    return Scene(
        name,
        form,
        np.vstack([position, above[0]]),
        np.vstack([orientation, above[1]]),
        fixed,
        FLOOR,
        duration=duration,
        seed=seed,
    )


def five_layers(shape="pieces", seed=1):
    """The 190-unit test: layers of 64, 49, 36, 25 and 16; each is frozen at rest before the next is dropped."""
    layers, size = [triangular_grid(8, 8)], 8
    while size > 4:
        layers.append(hollows(layers[-1], size, size, upper=len(layers) % 2 == 0))
        size -= 1
    form = cubipod(shape)
    position, orientation = bed(form, layers[0], np.random.default_rng(seed))
    position[:, 2] += FALLING_DISTANCE
    return Scene(
        f"five_layers_{shape}",
        form,
        position,
        orientation,
        np.zeros(64, bool),
        FLOOR,
        duration=6.0,
        layers=tuple(layers),
        seed=seed,
    )


def sphere_pile(count=600, seed=1):
    """Spheres of radius 0.1 m poured into a square well of frictional walls, 1.6 m wide."""
    generator = np.random.default_rng(seed)
    radius, width, across = 0.1, 1.6, 7
    cells = np.array([(x, y, z) for z in range(-(-count // across**2)) for y in range(across) for x in range(across)][:count])
    position = (cells + 0.5) * width / across
    position += generator.uniform(-0.01, 0.01, position.shape)
    mass = 2300.0 * 4 / 3 * np.pi * radius**3
    form = Form((), radius, mass, (0.4 * mass * radius**2,) * 3)
    walls = (((1.0, 0, 0), 0.0), ((-1.0, 0, 0), -width), ((0, 1.0, 0), 0.0), ((0, -1.0, 0), -width))
    identity = np.tile([1.0, 0, 0, 0], (count, 1))
    return Scene(
        f"sphere_pile_{count}",
        form,
        position,
        identity,
        np.zeros(count, bool),
        FLOOR + walls,
        margin=0.0,
        duration=4.0,
        seed=seed,
    )


def box_stack(count=10):
    """A column of 1 m boxes of one tonne, each 1 mm above the one below."""
    position = np.column_stack([np.zeros(count), np.zeros(count), 0.501 + 1.001 * np.arange(count)])
    identity = np.tile([1.0, 0, 0, 0], (count, 1))
    return Scene(
        f"box_stack_{count}",
        box_form((1, 1, 1), 1000.0),
        position,
        identity,
        np.zeros(count, bool),
        FLOOR,
        margin=0.0,
        duration=10.0,
    )


def scaling(count):
    """About `count` hull units in one square layer over a fixed one: the cost against the number of units."""
    side = round(np.sqrt(count))
    return one_layer("hull", side, side, duration=1.0)._replace(name=f"scaling_{count}")


SCENES = {
    "layer_64_hull": lambda: one_layer("hull"),
    "layer_64_pieces": lambda: one_layer("pieces"),
    "five_layers_hull": lambda: five_layers("hull"),
    "five_layers_pieces": lambda: five_layers("pieces"),
    "sphere_pile_600": sphere_pile,
    "box_stack_10": box_stack,
    **{f"scaling_{count}": (lambda count=count: scaling(count)) for count in (100, 300, 1000, 3000)},
}
