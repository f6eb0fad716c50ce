"""The problem that recordings pose: which samples are observations, their residuals, and derivatives through the simulator."""

from copy import copy
from dataclasses import replace
from functools import cache, partial

import numpy as np

from hlcs.data.quantities import CHANNEL_UNITS, CHANNELS, have_unit
from hlcs.data.turns import continued
from hlcs.effects.witnesses import Camera
from hlcs.estimation.designs import DEEP, FURTHER, HIGH, Designs, changes_of, other_bodies_tell
from hlcs.estimation.fitting import chi2_of
from hlcs.estimation.linearization import Linearization, Recording, free_numbers, varied
from hlcs.estimation.problem import Problem
from hlcs.estimation.whitening import whiten
from hlcs.simulation.contact_motion import lies_on_a_face
from hlcs.simulation.initial_state import initial_guess, shifted, unknowns
from hlcs.simulation.simulator import Motion, Simulator
from minibullet import rotations

SAID = dict(
    zip(
        CHANNELS,
        [*"xyz", *(f"the {what} {axis}" for what in ("rotation about", "acceleration along") for axis in "xyz")],
        strict=True,
    )
)
LEVEL = 0.9999995  # z of the normal of a floor that is stated to be level: to 1 mm/m
SLACK = 1.1  # for the noise and the fit of the furthest and the deepest path that was recorded
STEPS = (1e-4, 1e-3, 1e-4, 1e-3)  # differences of an initial state: m, m/s, rad, rad/s
UNSEEN_START = 1e-5  # norm of the white change per m, m/s, rad or rad/s of a start below which it is rounding
LEAST_BEGUN = 8  # samples of a recording that a fit begins with: its unknown start takes up to six


