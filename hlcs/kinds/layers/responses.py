"""What effects do to layers, from paired simulations: a response of all values to each number, checked against runs.

Every model is simulated with the same seeds, so that a difference of two is known better than either. A response is a chain of
straight lines through the numbers at which its effect was simulated; those of several effects add up. A switch makes another
model, beside which effects are simulated anew. Where the search ends the model is simulated as a whole, and by what that differs
from the sum every later answer for the same effects is mended.
"""

from dataclasses import replace

import numpy as np

from hlcs.kinds.layers import observations
from hlcs.kinds.layers.model import coefficients
from minibullet.errors import InputError

STEPS = (0.5, 1.0, 2.0, 4.0)  # where a number is simulated, in first steps from its null value, either way


class Responses:
    """Simulations of a model of layers, alone and with effects, on all measured sets."""

    def __init__(self, simulator, model, sets, data, seeds):
        self.simulator, self.model, self.sets, self.data, self.seeds = simulator, model, sets, data, seeds
        (self.runs,) = self._simulate([model], "model " + ", ".join(model.effects))
        for measured_set, tests in zip(sets, self.runs, strict=True):
            if np.isfinite(tests).all(axis=1).sum() < 2:
                raise InputError(
                    f"the model under test cannot be placed on {measured_set.name}: fewer than two of {len(tests)} simulated "
                    f"tests stand; {simulator.refused or 'run `hlcs place` with these settings to see why'}"
                )
        self.base = observations.simulated(data, self.runs)
        self.stated = self._stated()
        self.taken = {}  # name of an effect -> {step of its number from the null value: its runs}
        self.nodes = {}  # the same -> (change of all values (n,), its variance), None where no placement stands
        self.beside = {}  # name of a switch -> the Responses of the model with it
        self.whole = {}  # names of the simulated effects of a model -> (the model, its runs)
        self.mended = {}  # the same -> (how far off the sum of responses is (n,), variance (n,) of its change)

    def _simulate(self, models, label, pairs=None):
        return coefficients(self.simulator, models, self.sets, self.seeds[:pairs], label)

    def _stated(self):
        """(change of all values (n,) that the effects make which the file of the model states, its variance (n,)).

        It is as little known as that of effects that a search finds: a model is judged alike before and after they are written
        into its file. Nothing is doubted where no placement stands without them."""
        read = tuple(term for term in self.model.stated if not term.candidate.simulated)
        none = np.zeros((2, len(self.data.value)))
        if read == self.model.stated:
            return none
        (without,) = self._simulate([replace(self.model, stated=read)], "model without its effects")
        shared = observations.shared_scatter(without, [self.runs])
        found = observations.change(self.data, without, self.runs, shared)
        return none if found is None else found

    # --- simulations ----------------------------------------------------------------------------------------------------------

    def take(self, wanted, pairs=None):
        """Simulate effects, in so many pairs of runs or in all; wanted: [(LayerCandidate, step of its number)]."""
        models = [self.model.with_effect(candidate, step) for candidate, step in wanted]
        for (candidate, step), runs in zip(wanted, self._simulate(models, "effects", pairs) if models else (), strict=True):
            self.taken.setdefault(candidate.name, {})[step] = runs
        self._renew()

    def take_beside(self, switch, others, pairs):
        """Simulate other candidates in the model with a switch, as far as that can be placed: there they act as they do here no
        longer (units that slide more settle deeper, unless they are as wide as their hulls)."""
        model = self.model.with_effect(switch, switch.step)
        try:
            inner = Responses(self.simulator, model, self.sets, self.data, self.seeds)
        except InputError:
            return
        inner.take([(candidate, candidate.step) for candidate in others], pairs)
        self.beside[switch.name], self.taken[switch.name] = inner, {switch.step: inner.runs}
        self._renew()

    def _renew(self):
        """Read all responses anew: how far tests scatter is told by all that were run."""
        self.shared = observations.shared_scatter(self.runs, [runs for steps in self.taken.values() for runs in steps.values()])
        self.nodes = {
            name: {step: observations.change(self.data, self.runs, runs, self.shared) for step, runs in steps.items()}
            for name, steps in self.taken.items()
        }
        self._compare()

    def complete(self, models):
        """Simulate the effects of models near to their numbers, where that has not been done; was there anything to simulate?"""
        wanted = {}
        for model in models:
            for term in model.terms:
                own = self._holder(model, term)
                if (step := own.missing(term)) is not None:
                    wanted.setdefault(own, {})[term.name, step] = term.candidate
        for own, its in wanted.items():
            own.take([(candidate, step) for (_, step), candidate in its.items()])
        self._compare()
        return bool(wanted)

    def _holder(self, model, term):
        """The Responses that know what a term does beside the others of a model."""
        switch = next((name for name in model.effects if name in self.beside), term.name)
        return self if switch == term.name else self.beside[switch]

    def missing(self, term):
        """Where the effect of a term is to be simulated next, a step from its null value; None where that has been done near to
        its number in all pairs, or can not be done."""
        candidate, steps = term.candidate, [term.candidate.step]
        if candidate.free and candidate.simulated:
            (free,) = candidate.free
            wanted, size = term.numbers[free.name] - free.null, abs(candidate.step)
            steps = [float(np.copysign(size * part, wanted or candidate.step)) for part in STEPS]
            steps = [step for step in steps if free.inside(free.null + step) == free.null + step]
            steps.sort(key=lambda step: abs(np.log(max(abs(wanted), 1e-9 * size) / abs(step))))
        if not candidate.simulated or not steps:
            return None
        known = self.taken.get(candidate.name, {}).get(steps[0])
        return None if known and len(known[0]) == len(self.seeds) else steps[0]

    def mend(self, model):
        """Simulate a model with all its effects: what is said of these effects afterwards goes through these runs."""
        (runs,) = self._simulate([model], "model " + ", ".join(model.effects))
        if observations.change(self.data, self.runs, runs, self.shared) is not None:  # else the responses alone are believed
            self.whole[_simulated(model)] = model, runs
        self._compare()

    def _compare(self):
        """Set models that were simulated as a whole beside the sums of the responses as these are now."""
        self.mended = {}
        for names, (model, runs) in self.whole.items():
            moved, variance = observations.change(self.data, self.runs, runs, self.shared)
            self.mended[names] = self.base.value + moved - self.values(model), variance

    def runs_of(self, model):
        """Simulated tests (seeds, M) of each set, as a model has them: those of a model that was simulated, moved to its mean."""
        _, runs = self.whole.get(_simulated(model), (self.model, self.runs))
        values = self.values(model)
        layers = [observations.rows_of(self.data, index)[0] for index in range(len(runs))]
        return [tests + values[here] - np.nanmean(tests, axis=0) for here, tests in zip(layers, runs, strict=True)]

    # --- answers ----------------------------------------------------------------------------------------------------------------

    def change(self, model):
        """(change of all values (n,) that the simulated effects of a model make, its variance (n,) by the seeds).

        InputError where none stands."""
        moved = np.array([self._holder(model, term)._moved(term) for term in model.terms if term.candidate.simulated])
        change, variance = moved.sum(axis=0) if len(moved) else np.zeros((2, len(self.data.value)))
        if _simulated(model) in self.mended:
            off, variance = self.mended[_simulated(model)]
            change = change + off
        return change, variance

    def values(self, model):
        """All values (n,) as a model says they are read; InputError where none stands."""
        values = self.base.value + self.change(model)[0]
        for term in model.terms:
            values = values if term.candidate.simulated else self._read(term, values)  # what is simulated is read as it is
        return values

    def _moved(self, term):
        """(change of all values (n,) that the simulated effect of a term makes, its variance (n,))."""
        candidate = term.candidate
        nodes, wanted = self.nodes.get(candidate.name, {}), candidate.step
        if candidate.free:
            wanted = term.numbers[candidate.free[0].name] - candidate.free[0].null
        if wanted == 0.0:
            return np.zeros((2, len(self.data.value)))
        side = sorted((step for step in nodes if step * wanted > 0), key=abs) or sorted(nodes, key=abs)[:1]
        fallen = min((abs(step) for step in side if nodes[step] is None), default=np.inf)
        standing = [step for step in side if abs(step) < fallen]
        if not standing or abs(wanted) >= fallen:
            raise InputError(f"no placement stands with {candidate.name}")
        if abs(wanted) >= abs(standing[-1]) or standing[-1] * wanted < 0:
            change, variance = nodes[standing[-1]]
            return change * (wanted / standing[-1]), variance * (wanted / standing[-1]) ** 2
        ends = np.array([np.zeros((2, len(self.data.value))), *(nodes[step] for step in standing)])
        sizes = np.abs([0.0, *standing])
        above = int(np.searchsorted(sizes, abs(wanted)))
        part = (abs(wanted) - sizes[above - 1]) / (sizes[above] - sizes[above - 1])
        return ends[above - 1] + part * (ends[above] - ends[above - 1])

    def _read(self, term, values):
        """All values (n,) as an effect on the reading changes them."""
        read, numbers = values.copy(), term.numbers.values()
        for index, measured_set in enumerate(self.sets):
            layers, _ = observations.rows_of(self.data, index)
            read[layers] = term.candidate.read(values[layers], measured_set, *numbers)
        return read


def _simulated(model):
    """Names of the effects of a model that are simulated."""
    return frozenset(term.name for term in model.terms if term.candidate.simulated)
