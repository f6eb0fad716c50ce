"""The problem that recordings pose: which samples are observations, their residuals, and derivatives through the simulator."""

from dataclasses import replace

import numpy as np

from hlcs.data.quantities import CHANNEL_UNITS, CHANNELS, have_unit
from hlcs.effects.witnesses import Camera
from hlcs.estimation.designs import Designs, changes_of, other_bodies_tell
from hlcs.estimation.linearization import Linearization, Recording
from hlcs.estimation.problem import Problem
from hlcs.estimation.whitening import whiten
from hlcs.simulation import contact_motion
from hlcs.simulation.initial_state import initial_guess, shifted, unknowns
from hlcs.simulation.simulator import Motion, Simulator
from minibullet import rotations

STEPS = (1e-4, 1e-3, 1e-4, 1e-3)  # differences of an initial state: m, m/s, rad, rad/s
UNSEEN = 1e-5  # norm of the white change per m, m/s, rad or rad/s of a start below which it is rounding, and the start unseen


class TrajectoryProblem(Problem):
    """Trials, their noise, and the simulator that predicts them."""

    def __init__(self, trials, noise, simulator: Simulator):
        self.trials, self.noise, self.simulator = tuple(trials), noise, simulator
        self.difference_steps = {}  # (effect, number) -> step of its derivative
        self.step_change = None  # what shorter time steps add to the observations, list of (n_i,); None = not looked at
        self.dropped = [np.zeros((len(trial.times), len(CHANNELS)), bool) for trial in self.trials]
        self.lies_flat = [
            seated
            and noise.orientation is not None
            and contact_motion.lies_on_a_face(trial.body, trial.surroundings.floor_normal, trial.orientation, noise.orientation)
            for trial, seated in zip(self.trials, simulator.seated, strict=True)
        ]
        self.recordings = [self._recording(k) for k in range(len(self.trials))]
        # unit of the error as it is told: of positions; where none are measured of rotations, or of accelerations
        seen = np.concatenate([recording.channel for recording in self.recordings])
        self.unit = next((unit for unit in CHANNEL_UNITS if have_unit(seen, unit).any()), CHANNEL_UNITS[1])

    def _recording(self, index):
        trial, noise = self.trials[index], self.noise
        there = trial.measured & ~self.dropped[index]
        there[:, np.repeat([noise.of_unit(unit) is None for unit in CHANNEL_UNITS], 3)] = False
        channel, sample = np.nonzero(there.T)
        times = trial.times[sample]
        unknown = unknowns(trial, there.any(axis=0), self.simulator.seated[index], self.lies_flat[index], self.simulator.contact)
        return Recording(channel, sample, times, noise.whitening(channel, times), unknown)

    def drop(self, flags):
        """Leave isolated samples out, for every model alike: flags is a list of (n, 9) booleans."""
        self.dropped = [old | new for old, new in zip(self.dropped, flags, strict=True)]
        if self.step_change is not None:
            kept = [~flag[recording.sample, recording.channel] for flag, recording in zip(flags, self.recordings, strict=True)]
            self.step_change = [change[keep] for change, keep in zip(self.step_change, kept, strict=True)]
        self.recordings = [self._recording(k) for k in range(len(self.trials))]

    def initial_guess(self):
        """Initial states read off the first samples, (trials, 13); what the file states is taken from there."""
        known = zip(self.trials, self.simulator.start_time, self.simulator.seated, self.lies_flat, strict=True)
        return np.array([initial_guess(*trial, self.simulator.contact) for trial in known])

    def residual(self, index, trajectory):
        """Measured - model for one recording, (n_obs,) [m, rad, m/s2]; trajectory: its Motion."""
        residual = self._difference(index, trajectory)
        return residual if self.step_change is None else residual - self.step_change[index]

    def changes(self, before, after):
        """What trajectories `after` have more than trajectories `before` at the observations, list of (n_i,)."""
        return [self._difference(k, a) - self._difference(k, b) for k, (a, b) in enumerate(zip(before, after, strict=True))]

    def _difference(self, index, trajectory):
        trial, recording = self.trials[index], self.recordings[index]
        position, orientation, force = trajectory
        table = np.empty((len(trial.times), len(CHANNELS)))
        table[:, :3] = trial.position - position
        if have_unit(recording.channel, "rad").any():
            measured = np.nan_to_num(trial.orientation)
            table[:, 3:6] = rotations.logarithm(rotations.product(measured, rotations.conjugate(orientation)))
        if trial.accelerations:
            table[:, 6:] = trial.accelerations.values - force
        return table[recording.sample, recording.channel]

    def residuals(self, model, initial_states):
        """Raw residuals of every recording, list of (n_i,)."""
        with np.errstate(all="ignore"):  # a step may leave what can be; its chi2 is then not finite and it is refused
            trajectories = self.simulator.simulate(model, initial_states, np.arange(len(self.trials)))
        return [self.residual(k, trajectory) for k, trajectory in enumerate(trajectories)]

    def linearise(self, model, initial_states, only=None):
        """Linearization at this point; with `only`, of the recordings of these indices, and of their initial states alone."""
        which = np.arange(len(self.trials)) if only is None else np.asarray(only)
        perturbed, owner = [initial_states[which]], list(which)
        for k in which:
            for number in self.recordings[k].unknown:
                perturbed.append(shifted(initial_states[k], number, STEPS[number[0]] * self.difference_scale)[None])
                owner.append(k)
        trajectories = self.simulator.simulate(model, np.concatenate(perturbed), np.array(owner))
        raw = [self.residual(k, trajectory) for k, trajectory in zip(which, trajectories, strict=False)]
        place, state_columns, white = len(which), [], []
        for k, residual in zip(which, raw, strict=True):
            recording, columns = self.recordings[k], []
            for number in recording.unknown:
                change = residual - self.residual(k, trajectories[place])
                columns.append(change / (STEPS[number[0]] * self.difference_scale))
                place += 1
            table = np.nan_to_num(stacked(columns, len(residual)), posinf=0.0, neginf=0.0)  # no finite run, no derivative
            seen = whiten(recording.whitening, table)
            state_columns.append(np.where(np.linalg.norm(seen, axis=0) > UNSEEN, seen, 0.0))
            white.append(whiten(recording.whitening, residual))
        unperturbed = [  # not the whole batch
            Motion(*(None if part is None else part.copy() for part in motion)) for motion in trajectories[: len(which)]
        ]
        none = [stacked([], len(residual)) for residual in raw]
        linear = Linearization(raw, white, state_columns, none, trajectories=unperturbed)
        return linear if only is not None else self._with_parameters(model, initial_states, linear)

    def _with_parameters(self, model, initial_states, linear):
        """A Linearization with the columns of the model's free numbers."""
        columns = [[] for _ in self.trials]
        moves = [[] for _ in self.trials]
        for index, term in enumerate(model.terms):
            for free in term.candidate.free:

                def moved(value, index=index, term=term, free=free):
                    return model.with_at(index, term.numbers | {free.name: value})

                value = term.numbers[free.name]
                changes, state_moves = self.derivative(term.name, free, value, moved, linear, initial_states)
                for k, (change, move) in enumerate(zip(changes, state_moves, strict=True)):
                    columns[k].append(change)
                    moves[k].append(move)
        return replace(
            linear,
            parameter_columns=[stacked(part, len(white)) for part, white in zip(columns, linear.white, strict=True)],
            state_moves=[stacked(part, n.shape[1]) for part, n in zip(moves, linear.state_columns, strict=True)],
        )

    # --- the next experiment --------------------------------------------------------------------------------------------------

    @property
    def camera(self):
        """What a direct reading by the same camera depends on."""
        low, high = self.simulator.height_range
        return Camera(self.noise.position or 0.0, self.noise.step, max(high - low, 0.1))

    def designs(self, final, other):
        """Designs that tell two fits apart, made of the longest recording."""
        longest = max(range(len(self.trials)), key=lambda k: (np.ptp(self.trials[k].times), self.trials[k].name))
        trial, simulator = self.trials[longest], self.simulator
        other_bodies = other_bodies_tell((*final.model.terms, *other.model.terms))
        options, starts, trials = zip(
            *changes_of(trial, final.initial_states[longest], simulator.contact, simulator.seated[longest], other_bodies),
            strict=True,
        )
        measured = np.where(np.isfinite(trial.position).any(axis=0), 0.0, np.nan)
        trials = tuple(replace(each, position=np.tile(measured, (len(each.times), 1)), recording="") for each in trials)
        count = len(trials)
        new = Simulator(
            final.model,
            trials,
            np.repeat(simulator.start_time[longest], count),
            simulator.contact,
            simulator.time_step,
            np.repeat(simulator.seated[longest], count),
        )
        new.height_range = simulator.height_range
        return Designs(TrajectoryProblem(trials, self.noise, new), np.array(starts), options)

    def worst(self, fit):
        """(where a fit misses most, in words; the same as {input: value})."""
        misfit = [float(part @ part) / max(len(part), 1) for part in fit.linearization.projected[0]]
        share = [float(part @ part) for part in fit.linearization.projected[0]]
        index = max(range(len(misfit)), key=lambda k: (np.nan_to_num(misfit[k], nan=np.inf), self.trials[k].name))
        trial, recording, white = self.trials[index], self.recordings[index], fit.linearization.projected[0][index]
        channels = {CHANNELS[c]: float(np.sum(white[recording.channel == c] ** 2)) for c in np.unique(recording.channel)}
        channel = max(sorted(channels), key=channels.get)
        name = trial.recording or trial.name
        text = (
            f"{name} (where the model misses by {np.sqrt(misfit[index]):.2g} times the noise, most in {channel}; it holds "
            f"{100 * share[index] / max(sum(share), 1e-300):.0f} % of the misfit)"
        )
        return text, {"repeat": name}


def stacked(columns, rows):
    """Columns (rows,) beside each other, (rows, k); k may be 0."""
    return np.column_stack(columns) if columns else np.zeros((rows, 0))
