"""The record of a body: everything that it was told to be, checked, whether by its user or by a file.

A record is a dictionary: shape (None for a plane), name, fixed, group (-1: none), position, orientation, velocity,
angular_velocity, friction and restitution (NaN: the world's), margin, mass, inertia (principal moments), frame (principal axes
in the user's body axes); for a plane also normal and height. SI units. Messages begin with a title that names the body.
"""

import numpy as np

from minibullet import rotations
from minibullet.errors import InputError, is_number, shown_value
from minibullet.shapes.convex import weighs
from minibullet.shapes.polyhedra import principal_axes

STATE = {"position": 3, "orientation": 4, "velocity": 3, "angular_velocity": 3}  # field: how many numbers
MOST_GROUP = 2**62  # groups are kept as whole numbers of 64 bits


def body(
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
    """The record of a body that ``World.add`` was told of."""
    title = f"body {name!r}"
    if isinstance(shape, type) or not hasattr(shape, "pieces"):
        raise InputError(f"{title}: shape = {shape!r}; it must be a shape such as Box(1, 1, 1)")
    check_volume(title, shape)
    record = {"shape": shape, "fixed": bool(fixed), "margin": margin}
    state = dict(zip(STATE, (position, orientation, velocity, angular_velocity), strict=True))
    record = alike(record, name, group, friction, restitution, **state)
    if fixed:
        if np.any(record["velocity"]) or np.any(record["angular_velocity"]):
            raise InputError(f"{title}: fixed=True with a velocity; a fixed body never moves (leave velocity out)")
        record["mass"], tensor = np.inf, shape.inertia
    else:
        record["mass"], tensor = _mass(title, shape, density, mass, inertia)
    record["inertia"], record["frame"] = _principal(title, tensor)
    return record


def alike(record, name, group, friction, restitution, **state):
    """The record of a body like that of another record, in a state of its own: what is the same of both is not checked again."""
    title = f"body {name!r}"
    own = {"name": name, "group": _group(title, group)}
    own |= {key: vector(title, key, state[key], size) for key, size in STATE.items()}
    own["orientation"] = unit(title, own["orientation"])
    return record | own | _manners(title, friction, restitution, record["margin"])


def plane(normal, height, friction, restitution, name, group):
    """The record of a half-space that ``World.add_plane`` was told of."""
    title = f"plane {name!r}"
    normal = vector(title, "normal", normal, 3)
    size = np.sqrt(rotations.dot(normal, normal))
    if not 0.0 < size < np.inf:
        raise InputError(f"{title}: normal = {normal.tolist()}; it needs a direction, best of length 1")
    height = _number(title, "height", height, -np.inf, np.inf)
    normal = normal / size
    return {
        "shape": None,
        "name": name,
        "fixed": True,
        "group": _group(title, group),
        "position": normal * height,
        "normal": normal,
        "height": height,
        "orientation": rotations.between(np.array([0.0, 0.0, 1.0]), normal),
        "velocity": np.zeros(3),
        "angular_velocity": np.zeros(3),
        "mass": np.inf,
        "inertia": np.full(3, np.inf),
        "frame": np.array([1.0, 0.0, 0.0, 0.0]),
    } | _manners(title, friction, restitution, 0.0)


def to_plain(record):
    """What a file must keep of a record, as plain numbers; the shape and the state are kept elsewhere."""
    return {
        key: value.tolist() if isinstance(value, np.ndarray) else value
        for key, value in record.items()
        if key != "shape" and key not in STATE
    }


def from_plain(item, shape, state):
    """The record that ``to_plain`` made plain, of this shape (None: a plane) and state (position, orientation, velocity, angular
    velocity), checked as if its user had told it: a file may have been changed."""
    name = item.get("name")
    if not isinstance(name, str) or len(name) > 10_000:
        raise InputError(f"a body's name = {shown_value(name)}; it must be text")
    title = f"body {name!r}"
    friction, restitution = (None if _is_nan(item.get(key)) else item.get(key, "left out") for key in ("friction", "restitution"))
    group = item.get("group", "left out")
    if shape is None:
        record = plane(item.get("normal"), item.get("height"), friction, restitution, name, None if group == -1 else group)
        record["normal"] = np.array(item["normal"], dtype=float)  # of length 1 already: to the bit what it was
        if abs(record["normal"] @ record["normal"] - 1.0) > 1e-9:
            raise InputError(f"plane {name!r}: normal = {shown_value(item['normal'])}; it must have the length 1")
    else:
        check_volume(title, shape)
        group = _group(title, None if group == -1 else group)
        record = {"shape": shape, "name": name, "fixed": item.get("fixed"), "group": group}
        if not isinstance(record["fixed"], bool):
            raise InputError(f"{title}: fixed = {shown_value(record['fixed'])}; it must be true or false")
        record |= _manners(title, friction, restitution, item.get("margin", "left out"))
        record["mass"] = np.inf if record["fixed"] else _number(title, "mass", item.get("mass"), np.finfo(float).tiny, np.inf)
        if record["fixed"] and item.get("mass") != np.inf:
            raise InputError(f"{title}: mass = {shown_value(item.get('mass'))}; that of a fixed body is infinite")
        record["inertia"] = vector(title, "inertia", item.get("inertia"), 3)
        _check_moments(title, record["inertia"])
        record["frame"] = vector(title, "frame", item.get("frame"), 4)
        if abs(record["frame"] @ record["frame"] - 1.0) > 1e-9:
            raise InputError(f"{title}: frame = {shown_value(item['frame'])}; it must be a quaternion of length 1")
    record |= dict(zip(STATE, state, strict=True))
    if record["fixed"] and (np.any(record["velocity"]) or np.any(record["angular_velocity"])):
        raise InputError(f"{title}: fixed, with a velocity; a fixed body never moves")
    return record


def _manners(title, friction, restitution, margin):
    """How a body meets others; NaN stands for None, 'the world's own'."""
    return {
        "friction": np.nan if friction is None else _number(title, "friction", friction, 0.0, np.inf),
        "restitution": np.nan if restitution is None else _number(title, "restitution", restitution, 0.0, 1.0),
        "margin": _number(title, "margin", margin, 0.0, np.inf),
    }


def _is_nan(value):
    return isinstance(value, float) and value != value


def vector(title, field, value, size):
    """So many finite numbers as an array, or InputError."""
    try:
        array = np.array(value, dtype=float).reshape(-1)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{title}: {field} = {shown_value(value)}; it needs {size} numbers") from None
    if array.shape != (size,):
        raise InputError(f"{title}: {field} has {array.size} values; it needs {size}")
    if not np.isfinite(array).all():
        raise InputError(f"{title}: {field} = {array.tolist()}; every component must be finite")
    return array


def unit(title, quaternion):
    """The quaternion (4,) made one of length 1, or InputError where it has no length."""
    if not quaternion.any():
        raise InputError(f"{title}: orientation = {quaternion.tolist()}; a quaternion (w, x, y, z) of length 0 is no rotation")
    size = np.sqrt(rotations.dot(quaternion, quaternion))
    if not 1e-100 < size < 1e100:  # its squares leave the range of floating-point numbers
        return rotations.normalised(quaternion)
    return quaternion / size if size != 1.0 else quaternion


def check_volume(title, shape):
    """Refuse a solid whose mass properties floating-point numbers cannot hold."""
    if not weighs(shape):
        raise InputError(
            f"{title}: the volume of its shape is {shape.volume:g} m3, and its inertia is not a number above zero that double "
            "precision holds; give lengths in metres"
        )


def _group(title, group):
    """The number of a group, -1 for None; InputError where it is no whole number >= 0."""
    if group is None:
        return -1
    if not is_number(group) or group != group // 1 or not 0 <= group <= MOST_GROUP:
        raise InputError(f"{title}: group = {shown_value(group)}; it must be a whole number >= 0 (None: touches everybody)")
    return int(group)


def _number(title, field, value, low, high):
    """A finite number within bounds."""
    if not is_number(value) or not low <= value <= high:
        bound = (
            f"between {low:g} and {high:g}" if np.isfinite(high) else (f">= {low:g} and finite" if np.isfinite(low) else "finite")
        )
        raise InputError(f"{title}: {field} = {shown_value(value)}; it must be {bound}")
    return float(value)


def _mass(title, shape, density, mass, inertia):
    """Mass [kg] and inertia tensor (3, 3) [kg m2] from density or mass, and the user's inertia where given."""
    if (density is None) == (mass is None):
        raise InputError(f"{title}: give density or mass, exactly one of them (for a fixed body use fixed=True)")
    field, value, unit = ("density", density, "kg/m3") if mass is None else ("mass", mass, "kg")
    if not is_number(value) or not value > 0:
        raise InputError(
            f"{title}: {field} = {shown_value(value)} {unit}; a moving body needs {field} > 0 (for a fixed body use fixed=True)"
        )
    mass = float(density * shape.volume if mass is None else mass)
    if not 0.0 < mass < np.inf:
        raise InputError(f"{title}: {field} = {value!r} {unit} makes a mass of {mass:g} kg, which no moving body can have")
    if inertia is None:
        return mass, mass / shape.volume * np.asarray(shape.inertia)
    try:
        tensor = np.array(inertia, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(
            f"{title}: inertia = {shown_value(inertia)}; it needs three principal moments or a symmetric 3x3 matrix"
        ) from None
    if tensor.shape == (3,):
        tensor = np.diag(tensor)
    if tensor.shape != (3, 3) or not np.isfinite(tensor).all() or (np.abs(tensor - tensor.T) > 1e-9 * np.abs(tensor.T)).any():
        raise InputError(
            f"{title}: inertia = {shown_value(np.array(inertia).tolist())}; it needs three principal moments or a symmetric "
            "3x3 matrix"
        )
    return mass, tensor


def _principal(title, tensor):
    """Principal moments (3,) and the quaternion of the principal axes; the user's axes where they are principal already."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = np.abs(tensor).tolist()  # on a few numbers Python is quicker than NumPy
    if max(xy, xz, yx, yz, zx, zy) <= 1e-10 * max(xx, yy, zz):
        moments, frame = np.diag(tensor).copy(), np.array([1.0, 0.0, 0.0, 0.0])
    else:
        moments, axes = principal_axes(tensor)
        frame = rotations.from_matrix(axes)
    _check_moments(title, moments)
    if max(moments.tolist()) - min(moments.tolist()) <= 1e-10 * moments.max():
        moments[:] = moments.mean()
    return moments, frame


def _check_moments(title, moments):
    """Refuse principal moments (3,) that no solid has."""
    moments = moments.tolist()
    if not all(0.0 < moment < np.inf for moment in moments):
        raise InputError(f"{title}: inertia has the principal moments {moments} kg m2; all must be > 0")
    for k in range(3):
        if moments[k] > (sum(moments) - moments[k]) * (1.0 + 1e-9):
            raise InputError(
                f"{title}: inertia moments {moments} kg m2: the {k + 1}. exceeds the sum of the other two; "
                "no solid has that (A + B >= C)"
            )
