"""The semicircular arch of case 34: its least thickness by linear programming, and how far it sags in the engine."""

import numpy as np
import small_worlds as sw
from scipy.optimize import linprog

import minibullet as mb


def blocks(count, thickness):
    """Blocks of an arch with centre-line radius 1: list of (4, 2) corners (x, z), from the right foot to the left."""
    angle = np.linspace(0, np.pi, count + 1)
    ray = np.column_stack([np.cos(angle), np.sin(angle)])
    inner, outer = (1 - thickness / 2) * ray, (1 + thickness / 2) * ray
    return [np.array([inner[i], outer[i], outer[i + 1], inner[i + 1]]) for i in range(count)]


def area_and_centre(corners):
    """Of a polygon (n, 2)."""
    x, z = corners.T
    cross = x * np.roll(z, -1) - np.roll(x, -1) * z
    area = cross.sum() / 2
    centre = [((c + np.roll(c, -1)) * cross).sum() / (6 * area) for c in (x, z)]
    return abs(area), np.array(centre)


def stands(count, thickness, friction):
    """Is there a set of joint forces inside the joints and the friction cones that holds every block's weight?

    Unknowns: at the two ends of each of the count + 1 joints a normal force >= 0 and a friction force within mu of it.
    """
    angle = np.linspace(0, np.pi, count + 1)
    unknowns = 4 * (count + 1)  # (normal, friction) at the inner and the outer end of each joint
    balance, weight = np.zeros((3 * count, unknowns)), np.zeros(3 * count)
    for i, corners in enumerate(blocks(count, thickness)):
        area, centre = area_and_centre(corners)
        weight[3 * i + 1] = area
        for joint, sign in ((i, 1.0), (i + 1, -1.0)):
            ray = np.array([np.cos(angle[joint]), np.sin(angle[joint])])
            along = np.array([-ray[1], ray[0]])  # pushes the block that comes after the joint
            for end, radius in enumerate((1 - thickness / 2, 1 + thickness / 2)):
                arm = radius * ray - centre
                for kind, direction in enumerate((along, ray)):
                    force = sign * direction
                    balance[3 * i : 3 * i + 3, 4 * joint + 2 * end + kind] += (*force, arm[0] * force[1] - arm[1] * force[0])
    limits = np.zeros((4 * (count + 1), unknowns))
    for pair in range(2 * (count + 1)):
        for row, sign in enumerate((1.0, -1.0)):
            limits[2 * pair + row, [2 * pair, 2 * pair + 1]] = -friction, sign
    bounds = [(0, None), (None, None)] * (2 * (count + 1))
    return linprog(np.zeros(unknowns), limits, np.zeros(len(limits)), balance, weight, bounds).status == 0


def least_thickness(count, friction):
    """Smallest t/R at which the arch stands, by bisection to 1e-6."""
    low, high = 0.05, 0.2
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if stands(count, middle, friction) else (middle, high)
    return high


def sag(count, thickness, friction, seconds, width=0.2):
    """Largest distance [m] that a block of the arch on the floor z = 0 moves."""
    world = sw.make(friction=friction)
    world.add_plane()
    bodies, starts = [], []
    for corners in blocks(count, thickness):
        points = np.array([(x, y, z) for x, z in corners for y in (-width / 2, width / 2)])
        shape = mb.ConvexPiece(points)
        bodies.append(world.add(shape, density=1000.0, position=shape.centre_of_mass))
        starts.append(shape.centre_of_mass)
    world.run(seconds)
    return max(np.linalg.norm(body.position - start) for body, start in zip(bodies, starts, strict=True))
