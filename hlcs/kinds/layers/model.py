"""The model under test for layers, and its simulations: over seeds, in several processes, kept on disk.

Every model, candidate and set is simulated with the same seeds (common random numbers), so that differences between them are
known better than the layer coefficients themselves. Finished runs stay in one SQLite file under the key of their settings and of
the code that made them: a second diagnosis of the same tables reads them back.
"""

import sys
from dataclasses import dataclass, replace

import numpy as np

from hlcs.kinds.layers.candidates import named
from hlcs.placement import run_queue
from hlcs.placement.procedure import PlacementTest
from hlcs.placement.run_store import Store, default_store, key_of
from hlcs.placement.settings_table import settings_of
from hlcs.placement.single_run import layer_coefficients_of
from hlcs.simulation.model import Term, Terms
from minibullet.errors import InputError, is_number, shown


@dataclass(frozen=True)
class LayerModel(Terms):
    """A placement test and the effects added to it; effects that only touch the reading are kept beside the test.

    base: PlacementTest; terms: what was added to it, in order, after what the file states. `placement` is the test with all of
    them that a test can hold.
    """

    base: PlacementTest
    terms: tuple[Term, ...] = ()
    stated: tuple[Term, ...] = ()  # by the experiment file, before all others

    @property
    def effects(self):
        """Names of all effects in it."""
        return tuple(term.name for term in self._all)

    @property
    def _all(self):
        return *self.stated, *self.terms

    @property
    def placement(self):
        """The mended PlacementTest, ready to run."""
        return self._changed(self.base)

    @property
    def kinds(self):
        """Classes of all effects in it: none of a layer is a law of motion that others act through."""
        return ()

    def _changed(self, test):
        for term in self._all:
            test = term.candidate.applied(test, *term.numbers.values())
        return test

    def with_effect(self, candidate, step):
        """The same model with one effect more, its number a step from the null value."""
        return self.with_term(Term(candidate, tuple((free.name, float(free.null + step)) for free in candidate.free)))

    def test(self, measured_set, seed):
        """The PlacementTest of one measured LayerSet."""
        return replace(self._changed(measured_set.placed(self.base)), seed=int(seed))

    def read(self, coefficients, measured_set):
        """Simulated layer coefficients (.., M) as this model says they are read."""
        for term in self._all:
            coefficients = term.candidate.read(coefficients, measured_set, *term.numbers.values())
        return coefficients

    def run(self, seed=1, progress=None):
        """Run the mended placement test; returns a PlacementResult (readings that only the measurement changes are as placed)."""
        return replace(self.placement, seed=seed).run(progress)

    @property
    def entries(self):
        """What [model] effects of an experiment file holds of it: name and numbers of each effect."""
        return tuple({"name": term.name, **term.numbers} for term in self._all)

    def __str__(self):
        """What is placed, and what was added to it."""
        known = {term.name: {free.name: (free.unit, "") for free in term.candidate.free} for term in self._all}
        laws = dict.fromkeys(self.effects, "")
        return "\n".join(self._told(f"units of shape {self.base.shape} placed layer by layer", laws, known))


def model_of(measurement):
    """The LayerModel of a LayerMeasurement, with the effects its file lists under [model]."""
    model = LayerModel(measurement.test)
    for entry in measurement.file.effects:
        try:
            model = replace(model, stated=(*model.stated, _stated(entry, model.placement, measurement.sets)))
        except InputError as problem:
            raise InputError(f"{measurement.file.place('model.effects')}: {problem}") from None
    return model


def _stated(entry, test, sets):
    """The Term of an entry of [model] effects."""
    candidate = named(entry["name"], test, sets)
    numbers = {key: value for key, value in entry.items() if key != "name" and (key, value) not in candidate.constants}
    names = [free.name for free in candidate.free]
    if set(numbers) != set(names):
        wanted = f"{'one number' if len(names) == 1 else 'numbers'}, {', '.join(names)}" if names else "no number"
        raise InputError(f"{candidate.name} needs {wanted}; got {shown(sorted(numbers))}")
    for name, value in numbers.items():
        if not is_number(value):
            raise InputError(f"{candidate.name}.{name} = {shown(repr(value))}; it must be a finite number")
    return Term(candidate, tuple((name, float(numbers[name])) for name in names))


# -------------------------------------------------------------------------------------------------------- simulations
class PlacementSimulator:
    """Runs tests that are not yet in the store.

    store: file of finished runs, None = layers.sqlite in the cache (`default_store`); workers: processes; progress: show a bar on
    a terminal; function: the simulation of one test (must be importable), `layer_coefficients_of` unless tests want something
    quicker.
    """

    def __init__(self, store=None, workers=None, progress=False, function=layer_coefficients_of):
        self.store, self.workers, self.progress, self.function = (
            store or default_store("layers.sqlite"),
            workers,
            progress,
            function,
        )
        self.ran = 0  # how many tests were run
        self.refused = ""  # why the physics refused the first of the last tests that it refused

    def __call__(self, tests, label="simulating"):
        """[k (M,), nan where no plate found support, or None where the physics refused] of tests, each run once."""
        keys = [key_of(self._settings(test)) for test in tests]
        with Store(self.store, _coefficients) as store:
            missing = {key: test for key, test in zip(keys, tests, strict=True) if key not in store}
            if missing:
                self._run(missing, store, label, len(set(keys)) - len(missing))
            results = run_queue.results(store, keys)
        self.refused = next((result["error"] for result in results if result["error"]), "")
        return [result["k"] for result in results]

    def _run(self, missing, store, label, finished):
        from tqdm import tqdm

        if self.progress and (unused := run_queue.unused_rows(store, missing)):
            tqdm.write(unused, file=sys.stderr)
        with tqdm(total=len(missing), desc=label, unit="test", leave=False, disable=None if self.progress else True) as bar:
            self.ran += run_queue.finish(
                store, missing, self.function, self._settings, self.workers, done=bar.update, finished=finished
            )

    def _settings(self, test):
        return {**settings_of(test), "made_by": f"{self.function.__module__}.{self.function.__name__}"}


def _coefficients(row):
    """A stored row with its layer coefficients as an array, None where the physics refused, and why it did."""
    return {"k": None if "error" in row else np.array(row["k"], dtype=float), "error": row.get("error", "")}


def coefficients(simulator, models, sets, seeds, label="simulating"):
    """[[k (seeds, M) as read, nan rows where the physics refused] for each set] for each model: all runs in one go."""
    cases = [(model, measured_set) for model in models for measured_set in sets]
    results = iter(simulator([model.test(measured_set, seed) for model, measured_set in cases for seed in seeds], label))
    tables = []
    for model, measured_set in cases:
        absent = np.full(measured_set.layers, np.nan)
        runs = np.array([absent if k is None else k for _, k in zip(seeds, results, strict=False)])
        tables.append(model.read(runs, measured_set))
    return [tables[first : first + len(sets)] for first in range(0, len(tables), len(sets))]
