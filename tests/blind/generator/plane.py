"""A block that slides and a ball that rolls on a plane: two equations in the plane, Runge-Kutta of fourth order, stopping
as an event."""

import numpy as np
from numba import njit

from .fluid import displaced
from .noise import lean, product, small_turn

NAMES = (
    "g_1",
    "g_2",
    "g_n",
    "mu",
    "ratio",
    "stribeck_speed",
    "stribeck_power",
    "viscous",
    "viscous_form",
    "smooth",
    "cross",
    "cross_angle",
    "rate",
    "quadratic",
    "arm",
    "arm_form",
    "kappa",
    "held",
    "patch",
    "patch_1",
    "patch_2",
    "patch_size",
    "wave",
    "wave_number",
    "shake",
    "shake_rate",
    "shake_phase",
    "shake_heading",
    "spin_torque",
    "spin_rate",
    "added",
)
(
    G1,
    G2,
    GN,
    MU,
    RATIO,
    STRIBECK_SPEED,
    STRIBECK_POWER,
    VISCOUS,
    VISCOUS_FORM,
    SMOOTH,
    CROSS,
    CROSS_ANGLE,
    RATE,
    QUADRATIC,
    ARM,
    ARM_FORM,
    KAPPA,
    HELD,
    PATCH,
    PATCH_1,
    PATCH_2,
    PATCH_SIZE,
    WAVE,
    WAVE_NUMBER,
    SHAKE,
    SHAKE_RATE,
    SHAKE_PHASE,
    SHAKE_HEADING,
    SPIN_TORQUE,
    SPIN_RATE,
    ADDED,
) = range(len(NAMES))


@njit(cache=True)
def resistance(speed, c, s, p):
    """Force by the ground over the mass [m/s2] at a speed [m/s], heading (c, s): friction of the block, or rolling resistance."""
    if p[KAPPA] > 0:
        return p[ARM] * p[GN] * (1 + p[ARM_FORM] * 0.1 * np.log(speed / 0.3 + 0.05))
    mu = p[MU] * (1 + (p[RATIO] - 1) * np.exp(-((speed / p[STRIBECK_SPEED]) ** p[STRIBECK_POWER])))
    mu += p[VISCOUS] * speed ** (1 - 0.25 * p[VISCOUS_FORM])
    ca, sa = np.cos(p[CROSS_ANGLE]), np.sin(p[CROSS_ANGLE])
    along, across = c * ca + s * sa, -c * sa + s * ca
    mu *= np.sqrt(along**2 + (p[CROSS] * across) ** 2)
    if p[SMOOTH] > 0:
        mu *= np.tanh(speed / p[SMOOTH])
    return mu * p[GN]


@njit(cache=True)
def acceleration(q, t, p):
    """Time derivative of (place 2, velocity 2) in the plane."""
    speed = np.sqrt(q[2] ** 2 + q[3] ** 2) + 1e-30
    c, s = q[2] / speed, q[3] / speed
    brake = resistance(speed, c, s, p)
    d1, d2 = q[0] - p[PATCH_1], q[1] - p[PATCH_2]
    brake += p[PATCH] * p[GN] * np.exp(-(d1 * d1 + d2 * d2) / p[PATCH_SIZE] ** 2)  # a rough or sticky spot
    air = p[RATE] + p[QUADRATIC] * speed
    gain = 1.0 / (1.0 + p[KAPPA] + p[ADDED])  # the spin of a rolling ball and the fluid that moves along share the push
    wave = p[WAVE] * p[GN] * np.sin(p[WAVE_NUMBER] * (q[0] + 0.6 * q[1]))  # an undulating floor
    shake = p[SHAKE] * np.sin(p[SHAKE_RATE] * t + p[SHAKE_PHASE])  # the board shakes along itself
    out = np.empty(4)
    out[0], out[1] = q[2], q[3]
    out[2] = gain * (p[G1] + wave + shake * np.cos(p[SHAKE_HEADING]) - air * q[2] - brake * c)
    out[3] = gain * (p[G2] + 0.6 * wave + shake * np.sin(p[SHAKE_HEADING]) - air * q[3] - brake * s)
    return out


