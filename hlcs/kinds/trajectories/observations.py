"""All observations beside a fitted model, how they are judged, and where they miss."""

import numpy as np

from hlcs.data.quantities import CHANNELS
from hlcs.data.rigid_body import rigid_body
from hlcs.estimation.adequacy import blocks_in_time, fit_adequacy
from hlcs.kinds.protocol import misses
from hlcs.simulation.regimes import REGIMES, classify_regimes
from minibullet import rotations


def recording_scale(recording):
    """1/sigma of every observation of a recording, (n,)."""
    return 1 / recording.whitening.sigma


def observations(problem, fit):
    """Table of all observations as arrays: trial, the recording that it is a part of, channel, phase, time, height, speed,
    residual, in sigma, white (n,) each."""
    trajectories, white = fit.linearization.trajectories, fit.linearization.projected[0]
    columns, wholes = {}, recordings_of(problem)
    for k, (recording, motion) in enumerate(zip(problem.recordings, trajectories, strict=True)):
        position, orientation = motion.position, motion.orientation
        times = problem.trials[k].times
        speed = np.linalg.norm(np.gradient(position, times, axis=0), axis=1)
        raw = fit.linearization.raw[k]
        force = np.zeros_like(position) if motion.specific_force is None else motion.specific_force
        modelled = np.concatenate([position, rotations.logarithm(orientation), force], axis=1)
        model = modelled[recording.sample, recording.channel]
        regimes = classify_regimes(problem.trials[k], rigid_body(problem.trials[k].body).shape, position, orientation)
        parts = {
            "trial": np.full(len(raw), k),
            "recording": np.full(len(raw), wholes.index(problem.trials[k].whole)),
            "channel": recording.channel,
            "time": recording.times,
            "phase": np.array(REGIMES)[regimes[recording.sample]],
            "height": position[recording.sample, 2],
            "speed": speed[recording.sample],
            "measured": model + raw,
            "model": model,
            "residual": raw,
            "sigmas": raw * recording_scale(recording),
            "white": white[k],
        }
        for name, values in parts.items():
            columns.setdefault(name, []).append(values)
    return {name: np.concatenate(parts) for name, parts in columns.items()}


def recordings_of(problem):
    """Names of the recordings of a problem, whole or in segments, in order."""
    return list(dict.fromkeys(trial.whole for trial in problem.trials))


def partitions(table):
    """Ways to cut the observations into blocks whose sums would show a slow or a common misfit: name -> labels (n,)."""
    chain = table["trial"] * len(CHANNELS) + table["channel"]
    labels = {f"blocks of {length} samples": blocks_in_time(chain, length) for length in (4, 12, 36)}
    if len(np.unique(table["trial"])) >= 3:
        for name in ("time", "height", "speed"):
            values = table[name]
            edges = np.quantile(values, np.linspace(0, 1, 13)[1:-1])
            labels[f"common to all recordings against {name}"] = table["channel"] * 100 + np.searchsorted(edges, values)
    return labels


def judge(problem, fit):
    """Adequacy of a fit and its table of observations."""
    table = observations(problem, fit)
    models = np.split(table["model"], np.cumsum([len(recording.channel) for recording in problem.recordings])[:-1])
    return fit_adequacy(problem, fit, partitions(table), models), table


def told_of(trial):
    """Of what a Trial tells beside its own channels: time, and height and speed where it has positions to know them by."""
    placed = np.isfinite(trial.position)
    moves = placed.any() or trial.accelerations is not None
    return ("time", *(["height"] if placed[:, 2].any() else []), *(["speed"] if moves else []))


def where_it_fails(problem, table):
    """Rows {trial, channel, phase, rms, sigma, height, speed, time}, the worst first.

    sigma: root mean square of the residual in units of the noise; height, speed and time where the residual is largest, None
    for what the recording says nothing of: a height in a film from above, a speed beside angles alone.
    """
    where = []
    names, kind = np.unique(table["phase"], return_inverse=True)
    label = (table["trial"] * len(CHANNELS) + table["channel"]) * len(names) + kind
    order = np.argsort(label, kind="stable")
    for inside in np.split(order, np.flatnonzero(np.diff(label[order])) + 1):
        worst = inside[np.argmax(np.abs(table["sigmas"][inside]))]
        row = {
            "trial": problem.trials[table["trial"][worst]].name,
            "channel": CHANNELS[table["channel"][worst]],
            "phase": str(table["phase"][worst]),
        }
        seen = told_of(problem.trials[table["trial"][worst]])
        at_worst = {name: float(table[name][worst]) if name in seen else None for name in ("time", "height", "speed")}
        where.append(row | misses(table, inside) | at_worst)
    return tuple(sorted(where, key=lambda row: (-row["sigma"], row["trial"], row["channel"], row["phase"])))
