"""Small worlds for the validation cases."""

import numpy as np

import minibullet as mb

GRAVITY = 9.81  # m/s2


def make(gravity=GRAVITY, effects=(), **settings):
    """A world with gravity and the given settings; the step is 1/240 s unless named."""
    pull = (mb.Gravity(gravity),) if gravity else ()
    return mb.World(effects=[*pull, *effects], settings=mb.Settings(**settings))


def about(axis, angle):
    """Quaternion of a turn by `angle` [rad] about a unit axis."""
    return np.array([np.cos(angle / 2), *(np.sin(angle / 2) * np.asarray(axis, float))])


def rotation(quaternion):
    """Matrix (3, 3) of a quaternion, written out here so that the tests do not lean on the engine."""
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


class Incline:
    """A plane through the origin that falls towards +x by `degrees`."""

    def __init__(self, degrees):
        self.angle = np.radians(degrees)
        self.normal = np.array([np.sin(self.angle), 0, np.cos(self.angle)])
        self.down = np.array([np.cos(self.angle), 0, -np.sin(self.angle)])
        self.orientation = about((0, 1, 0), self.angle)  # of a body that lies flat on it

    def world(self, **settings):
        """A world whose only floor is this plane."""
        world = make(**settings)
        world.add_plane(normal=self.normal, height=0.0)
        return world


def turned(body, orientation):
    """Angle [rad] between the body's orientation and another."""
    matrix = rotation(body.orientation) @ rotation(orientation).T
    skew = np.array([matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1]])
    return np.arctan2(np.linalg.norm(skew), np.trace(matrix) - 1)


def kinetic_energy(bodies, masses, inertias):
    """Sum of m v^2/2 + w.I w/2 [J]; inertias (3,) principal in body axes."""
    energy = 0.0
    for body, mass, inertia in zip(bodies, masses, inertias, strict=True):
        spin = rotation(body.orientation).T @ body.angular_velocity
        energy += 0.5 * mass * (body.velocity @ body.velocity) + 0.5 * (np.asarray(inertia) * spin) @ spin
    return energy


def overlap_of_boxes(bodies, edges):
    """Deepest overlap [m] between boxes of the same edges and with the floor z = 0, by separating axes."""
    import geometry

    corners = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * edges
    form = type("Form", (), {"radius": 0.0, "pieces": (corners,)})
    position, orientation = np.array([b.position for b in bodies]), np.array([b.orientation for b in bodies])
    return geometry.deepest_overlap(form, (((0, 0, 1.0), 0.0),), 0.0, position, orientation, np.zeros(len(bodies), bool))


def floor_force(world):
    """Sum of the normal forces [N] of all contacts with planes in the last step; the first body named is the plane."""
    table = world.contacts.to_dataframe()
    names = {body.name for body in world.bodies}
    return table.loc[~(table.body_a.isin(names) & table.body_b.isin(names)), "normal_force"].sum()
