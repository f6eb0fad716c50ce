"""A problem in closed form for the tests of fits: values = number * time + the constant of each recording + noise."""

from types import SimpleNamespace

import numpy as np

from hlcs.data.experiment_file import Surroundings
from hlcs.effects import Candidate, Free, class_named
from hlcs.estimation.cross_validation import CrossValidation
from hlcs.estimation.linearization import Linearization, Recording
from hlcs.estimation.problem import Problem
from hlcs.estimation.whitening import whiten, whitening_of
from hlcs.selection.search import Search
from hlcs.selection.sets import FittedSets
from hlcs.simulation.model import Model, Term

RATE = Candidate("linear_drag", class_named("linear_drag"), (Free("rate", "1/s", 0.0, 10.0, 0.0, 1.0),))


COMMON = {"body": None, "surroundings": Surroundings()}  # of all trials


def model(rate):
    """The model with one number."""
    return Model((Term(RATE, (("rate", rate),)),))


class Line(Problem):
    """Recordings of rate * t + c_k, c_k the only unknown of the initial state of recording k; white noise of sigma."""

    def __init__(self, times, values, sigma=1.0, groups=None):
        self.times, self.values, self.difference_steps, self.unit = times, values, {}, "m"
        self.noise = SimpleNamespace(position=sigma, orientation=None, of_unit=lambda unit: sigma)
        names = groups or [str(k) for k in range(len(times))]
        self.trials = [SimpleNamespace(group=name, name=name, whole=name, **COMMON) for name in names]
        self.simulator = SimpleNamespace(contact=False, body_steps=0.0, simulate_all=None)
        unknown = ((0, np.array([1.0, 0.0, 0.0])),)
        self.recordings = []
        for t in times:
            whitening = whitening_of(np.zeros(len(t), int), t, np.full(len(t), sigma), {0: (0.0, 0.0)}, t[1] - t[0])
            self.recordings.append(Recording(np.zeros(len(t), int), np.arange(len(t)), t, whitening, unknown))

    def initial_guess(self):
        states = np.zeros((len(self.times), 13))
        states[:, 6] = 1.0
        return states

    def residuals(self, model, initial_states):
        rate = model.terms[0].numbers["rate"] if model.terms else 0.0
        return [y - rate * t - state[0] for t, y, state in zip(self.times, self.values, initial_states, strict=True)]

    def linearise(self, model, initial_states, only=None):
        raw = self.residuals(model, initial_states)

        def white(columns):
            return [whiten(recording.whitening, part) for recording, part in zip(self.recordings, columns, strict=True)]

        slopes = white([t[:, None] if model.terms else np.zeros((len(t), 0)) for t in self.times])
        return Linearization(raw, white(raw), white([np.ones((len(t), 1)) for t in self.times]), slopes)


LAWS = {
    name: Candidate(name, class_named(name), (Free("rate", "1/s", 0.0, 10.0, 0.0, 0.0),))
    for name in ("linear_drag", "spin_decay")
}


class Bend(Line):
    """Two laws: rate * t of the one, rate * (t + bend * t^2) of the other."""

    bend = 0.0

    def shape(self, name, t):
        return t if name == "linear_drag" else t + self.bend * t**2

    def residuals(self, model, initial_states):
        told = zip(self.times, self.values, initial_states, strict=True)
        return [
            y - state[0] - sum(term.numbers["rate"] * self.shape(term.name, t) for term in model.terms) for t, y, state in told
        ]

    def linearise(self, model, initial_states, only=None):
        raw = self.residuals(model, initial_states)

        def white(columns):
            return [whiten(recording.whitening, part) for recording, part in zip(self.recordings, columns, strict=True)]

        table = [np.array([self.shape(term.name, t) for term in model.terms]).reshape(-1, len(t)).T for t in self.times]
        return Linearization(raw, white(raw), white([np.ones((len(t), 1)) for t in self.times]), white(table))


def sets(bend, generator, sigma=0.05):
    """FittedSets of recordings that rise by 3 a second, whose two candidates are alike where bend = 0."""
    times = [np.linspace(0.0, 2.0, 25) for _ in range(4)]
    problem = Bend(times, [3.0 * t + sigma * generator.standard_normal(25) for t in times], sigma, ["a", "b", "a", "b"])
    problem.bend = bend
    search = Search(problem, LAWS.values(), problem.fit(Model())).run()
    return FittedSets(search, CrossValidation(problem.trials, "group"))
