"""What stands in a world: checked records of bodies, their handles, and the arrays that a step reads (the scene).

Bodies enter the arrays at the next step, all waiting ones together, sorted by where they are: results do not depend on the
order in which they were added.
"""

from numbers import Real

import numpy as np

from minibullet import rotations
from minibullet.bodies import Bodies
from minibullet.errors import InputError
from minibullet.geometry import pack
from minibullet.polyhedra import principal_axes
from minibullet.scene import PlaneShape, Scene

STATE = {"position": 3, "orientation": 4, "velocity": 3, "angular_velocity": 3}


class Body:
    """Handle of one body: live position, orientation, velocity, angular_velocity (world frame); each can be set.

    shape, name, mass [kg], inertia (principal moments [kg m2]), friction, restitution (None = the world's), fixed, group.
    """

    is_plane = False

    def __init__(self, registry, record):
        self._registry, self._record, self._row = registry, record, None

    def __getattr__(self, name):
        record = object.__getattribute__(self, "_record")
        if name in STATE:
            return self._registry.state(self, name)
        if name in record:
            return record[name]
        raise AttributeError(f"a body has no {name!r}")

    def __setattr__(self, name, value):
        if name in STATE:
            self._registry.set_state(self, name, value)
        elif name.startswith("_"):
            object.__setattr__(self, name, value)
        else:
            raise AttributeError(f"body {self._record['name']!r}: {name} cannot be set after the body was added")

    def __repr__(self):
        return f"<Body {self.name!r} at {np.array2string(self.position, precision=4)} m>"


class Plane(Body):
    """Handle of a fixed half-space."""

    is_plane = True


