"""All observations beside a fitted model, how they are judged, and where they miss."""

import numpy as np

from hlcs.data.rigid_body import rigid_body
from hlcs.estimation.adequacy import adequacy, blocks_in_time
from hlcs.estimation.least_squares import basis, project_out
from hlcs.estimation.trajectory_problem import CHANNELS
from hlcs.simulation.regimes import REGIMES, classify_regimes
from minibullet import rotations


def recording_scale(recording):
    """1/sigma of every observation of a recording, (n,)."""
    return 1 / recording.whitening.sigma


def observations(problem, fit):
    """Table of all observations as arrays: trial, channel, phase, time, height, speed, residual, in sigma, white (n,) each."""
    answers = fit.linearization.trajectories or problem.simulator.simulate(
        fit.model, fit.initial_states, np.arange(len(problem.trials))
    )
    white = fit.linearization.projected[0]
    columns = {}
    for k, (recording, (position, orientation)) in enumerate(zip(problem.recordings, answers, strict=True)):
        times = problem.trials[k].times
        speed = np.linalg.norm(np.gradient(position, times, axis=0), axis=1)
        raw = fit.linearization.raw[k]
        turn = rotations.logarithm(orientation)
        table = np.concatenate([position, turn], axis=1)[recording.sample, recording.channel]
        doing = classify_regimes(problem.trials[k], rigid_body(problem.trials[k].body).shape, position, orientation)
        rows = {
            "trial": np.full(len(raw), k),
            "channel": recording.channel,
            "time": recording.times,
            "phase": np.array(REGIMES)[doing[recording.sample]],
            "height": position[recording.sample, 2],
            "speed": speed[recording.sample],
            "measured": table + raw,
            "model": table,
            "residual": raw,
            "sigmas": raw * recording_scale(recording),
            "white": white[k],
        }
        for name, values in rows.items():
            columns.setdefault(name, []).append(values)
    return {name: np.concatenate(parts) for name, parts in columns.items()}


def partitions(table):
    """Ways to cut the observations into blocks whose sums would show a slow or a common misfit: name -> labels (n,)."""
    chain = table["trial"] * 6 + table["channel"]
    found = {f"blocks of {length} samples": blocks_in_time(chain, length) for length in (4, 12, 36)}
    if len(np.unique(table["trial"])) >= 3:
        for name in ("time", "height", "speed"):
            values = table[name]
            edges = np.quantile(values, np.linspace(0, 1, 13)[1:-1])
            found[f"common to all recordings against {name}"] = table["channel"] * 100 + np.searchsorted(edges, values)
    return found


def judge(problem, fit):
    """Adequacy of a fit and its table of observations."""
    table = observations(problem, fit)
    r, s = fit.linearization.projected
    s_all = np.concatenate(s)
    r_all = project_out(basis(s_all), np.concatenate(r))
    cuts = np.cumsum([len(part) for part in r])[:-1]
    draw = problem.noise.drawer(problem.recordings)
    verdict = adequacy(np.split(r_all, cuts), fit.linearization.state_columns, s, partitions(table), draw)
    return verdict, table


def where_it_fails(problem, table):
    """Rows {trial, channel, phase, rms, sigma, height, speed, time}, the worst first.

    sigma: root mean square of the residual in units of the noise; height, speed and time where the residual is largest.
    """
    found = []
    regimes = table.get("phase", np.full(len(table["trial"]), "flight"))
    names, kind = np.unique(regimes, return_inverse=True)
    label = (table["trial"] * 6 + table["channel"]) * len(names) + kind
    order = np.argsort(label, kind="stable")
    for here in np.split(order, np.flatnonzero(np.diff(label[order])) + 1):
        worst = here[np.argmax(np.abs(table["sigmas"][here]))]
        found.append(
            {
                "trial": problem.trials[table["trial"][worst]].name,
                "channel": CHANNELS[table["channel"][worst]],
                "phase": str(regimes[worst]),
                "rms": float(np.sqrt(np.mean(table["residual"][here] ** 2))),
                "sigma": float(np.sqrt(np.mean(table["sigmas"][here] ** 2))),
                "time": float(table["time"][worst]),
                "height": float(table["height"][worst]),
                "speed": float(table["speed"][worst]),
            }
        )
    return tuple(sorted(found, key=lambda row: (-row["sigma"], row["trial"], row["channel"], row["phase"])))
