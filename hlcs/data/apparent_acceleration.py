"""How fast a recorded coordinate falls, rises or slows down, whatever moves it."""

import numpy as np


def acceleration(trial, axis, segments=8, least=6):
    """(typical second derivative of a recorded coordinate, its standard error) [m/s2]; None with fewer than 5 samples.

    In free flight of one parabola through all samples; where there is a floor the median over segments, so that a few impacts
    between them do not matter. The error is infinite where there are fewer than three segments.
    """
    there = np.isfinite(trial.position[:, axis])
    times, values = trial.times[there], trial.position[there, axis]
    if len(times) < 5:
        return None
    if trial.surroundings.floor_height is None:
        return of_a_parabola(times, values)
    count = int(np.clip(len(times) // least, 1, segments))
    curvatures = np.array(
        [
            2 * np.polyfit(times[part] - times[part[0]], values[part], 2)[0]
            for part in np.array_split(np.arange(len(times)), count)
        ]
    )
    middle = float(np.median(curvatures))
    return middle, 1.4826 * 1.25 * float(np.median(np.abs(curvatures - middle))) / np.sqrt(count) if count > 2 else np.inf


def of_a_parabola(times, values):
    """(second derivative of one parabola through all samples, its standard error)."""
    curve = np.polyfit(times - times[0], values, 2)
    scatter = np.std(values - np.polyval(curve, times - times[0]))
    return 2 * float(curve[0]), float(scatter) * np.sqrt(720 / len(times)) / (times[-1] - times[0]) ** 2