class Registry:
    """Checks what is added, keeps the handles in the order of adding and the scene's arrays."""

    def __init__(self):
        self.handles, self.waiting, self.scene = [], [], Scene()
        self._pieces, self._piece_ranges = [PlaneShape((0.0, 0.0, 1.0))], {}

    # ---- adding
    # ------------------------------------------------------------------------------------------------------------------

    def add(
        self,
        shape,
        density,
        mass,
        inertia,
        position,
        orientation,
        velocity,
        angular_velocity,
        friction,
        restitution,
        margin,
        fixed,
        name,
        group,
    ):
        name = f"body {len(self.handles)}" if name is None else str(name)
        title = f"body {name!r}"
        if isinstance(shape, type) or not hasattr(shape, "pieces"):
            raise InputError(f"{title}: shape = {shape!r}; it must be a shape such as Box(1, 1, 1)")
        record = {"shape": shape, "name": name, "fixed": bool(fixed), "group": _group(title, group)}
        for key, value in (
            ("position", position),
            ("orientation", orientation),
            ("velocity", velocity),
            ("angular_velocity", angular_velocity),
        ):
            record[key] = _vector(title, key, value, STATE[key])
        record["orientation"] = _unit(title, record["orientation"])
        record["friction"] = _number(title, "friction", friction, 0.0, np.inf)
        record["restitution"] = _number(title, "restitution", restitution, 0.0, 1.0)
        record["margin"] = _number(title, "margin", margin, 0.0, np.inf)
        if fixed:
            if np.any(record["velocity"]) or np.any(record["angular_velocity"]):
                raise InputError(f"{title}: fixed=True with a velocity; a fixed body never moves (leave velocity out)")
            record["mass"], tensor = np.inf, shape.inertia
        else:
            record["mass"], tensor = _mass(title, shape, density, mass, inertia)
        record["inertia"], record["frame"] = _principal(title, tensor)
        return self._wait(Body(self, record))

    def add_plane(self, normal, height, friction, restitution, name, group=None):
        name = f"plane {len(self.handles)}" if name is None else str(name)
        title = f"plane {name!r}"
        normal = _vector(title, "normal", normal, 3)
        size = np.sqrt(rotations.dot(normal, normal))
        if size == 0.0:
            raise InputError(f"{title}: normal = {normal.tolist()}; it needs a direction")
        height = _number(title, "height", height, -np.inf, np.inf)
        unit = normal / size
        record = {
            "shape": None,
            "name": name,
            "fixed": True,
            "group": _group(title, group),
            "position": unit * height,
            "normal": unit,
            "height": height,
            "orientation": rotations.between(np.array([0.0, 0.0, 1.0]), unit),
            "velocity": np.zeros(3),
            "angular_velocity": np.zeros(3),
            "mass": np.inf,
            "margin": 0.0,
            "inertia": np.full(3, np.inf),
            "frame": np.array([1.0, 0.0, 0.0, 0.0]),
            "friction": _number(title, "friction", friction, 0.0, np.inf),
            "restitution": _number(title, "restitution", restitution, 0.0, 1.0),
        }
        return self._wait(Plane(self, record))

    def _wait(self, handle):
        self.handles.append(handle)
        self.waiting.append(handle)
        return handle

    def enrol(self):
        """Bring waiting bodies into the scene, sorted by place, and return the scene."""
        if not self.waiting:
            return self.scene
        scene = self.scene
        order = sorted(self.waiting, key=_place)
        before = len(self._pieces)
        ranges = np.array([self.pieces_of(handle) for handle in order], dtype=np.int64).reshape(-1, 2)
        if len(self._pieces) > before:
            scene.collision.pieces = pack(self._pieces)
        columns = {
            key: np.array([handle._record[key] for handle in order], dtype=float)
            for key in (
                "position",
                "orientation",
                "velocity",
                "angular_velocity",
                "mass",
                "inertia",
                "friction",
                "restitution",
                "margin",
                "frame",
            )
        }
        shapes = [handle._record["shape"] for handle in order]
        volume = np.array([shape.volume if shape else np.inf for shape in shapes])
        new = Bodies(
            columns["position"],
            rotations.normalised(rotations.product(columns["orientation"], columns["frame"])),
            np.concatenate([columns["velocity"], columns["angular_velocity"]], axis=1),
            columns["mass"],
            columns["inertia"],
            volume,
            np.array([shape.surface_area / 4.0 if shape else np.inf for shape in shapes]),
            np.cbrt(3.0 * volume / (4.0 * np.pi)),
        )
        for row, handle in enumerate(order):
            handle._row = len(scene.names) + row
        scene.names.extend(handle._record["name"] for handle in order)
        scene.bodies = Bodies(*(np.concatenate(pair) for pair in zip(scene.bodies, new, strict=True)))
        scene.friction = np.concatenate([scene.friction, columns["friction"]])
        scene.restitution = np.concatenate([scene.restitution, columns["restitution"]])
        scene.margin = np.concatenate([scene.margin, columns["margin"]])
        scene.frame = np.concatenate([scene.frame, columns["frame"]])
        scene.reach = np.concatenate([scene.reach, [shape.bounding_radius if shape else 0.0 for shape in shapes]])
        scene.moved = np.concatenate([scene.moved, np.zeros(len(order))])
        scene.group = np.concatenate([scene.group, np.array([handle._record["group"] for handle in order], dtype=np.int64)])
        scene.piece_ranges = np.concatenate([scene.piece_ranges, ranges])
        self.waiting = []
        return scene

    def pieces_of(self, handle):
        record = handle._record
        if handle.is_plane:
            return 0, 1
        key = (record["shape"], record["frame"].tobytes())
        if key not in self._piece_ranges:
            first = len(self._pieces)
            turn = rotations.conjugate(record["frame"])
            plain = np.array_equal(record["frame"], (1.0, 0.0, 0.0, 0.0))
            self._pieces.extend(piece if plain else piece.moved(orientation=turn) for piece in record["shape"].pieces)
            self._piece_ranges[key] = (first, len(self._pieces))
        return self._piece_ranges[key]

    # ---- looking and changing
    # ----------------------------------------------------------------------------------------------------

    def state(self, handle, name):
        if handle._row is None:
            return handle._record[name].copy()
        bodies, row = self.scene.bodies, handle._row
        if name == "position":
            return bodies.position[row].copy()
        if name == "orientation":
            turned = bodies.orientation[row].copy()
            frame = self.scene.frame[row]  # mostly the user's axes are the principal ones already
            return rotations.product(turned, rotations.conjugate(frame)) if frame[1:].any() else turned
        return bodies.twist[row, :3].copy() if name == "velocity" else bodies.twist[row, 3:].copy()

    def set_state(self, handle, name, value):
        title = f"body {handle._record['name']!r}"
        value = _vector(title, name, value, STATE[name])
        if name == "orientation":
            value = _unit(title, value)
        if handle._record["fixed"] and name in ("velocity", "angular_velocity") and value.any():
            raise InputError(f"{title}: {name} = {value.tolist()}; a fixed body never moves")
        if handle._row is None:
            handle._record[name] = value
            return
        scene, row = self.scene, handle._row
        position, orientation, twist = (array.copy() for array in scene.bodies[:3])
        if name == "position":
            position[row] = value
        elif name == "orientation":
            orientation[row] = rotations.product(value, scene.frame[row])
        else:
            twist[row, slice(0, 3) if name == "velocity" else slice(3, 6)] = value
        scene.bodies = scene.bodies._replace(position=position, orientation=orientation, twist=twist)
        if name in ("position", "orientation"):
            scene.moved[row] = np.inf  # every kept answer about this body is void

    def freeze(self, handles):
        scene = self.enrol()
        if any(handle._registry is not self for handle in handles):
            raise InputError("freeze: one of the bodies belongs to another world")
        rows = [handle._row for handle in handles]
        mass, twist = scene.bodies.mass.copy(), scene.bodies.twist.copy()
        mass[rows], twist[rows] = np.inf, 0.0
        scene.bodies = scene.bodies._replace(mass=mass, twist=twist)
        scene.moved[rows] = 0.0
        for handle in handles:
            handle._record.update(mass=np.inf, fixed=True)