@njit(cache=True)
def advance(q, t, h, p):
    """One classical fourth-order step, and whether the body turned round on the way (the law jumps there, so no stage may)."""
    a = acceleration(q, t, p)
    b = acceleration(q + 0.5 * h * a, t + 0.5 * h, p)
    c = acceleration(q + 0.5 * h * b, t + 0.5 * h, p)
    d = acceleration(q + h * c, t + h, p)
    after, stage_2, stage_3, stage_4 = q + h / 6.0 * (a + 2 * b + 2 * c + d), q + 0.5 * h * a, q + 0.5 * h * b, q + h * c
    reversed_ = False
    for stage in (after, stage_2, stage_3, stage_4):
        reversed_ = reversed_ or stage[2] * q[2] + stage[3] * q[3] <= 0
    return after, reversed_


@njit(cache=True)
def travel(start, times, step, p):
    """States (n, 4) at rising times [s]; at rest before t = 0, held at rest when the drive stays below the resistance."""
    out = np.empty((len(times), 4))
    q, t = start.copy(), 0.0
    stopped = q[2] ** 2 + q[3] ** 2 < 1e-18
    for i in range(len(times)):
        while t < times[i] - 1e-12:
            drive = np.sqrt(p[G1] ** 2 + p[G2] ** 2)
            if stopped:
                at_start = resistance(1e-9, p[G1] / (drive + 1e-12), p[G2] / (drive + 1e-12), p)
                if p[SMOOTH] > 0 and p[KAPPA] == 0:
                    at_start = p[MU] * p[GN]
                if drive <= at_start * p[HELD]:
                    break
                stopped = False
                q[2], q[3] = 1e-9 * p[G1] / drive, 1e-9 * p[G2] / drive
            h = min(step, times[i] - t)
            after, stops = advance(q, t, h, p)
            if stops:
                low, high = 0.0, h
                for _ in range(40):
                    middle = 0.5 * (low + high)
                    after, stops = advance(q, t, middle, p)
                    if stops:
                        high = middle
                    else:
                        low = middle
                q, t = advance(q, t, low, p)[0], t + low
                q[2] = q[3] = 0.0
                stopped = True
            else:
                q, t = after, t + h
        if stopped:
            t = max(t, times[i])
        out[i] = q
    return out


def frame(normal):
    """Two unit vectors in the plane and its normal: rows of a (3, 3) matrix."""
    n = np.asarray(normal, float) / np.linalg.norm(normal)
    first = np.array([1.0, 0.0, 0.0]) - n[0] * n
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(n, first), n])


