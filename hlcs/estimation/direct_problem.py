"""The problem that a table poses: its model foretells every number at once, and no initial state absorbs anything."""

from abc import abstractmethod
from typing import NamedTuple

import numpy as np

from hlcs.estimation.linearization import Linearization, varied
from hlcs.estimation.problem import Problem, difference_step
from minibullet.errors import InputError


class NoSimulator:
    """The part of a simulator that a search asks for, where no motion is simulated during it."""

    contact, body_steps = False, 0.0


class Rows(NamedTuple):
    """Rows of a table that are held out together: what a recording is elsewhere."""

    group: str
    rows: np.ndarray  # indices of the table
    body: object = None
    surroundings: object = None

    @property
    def name(self):
        return self.group

    whole = name  # no recording is cut into segments here
    session = ""


class DirectProblem(Problem):
    """Base of the problems of tables: a kind of measurement sets `trials` (each with `rows`, indices of the table) and `values`
    (n,), and defines `predict(model)` -> (n,)."""

    simulator = NoSimulator()

    @property
    def measured(self):
        """The rows, not their groups."""
        return len(self.values)

    @abstractmethod
    def predict(self, model):
        """What the model foretells of all rows of the table (n,)."""

    def batched(self, functions):
        """[function() for function in functions]: none of them waits for a simulation."""
        return [function() for function in functions]

    def initial_guess(self):
        return np.zeros((len(self.trials), 13))

    def stepped(self, initial_states, moves):
        """The same initial states: none of them moves."""
        return initial_states

    def residuals(self, model, initial_states):
        difference = self.values - self.predict(model)
        return [difference[trial.rows] for trial in self.trials]

    def linearise(self, model, initial_states):
        raw = self.residuals(model, initial_states)
        columns = [np.zeros((len(part), 0)) for part in raw]
        for _, free, value, moved in varied(model):
            step = difference_step(free, value)
            if value + step > free.most:
                step = -step
            try:
                changed = self.residuals(moved(value + step), initial_states)
            except InputError:  # one side may be where nothing can be: larger units that do not lie on their grid
                step = -step
                changed = self.residuals(moved(value + step), initial_states)
            slopes = self.whitened([(before - after) / step for before, after in zip(raw, changed, strict=True)])
            columns = [np.column_stack([part, slope]) for part, slope in zip(columns, slopes, strict=True)]
        return Linearization(raw, self.whitened(raw), [np.zeros((len(part), 0)) for part in raw], columns)
