"""A sphere in a fluid and against a floor: Runge-Kutta of fourth order, impacts located as events. Used by flight, sinking,
bounce.

Laws are in the form of nature here, not of any library: every one has a `form` number; 0 gives the textbook law that a
library would use, 1 another one close to it (drag coefficient falling with Reynolds number, restitution of another power).
"""

import numpy as np
from numba import njit

from .noise import lean, product, small_turn

NAMES = (
    "mass",
    "radius",
    "gravity_x",
    "gravity_y",
    "gravity_z",
    "rho",
    "c_drag",
    "c_form",
    "v_ref",
    "rate",
    "rate_form",
    "buoyant",
    "added",
    "flow_x",
    "flow_y",
    "flow_z",
    "magnus",
    "spin_rate",
    "spin_form",
    "spin_ref",
    "n_x",
    "n_y",
    "n_z",
    "height",
    "e",
    "e_exponent",
    "e_form",
    "mu",
    "gust_x",
    "gust_y",
    "gust_z",
    "gust_time",
    "gust_width",
    "lift",
    "pull",
    "pull_x",
    "pull_y",
    "pull_z",
    "pull_size",
    "swirl",
    "floor",
    "mu_form",
    "c_sub",
    "c_sup",
    "re_c",
    "crisis_form",
    "nu",
)
(
    MASS,
    RADIUS,
    GX,
    GY,
    GZ,
    RHO,
    CD,
    C_FORM,
    V_REF,
    RATE,
    RATE_FORM,
    BUOYANT,
    ADDED,
    UX,
    UY,
    UZ,
    MAGNUS,
    SPIN_RATE,
    SPIN_FORM,
    SPIN_REF,
    NX,
    NY,
    NZ,
    HEIGHT,
    E,
    E_EXPONENT,
    E_FORM,
    MU,
    GUST_X,
    GUST_Y,
    GUST_Z,
    GUST_TIME,
    GUST_WIDTH,
    LIFT,
    PULL,
    PULL_X,
    PULL_Y,
    PULL_Z,
    PULL_SIZE,
    SWIRL,
    FLOOR,
    MU_FORM,
    C_SUB,
    C_SUP,
    RE_C,
    CRISIS_FORM,
    NU,
) = range(len(NAMES))


@njit(cache=True)
def derivative(s, t, p):
    """Time derivative of the state s = position, velocity, spin (9,) at time t [s] under the parameters p."""
    out = np.empty(9)
    wx, wy, wz = s[3] - p[UX], s[4] - p[UY], s[5] - p[UZ]
    speed = np.sqrt(wx * wx + wy * wy + wz * wz) + 1e-12
    r, m = p[RADIUS], p[MASS]
    volume = 4.0 / 3.0 * np.pi * r**3
    # drag: C falls with Reynolds number as a small power, through its nominal value at v_ref
    k = 0.5 * p[RHO] * p[CD] * np.pi * r * r * speed * (speed / p[V_REF]) ** (-0.3 * p[C_FORM])
    if p[RE_C] > 0:  # the boundary layer turns turbulent: another power than the textbook's fourth where the form is not 0
        ratio = 2.0 * r * speed / (p[NU] * p[RE_C])
        c = p[C_SUP] + (p[C_SUB] - p[C_SUP]) / (1.0 + ratio ** (4.0 + p[CRISIS_FORM]))
        k += 0.5 * p[RHO] * c * np.pi * r * r * speed
    k += m * p[RATE] * (speed / p[V_REF]) ** (0.15 * p[RATE_FORM])
    magnus = p[MAGNUS] * np.pi * p[RHO] * r**3
    gust = m * np.exp(-(((t - p[GUST_TIME]) / p[GUST_WIDTH]) ** 2))
    dx, dy, dz = p[PULL_X] - s[0], p[PULL_Y] - s[1], p[PULL_Z] - s[2]
    pull = m * p[PULL] * p[PULL_SIZE] ** 2 / (dx * dx + dy * dy + dz * dz + p[PULL_SIZE] ** 2) ** 1.5
    lift = m * p[LIFT] * t
    swirl = m * p[SWIRL]
    inertia = m + p[ADDED] * volume * p[RHO]
    sink = m - p[BUOYANT] * volume
    out[0], out[1], out[2] = s[3], s[4], s[5]
    out[3] = (
        sink * p[GX] - k * wx + magnus * (s[7] * wz - s[8] * wy) + gust * p[GUST_X] + pull * dx - lift * wy - swirl * s[1]
    ) / inertia
    out[4] = (
        sink * p[GY] - k * wy + magnus * (s[8] * wx - s[6] * wz) + gust * p[GUST_Y] + pull * dy + lift * wx + swirl * s[0]
    ) / inertia
    out[5] = (sink * p[GZ] - k * wz + magnus * (s[6] * wy - s[7] * wx) + gust * p[GUST_Z] + pull * dz) / inertia
    spin = np.sqrt(s[6] ** 2 + s[7] ** 2 + s[8] ** 2) + 1e-12
    decay = p[SPIN_RATE] * (spin / p[SPIN_REF]) ** (0.3 * p[SPIN_FORM])
    out[6], out[7], out[8] = -decay * s[6], -decay * s[7], -decay * s[8]
    return out


