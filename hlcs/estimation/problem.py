"""The problem that every kind of measurement poses to a search: whitened residuals, derivatives, and Gauss-Newton fits of them.

Shared numbers (the parameters of effects) and initial states are refined together; the initial states are then projected
out, so that everything downstream sees, per recording, a white residual and white signatures without the freedom of the state.
"""

from dataclasses import replace

import numpy as np

from hlcs.estimation.least_squares import bounded_least_squares, least_squares, null_prior, project_out
from hlcs.estimation.linearization import Fit, free_numbers
from hlcs.estimation.whitening import whiten
from hlcs.simulation.batching import run_tasks
from hlcs.simulation.initial_state import stepped

CLEAR = 20.0  # norm of the white change of the observations at which a derivative through contacts stands clear of their noise
WIDE = 0.05  # widest step of a derivative through contacts, part of the range of the number


class Problem:
    """Base of the problems: what is common once residuals and linearisation are known.

    A kind of measurement sets `trials`, `noise`, `simulator`, `recordings`, `unit` (of the error as it is told) and
    `difference_steps` ({}), and defines `initial_guess()`, `residuals(model, initial_states)` and
    `linearise(model, initial_states)`.
    """

    @property
    def segmented(self):
        """Are the recordings segments of longer ones?"""
        return any(trial.recording for trial in self.trials)

    @property
    def difference_scale(self):
        """Size of finite differences relative to the smooth case: contacts need wider ones."""
        return 10.0 if self.simulator.contact else 1.0

    def batched(self, functions):
        """[function() for function in functions]; what they simulate with contacts on the way is simulated in batches."""
        if self.simulator.contact:
            return run_tasks(self.simulator.simulate_all, functions)
        return [function() for function in functions]

    # --- derivatives ----------------------------------------------------------------------------------------------------------

    def signature(self, model, initial_states, plus):
        """White change of the observations from a model to the model `plus`, list of (n_i,)."""
        before, after = self.residuals(model, initial_states), self.residuals(plus, initial_states)
        return [whiten(recording.whitening, a - b) for recording, a, b in zip(self.recordings, before, after, strict=True)]

    def derivative(self, name, free, value, moved, linear, initial_states, reach=WIDE):
        """White change of the observations per unit of a free number at `value`, list of (n_i,), and what the initial states do
        along with it, list of (unknowns_i,); moved: value -> model; linear: at the value.

        Runs with contacts answer a small change with some noise of their own (which sweep converged, which step stopped the
        body), so there the step is widened until the change, less what the initial states absorb, stands clear of it. A wide step
        moves the impacts, so there the initial states go along by what would absorb the change: what a fit would see is left.
        reach: part of the range between its bounds that the widest step may span.
        """
        amount = self.difference_steps.get((name, free.name)) or difference_step(free, value) * self.difference_scale
        widest = reach * min(free.high - free.low, 1e3)

        def change(step, states):
            after = self.residuals(moved(value + step), states)
            return [whiten(rec.whitening, a - b) for rec, a, b in zip(self.recordings, linear.raw, after, strict=True)]

        def size(changes):
            left = [np.sum(project_out(q, part) ** 2) for q, part in zip(linear.state_bases, changes, strict=True)]
            return float(np.sqrt(sum(left)))

        while True:
            step = -amount if value + amount > free.high and free.period is None else amount
            changes = change(step, initial_states)
            if not self.simulator.contact or not size(changes) < CLEAR or amount >= widest:
                break
            amount = min(amount * float(np.clip(1.5 * CLEAR / max(size(changes), 1e-9), 2.0, 30.0)), widest)
        self.difference_steps[name, free.name] = min(amount, widest * WIDE / reach)
        moves = [np.zeros(columns.shape[1]) for columns in linear.state_columns]
        if self.simulator.contact and any(len(move) for move in moves) and np.isfinite(size(changes)):
            along = [
                -least_squares(columns, part).estimate if columns.shape[1] else np.zeros(0)
                for columns, part in zip(linear.state_columns, changes, strict=True)
            ]
            followed = change(step, self._stepped(initial_states, along))
            if size(followed) < size(changes):
                changes, moves = followed, along
        return [part / step for part in changes], [move / step for move in moves]

    def _stepped(self, initial_states, moves, share=1.0):
        """Initial states after a share of the moves of their unknowns, (trials, 13)."""
        return np.array(
            [
                stepped(state, recording.unknown, share * move)
                for state, recording, move in zip(initial_states, self.recordings, moves, strict=True)
            ]
        )

    # --- Gauss-Newton ---------------------------------------------------------------------------------------------------------

    def fit(self, model, initial_states=None, iterations=12):
        """Fit of the model's free numbers and of all initial states; keeps to the bounds."""
        close = 0.3 if self.simulator.contact else 0.02  # fall of chi2 below which a further step is not worth its simulations
        initial_states = self.initial_guess() if initial_states is None else initial_states.copy()
        linear = self.linearise(model, initial_states)
        chi2 = sum(float(r @ r) for r in linear.white)
        for _ in range(iterations):
            values = values_of(model)
            step, state_steps, promised = self._newton_step(linear, model, values)
            if promised < close + 1e-6 * chi2:
                break
            factor = 1.0
            while factor > 0.02:
                new_model = with_values(model, values + factor * step)
                new_states, new_chi2 = self._moved(new_model, initial_states, state_steps, factor)
                if new_chi2 < chi2:  # never true of a run that left the finite numbers
                    break
                factor *= 0.35
            else:
                break
            model, initial_states = new_model, new_states
            linear = self.linearise(model, initial_states)
            gained, chi2 = chi2 - new_chi2, new_chi2
            if gained < close + 1e-6 * chi2:
                break
        return self.fit_at(model, initial_states, linear)

    def _newton_step(self, linear, model, values):
        """(step of the free numbers, list of steps of the initial states, promised fall of chi2), numbers kept within bounds."""
        step = bounded_least_squares(*linear.projected, values, free_numbers(model))
        state_steps, promised = [], 0.0
        for k, (r, n, s) in enumerate(zip(linear.white, linear.state_columns, linear.parameter_columns, strict=True)):
            rest = r - s @ step
            move = least_squares(n, rest).estimate if n.shape[1] else np.zeros(0)
            state_steps.append(move if linear.state_moves is None else move + linear.state_moves[k] @ step)
            promised += float(r @ r) - float(np.sum((rest - n @ move) ** 2))
        return step, state_steps, promised

    def _moved(self, model, initial_states, moves, factor):
        """(initial states, chi2) after a part of their moves; segments of a tumble, each with a way of its own, may take less."""
        shares = (factor, 0.3 * factor, 0.0) if self.segmented else (factor,)
        options = np.array([self._stepped(initial_states, moves, share) for share in shares])
        losses = np.array(
            [
                [
                    float(np.sum(whiten(recording.whitening, part) ** 2))
                    for recording, part in zip(self.recordings, self.residuals(model, option), strict=True)
                ]
                for option in options
            ]
        )
        best = np.argmin(np.where(np.isfinite(losses), losses, np.inf), axis=0)
        every = np.arange(len(self.recordings))
        return options[best, every], float(losses[best, every].sum())

    def fit_at(self, model, initial_states, linear):
        """The Fit at this point, with covariance of the free numbers."""
        frees, values = free_numbers(model), values_of(model)
        r, s = linear.projected
        rows, aims = null_prior(values, frees)
        columns, aim = np.concatenate([*s, rows]), np.concatenate([*r, aims])
        covariance = np.zeros((len(frees), len(frees)))
        if len(frees) and np.isfinite(columns).all() and np.isfinite(aim).all():  # a run may leave the finite numbers
            covariance = least_squares(columns, aim).covariance
        near = [1e-6 * abs(free.high - free.low) for free in frees]
        at_bound = tuple(
            free.period is None and bool(value <= free.low + room and free.null != free.low or value >= free.high - room)
            for value, room, free in zip(values, near, frees, strict=True)
        )
        return Fit(model, initial_states, linear, values, covariance, at_bound)


def difference_step(free, value):
    """Difference for a derivative with respect to a free number."""
    span = free.high - free.low
    return 1e-4 * span if np.isfinite(span) and span < 1e5 else 1e-4 * max(abs(value), 1.0)


def values_of(model):
    """Values of the free numbers of a model's terms, in order (p,)."""
    return np.array([term.numbers[free.name] for term in model.terms for free in term.candidate.free])


def with_values(model, values):
    """The model with other values of its free numbers (p,), each kept inside its bounds."""
    terms, values = [], iter(values)
    for term in model.terms:
        found = {free.name: float(free.inside(value)) for free, value in zip(term.candidate.free, values, strict=False)}
        terms.append(term.at(term.numbers | found))
    return replace(model, terms=tuple(terms))
