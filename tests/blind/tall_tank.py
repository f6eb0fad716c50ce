"""The packaged table of sinking times: closed form of a sphere that sinks from rest, C = constant.

(m + C_a rho V) dv/dt = (m - rho V) g - rho C A v2/2, so z = ln cosh(t sqrt(g' k))/k with g' the first acceleration and k the
resistance, each over the inertia. What is hidden: depths were read along a glass that leans by 15 degrees, 1/cos 15 = 1.035.
"""

import numpy as np

from .generator.case import csv_text, toml_text

RADIUS, DENSITY, WATER, GRAVITY = 0.008, 2500.0, 998.0, 9.81  # glass; SI
DRAG, ADDED = 0.45, 0.5
DEPTHS = np.arange(0.25, 2.01, 0.25)  # m, as read
DAYS, REPEATS, HAND = 3, 3, 0.02  # s, one standard deviation of a stop watch started and stopped by hand
FACTOR = 1.035
TIED = ["mass_offset", "quadratic_drag", "size_error", "time_scale"]


def sinking_time(depth, radius=RADIUS, mass=None):
    """Seconds from rest to a depth [m] (n,)."""
    volume = 4 / 3 * np.pi * radius**3
    mass = DENSITY * volume if mass is None else mass
    inertia = mass + ADDED * WATER * volume
    first, resistance = GRAVITY * (mass - WATER * volume) / inertia, 0.5 * WATER * DRAG * np.pi * radius**2 / inertia
    return np.arccosh(np.exp(resistance * np.asarray(depth))) / np.sqrt(first * resistance)


def table(title):
    """({file name: text}, answer without its text) of the set."""
    rng = np.random.default_rng([19_09_2021, 11])
    mass = float(f"{DENSITY * 4 / 3 * np.pi * RADIUS**3:.4g}")
    rows = []
    for day in range(DAYS):
        for depth in np.tile(DEPTHS, REPEATS):
            seconds = sinking_time(depth / FACTOR, mass=mass) + HAND * rng.normal()
            rows.append((f"{depth:g}", f"{seconds:.3f}", f"morning {day + 1}"))
    model = (
        {"name": "buoyancy", "fluid_density": WATER},
        {"name": "added_mass", "coefficient": ADDED},
        {"name": "quadratic_drag", "drag_coefficient": DRAG},
    )
    files = {
        "outcomes.csv": csv_text(["height_m", "fall_time_s", "group"], rows),
        "experiment.toml": toml_text(
            {
                "": {"kind": "outcomes", "title": title},
                "body": {"shape": "sphere", "radius": RADIUS, "mass": mass},
                "surroundings": {"gravity": GRAVITY, "fluid_density": WATER, "fluid_viscosity": 1.0e-3},
                "model": {"effects": list(model)},
                "measurement": {"file": "outcomes.csv"},
                "diagnose": {"hold_out": "group"},
            }
        ),
    }
    shift = sinking_time(DEPTHS / FACTOR, mass=mass) - sinking_time(DEPTHS, mass=mass)
    law = {"length_scale": {"factor": FACTOR}}
    answer = {
        "effects": ["length_scale"],
        "parameters": law,
        "hidden_laws": law,
        "strengths": {"length_scale": float(np.sqrt(np.mean(shift**2)) / HAND)},
        "tied": TIED,
        "possible": [],
        "outside": False,
        "noise": {"regime": "replicates", "time": HAND},
    }
    return files, answer
