"""What these data cannot tell apart, and the experiment that would.

Every design is judged by lambda = min over what stays unknown of |y_A - y_B|^2 in units of the noise, A and B the two
surviving rivals with their fitted numbers: the right one wins by more than 6 units with probability 0.9 when
N lambda >= 16.4 (T-optimal design: Atkinson and Fedorov, Biometrika 62 (1975) 57).
"""

from dataclasses import replace

import numpy as np

from hlcs.data.recordings import Trial
from hlcs.effects.witnesses import WITNESSES, Camera
from hlcs.estimation.least_squares import project_out
from hlcs.estimation.trajectory_problem import TrajectoryProblem
from hlcs.estimation.whitening import whiten
from hlcs.records import NextExperiment
from hlcs.simulation.simulator import Simulator
from minibullet import rotations

SEPARATION = 16.4


def tests_needed(separation):
    """N = ceil(16.4 / lambda), None where a hundred tests do not separate."""
    return int(np.ceil(SEPARATION / separation)) if separation > SEPARATION / 100 else None


def hardest(options):
    """Of the best experiments for pairs of rivals, each (lambda, names, ...), that for the pair hardest to separate."""
    return min(options, key=lambda option: option[:2])


def next_experiment(sets, verdict):
    """The experiment that best separates the best set from those that do as well, or finds out what stays unexplained."""
    problem, fits = sets.search.problem, sets.search.fits
    final, found = fits[sets.best], []
    for effects in sets.tied[1:]:
        other = fits[effects]
        names = " + ".join(sorted(sets.best - effects)), " + ".join(sorted(effects - sets.best))
        terms = [
            term for fit, rest in ((final, effects), (other, sets.best)) for term in fit.model.terms if term.name not in rest
        ]
        options = witnesses(problem, terms)
        if isinstance(problem.simulator, Simulator):
            options += [(score, text, design, False) for score, text, design in designs(problem, final, other)]
        if options:
            best = max(options, key=lambda option: (min(option[0], 2 * SEPARATION), option[3], option[0], option[1]))
            found.append((best[0], names, *best[1:3]))
    if not found:
        return unexplained(problem, verdict, ())
    score, names, text, design = hardest(found)
    needed = tests_needed(score)
    many = f"{needed} test{'' if needed == 1 else 's'}" if needed else "more than a hundred tests"
    sentence = f"{text} ({many} to tell {names[0]} from {names[1]}, lambda = {score:.3g} a test)"
    if len({pair for _, pair, _, _ in found}) > 1:
        others = sorted({f"{pair[1]}: {other}" for _, pair, other, _ in found if pair != names and other != text})
        sentence += "".join(f"; against {entry}" for entry in others[:3])
    separates = tuple(name for part in names for name in part.split(" + "))
    if verdict == "unexplained":
        return unexplained(problem, verdict, separates, sentence, needed, design)
    return NextExperiment(sentence, separates, needed, design)


def unexplained(problem, verdict, names, more="", needed=None, design=None):
    """What to do where the model fails and no candidate mends it."""
    if isinstance(problem.simulator, Simulator) and problem.unit == "m":
        text = (
            "film a dense ball (no drag to speak of) and a ruler in the same view, or repeat from known heights: that "
            "separates the camera from the motion"
        )
    else:
        text = "repeat the settings where the model misses most, in another order and by other hands"
    return NextExperiment(text + (f"; then: {more}" if more else ""), names, needed, design or {})


# --- direct witnesses: measure the suspect itself ----------------------------------------------------------------------


def witnesses(problem, terms):
    """[(lambda, text, design, True)]: direct readings of effects that two explanations do not share."""
    low, high = problem.simulator.height_range
    camera = Camera(problem.noise.position or 0.0, problem.noise.step, max(high - low, 0.1))
    found = []
    for term in terms:
        reading = WITNESSES.get(term.candidate.kind)
        if reading and camera.sigma > 0:
            size = reading.size(term.numbers, camera)
            text = reading.text.format(extent=camera.extent)
            found.append((float(reading.frames * size**2), text, {"witness": term.name}, True))
    return found


# --- designs: another throw, drop or body ------------------------------------------------------------------------------


