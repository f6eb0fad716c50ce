"""Is the start that a file states of a recording that of the motion in it? Lengths in other units are told."""

import numpy as np

FAR = 3.0  # how many times the size of a recording a start may lie aside of it, or a body fly in one typical step
LEAST_SIZE = 0.1  # size of a recording, at least: noise about a body at rest is no way [m]


def check_start(trial, file):
    """Tell of a stated start that is out of reach of the recording, a Trial; file: the ExperimentFile that states it.

    A body begins where its first sample is, so a start many times the whole way aside of that is in another unit; and a velocity
    that leads as far within a step of the recording is another one than it shows. A liquid may stop a body at once.
    """
    seen = np.isfinite(trial.position).any(axis=0)
    if not trial.start or not seen.any() or len(trial.times) < 2:
        return
    values = trial.position[:, seen]
    size = max(float(np.linalg.norm(np.nanmax(values, axis=0) - np.nanmin(values, axis=0))), LEAST_SIZE)
    first = np.array([column[np.isfinite(column)][0] for column in values.T])
    index = next(index for index, entry in enumerate(file.trials) if entry.start is trial.start)
    if "position" in trial.start:
        aside = float(np.linalg.norm(np.asarray(trial.start["position"])[seen] - first))
        if aside > FAR * size:
            what = f"is {aside:.3g} m aside of the first sample, in a recording of {size:.3g} m: lengths are in m"
            file.source.warn("position", what, "trial.start", index)
    if "velocity" in trial.start and not trial.surroundings.in_liquid:
        step, speed = float(np.median(np.diff(trial.times))), float(np.linalg.norm(np.asarray(trial.start["velocity"])[seen]))
        if speed * step > FAR * size:
            what = (
                f"{speed:.3g} m/s lead {speed * step:.3g} m away within one step of {step:.3g} s, in a recording of "
                f"{size:.3g} m: velocities are in m/s"
            )
            file.source.warn("velocity", what, "trial.start", index)
