"""Viscosity read from recordings of a sinking body, without any fit: where a search for it begins.

Far from free fall a small change of a model without drag says nothing of a drag that carries the whole weight.
"""

import numpy as np

from hlcs.data.rigid_body import known_body, rigid_body

LEAST = 5  # samples of a recording from which speed and acceleration are read


def read_viscosity(trials):
    """The median viscosity over recordings that gives the mean drag on them by Stokes's law [Pa s]; None where none shows one.

    Drag = weight less lift less mass times acceleration = 6 pi eta r v, each the mean over a recording: of a parabola through its
    heights. In a liquid half of the displaced mass is accelerated with the body (H. Lamb, Hydrodynamics (1932), art. 92).
    """
    found = [eta for trial in trials if (eta := _of_one(trial)) is not None]
    return float(np.median(found)) if found else None


def _of_one(trial):
    """The viscosity of one recording, None where the body is not known, does not sink, or is not held back."""
    there = np.isfinite(trial.position[:, 2])
    if not known_body(trial.body) or there.sum() < LEAST:
        return None
    times, heights = trial.times[there], trial.position[there, 2]
    bend = np.polyfit(times - times.mean(), heights, 2)[0]
    speed = (heights[0] - heights[-1]) / (times[-1] - times[0])
    body, around = rigid_body(trial.body), trial.surroundings
    displaced = around.fluid_density * body.volume if around.in_liquid else 0.0
    drag = (body.mass - displaced) * around.gravity + (body.mass + displaced / 2) * 2 * bend
    eta = drag / (6 * np.pi * body.radius * speed) if speed > 0 else 0.0
    return float(eta) if eta > 0 else None