@njit(cache=True)
def runge_kutta(s, t, h, p):
    """One classical fourth-order step."""
    a = derivative(s, t, p)
    b = derivative(s + 0.5 * h * a, t + 0.5 * h, p)
    c = derivative(s + 0.5 * h * b, t + 0.5 * h, p)
    d = derivative(s + h * c, t + h, p)
    return s + h / 6.0 * (a + 2 * b + 2 * c + d)


@njit(cache=True)
def gap(s, p):
    """Distance of the sphere from the floor [m]."""
    return s[0] * p[NX] + s[1] * p[NY] + s[2] * p[NZ] - p[HEIGHT] - p[RADIUS]


@njit(cache=True)
def impact(s, p):
    """Newton's restitution and Coulomb's impulse on a solid sphere: the state just after."""
    n = np.array([p[NX], p[NY], p[NZ]])
    v, w = s[3:6].copy(), s[6:9].copy()
    normal = v @ n
    if normal >= 0:
        return s
    speed = -normal
    # e = e_1 (v / 1 m/s)^-exponent; the other form is linear in the fifth root of the speed
    e = p[E] * ((1 - p[E_FORM]) * speed ** (-p[E_EXPONENT]) + p[E_FORM] * (1 + 5 * p[E_EXPONENT] * (1 - speed**0.2)))
    e = min(max(e, 0.0), 1.0)
    slip = v - normal * n + np.cross(w, -p[RADIUS] * n)
    size = np.sqrt(slip @ slip)
    jn = (1 + e) * speed
    mu = p[MU] * (1 + p[MU_FORM] * 0.1 * (1 - np.exp(-size)))
    # fluid that moves along shares the blow: linear inertia M = m + added mass, about the centre I = 2/5 m r^2 alone
    heavier = 1.0 + p[ADDED] * 4.0 / 3.0 * np.pi * p[RADIUS] ** 3 * p[RHO] / p[MASS]
    jt = min(mu * jn, size / (1.0 + 2.5 * heavier))  # 1 + M r^2 / I = 7/2 for a solid sphere without fluid
    out = s.copy()
    push = np.zeros(3) if size < 1e-12 else -jt / size * slip
    out[3:6] = v + jn * n + push
    out[6:9] = w + heavier * np.cross(-p[RADIUS] * n, push) / (0.4 * p[RADIUS] ** 2)
    return out


@njit(cache=True)
def fly(start, times, step, p):
    """States (n, 9) and turns (n, 3, rotation vectors since the sample before) at the rising times; at rest before t = 0."""
    out, turns = np.empty((len(times), 9)), np.zeros((len(times), 3))
    s, t, resting = start.copy(), 0.0, False
    for i in range(len(times)):
        while t < times[i] - 1e-12 and not resting:
            h = min(step, times[i] - t)
            after = runge_kutta(s, t, h, p)
            if p[FLOOR] > 0 and gap(after, p) < 0:
                low, high = 0.0, h
                for _ in range(50):
                    middle = 0.5 * (low + high)
                    if gap(runge_kutta(s, t, middle, p), p) < 0:
                        high = middle
                    else:
                        low = middle
                hit = runge_kutta(s, t, low, p)
                turns[i] += low * 0.5 * (s[6:9] + hit[6:9])
                t += max(low, 1e-9)
                s = impact(hit, p)
                if abs(s[3] * p[NX] + s[4] * p[NY] + s[5] * p[NZ]) < 5e-3:
                    resting = True
            else:
                turns[i] += h * 0.5 * (s[6:9] + after[6:9])
                s, t = after, t + h
        out[i] = s
    return out, turns