class TrajectoryProblem(Problem):
    """Trials, their noise, and the simulator that predicts them."""

    def __init__(self, trials, noise, simulator: Simulator):
        self.trials, self.noise, self.simulator = tuple(trials), noise, simulator
        self.difference_steps = {}  # (effect, number) -> step of its derivative
        self.starts_stated = True  # is what the file states of starts known?
        self.summed = False  # are accelerations compared by their running sums?
        self.step_change = None  # what shorter time steps add to the observations, list of (n_i,); None = not looked at
        self.dropped = [np.zeros((len(trial.times), len(CHANNELS)), bool) for trial in self.trials]
        self.lies_flat = [seated and flat(trial, noise) for trial, seated in zip(self.trials, simulator.seated, strict=True)]
        self.recordings = [self._recording(k) for k in range(len(self.trials))]
        # unit of the error as it is told: of positions; where none are measured of rotations, or of accelerations
        seen = np.concatenate([recording.channel for recording in self.recordings])
        self.unit = next((unit for unit in CHANNEL_UNITS if have_unit(seen, unit).any()), CHANNEL_UNITS[1])

    @property
    def segmented(self):
        """Are the recordings segments of longer ones?"""
        return any(trial.recording for trial in self.trials)

    def _recording(self, index):
        trial, noise = self.trials[index], self.noise
        there = trial.measured & ~self.dropped[index]
        there[:, np.repeat([noise.of_unit(unit) is None for unit in CHANNEL_UNITS], 3)] = False
        channel, sample = np.nonzero(there.T)
        times = trial.times[sample]
        turns = {
            key: trial.start[key] for key in ("orientation", "angular_velocity") if key in trial.start and not there[:, 3].any()
        }
        known = trial if self.starts_stated else replace(trial, start=turns)
        unknown = unknowns(known, there.any(axis=0), self.simulator.seated[index], self.lies_flat[index], self.contact)
        # through contacts columns are rough: how much they tell of a start differs by chance from model to model
        spreads = None if self.contact else belief_in(unknown, trial)
        return Recording(channel, sample, times, noise.whitening(channel, times), unknown, spreads)

    def with_noise(self, noise):
        """The same problem with another Noise of the same channels."""
        return self._with(noise=noise)

    def _with(self, **changes):
        """The same problem with other attributes."""
        other = copy(self)
        vars(other).update(changes, difference_steps=dict(self.difference_steps))
        other.recordings = [other._recording(k) for k in range(len(self.trials))]
        return other

    def with_starts_fitted(self):
        """The same problem with all starts fitted, stated or not, as far as the data show them; None where all are fitted."""
        other = self._with(starts_stated=False)
        same = all(len(a.unknown) == len(b.unknown) for a, b in zip(self.recordings, other.recordings, strict=True))
        return None if same else other

    def fit(self, model, initial_states=None, limit=None):
        """As in `Problem`. An acceleration leaps where a body stops or hits, and no derivative tells that it should do so later:
        such a fit begins where the running sums of the readings, which only bend there, are fitted best. Where turns have gone
        round minima are many: such a fit begins with the first samples."""
        if not self.summed and self.leaps:
            begun = self._with(summed=True, step_change=None).fit(model, initial_states)
            model, initial_states = begun.model, begun.initial_states
        elif initial_states is not None and self.may_go_round and free_numbers(model):
            model, initial_states = self.begun(model, initial_states)
        return super().fit(model, initial_states, limit)

    @property
    def may_go_round(self):
        """Can turns be missed by more than half a turn, so that minima are many: measured ones, through contacts, and of whole
        recordings?"""
        turns = any(have_unit(recording.channel, "rad").any() for recording in self.recordings)
        return turns and self.contact and not self.segmented

    def begun(self, model, initial_states):
        """(Model, initial states) to begin a fit from: these, or where turns have gone round those of a fit of the first samples,
        where it is nearer to all."""
        raw = self.residuals(model, initial_states)
        turns = [part[have_unit(recording.channel, "rad")] for part, recording in zip(raw, self.recordings, strict=True)]
        if not any(np.abs(part).max(initial=0.0) > np.pi for part in turns):
            return model, initial_states
        fit = Problem.fit(self.beginning(), model, self.initial_guess())
        chi2 = [chi2_of(self.whitened(each)).sum() for each in (raw, self.residuals(fit.model, fit.initial_states))]
        return (fit.model, fit.initial_states) if chi2[1] < chi2[0] else (model, initial_states)

    def beginning(self):
        """The same problem with the samples of the first quarter of each recording."""
        later = [np.arange(len(trial.times)) >= max(len(trial.times) // 4, LEAST_BEGUN) for trial in self.trials]
        dropped = [flags | its[:, None] for flags, its in zip(self.dropped, later, strict=True)]
        return self._with(dropped=dropped, step_change=None)

    @property
    def leaps(self):
        """Do readings leap where a body stops or hits? A step ends right where the next reading begins to leap, and from there a
        derivative to one side says nothing of the other."""
        return self.contact and any(trial.accelerations for trial in self.trials)

    def leave_out(self, flags):
        """Leave isolated samples out, these and no others, for every model alike: flags is a list of (n, 9) booleans."""
        former, self.dropped = self.dropped, list(flags)
        if any((old & ~new).any() for old, new in zip(former, flags, strict=True)):
            self.step_change = None  # it is not known of what comes back
        if self.step_change is not None:
            kept = [~flag[recording.sample, recording.channel] for flag, recording in zip(flags, self.recordings, strict=True)]
            self.step_change = [change[keep] for change, keep in zip(self.step_change, kept, strict=True)]
        self.recordings = [self._recording(k) for k in range(len(self.trials))]

    def initial_guess(self):
        """Initial states read off the first samples, (trials, 13); what the file states is taken from there."""
        known = zip(self.trials, self.simulator.start_time, self.simulator.seated, self.lies_flat, strict=True)
        return np.array([initial_guess(*trial, self.contact) for trial in known])

    def residuals_of(self, owner, trajectories):
        """Measured - model at the observations of runs, list of (n_obs,) [m, rad, m/s2]; trajectories: their Motions; owner:
        recording of each, in any order."""
        runs, found = {}, [None] * len(owner)
        for run, index in enumerate(owner):
            runs.setdefault(int(index), []).append(run)
        for index, its in runs.items():
            for run, difference in zip(its, self._differences(index, [trajectories[run] for run in its]), strict=True):
                found[run] = difference if self.step_change is None else difference - self.step_change[index]
        return found

    def changes(self, before, after):
        """What trajectories `after` have more than trajectories `before` at the observations, list of (n_i,)."""
        missed = (self._differences(k, pair) for k, pair in enumerate(zip(before, after, strict=True)))
        return [by_before - by_after for by_before, by_after in missed]

    def _differences(self, index, trajectories):
        """Measured - model at the observations of one recording for several runs of it, (runs, n_obs)."""
        trial, recording = self.trials[index], self.recordings[index]
        position, orientation, force = zip(*trajectories, strict=True)
        table = np.empty((len(trajectories), len(trial.times), len(CHANNELS)))
        table[..., :3] = trial.position - np.stack(position)
        if have_unit(recording.channel, "rad").any():
            seen = np.isfinite(trial.orientation[:, 0])
            there = rotations.conjugate(np.stack(orientation)[:, seen])
            table[:, seen, 3:6] = continued(rotations.logarithm(rotations.product(trial.orientation[seen], there)))
        if trial.accelerations:
            table[..., 6:] = trial.accelerations.values - np.stack(force)
            if self.summed:
                read = ~np.isnan(trial.accelerations.values)
                table[..., 6:] = np.cumsum(np.where(read, table[..., 6:], 0.0), axis=1) / np.sqrt(len(read))
        return table[:, recording.sample, recording.channel]

    def residuals(self, model, initial_states):
        """Raw residuals of every recording, list of (n_i,)."""
        return self.residuals_at(model, [initial_states])[0]

    def residuals_at(self, model, options):
        """As in `Problem`, all simulated beside each other: most of what a step costs, it costs for one body as for many."""
        count = len(self.trials)
        with np.errstate(all="ignore"):  # a step may leave what can be; its chi2 is then not finite and it is refused
            trajectories = self.simulator.simulate(model, np.concatenate(options), np.tile(np.arange(count), len(options)))
        residuals = self.residuals_of(np.tile(np.arange(count), len(options)), trajectories)
        return [residuals[first : first + count] for first in range(0, len(residuals), count)]

    def linearise(self, model, initial_states, only=None):
        """Linearization at this point; with `only`, of the recordings of these indices, and of their initial states alone."""
        if only is not None:
            return self._along_states(model, initial_states, np.asarray(only))
        linear = cache(partial(self._along_states, model, initial_states, np.arange(len(self.trials))))
        looks = [partial(self.derivative, *number, linear, initial_states) for number in varied(model)]
        linear, *found = self.batched([linear, *looks])  # the first one is known before the others ask for it
        columns, moves = ([[each[part][k] for each in found] for k in range(len(self.trials))] for part in (0, 1))
        return replace(
            linear,
            parameter_columns=[stacked(part, len(white)) for part, white in zip(columns, linear.white, strict=True)],
            state_moves=[stacked(part, n.shape[1]) for part, n in zip(moves, linear.state_columns, strict=True)],
        )

    def _along_states(self, model, initial_states, which):
        """Linearization of the recordings of these indices in their initial states alone."""
        perturbed, owner = [initial_states[which]], list(which)
        # a velocity across all that is measured acts by its square: to one side there seems to be a slope
        sides = (1, -1) if self.leaps or any(trial.unplaced for trial in self.trials) else (1,)
        for k in which:
            for number in self.recordings[k].unknown:
                step = STEPS[number[0]] * self.difference_scale
                perturbed += [shifted(initial_states[k], number, side * step)[None] for side in sides]
                owner += [k] * len(sides)
        trajectories = self.simulator.simulate(model, np.concatenate(perturbed), np.array(owner))
        residuals = self.residuals_of(owner, trajectories)
        raw = residuals[: len(which)]
        beside, state_columns, white = iter(residuals[len(which) :]), [], []
        for k, residual in zip(which, raw, strict=True):
            recording, columns = self.recordings[k], []
            for number in recording.unknown:
                ahead = next(beside)
                behind = residual if len(sides) == 1 else next(beside)
                columns.append((behind - ahead) / (len(sides) * STEPS[number[0]] * self.difference_scale))
            table = np.nan_to_num(stacked(columns, len(residual)), posinf=0.0, neginf=0.0)  # no finite run, no derivative
            seen = whiten(recording.whitening, table)
            state_columns.append(np.where(np.linalg.norm(seen, axis=0) > UNSEEN_START, seen, 0.0))
            white.append(whiten(recording.whitening, residual))
        unperturbed = [  # not the whole batch
            Motion(*(None if part is None else part.copy() for part in motion)) for motion in trajectories[: len(which)]
        ]
        none = [stacked([], len(residual)) for residual in raw]
        spreads = [self.recordings[k].spreads for k in which]
        return Linearization(raw, white, state_columns, none, trajectories=unperturbed, state_spreads=spreads)

    # --- the next experiment --------------------------------------------------------------------------------------------------

    @property
    def camera(self):
        """What a direct reading by the same camera depends on."""
        there = np.concatenate([trial.position for trial in self.trials])
        surroundings = [trial.surroundings for trial in self.trials]
        return Camera(
            self.noise.position or 0.0,
            self.noise.step,
            max(span_of(there), 0.1),
            upright=bool(np.isfinite(there[:, 2]).any()),
            touching=bool(np.any(self.simulator.seated)),
            level=all(one.floor_normal[2] > LEVEL for one in surroundings),
            liquid=any(one.in_liquid for one in surroundings),
        )

    def designs(self, final, other):
        """Designs that tell two fits apart, made of the longest recording; a segment only where a recording begins with it."""
        first = [k for k in range(len(self.trials)) if self.trials[k].first_row == 0]
        longest = max(first, key=lambda k: (np.ptp(self.trials[k].times), self.trials[k].name))
        trial, start, seated = self.trials[longest], final.initial_states[longest], bool(self.simulator.seated[longest])
        other_bodies = other_bodies_tell((*final.model.terms, *other.model.terms))
        designs, starts, trials = zip(*changes_of(trial, start, self.contact, seated, other_bodies), strict=True)
        new, starts = self._changed(final.model, longest, trials), np.array(starts)
        with np.errstate(all="ignore"):
            paths = [motion.position for motion in new.simulate(final.model, starts, np.arange(len(starts)))]
        kept = [k for k, path in enumerate(paths) if k == 0 or self._in_view(path)]  # the first repeats what there is
        options = [told_how_high(designs[k], paths[0], paths[k]) for k in kept]
        trials = [self._unread(trials[k]) for k in kept]
        problem = TrajectoryProblem(trials, self.noise, self._changed(final.model, longest, trials))
        return Designs(problem, starts[kept], tuple(options))

    def _changed(self, model, like, trials):
        """A Simulator of trials that are made like one of these."""
        old, count = self.simulator, len(trials)
        return old.for_trials(model, trials, *(np.repeat(each[like], count) for each in old.of_trials))

    @staticmethod
    def _unread(trial):
        """A trial with the channels that were measured, of no account what it measures."""
        measured = np.where(np.isfinite(trial.position).any(axis=0), 0.0, np.nan)
        return replace(trial, position=np.tile(measured, (len(trial.times), 1)), recording="")

    def _in_view(self, path):
        """Does a path (n, 3) stay where the same camera, in the same house or tank, can see it?"""
        ways = [trial.position - first_seen(trial.position) for trial in self.trials]
        furthest = max(float(np.nanmax(np.abs(way), initial=0.0)) for way in ways)
        deepest = max(float(np.nanmax(-way[:, 2], initial=0.0)) for way in ways)
        room = DEEP if any(trial.surroundings.in_liquid for trial in self.trials) else HIGH
        way = path - path[0]
        return bool(np.max(np.abs(way)) <= SLACK * FURTHER * furthest and np.max(-way[:, 2]) <= max(room, SLACK * deepest))

    def worst(self, fit):
        """(where a fit misses most, in words; the same as {input: value})."""
        share = fit.chi2_per_recording
        misfit = [left / max(len(recording.times), 1) for left, recording in zip(share, self.recordings, strict=True)]
        index = max(range(len(misfit)), key=lambda k: (np.nan_to_num(misfit[k], nan=np.inf), self.trials[k].name))
        trial, recording, white = self.trials[index], self.recordings[index], fit.linearization.projected[0][index]
        channels = {CHANNELS[c]: float(np.sum(white[recording.channel == c] ** 2)) for c in np.unique(recording.channel)}
        channel = max(sorted(channels), key=channels.get)
        name = trial.whole
        text = (
            f"{name} (where the model misses by {np.sqrt(misfit[index]):.2g} times the noise, most in {SAID[channel]}; it holds "
            f"{100 * share[index] / max(sum(share), 1e-300):.0f} % of the misfit)"
        )
        return text, {"repeat": name}


def flat(trial, noise):
    """Does a body show that it lies on a face, on its floor as it is stated?"""
    normal, sigma = trial.surroundings.floor_normal, noise.orientation
    return sigma is not None and lies_on_a_face(trial.body, normal, trial.orientation, sigma)


def span_of(position):
    """How far positions (n, 3) reach along the axis on which they reach farthest [m]; 0 where none was seen."""
    there = [axis[np.isfinite(axis)] for axis in position.T]
    return max([float(np.ptp(axis)) for axis in there if len(axis)], default=0.0)


def belief_in(unknown, trial):
    """How wide the belief in each unknown of the initial state of a trial is, (unknowns,) [m, m/s, rad, rad/s]: it moves by what
    is seen to be moved, or by a metre, and turns by a radian, in the time of the recording."""
    reach = span_of(trial.position) or 1.0
    time = max(float(np.ptp(trial.times)), 1e-9)
    of_slots = (reach, reach / time, 1.0, 1.0 / time)
    return np.array([of_slots[slot] for slot, _ in unknown])


def first_seen(position):
    """The first seen place on each axis of positions (n, 3); NaN on an axis that none was seen on."""
    there = np.isfinite(position)
    return np.where(there.any(axis=0), position[there.argmax(axis=0), np.arange(3)], np.nan)


def told_how_high(design, path, longer):
    """A Design of a longer flight that says from how much higher, given the path that was flown and the longer one (n, 3)."""
    down = float(path[-1, 2] - longer[-1, 2])
    if "duration" not in design.what or down <= 0:
        return design
    return design._replace(text=f"{design.text}, from {down:.2g} m higher")


def stacked(columns, rows):
    """Columns (rows,) beside each other, (rows, k); k may be 0."""
    return np.column_stack(columns) if columns else np.zeros((rows, 0))
