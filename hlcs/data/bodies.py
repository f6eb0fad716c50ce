"""The body of an experiment: what its file says of it, checked key by key."""

from dataclasses import dataclass, field, replace

import numpy as np

from minibullet.errors import InputError
from minibullet.shapes.mesh_files import mesh_file

SHAPES = {  # shape -> the keys that say its size
    "sphere": ("radius",),
    "box": ("size",),
    "cubipod": ("side",),
    "mesh": ("mesh",),
    "disc": ("radius", "height"),
    "cylinder": ("radius", "height"),
    "cone": ("radius", "height"),
}
SIZES = dict(low=1e-6, high=1e3)  # lengths of a body: dust to a hill, so that volumes and inertias are numbers [m]
CUBIPOD_REACH = 0.9  # from the centre of a Cubipod to its corners, at most, in sides: sqrt(3)/2 of the cube
MOST_OUTLINES = 10.0  # a drag area in outlines of the body above which it is hardly meant: fins and sails are larger than it


@dataclass(frozen=True)
class Body:
    """What was dropped, slid, rolled or thrown. None = not stated."""

    shape: str = "sphere"
    radius: float | None = None  # of a sphere, a disc, a cylinder, the base of a cone [m]
    height: float | None = None  # of a disc, a cylinder, a cone: along z of the body [m]
    size: tuple[float, ...] | None = None  # edge lengths of a box [m]
    side: float | None = None  # cube side of a Cubipod [m]
    mesh: str | None = None  # path of a mesh file
    form: object = field(default=None, hash=False)  # the solid read from it, a minibullet shape
    mass: float | None = None  # [kg]
    inertia: tuple[float, ...] | None = None  # principal moments, body axes [kg m2]
    drag_area: float | None = None  # that a drag coefficient refers to; None = the mean projected area of the shape [m2]

    @property
    def sized(self):
        """Is the size of its shape stated?"""
        return all(getattr(self, key) is not None for key in SHAPES[self.shape])


def read_body(reader, table, section, base, index=None):
    """The Body of a table of an experiment file, what it leaves out as in `base`; InputError names the place."""
    numbers = {key: reader.number(table, key, section, index=index, **SIZES) for key in ("radius", "height", "side")}
    numbers["mass"] = reader.number(table, "mass", section, above=0.0, low=1e-12, high=1e9, index=index)
    numbers["drag_area"] = reader.number(table, "drag_area", section, index=index, above=0.0, low=1e-12, high=1e6)
    changes = {key: value for key, value in numbers.items() if value is not None}
    for key, bounds in (("size", SIZES), ("inertia", dict(low=1e-30))):
        value = reader.vector(table, key, section, 3, index=index, **bounds)
        changes |= {} if value is None else {key: value}
    for key, allowed in (("shape", tuple(SHAPES)), ("mesh", None)):
        value = reader.words(table, key, section, allowed, index=index)
        changes |= {} if value is None else {key: value}
    if "mesh" in changes:
        changes["mesh"] = str(reader.file_of(changes["mesh"], "mesh", section, index))
        try:
            changes["form"] = mesh_file(changes["mesh"])
        except InputError as error:
            reader.fail("mesh", str(error), section, index)
    body = replace(base, **changes)
    for key in {key: None for keys in SHAPES.values() for key in keys}:
        if key in changes and key not in SHAPES[body.shape]:
            *others, last = (f'"{shape}"' for shape, keys in SHAPES.items() if key in keys)
            owners = f"{', '.join(others)} or {last}" if others else last
            reader.fail(key, f'belongs to shape {owners}, but the shape is "{body.shape}"', section, index)
    if body.inertia:
        a, b, c = sorted(body.inertia)
        if a + b < c * (1 - 1e-9):
            reader.fail(
                "inertia",
                f"no solid has principal moments {list(body.inertia)}: the largest exceeds the sum of the others",
                section,
                index,
            )
    _check_density(reader, body, table, section, index)
    _check_reach(reader, body, changes, section, index)
    return body


def refuse_unsized(reader, body, by_rows, *place):
    """Refuse a shape that was named without its size; a body that nobody describes is a sphere of no stated size.

    by_rows: may a table of outcomes state a radius row by row?; place: section and index where the shape stands.
    """
    missing = [key for key in SHAPES[body.shape] if getattr(body, key) is None and not (by_rows and key == "radius")]
    if body.shape == "mesh" and missing:
        reader.fail("shape", '"mesh" of which file? Add mesh = "unit.stl" (.stl, .obj, .ply or .off, in m)', *place)
    if body.shape != "sphere" and missing:
        add = " and ".join(f"{key} = {'[x, y, z]' if key == 'size' else '..'}" for key in missing)
        reader.fail("shape", f'"{body.shape}" of which size? Add {add} (in m)', *place)


def bounding_radius(body):
    """Greatest distance of the surface of a body from its centre of mass if it is homogeneous [m]; None where not sized."""
    if not body.sized:
        return None
    return {
        "sphere": lambda: body.radius,
        "box": lambda: float(np.linalg.norm(body.size)) / 2,
        "cubipod": lambda: body.side * CUBIPOD_REACH,
        "mesh": lambda: body.form.bounding_radius if body.form else None,
        "disc": lambda: float(np.hypot(body.radius, body.height / 2)),
        "cylinder": lambda: float(np.hypot(body.radius, body.height / 2)),
        "cone": lambda: float(max(np.hypot(body.radius, body.height / 4), 0.75 * body.height)),
    }[body.shape]()


def _check_reach(reader, body, changes, section, index):
    """Refuse moments that no mass within the body has, m R^2 at most, and tell of a drag area far beyond its outline, pi R^2."""
    reach = bounding_radius(body) if {"inertia", "drag_area"} & set(changes) else None
    if reach is None:
        return
    if body.inertia and body.mass is not None and max(body.inertia) > body.mass * reach**2 * (1 + 1e-6):
        reader.fail(
            "inertia",
            f"{max(body.inertia):.3g} kg m2 is more than {body.mass:g} kg within {reach:.3g} m of the centre can have, "
            f"{body.mass * reach**2:.3g}; units are kg m2 (not kg cm2 or g mm2)",
            section,
            index,
        )
    if body.drag_area is not None and body.drag_area > MOST_OUTLINES * np.pi * reach**2:
        reader.warn(
            "drag_area",
            f"{body.drag_area:g} m2 is hardly meant of a body within {reach:.3g} m of its centre, whose outline has at most "
            f"{np.pi * reach**2:.3g} m2; areas are in m2 (not cm2)",
            section,
            index,
        )


def _check_density(reader, body, table, section, index):
    if said := impossible_density(body):
        reader.fail("mass" if "mass" in table else SHAPES[body.shape][0], said, section, index)


def impossible_density(body):
    """Why no body has this mass and size, in words; "" where one may, or where they are not known."""
    volume = {
        "sphere": lambda: 4 / 3 * np.pi * body.radius**3,
        "box": lambda: float(np.prod(body.size)),
        "cubipod": lambda: body.side**3,
        "mesh": lambda: body.form.volume,
        "disc": lambda: np.pi * body.radius**2 * body.height,
        "cylinder": lambda: np.pi * body.radius**2 * body.height,
        "cone": lambda: np.pi * body.radius**2 * body.height / 3,
    }.get(body.shape)
    if volume is None or body.mass is None or not body.sized:
        return ""
    density = body.mass / volume()
    if 0.02 <= density <= 30000.0:
        return ""
    return f"mass and size give a density of {density:.3g} kg/m3, which no body has; units are kg and m (not g, mm or cm)"
