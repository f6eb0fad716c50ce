"""What stands in a world: checked records of bodies, their handles, and the arrays that a step reads (the scene).

Bodies enter the arrays at the next step, all waiting ones together, sorted by where they are: results do not depend on the
order in which they were added.
"""

import numpy as np

from minibullet import rotations
from minibullet.bodies import Bodies
from minibullet.collision.packing import pack
from minibullet.errors import InputError
from minibullet.scene import records
from minibullet.scene.building import PlaneShape, Scene
from minibullet.scene.records import STATE

COLUMNS = (*STATE, "mass", "inertia", "friction", "restitution", "margin", "frame")  # of a record that become arrays of the scene


class Body:
    """Handle of one body: live position, orientation, velocity, angular_velocity (world frame). What is read is a copy: each is
    set as a whole, ``body.velocity += (1.0, 0.0, 0.0)``; a component that is set alone is set in the copy.

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
        self.handles, self.waiting, self.aside, self.scene = [], [], [], Scene()
        self._pieces, self._piece_ranges = [PlaneShape((0.0, 0.0, 1.0))], {}

    # ---- adding
    # ------------------------------------------------------------------------------------------------------------------

    def add(self, shape, name, **given):
        name = f"body {len(self.handles)}" if name is None else str(name)
        return self.wait(Body(self, records.body(shape, name=name, **given)))

    def add_alike(self, handle, name, **given):
        """Add a body that is like another one, but for what `records.alike` takes."""
        return self.wait(Body(self, records.alike(handle._record, name, **given)))

    def add_plane(self, normal, height, friction, restitution, name, group=None):
        name = f"plane {len(self.handles)}" if name is None else str(name)
        return self.wait(Plane(self, records.plane(normal, height, friction, restitution, name, group)))

    def wait(self, handle):
        self.handles.append(handle)
        self.waiting.append(handle)
        return handle

    def commit(self, order=None):
        """Bring waiting bodies into the scene, sorted by place (or as in ``order``), and return the scene."""
        if not self.waiting:
            return self.scene
        scene = self.scene
        order = order or sorted(self.waiting, key=_place)
        before = len(self._pieces)
        ranges = np.array([self.pieces_of(handle) for handle in order], dtype=np.int64).reshape(-1, 2)
        if len(self._pieces) > before:
            scene.collision.pieces = pack(self._pieces)
        column = {key: np.array([handle._record[key] for handle in order], dtype=float) for key in COLUMNS}
        shapes = [handle._record["shape"] for handle in order]
        volume = np.array([shape.volume if shape else np.inf for shape in shapes])
        new = Bodies(
            column["position"],
            rotations.normalised(rotations.product(column["orientation"], column["frame"])),
            np.concatenate([column["velocity"], column["angular_velocity"]], axis=1),
            column["mass"],
            column["inertia"],
            volume,
            np.array([shape.surface_area / 4.0 if shape else np.inf for shape in shapes]),
            np.cbrt(3.0 * volume / (4.0 * np.pi)),
        )
        for row, handle in enumerate(order):
            handle._row = len(scene.names) + row
        scene.names.extend(handle._record["name"] for handle in order)
        scene.bodies = Bodies(*(np.concatenate(pair) for pair in zip(scene.bodies, new, strict=True)))
        for name, more in {
            **{key: column[key] for key in ("friction", "restitution", "margin", "frame")},
            "bounding_radius": [shape.bounding_radius if shape else 0.0 for shape in shapes],
            "past_motion": np.zeros(len(order)),
            "group": np.array([handle._record["group"] for handle in order], dtype=np.int64),
            "piece_ranges": ranges,
        }.items():
            setattr(scene, name, np.concatenate([getattr(scene, name), more]))
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
        value = records.vector(title, name, value, STATE[name])
        if name == "orientation":
            value = records.unit(title, value)
        if handle._record["fixed"] and name in ("velocity", "angular_velocity") and value.any():
            raise InputError(f"{title}: {name} = {value.tolist()}; a fixed body never moves")
        if handle._row is None:
            handle._record[name] = value
            return
        scene, row = self.scene, handle._row
        column = name if name in ("position", "orientation") else "twist"
        array = getattr(scene.bodies, column).copy()  # a copy: steps before this one keep what they saw
        if name == "orientation":
            array[row] = rotations.product(value, scene.frame[row])
        else:
            array[row, slice(3, 6) if name == "angular_velocity" else slice(0, 3)] = value
        scene.bodies = scene.bodies._replace(**{column: array})
        if name in ("position", "orientation"):
            scene.past_motion[row] = np.inf  # nothing cached about this body holds

    def freeze(self, handles):
        scene = self.commit()
        if any(handle._registry is not self for handle in handles):
            raise InputError("freeze: one of the bodies belongs to another world")
        rows = [handle._row for handle in handles]
        mass, twist = scene.bodies.mass.copy(), scene.bodies.twist.copy()
        mass[rows], twist[rows] = np.inf, 0.0
        scene.bodies = scene.bodies._replace(mass=mass, twist=twist)
        scene.past_motion[rows] = 0.0
        for handle in handles:
            handle._record.update(mass=np.inf, fixed=True)

    def set_aside(self, handles):
        """Take fixed bodies out of the arrays; their handles keep where they are. What is left keeps its order and features."""
        scene, gone = self.commit(), set(handles)
        for handle in handles:
            if handle._registry is not self or handle._row is None or not handle._record["fixed"]:
                raise InputError(f"set_aside: body {handle.name!r} is not a fixed body of this world; freeze it first")
        for handle in handles:
            handle._record.update({name: self.state(handle, name) for name in STATE})
        keep = np.ones(len(scene.names), dtype=bool)
        keep[[handle._row for handle in handles]] = False
        row = np.cumsum(keep) - 1
        self.handles = [handle for handle in self.handles if handle not in gone]
        for handle in self.handles:
            handle._row = int(row[handle._row])
        for handle in handles:
            handle._row = None
        self.aside += handles
        scene.keep_rows(keep, row)

    def bring_back(self, handles):
        """Bodies that were set aside wait to enter the arrays again, where they were."""
        gone = set(handles)
        if gone - set(self.aside):
            raise InputError("bring_back: one of the bodies was not set aside")
        self.aside = [handle for handle in self.aside if handle not in gone]
        for handle in handles:
            self.wait(handle)


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
