"""Fitting the model to recordings: whitened residuals, one unknown start per recording, Gauss-Newton through the simulator.

Shared numbers (the parameters of effects) and starts are refined together; the starts are then projected out, so that
everything downstream sees, per recording, a white residual and white signatures with the freedom of the start removed.
"""

import numpy as np
from scipy import optimize

from hlcs.estimation import inference
from hlcs.estimation.effort import cut
from hlcs.estimation.linearization import Fit, Linear, Recording
from hlcs.simulation import contact_motion
from hlcs.simulation.batching import together
from hlcs.simulation.initial_state import guess, shifted, stepped, unknowns
from hlcs.simulation.model import Model
from hlcs.simulation.simulator import Shots
from minibullet import rotations

CHANNELS = ("x", "y", "z", "rx", "ry", "rz")
CLEAR = 20.0  # norm of the white change of the observations at which a derivative through contacts stands clear of their noise
WIDE = 0.05  # widest step of a derivative through contacts, part of the range of the number
STEPS = (1e-4, 1e-3, 1e-4, 1e-3)  # differences of a start: m, m/s, rad, rad/s


class Problem:
    """Trials, their noise, and the simulator that predicts them."""

    unit = "m"  # of the error as it is told: positions; "rad" where only orientations are measured

    def __init__(self, trials, noise, shots: Shots):
        self.trials, self.noise, self.shots = tuple(trials), noise, shots
        self.amounts = {}  # (effect, number) -> step of its derivative
        self.dropped = [np.zeros((len(trial.times), 6), bool) for trial in self.trials]
        self.flat = [
            seated
            and noise.orientation is not None
            and contact_motion.lies_on_a_face(trial.body, trial.surroundings.floor_normal, trial.orientation, noise.orientation)
            for trial, seated in zip(self.trials, shots.seated, strict=True)
        ]
        self.recordings = [self._recording(k) for k in range(len(self.trials))]
        if not any((recording.channel < 3).any() for recording in self.recordings):
            self.unit = "rad"

    def _recording(self, index):
        trial, noise = self.trials[index], self.noise
        there = np.concatenate([np.isfinite(trial.position), np.repeat(np.isfinite(trial.orientation[:, :1]), 3, axis=1)], axis=1)
        there &= ~self.dropped[index]
        if noise.orientation is None:
            there[:, 3:] = False
        if noise.position is None:
            there[:, :3] = False
        channel, sample = np.nonzero(there.T)
        times = trial.times[sample]
        unknown = unknowns(trial, there.any(axis=0), self.shots.seated[index], self.flat[index], self.shots.contact)
        return Recording(channel, sample, times, noise.chain(channel, times), unknown)

    def drop(self, flags):
        """Leave isolated samples out, for every model alike: flags is a list of (n, 6) booleans."""
        self.dropped = [old | new for old, new in zip(self.dropped, flags, strict=True)]
        self.recordings = [self._recording(k) for k in range(len(self.trials))]

    def at_once(self, functions):
        """[function() for function in functions]; what they simulate on the way runs side by side."""
        return together(self.shots.simulate_all, functions) if self.shots.contact else [function() for function in functions]

    # --- residuals ------------------------------------------------------------------------------------------------------------

    def residual(self, index, answer):
        """Measured - model for one recording, (n_obs,) [m, rad]."""
        trial, recording = self.trials[index], self.recordings[index]
        position, orientation = answer
        table = np.empty((len(trial.times), 6))
        table[:, :3] = trial.position - position
        if (recording.channel >= 3).any():
            measured = np.nan_to_num(trial.orientation)
            table[:, 3:] = rotations.logarithm(rotations.product(measured, rotations.conjugate(orientation)))
        return table[recording.sample, recording.channel]

    def guess(self):
        """Starts read off the first samples, (trials, 13); what the file states is taken from there."""
        shots = self.shots
        return np.array(
            [
                guess(trial, start_time, seated, flat, shots.contact)
                for trial, start_time, seated, flat in zip(self.trials, shots.start_time, shots.seated, self.flat, strict=True)
            ]
        )

    def residuals(self, model, starts):
        """Raw residuals of every recording, list of (n_i,)."""
        with np.errstate(all="ignore"):  # a trial step may leave the plausible; its loss is then not finite and it is refused
            answers = self.shots.simulate(model, starts, np.arange(len(self.trials)))
        return [self.residual(k, answer) for k, answer in enumerate(answers)]

    def signature(self, model, starts, plus, minus=None, distance=1.0):
        """White change of the observations from `minus` (default: the model) to `plus`, per unit distance, list of (n_i,)."""
        first = self.residuals(minus if minus is not None else model, starts)
        second = self.residuals(plus, starts)
        return [
            inference.whiten(recording.links, (a - b) / distance)
            for recording, a, b in zip(self.recordings, first, second, strict=True)
        ]

    def linearise(self, model, starts, terms=True, only=None):
        """Linear at this point; `terms` False leaves the parameter columns out, `only` keeps the recordings of these indices."""
        which = np.arange(len(self.trials)) if only is None else np.asarray(only)
        rows, owner = [starts[which]], list(which)
        for k in which:
            for number in self.recordings[k].unknown:
                rows.append(shifted(starts[k], number, STEPS[number[0]] * self.difference)[None])
                owner.append(k)
        answers = self.shots.simulate(model, np.concatenate(rows), np.array(owner))
        raw = [self.residual(k, answer) for k, answer in zip(which, answers, strict=False)]
        place, n, r = len(which), [], []
        for k, mine in zip(which, raw, strict=True):
            recording, columns = self.recordings[k], []
            for number in recording.unknown:
                columns.append((mine - self.residual(k, answers[place])) / (STEPS[number[0]] * self.difference))
                place += 1
            n.append(inference.whiten(recording.links, np.column_stack(columns)) if columns else np.zeros((len(mine), 0)))
            r.append(inference.whiten(recording.links, mine))
        if only is not None:
            return Linear(raw, r, n, [np.zeros((len(mine), 0)) for mine in raw])
        s = [[] for _ in self.trials]
        t = [[] for _ in self.trials]
        if terms:
            here = Linear(raw, r, n, s)
            for index, term in enumerate(model.terms):
                for free in term.candidate.free:

                    def moved(value, index=index, term=term, free=free):
                        return model.with_at(index, term.numbers | {free.name: value})

                    value = term.numbers[free.name]
                    columns, moves = self.derivative(term.name, free, value, moved, here, starts)
                    for k, (column, move) in enumerate(zip(columns, moves, strict=True)):
                        s[k].append(column)
                        t[k].append(move)
        s = [np.column_stack(columns) if columns else np.zeros((len(raw[k]), 0)) for k, columns in enumerate(s)]
        t = [np.column_stack(moves) if moves else np.zeros((n[k].shape[1], 0)) for k, moves in enumerate(t)]
        kept = [(position.copy(), turn.copy()) for position, turn in answers[: len(which)]]  # they are parts of the whole batch
        return Linear(raw, r, n, s, t, kept)

    @property
    def difference(self):
        """Size of finite differences relative to the smooth case: contacts need wider ones."""
        return 10.0 if self.shots.contact else 1.0

    def derivative(self, name, free, value, moved, linear, starts, reach=WIDE):
        """White change of the observations per unit of a free number at `value`, list of (n_i,), and what the starts do along
        with it, list of (unknowns_i,); moved: value -> model; linear: at the value.

        Runs with contacts answer a small change with some noise of their own (which sweep converged, which step stopped the
        body), so there the step is widened until the change, less what the starts absorb, stands clear of it. A wide step
        moves the impacts, so there the starts go along by what would absorb the change: what a fit would see is left. reach:
        part of the range between its bounds that the widest step may span.
        """
        amount = self.amounts.get((name, free.name)) or parameter_step(free, value) * self.difference
        widest = reach * min(free.high - free.low, 1e3)

        def change(step, there):
            return [
                inference.whiten(rec.links, before - after)
                for rec, before, after in zip(
                    self.recordings, linear.raw, self.residuals(moved(value + step), there), strict=True
                )
            ]

        def size(changes):
            return float(
                np.sqrt(sum(np.sum(inference.project_out(q, part) ** 2) for q, part in zip(linear.bases, changes, strict=True)))
            )

        while True:
            step = -amount if value + amount > free.high and free.period is None else amount
            found = change(step, starts)
            if not self.shots.contact or not size(found) < CLEAR or amount >= widest:
                break
            amount = min(amount * float(np.clip(1.5 * CLEAR / max(size(found), 1e-9), 2.0, 30.0)), widest)
        self.amounts[name, free.name] = min(amount, widest * WIDE / reach)
        moves = [np.zeros(columns.shape[1]) for columns in linear.n]
        if self.shots.contact and any(len(move) for move in moves) and np.isfinite(size(found)):
            along = [
                -inference.least_squares(columns, part).estimate if columns.shape[1] else np.zeros(0)
                for columns, part in zip(linear.n, found, strict=True)
            ]
            followed = change(
                step, np.array([stepped(starts[k], recording.unknown, along[k]) for k, recording in enumerate(self.recordings)])
            )
            if size(followed) < size(found):
                found, moves = followed, along
        return [part / step for part in found], [move / step for move in moves]

    def _parameter_steps(self, model):
        """[(model with one number moved a little, by how much)] for every free number."""
        found = []
        for index, term in enumerate(model.terms):
            for free in term.candidate.free:
                value = term.numbers[free.name]
                amount = parameter_step(free, value) * self.difference
                if value + amount > free.high:
                    amount = -amount
                moved = term.at(term.numbers | {free.name: value + amount})
                found.append((model.with_at(index, moved.numbers), amount))
        return found

    # --- Gauss-Newton ---------------------------------------------------------------------------------------------------------

    def fit(self, model, starts=None, iterations=12):
        """Fit of the model's free numbers and of all starts; keeps to the bounds."""
        close = 0.3 if self.shots.contact else 0.02  # fall of chi2 below which a further step is not worth its simulations
        starts = self.guess() if starts is None else starts.copy()
        linear = self.linearise(model, starts)
        loss = sum(float(r @ r) for r in linear.r)
        frees = [(index, free) for index, term in enumerate(model.terms) for free in term.candidate.free]
        for _ in range(iterations):
            values = np.array([model.terms[index].numbers[free.name] for index, free in frees])
            step, start_steps, promised = self._newton_step(linear, values, frees)
            if promised < close + 1e-6 * loss:
                break
            factor = 1.0
            while factor > 0.02:
                trial_model = _with_values(model, frees, values + factor * step)
                trial_starts, trial_loss = self._moved(trial_model, starts, start_steps, factor)
                if trial_loss < loss:  # never true of a run that left the finite numbers
                    break
                factor *= 0.35
            else:
                break
            model, starts = trial_model, trial_starts
            linear = self.linearise(model, starts)
            gained, loss = loss - trial_loss, trial_loss
            if gained < close + 1e-6 * loss:
                break
        return self.finished(model, starts, linear)

    def _moved(self, model, starts, moves, factor):
        """(starts, loss) after a part of their moves; pieces of a tumble, each with a way of its own, may take less of it."""
        shares = (factor, 0.3 * factor, 0.0) if cut(self) else (factor,)
        options = np.array(
            [
                [
                    stepped(start, recording.unknown, share * move)
                    for start, recording, move in zip(starts, self.recordings, moves, strict=True)
                ]
                for share in shares
            ]
        )
        losses = np.array(
            [
                [
                    float(np.sum(inference.whiten(recording.links, part) ** 2))
                    for recording, part in zip(self.recordings, self.residuals(model, option), strict=True)
                ]
                for option in options
            ]
        )
        best = np.argmin(np.where(np.isfinite(losses), losses, np.inf), axis=0)
        every = np.arange(len(self.recordings))
        return options[best, every], float(losses[best, every].sum())

    def finished(self, model, starts, linear):
        """The Fit at this point, with covariance of the free numbers."""
        frees = [(index, free) for index, term in enumerate(model.terms) for free in term.candidate.free]
        values = np.array([model.terms[index].numbers[free.name] for index, free in frees])
        r, s = linear.projected
        rows, aims = towards_null(values, [free for _, free in frees])
        columns, aim = np.concatenate([*s, rows]), np.concatenate([*r, aims])
        covariance = np.zeros((len(frees), len(frees)))
        if len(frees) and np.isfinite(columns).all() and np.isfinite(aim).all():  # a run may leave the finite numbers
            covariance = inference.least_squares(columns, aim).covariance
        near = [1e-6 * abs(free.high - free.low) for _, free in frees]
        at_bound = tuple(
            free.period is None and bool(value <= free.low + room and free.null != free.low or value >= free.high - room)
            for value, room, (_, free) in zip(values, near, frees, strict=True)
        )
        return Fit(model, starts, linear, values, covariance, at_bound)

    def _newton_step(self, linear, values, frees):
        """(step of the free numbers, list of steps of the starts, promised fall of chi2), numbers kept within bounds."""
        step = self.bounded_step(linear, values, [free for _, free in frees])
        starts, promised = [], 0.0
        for k, (rec_r, rec_n, rec_s) in enumerate(zip(linear.r, linear.n, linear.s, strict=True)):
            rest = rec_r - rec_s @ step
            move = inference.least_squares(rec_n, rest).estimate if rec_n.shape[1] else np.zeros(0)
            starts.append(move if linear.t is None else move + linear.t[k] @ step)
            promised += float(rec_r @ rec_r) - float(np.sum((rest - rec_n @ move) ** 2))
        return step, starts, promised

    @staticmethod
    def bounded_step(linear, values, frees):
        """Least-squares step of numbers at `values` (p,) that keeps them within the bounds of their Free entries, (p,)."""
        r, s = linear.projected
        rows, aims = towards_null(values, frees)
        r, s = np.concatenate([*r, aims]), np.concatenate([*s, rows])
        low = np.array([free.low if free.period is None else -np.inf for free in frees])
        high = np.array([free.high if free.period is None else np.inf for free in frees])
        step = inference.least_squares(s, r).estimate if len(frees) else np.zeros(0)
        if ((values + step >= low) & (values + step <= high)).all() or not np.isfinite(s).all():
            return step
        bounds = np.minimum(low - values, 0.0), np.maximum(high - values, 0.0)
        return optimize.lsq_linear(s, r, bounds, method="bvls").x


def towards_null(values, frees):
    """Rows (p, p) and aims (p,) for least squares that keep near its null value what the data do not show.

    They count as much as one observation that says: within its bounds. What the data do show they leave alone.
    """
    width = np.array([min(free.high - free.low, 1e6) for free in frees])
    null = np.array([value if free.null is None else free.null for value, free in zip(values, frees, strict=True)])
    return np.diag(1 / width) if frees else np.zeros((0, 0)), (null - values) / width if frees else np.zeros(0)


def parameter_step(free, value):
    """Difference for a derivative with respect to a free number."""
    span = free.high - free.low
    return 1e-4 * span if np.isfinite(span) and span < 1e5 else 1e-4 * max(abs(value), 1.0)


def _with_values(model, frees, values):
    terms = list(model.terms)
    for (index, free), value in zip(frees, values, strict=True):
        terms[index] = terms[index].at(terms[index].numbers | {free.name: float(free.inside(value))})
    return Model(tuple(terms), model.fixed, model.own, model.time_step)
