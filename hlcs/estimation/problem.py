"""The problem that every kind of measurement poses to a search: whitened residuals, their derivatives, and fits of them.

Shared numbers (the parameters of effects) are fitted to all recordings; the initial state of each follows them and is then
projected out, so that everything downstream sees, per recording, a white residual and white signatures without its freedom.
"""

import numpy as np

from hlcs.data.quantities import have_unit
from hlcs.effects.contract import in_sessions
from hlcs.effects.witnesses import direct_reading
from hlcs.estimation import fitting, segment_profiles
from hlcs.estimation.least_squares import least_squares
from hlcs.estimation.linearization import free_numbers, width_of
from hlcs.estimation.whitening import colour, whiten
from hlcs.simulation.batching import run_tasks
from hlcs.simulation.initial_state import stepped

LEAST_CHANGE = 20.0  # white norm of the change of the observations from which a derivative through contacts shows
MOST_CHANGE = 200.0  # white norm above which a step that was widened elsewhere is too wide here: it leads past impacts
WIDE = 0.05  # widest step of a derivative through contacts, part of the range of the number


class Problem:
    """Base of the problems: what is common once residuals and linearisation are known.

    A kind of measurement sets `trials`, `noise`, `simulator`, `recordings`, `unit` (of the error as it is told) and
    `difference_steps` ({}, for contacts, which answer with some noise of their own), and defines `initial_guess()`,
    `residuals(model, initial_states)` and `linearise(model, initial_states)`.
    """

    shared_doubt = 0.0  # standard deviation of the logarithm of errors that observations share
    overdispersion = 1.0  # how many residuals count as one in its fits: what is believed of numbers weighs so much more
    subject = "the motion"  # what is measured, in words
    segmented = False  # are the recordings segments of longer ones?

    @property
    def measured(self):
        """How many different things were measured: as many numbers describe them without any law."""
        return len(self.trials)

    @property
    def contact(self):
        """Does anything touch?"""
        return self.simulator.contact

    @property
    def difference_scale(self):
        """Size of finite differences relative to the smooth case: contacts need wider ones."""
        return 10.0 if self.contact else 1.0

    def batched(self, functions):
        """[function() for function in functions]; what they simulate on the way is simulated in batches."""
        return run_tasks(self.simulator.simulate_all, functions)

    # --- noise ----------------------------------------------------------------------------------------------------------------

    def whitened(self, raw):
        """Observations in units of the channels as white ones, lists of (n_i,)."""
        return [whiten(recording.whitening, part) for recording, part in zip(self.recordings, raw, strict=True)]

    def in_sigmas(self, white):
        """White residuals turned back into residuals in units of sigma, lists of (n_i,)."""
        return [
            colour(recording.whitening, part) / recording.whitening.sigma
            for recording, part in zip(self.recordings, white, strict=True)
        ]

    @property
    def noise_level(self):
        """Noise of the observations that errors are told of, root mean square [unit of the problem]; None = unknown."""
        known = [recording.whitening.sigma[have_unit(recording.channel, self.unit)] for recording in self.recordings]
        sigmas = np.concatenate(known)
        return float(np.sqrt(np.mean(sigmas**2))) if len(sigmas) else self.noise.of_unit(self.unit)

    def error(self, white):
        """RMS over the observations that have the unit of the problem, in that unit, of white residuals, list of (n_i,)."""
        known = zip(self.recordings, white, strict=True)
        parts = [colour(recording.whitening, part)[have_unit(recording.channel, self.unit)] for recording, part in known]
        total, count = sum(float(np.sum(part**2)) for part in parts), sum(map(len, parts))
        return float(np.sqrt(total / max(count, 1)))

    # --- derivatives ----------------------------------------------------------------------------------------------------------

    def signature(self, model, initial_states, plus):
        """White change of the observations from a model to the model `plus`, list of (n_i,)."""
        before, after = self.residuals(model, initial_states), self.residuals(plus, initial_states)
        return self.whitened([a - b for a, b in zip(before, after, strict=True)])

    def derivative(self, name, free, value, moved, linear, initial_states, reach=WIDE, to=None):
        """White change of the observations per unit of a free number at `value`, list of (n_i,), and what the initial states do
        along with it, list of (unknowns_i,); moved: value -> model; linear: function that gives the Linearization at the value,
        called once the first change has been simulated.

        Runs with contacts answer a small change with some noise of their own (which sweep converged, which step stopped the
        body), so there the step is widened until the change, less what the initial states absorb, stands clear of it, and one
        that was widened elsewhere is narrowed where it changes far more. A wide step moves the impacts, so there the initial
        states go along by what would absorb the change: what a fit would see is left.
        The widest step is tried either way.
        reach: part of the plausible range that the widest step may span; to: value as far as which it is taken, if that is known.
        """
        least, known = difference_step(free, value) * self.difference_scale, to not in (None, value)
        amount = to - value if known else self.difference_steps.get((name, free.name), least)
        widest, widened = reach * width_of(free), False

        def change(step, states):
            after = self.residuals(moved(value + step), states)
            return self.whitened([a - b for a, b in zip(linear().raw, after, strict=True)])

        def size(changes):
            return float(np.sqrt(sum(np.sum(part**2) for part in linear().without_states(changes))))

        while True:
            step = -amount if value + amount > free.most else amount
            changes = change(step, initial_states)
            if known or not self.contact:
                break
            found = size(changes)
            if found < LEAST_CHANGE and amount >= widest and step > 0 and free.inside(value - amount) == value - amount:
                behind = change(-amount, initial_states)  # a floor that grips shows nothing of more friction, and much of less
                if np.isfinite(size(behind)) and size(behind) > max(found, LEAST_CHANGE):
                    step, changes = -amount, behind
                    break
            fitting = 1.5 * LEAST_CHANGE / max(found, 1e-9)
            if found < LEAST_CHANGE and amount < widest:
                amount, widened = min(amount * float(np.clip(fitting, 2.0, 30.0)), widest), True
            elif MOST_CHANGE < found < np.inf and amount > least and not widened:
                amount = max(amount * fitting, least)
            else:
                break
        if not known and self.contact:
            self.difference_steps[name, free.name] = min(amount, widest * WIDE / reach)
        moves = [np.zeros(columns.shape[1]) for columns in linear().state_columns]
        if self.contact and any(len(move) for move in moves) and np.isfinite(size(changes)):
            absorbed = zip(linear().state_columns, changes, strict=True)
            along = [-least_squares(columns, part).estimate for columns, part in absorbed]
            followed = change(step, self.stepped(initial_states, along))
            if size(followed) < size(changes):
                changes, moves = followed, along
        finite = np.isfinite(size(changes))  # a run that left the finite numbers shows no derivative
        return [part / step if finite else np.zeros(len(part)) for part in changes], [move / step for move in moves]

    # --- the next experiment --------------------------------------------------------------------------------------------------

    def reading(self, term):
        """(what measures an effect directly, its separation from no effect in units of chi2), None where nothing does."""
        sessions = in_sessions(term.numbers).values() or (term.numbers,)
        readings = [direct_reading(term.candidate.kind, numbers, self.camera) for numbers in sessions]
        return max(filter(None, readings), key=lambda reading: reading[1], default=None)

    # --- fits -----------------------------------------------------------------------------------------------------------------

    def fit(self, model, initial_states=None, limit=None):
        """Fit of the model's free numbers and of all initial states: trust-region least squares (`estimation.fitting`); limit:
        function that says what it may cost to be of interest."""
        fit = segment_profiles.fit if self.segmented and free_numbers(model) else fitting.fit
        with np.errstate(all="ignore"):  # a run may leave the finite numbers on the way; its chi2 is then infinite
            return fit(self, model, self.initial_guess() if initial_states is None else initial_states, limit)

    def fit_at(self, model, initial_states, converged=True):
        """The Fit at this point, no step taken."""
        return fitting.fit_at(model, initial_states, self.linearise(model, initial_states), converged)

    def stepped(self, initial_states, moves):
        """Initial states after moves of their unknowns, list of (unknowns_i,) -> (trials, 13)."""
        known = zip(initial_states, self.recordings, moves, strict=True)
        return np.array([stepped(state, recording.unknown, move) for state, recording, move in known])

    def residuals_at(self, model, options):
        """Raw residuals of every recording at each of some initial states, list of (trials, 13): list of lists of (n_i,)."""
        return [self.residuals(model, initial_states) for initial_states in options]

    def white_residuals(self, model, initial_states):
        """Whitened residuals of every recording, list of (n_i,)."""
        return self.whitened(self.residuals(model, initial_states))


def difference_step(free, value):
    """Difference for a derivative with respect to a free number: a part of its plausible range, and of an amount that may be any
    part of that, as the viscosity of water is of honey's, a part of itself, as far as rounding lets a change show."""
    span = free.high - free.low
    step = 1e-4 * span if np.isfinite(span) and span < 1e5 else 1e-4 * max(abs(value), 1.0)
    return min(step, max(1e-3 * value, 1e-4 * step)) if value > 0 and free.least == free.null == 0 else step
