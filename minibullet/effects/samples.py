"""The bodies and contacts on which an effect is tried, and the
same seen from another direction, in another order, in other units.
"""

import re
from dataclasses import fields, replace

import numpy as np

from minibullet.bodies import Bodies, ContactLaw, Contacts
from minibullet.effects.contract import Effect, parameters
from minibullet.rotations import between, product, random, rotate

# exponents of (length, mass, time) of the units that parameters are written in
DIMENSIONS = {
    "-": (0, 0, 0),
    "1": (0, 0, 0),
    "rad": (0, 0, 0),
    "weights": (0, 0, 0),
    "m": (1, 0, 0),
    "kg": (0, 1, 0),
    "s": (0, 0, 1),
    "Hz": (0, 0, -1),
    "N": (1, 1, -2),
    "Pa": (-1, 1, -2),
    "J": (2, 1, -2),
    "W": (2, 1, -3),
}
# and of the columns of the records, by field; a twist has two kinds of columns
RECORD_DIMENSIONS = {
    "position": (1, 0, 0),
    "mass": (0, 1, 0),
    "inertia": (2, 1, 0),
    "volume": (3, 0, 0),
    "area": (2, 0, 0),
    "radius": (1, 0, 0),
    "twist": ((1, 0, -1), (0, 0, -1)),
    "point": (1, 0, 0),
    "gap": (1, 0, 0),
    "velocity": (1, 0, -1),
    "load": (1, 1, -2),
    "rolling_arm": (1, 0, 0),
    "spinning_arm": (1, 0, 0),
    "adhesion": (1, 1, -2),
}
WRENCH_DIMENSIONS = ((1, 1, -2), (2, 1, -2))


def sample_bodies() -> Bodies:
    """Seven moving bodies of unlike size, density, attitude and speed; the first is at rest, the second only spins, the
    third only flies.
    """
    generator = np.random.default_rng(7)
    n = 7
    radius = np.exp(generator.uniform(np.log(0.02), np.log(1.0), n))
    volume = 4.0 / 3.0 * np.pi * radius**3
    mass = generator.uniform(300.0, 3000.0, n) * volume
    twist = 3.0 * generator.standard_normal((n, 6))
    twist[0] = twist[1, :3] = twist[2, 3:] = 0.0
    # equal moments within a factor 5/3 obey the triangle inequality of every rigid body
    inertia = (mass * radius**2)[:, None] * generator.uniform(0.3, 0.5, (n, 3))
    position = generator.uniform(-2.0, 2.0, (n, 3)) + [0.0, 0.0, 2.0]
    return Bodies(position, random(generator, n), twist, mass, inertia, volume, 1.1 * np.pi * radius**2, radius)


def with_fixed_body(bodies: Bodies) -> Bodies:
    """The bodies and a fixed one after them, as laws of contact see them."""
    fixed = Bodies(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(6), np.inf, np.full(3, np.inf), 1.0, 1.0, 1.0)
    return Bodies(*(np.concatenate([array, np.asarray(last)[None]]) for array, last in zip(bodies, fixed, strict=True)))


def sample_contacts() -> tuple[Contacts, ContactLaw]:
    """Nine contacts among eight bodies, the last of them fixed: at
    rest, sliding slowly and fast, parting, new; two share a pair.
    """
    generator = np.random.default_rng(9)
    m = 9
    body_a = np.array([0, 1, 2, 3, 3, 7, 7, 4, 7])
    body_b = np.array([1, 2, 3, 4, 4, 5, 6, 7, 0])
    normal = rotate(random(generator, m), np.array([0.0, 0.0, 1.0]))
    velocity = generator.standard_normal((m, 3)) * 10.0 ** generator.uniform(-3.0, 1.0, (m, 1))
    velocity[0] = 0.0
    velocity[1] = -0.05 * normal[1]
    load = 10.0 ** generator.uniform(-2.0, 4.0, m)
    load[[2, 8]] = 0.0
    point, gap = generator.uniform(-1.0, 1.0, (m, 3)), generator.uniform(-1e-3, 1e-3, m)
    contacts = Contacts(body_a, body_b, point, normal, gap, velocity, load)
    law = ContactLaw(*(generator.uniform(0.2, 0.8, m) for _ in ContactLaw._fields))
    return contacts, law


def turned(q, record):
    """The same Bodies or Contacts in a world turned by q."""
    if isinstance(record, Bodies):
        return record._replace(
            position=rotate(q, record.position), orientation=product(q, record.orientation), twist=turned_columns(q, record.twist)
        )
    return record._replace(point=rotate(q, record.point), normal=rotate(q, record.normal), velocity=rotate(q, record.velocity))


def turned_columns(q, twists):
    """Turn both halves of twists or wrenches, (n, 6)."""
    return np.concatenate([rotate(q, twists[:, :3]), rotate(q, twists[:, 3:])], axis=1)


def a_turn():
    """A turn that mixes all axes."""
    return between(np.array([0.0, 0.0, 1.0]), np.array([0.6, -0.7, -0.3]))


def rows(record, index):
    """The record of the given rows only."""
    return type(record)(*(array[index] for array in record))


def dimensions_of(unit: str):
    """Exponents (length, mass, time) of a unit such as "kg/m3", "1/s", "Pa s"; None where it is not understood."""
    total = np.zeros(3, dtype=int)
    for k, part in enumerate(unit.split("/")):
        for word in part.split() or [""]:
            match = re.fullmatch(r"(-|1|[A-Za-z]+)(-?\d+)?", word)
            if match is None or match[1] not in DIMENSIONS:
                return None
            total += (1 if k == 0 else -1) * int(match[2] or 1) * np.array(DIMENSIONS[match[1]])
    return tuple(total.tolist())


def factor(dimensions, units) -> float:
    """By how much a number of these dimensions grows in the new units (sizes of the old metre, kilogram, second in new ones)."""
    return float(np.prod(np.asarray(units, dtype=float) ** np.asarray(dimensions)))


def in_units(units, value):
    """A record or an effect with its numbers in other units; None for an effect with a unit not understood."""
    if isinstance(value, Effect):
        changes = {}
        for name, known in parameters(value).items():
            dimensions = dimensions_of(known.unit)
            if dimensions is None:
                return None
            changes[name] = getattr(value, name) * factor(dimensions, units)
        for field in fields(value):
            inner = getattr(value, field.name)
            if isinstance(inner, tuple) and inner and isinstance(inner[0], Effect):
                changes[field.name] = tuple(in_units(units, effect) for effect in inner)
        return replace(value, **changes)
    return value._replace(
        **{
            name: in_units_columns(units, getattr(value, name), dimensions)
            for name, dimensions in RECORD_DIMENSIONS.items()
            if name in value._fields
        }
    )


def in_units_columns(units, array, dimensions):
    """An array in other units; two sets of dimensions belong to the first and the last three columns."""
    if isinstance(dimensions[0], tuple):
        return array * np.repeat([factor(half, units) for half in dimensions], 3)
    return array * factor(dimensions, units)