def _place(handle):
    """Sorting key of a waiting body: where it is, how it lies, how it moves, what it weighs. Bodies with equal keys are alike."""
    record = handle._record
    shape = record["shape"]
    return (
        *record["position"][::-1],
        *record["orientation"],
        *record["velocity"],
        *record["angular_velocity"],
        record["mass"],
        shape.volume if shape else 0.0,
        record["group"],
    )


def _vector(title, field, value, size):
    try:
        array = np.array(value, dtype=float).reshape(-1)
    except (TypeError, ValueError):
        raise InputError(f"{title}: {field} = {value!r}; it needs {size} numbers") from None
    if array.shape != (size,):
        raise InputError(f"{title}: {field} has {array.size} values; it needs {size}")
    if not np.isfinite(array).all():
        raise InputError(f"{title}: {field} = {array.tolist()}; every component must be finite")
    return array


def _unit(title, quaternion):
    size = np.sqrt(rotations.dot(quaternion, quaternion))
    if size == 0.0:
        raise InputError(f"{title}: orientation = {quaternion.tolist()}; a quaternion (w, x, y, z) of length 0 is no rotation")
    return quaternion / size if size != 1.0 else quaternion


def _group(title, group):
    """The number of a group, -1 for None; InputError where it is no whole number >= 0."""
    if group is None:
        return -1
    if isinstance(group, bool) or not isinstance(group, Real) or group != group // 1 or group < 0:
        raise InputError(f"{title}: group = {group!r}; it must be a whole number >= 0 (None: touches everybody)")
    return int(group)


def _number(title, field, value, low, high):
    """A finite number within bounds; NaN stands for None, 'the world's own'."""
    if value is None:
        return np.nan
    if isinstance(value, bool) or not isinstance(value, Real) or not np.isfinite(value) or not low <= value <= high:
        bound = (
            f"between {low:g} and {high:g}"
            if np.isfinite(high)
            else (f">= {low:g} and finite" if np.isfinite(low) else "finite")
        )
        raise InputError(f"{title}: {field} = {value!r}; it must be {bound}")
    return float(value)


def _mass(title, shape, density, mass, inertia):
    """Mass [kg] and inertia tensor (3, 3) [kg m2] from density or mass, and the user's inertia where given."""
    if (density is None) == (mass is None):
        raise InputError(f"{title}: give density or mass, exactly one of them (for a fixed body use fixed=True)")
    field, value, unit = ("density", density, "kg/m3") if mass is None else ("mass", mass, "kg")
    if isinstance(value, bool) or not isinstance(value, Real) or not np.isfinite(value) or not value > 0:
        raise InputError(
            f"{title}: {field} = {value!r} {unit}; a moving body needs {field} > 0 (for a fixed body use fixed=True)"
        )
    mass = float(density * shape.volume if mass is None else mass)
    if inertia is None:
        return mass, mass / shape.volume * np.asarray(shape.inertia)
    try:
        tensor = np.array(inertia, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{title}: inertia = {inertia!r}; it needs three principal moments or a symmetric 3x3 matrix") from None
    if tensor.shape == (3,):
        tensor = np.diag(tensor)
    if tensor.shape != (3, 3) or not np.isfinite(tensor).all() or not np.allclose(tensor, tensor.T, rtol=1e-9, atol=0.0):
        raise InputError(
            f"{title}: inertia = {np.array(inertia).tolist()}; it needs three principal moments or a symmetric 3x3 matrix"
        )
    return mass, tensor


def _principal(title, tensor):
    """Principal moments (3,) and the quaternion of the principal axes; the user's axes where they are principal already."""
    size = np.abs(tensor).max()
    if np.abs(tensor - np.diag(np.diag(tensor))).max() <= 1e-10 * size:
        moments, frame = np.diag(tensor).copy(), np.array([1.0, 0.0, 0.0, 0.0])
    else:
        moments, axes = principal_axes(tensor)
        frame = rotations.from_matrix(axes)
    if not (moments > 0.0).all():
        raise InputError(f"{title}: inertia has the principal moments {moments.tolist()} kg m2; all must be > 0")
    for k in range(3):
        if moments[k] > (moments.sum() - moments[k]) * (1.0 + 1e-9):
            raise InputError(
                f"{title}: inertia moments {moments.tolist()} kg m2: the {k + 1}. exceeds the sum of the other two; "
                "no solid has that (A + B >= C)"
            )
    if np.ptp(moments) <= 1e-10 * moments.max():
        moments[:] = moments.mean()
    return moments, frame