def parameters(inputs, effects):
    """Parameter array from nominal-style inputs and {effect: parameters}."""
    p = dict.fromkeys(NAMES, 0.0)
    p.update(
        mass=inputs["mass"],
        radius=inputs["radius"],
        rho=inputs.get("fluid_density", 0.0),
        v_ref=inputs.get("v_ref", 3.0),
        spin_ref=20.0,
        gust_width=1.0,
        pull_size=1.0,
        e=inputs.get("restitution", 0.0),
        mu=inputs.get("friction", 0.0),
        floor=float("floor_height" in inputs),
        height=inputs.get("floor_height", 0.0),
    )
    p["mass"] *= 1 + effects.get("mass_offset", {}).get("relative", 0.0)
    p["height"] += effects.get("margin_offset", {}).get("offset", 0.0) * p["radius"] * (4 * np.pi / 3) ** (1 / 3)
    ax, ay = lean(inputs, effects)
    g = inputs["gravity"]
    p.update(gravity_x=g * np.sin(ax), gravity_y=g * np.sin(ay), gravity_z=-g * np.sqrt(1 - np.sin(ax) ** 2 - np.sin(ay) ** 2))
    normal = np.array(inputs.get("floor_normal", (0.0, 0.0, 1.0)), float)
    slope = effects.get("bottom_slope", {})
    normal = normal - normal[2] * np.array([slope.get("grade_x", 0.0), slope.get("grade_y", 0.0), 0.0])  # it rises by grade * x
    normal /= np.linalg.norm(normal)
    p.update(n_x=normal[0], n_y=normal[1], n_z=normal[2])
    drag = effects.get("quadratic_drag", {})
    p.update(c_drag=drag.get("drag_coefficient", 0.0), c_form=drag.get("form", 0.0))
    if "drag_crisis" in effects:
        law = effects["drag_crisis"]
        p.update(
            c_sub=law["subcritical"], c_sup=law["supercritical"], re_c=law["critical_reynolds"], crisis_form=law.get("form", 0.0)
        )
    p["nu"] = inputs.get("viscosity", 0.0) / p["rho"] if p["rho"] else 0.0
    p.update(rate=effects.get("linear_drag", {}).get("rate", 0.0), rate_form=effects.get("linear_drag", {}).get("form", 0.0))
    p["buoyant"] = effects.get("buoyancy", {}).get("fluid_density", 0.0)
    p["added"] = effects.get("added_mass", {}).get("coefficient", 0.0)
    flow = effects.get("uniform_flow", {})
    p.update(flow_x=flow.get("velocity_x", 0.0), flow_y=flow.get("velocity_y", 0.0), flow_z=flow.get("velocity_z", 0.0))
    p["magnus"] = effects.get("magnus", {}).get("coefficient", 0.0)
    p.update(spin_rate=effects.get("spin_decay", {}).get("rate", 0.0), spin_form=effects.get("spin_decay", {}).get("form", 0.0))
    p["e"] = effects.get("restitution", {}).get("coefficient", p["e"])
    if "velocity_dependent_restitution" in effects:
        law = effects["velocity_dependent_restitution"]
        p.update(e_exponent=law.get("exponent", 0.0), e_form=law.get("form", 0.0))
    if "friction" in effects:
        p.update(mu=effects["friction"]["coefficient"], mu_form=effects["friction"].get("form", 0.0))
    for outside in ("gust", "growing_lift", "magnet", "swirl"):
        p.update({key: value for key, value in effects.get(outside, {}).items() if key in p})
    side = effects.get("gust", {}).get("side", 1.0)
    p.update(gust_x=side * p["gust_x"], gust_y=side * p["gust_y"])
    return np.array([p[name] for name in NAMES])


def simulate(trial, inputs, effects, start, times, step):
    """Positions (n, 3) [m] and orientations (n, 4) of the sphere at true times [s] (negative: not yet released)."""
    p = parameters(inputs, effects)
    state = np.concatenate([start["position"], start["velocity"], start.get("angular_velocity", np.zeros(3))]).astype(float)
    if p[FLOOR] and gap(state, p) < 0:  # resting a hair inside a raised floor: start on it
        state[:3] += -gap(state, p) * p[[NX, NY, NZ]]
    states, turns = fly(state, np.asarray(times, float), step, p)
    orientation = None
    if "orientation" in start:
        # the spin axis is constant between impacts, so the turns of successive samples are exact there
        steps = small_turn(turns)
        orientation, current = np.empty((len(times), 4)), np.asarray(start["orientation"], float)
        for i in range(len(times)):
            current = product(steps[i], current)
            orientation[i] = current / np.linalg.norm(current)
    return states[:, :3], orientation
