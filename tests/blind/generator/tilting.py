"""A block that turns about the edge it stands on: one equation, Runge-Kutta of fourth order, valid until the edge slips,
lifts or the face lands."""

import numpy as np
from numba import njit

from .fluid import displaced
from .noise import lean, product, small_turn


@njit(cache=True)
def angular_acceleration(angle, rate, t, p):
    """Angular acceleration [rad/s2]; p = lever_1, lever_3 [m] of the centre from the edge upright, inertia about the edge / m,
    g_1, g_3, drag of the air [1/rad], then outside: shake amplitude [m/s2], rate [rad/s], phase, kick [rad/s2], its time [s]
    and side."""
    c, s = np.cos(angle), np.sin(angle)
    x, z = p[0] * c + p[1] * s, p[1] * c - p[0] * s
    g1 = p[3] + p[6] * np.sin(p[7] * t + p[8])
    kick = p[9] * p[11] * np.exp(-(((t - p[10]) / 0.05) ** 2))
    return (z * g1 - x * p[4]) / p[2] - p[5] * abs(rate) * rate + kick


@njit(cache=True)
def turn(angle, rate, times, step, p):
    """Angles [rad], rates and accelerations (n, 3) at rising times [s]; held before t = 0."""
    out = np.empty((len(times), 3))
    t = 0.0
    for i in range(len(times)):
        while t < times[i] - 1e-12:
            h = min(step, times[i] - t)
            a1, b1 = rate, angular_acceleration(angle, rate, t, p)
            a2, b2 = rate + 0.5 * h * b1, angular_acceleration(angle + 0.5 * h * a1, rate + 0.5 * h * b1, t + 0.5 * h, p)
            a3, b3 = rate + 0.5 * h * b2, angular_acceleration(angle + 0.5 * h * a2, rate + 0.5 * h * b2, t + 0.5 * h, p)
            a4, b4 = rate + h * b3, angular_acceleration(angle + h * a3, rate + h * b3, t + h, p)
            angle += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
            rate += h / 6 * (b1 + 2 * b2 + 2 * b3 + b4)
            t += h
        out[i, 0], out[i, 1], out[i, 2] = angle, rate, angular_acceleration(angle, rate, t, p)
    return out


def levers(inputs, effects):
    """Centre of mass from the edge, upright (horizontal, vertical) [m], the tracked centre likewise, and inertia about the
    edge / m [m2]."""
    width, height, size = inputs["width"], inputs["block_height"], inputs["nominal_diameter"]
    offset = effects.get("centre_of_mass_offset", {})
    centre = np.array([-width / 2, height / 2])
    mass_centre = centre + [offset.get("x", 0.0) * size, offset.get("z", 0.0) * size]
    inertia = effects.get("inertia_error", {}).get("factor", 1.0) * (width**2 + height**2) / 12
    _, moved_along = displaced(inputs, effects, inputs["mass"])
    return mass_centre, centre, inertia + (1 + moved_along) * mass_centre @ mass_centre


def parameters(inputs, effects, heading):
    """Parameter array of `angular_acceleration` for a block that leans towards the heading [rad]."""
    mass_centre, _, inertia = levers(inputs, effects)
    ax, ay = lean(inputs, effects)
    g = inputs["gravity"] * (1 - displaced(inputs, effects, inputs["mass"])[0])
    area, coefficient = inputs.get("area", 0.0), effects.get("quadratic_drag", {}).get("drag_coefficient", 0.0)
    drag = 0.5 * inputs.get("fluid_density", 0.0) * coefficient * area / inputs["mass"] * np.hypot(*mass_centre) ** 3 / inertia
    g1 = g * (np.sin(ax) * np.cos(heading) + np.sin(ay) * np.sin(heading))
    g3 = -g * np.sqrt(1 - np.sin(ax) ** 2 - np.sin(ay) ** 2)
    outside = {"shake": 0.0, "frequency": 1.0, "phase": 0.0, "kick": 0.0, "kick_time": 0.0, "side": 1.0}
    for name in ("shaken_floor", "kick"):
        outside.update({key: value for key, value in effects.get(name, {}).items() if key in outside})
    return np.array([*mass_centre, inertia, g1, g3, drag, *outside.values()])


def simulate(trial, inputs, effects, start, times, step):
    """Positions of the block's centre (n, 3) [m] and orientations (n, 4); start: heading [rad], angle [rad], pivot (3,) [m]."""
    heading, pivot = start["heading"], start["pivot"]
    p = parameters(inputs, effects, heading)
    states = turn(start["angle"], 0.0, np.asarray(times, float), step, p)
    _, centre, _ = levers(inputs, effects)
    c, s = np.cos(states[:, 0]), np.sin(states[:, 0])
    x, z = centre[0] * c + centre[1] * s, centre[1] * c - centre[0] * s
    along = np.array([np.cos(heading), np.sin(heading), 0.0])
    margin = effects.get("margin_offset", {}).get("offset", 0.0) * inputs["nominal_diameter"]
    position = pivot + x[:, None] * along + (z + margin)[:, None] * np.array([0.0, 0.0, 1.0])
    axis = np.array([-np.sin(heading), np.cos(heading), 0.0])
    yaw = small_turn(np.array([0.0, 0.0, heading]))
    return position, product(small_turn(states[:, :1] * axis), yaw)


def valid(inputs, effects, start, times, step, friction, last_angle):
    """How many of the times pass before the edge needs more than this friction, carries less than a fifth of the weight, or the
    angle leaves (0, last_angle)."""
    p = parameters(inputs, effects, start["heading"])
    angle, rate, gain = turn(start["angle"], 0.0, np.asarray(times, float), step, p).T
    x = p[0] * np.cos(angle) + p[1] * np.sin(angle)
    z = p[1] * np.cos(angle) - p[0] * np.sin(angle)
    horizontal = gain * z - rate**2 * x
    vertical = -gain * x - rate**2 * z + inputs["gravity"]
    fine = (
        (np.abs(horizontal) < friction * vertical) & (vertical > 0.2 * inputs["gravity"]) & (angle > 0.01) & (angle < last_angle)
    )
    return len(times) if fine.all() else int(np.argmin(fine))