def parameters(inputs, effects, axes, rolling):
    """Parameter array for a plane with the frame `axes`."""
    p = dict.fromkeys(NAMES, 0.0)
    ax, ay = lean(inputs, effects)
    g = inputs["gravity"] * np.array([np.sin(ax), np.sin(ay), -np.sqrt(1 - np.sin(ax) ** 2 - np.sin(ay) ** 2)])
    mass = inputs["mass"] * (1 + effects.get("mass_offset", {}).get("relative", 0.0))
    lifted, moved_along = displaced(inputs, effects, mass)
    g = g * (1 - lifted)
    radius = inputs.get("radius", 0.0)
    fluid, area = inputs.get("fluid_density", 0.0), np.pi * radius**2 if rolling else inputs.get("area", 0.0)
    p.update(
        g_1=axes[0] @ g,
        g_2=axes[1] @ g,
        g_n=-axes[2] @ g,
        added=moved_along,
        mu=inputs.get("friction", 0.0),
        ratio=1.0,
        stribeck_speed=1.0,
        stribeck_power=2.0,
        cross=1.0,
        patch_size=1.0,
        held=1.0,
    )
    if "friction" in effects:
        p.update(mu=effects["friction"]["coefficient"], smooth=0.01 * effects["friction"].get("form", 0.0))
    if "stribeck_friction" in effects:
        law = effects["stribeck_friction"]
        p.update(ratio=law["ratio"], stribeck_speed=law["speed"], stribeck_power=2.0 - law.get("form", 0.0))
    if "viscous_friction" in effects:
        p.update(viscous=effects["viscous_friction"]["slope"], viscous_form=effects["viscous_friction"].get("form", 0.0))
    if "anisotropic_friction" in effects:
        p.update(cross=effects["anisotropic_friction"]["ratio"], cross_angle=effects["anisotropic_friction"]["angle"])
    if "static_friction" in effects:
        p.update(held=effects["static_friction"]["ratio"])
    p["rate"] = effects.get("linear_drag", {}).get("rate", 0.0)
    p["quadratic"] = 0.5 * fluid * effects.get("quadratic_drag", {}).get("drag_coefficient", 0.0) * area / mass
    if rolling:
        p["kappa"] = 0.4 * effects.get("inertia_error", {}).get("factor", 1.0)
        law = effects.get("rolling_friction", {})
        p.update(arm=law.get("arm", 0.0) / radius, arm_form=law.get("form", 0.0))
        p["spin_torque"] = effects.get("spinning_friction", {}).get("arm", 0.0) * p["g_n"] / (p["kappa"] * radius**2)
        p["spin_rate"] = effects.get("spin_decay", {}).get("rate", 0.0)
    for outside in ("sticky_patch", "wavy_floor", "shaken_board"):
        p.update({key: value for key, value in effects.get(outside, {}).items() if key in p})
    return np.array([p[name] for name in NAMES])


def spin_angle(spin, torque, rate, times):
    """Angle [rad] turned about the normal: spin [rad/s] falling linearly (torque) or exponentially (rate), closed form."""
    times = np.maximum(times, 0.0)
    if rate > 0:
        return spin * (1 - np.exp(-rate * times)) / rate
    if torque > 0:
        times = np.minimum(times, abs(spin) / torque)
        return spin * times - 0.5 * np.sign(spin) * torque * times**2
    return spin * times


def simulate(trial, inputs, effects, start, times, step, rolling=False):
    """Positions (n, 3) [m] and orientations (n, 4) of a block or ball on its plane at true times [s]."""
    slope = effects.get("bottom_slope", {})
    normal = np.asarray(inputs["floor_normal"], float)
    normal = normal - normal[2] * np.array([slope.get("grade_x", 0.0), slope.get("grade_y", 0.0), 0.0])
    axes = frame(normal)
    p = parameters(inputs, effects, axes, rolling)
    clearance = inputs["clearance"] + effects.get("margin_offset", {}).get("offset", 0.0) * inputs["nominal_diameter"]
    place = axes @ np.asarray(start["position"], float)
    velocity = axes @ np.asarray(start["velocity"], float)
    states = travel(np.array([place[0], place[1], velocity[0], velocity[1]]), np.asarray(times, float), step, p)
    height = inputs.get("floor_height", 0.0) + clearance
    position = states[:, :1] * axes[0] + states[:, 1:2] * axes[1] + height * axes[2]
    orientation = None
    if "orientation" in start:
        first = np.asarray(start["orientation"], float)
        orientation = np.repeat(first[None], len(states), axis=0)
        if rolling:
            # increments between samples: rolling turns about n x travelled, spinning about n
            travelled = np.diff(states[:, :2], axis=0, prepend=place[None, :2]) @ axes[:2]
            angle = spin_angle(axes[2] @ start["angular_velocity"], p[SPIN_TORQUE], p[SPIN_RATE], np.asarray(times))
            turns = np.cross(axes[2], travelled) / inputs["radius"] + np.diff(angle, prepend=0.0)[:, None] * axes[2]
            current = first
            for i, turn in enumerate(small_turn(turns)):
                current = product(turn, current)
                orientation[i] = current
    return position, orientation