def designs(problem, final, other):
    """[(lambda of one test, text, design)] for changes of a trial already done, simulated under both rivals."""
    longest = max(
        range(len(problem.trials)),
        key=lambda k: (problem.trials[k].times[-1] - problem.trials[k].times[0], problem.trials[k].name),
    )
    trial, start = problem.trials[longest], final.initial_states[longest]
    speed = float(np.linalg.norm(start[3:6]))
    options = [("repeat the longest trial as it was", {"repeat": trial.name}, start, trial)]
    quarter = rotations.exponential(np.array([0.0, 0.0, np.pi / 2]))
    if speed > 0.3:
        for factor, word in ((2.0, "twice as fast"), (0.5, "half as fast")):
            faster = _with(start, velocity=factor)
            options.append((f"throw {word} ({factor * speed:.2g} m/s)", {"speed_m_s": factor * speed}, faster, trial))
        options.append(("turn the throw by 90 degrees", {"heading_deg": 90}, _turned(start, quarter), trial))
        options.append(("turn the throw by 180 degrees", {"heading_deg": 180}, _turned(_turned(start, quarter), quarter), trial))
    if np.linalg.norm(start[10:13]) > 1.0:
        options.append(("reverse the spin", {"spin": "reversed"}, _with(start, spin=-1.0), trial))
    if not problem.simulator.contact:
        options.append(("let it fly twice as long (from higher)", {"duration": "twice"}, start, _stretched(trial, 2.0)))
    if trial.body.mass is not None:
        for factor in (3.0, 1 / 3):
            heavy = replace(trial, body=replace(trial.body, mass=factor * trial.body.mass, inertia=None))
            options.append(
                (
                    f"use a body of the same size and {'three times' if factor > 1 else 'a third of'} the mass",
                    {"mass_kg": factor * trial.body.mass},
                    start,
                    heavy,
                )
            )
    found = []
    for text, design, new_start, new_trial in options:
        score = separation(problem, longest, final, other, new_start, new_trial)
        if np.isfinite(score):
            found.append((score, text, design))
    return found


def _with(start, velocity=1.0, spin=1.0):
    start = start.copy()
    start[3:6] *= velocity
    start[10:13] *= spin
    return start


def _turned(start, turn):
    start = start.copy()
    start[3:6], start[10:13] = rotations.rotate(turn, start[3:6]), rotations.rotate(turn, start[10:13])
    return start


def _stretched(trial, factor):
    """The trial with samples at the same rate for a longer time."""
    step, count = float(np.median(np.diff(trial.times))), int(factor * len(trial.times))
    times = trial.times[0] + step * np.arange(count)
    return Trial(
        trial.name,
        trial.group,
        times,
        np.resize(np.nan_to_num(trial.position), (count, 3)),
        np.resize(trial.orientation, (count, 4)),
        trial.start,
        trial.body,
        trial.surroundings,
    )


def separation(problem, index, final, other, start, trial):
    """lambda of one test: |y_A - y_B|^2 in units of the noise, start and B's own numbers free as far as the data let them."""
    measured = np.where(np.isfinite(problem.trials[index].position).any(axis=0), 0.0, np.nan)
    trial = replace(trial, position=np.tile(measured, (len(trial.times), 1)))
    simulator = Simulator(
        final.model,
        (trial,),
        problem.simulator.start_time[index : index + 1],
        problem.simulator.contact,
        problem.simulator.time_step,
        problem.simulator.seated[index : index + 1],
    )
    simulator.height_range = problem.simulator.height_range
    small = TrajectoryProblem((trial,), problem.noise, simulator)
    initial_states = start[None]
    with np.errstate(all="ignore"):
        linear = small.linearise(other.model, initial_states)
        mine = small.residuals(final.model, initial_states)[0]
    difference = whiten(small.recordings[0].whitening, linear.raw[0] - mine)
    if not np.isfinite(difference).all():
        return np.nan
    rest = project_out(linear.state_bases[0], difference)
    s = project_out(linear.state_bases[0], linear.parameter_columns[0])
    # B's numbers may move within what the present data allow: (I + S C S^T)^-1 in its cheap form
    prior = np.linalg.pinv(other.covariance) if other.covariance.size else np.zeros((0, 0))
    inner = s.T @ s + prior
    return float(rest @ rest - (s.T @ rest) @ np.linalg.lstsq(inner, s.T @ rest, rcond=None)[0])
