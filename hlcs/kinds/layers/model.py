"""The model under test for layers, and its simulations: over seeds, in several processes, kept on disk.

Every model, candidate and set is simulated with the same seeds (common random numbers), so that differences between them are
known better than the layer coefficients themselves. Finished runs stay in one SQLite file under the key of their settings and of
the code that made them: a second diagnosis of the same tables reads them back.
"""

import os
import sys
import tempfile
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from hlcs.files import folders
from hlcs.kinds.layers.candidates import named
from hlcs.placement import run_queue
from hlcs.placement.procedure import PlacementTest
from hlcs.placement.run_store import Store, key_of
from hlcs.placement.settings_table import placement_table, settings_of
from hlcs.placement.single_run import layer_coefficients_of
from hlcs.simulation.model import Term, Terms
from minibullet.errors import InputError, is_number
from minibullet.files.reading import read_bytes, shown

MEASURED = "measured.csv"  # copy of the data in a folder of results
MOST_BYTES = 10_000_000  # of such a copy; a table of layers has some kilobytes
CASE = ("grid", "bottom", "layers", "seed", "stacking")  # settings that come with a measured set, not with the model


@dataclass(frozen=True)
class LayerModel(Terms):
    """A placement test and the effects added to it; effects that only touch the reading are kept beside the test.

    base: PlacementTest; terms: what was added to it, in order, after what the file states. `placement` is the test with all of
    them that a test can hold.
    """

    base: PlacementTest
    terms: tuple[Term, ...] = ()
    stated: tuple[Term, ...] = ()  # by the experiment file, before all others
    source: object = field(default=None, repr=False, compare=False)  # (title, CSV) of the experiment file

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

    def to_toml(self, data=None):
        """An experiment file of this model: the settings under [placement], what acts on the reading or the grid in [model].

        data: how it names its CSV; left out: the full path, which is read from elsewhere with --allow-outside alone.
        """
        settings, effects = self.base, []
        for term in self._all:
            changed = term.candidate.applied(settings, *term.numbers.values())
            if term.candidate.reading is None and changed.grid == settings.grid and changed.bottom == settings.bottom:
                settings = changed
            else:
                effects.append({"name": term.name, **term.numbers})
        title, source = self.source or ("layers", None)
        default, table = PlacementTest(), placement_table(settings)
        stated = {key: value for key, value in table.items() if key not in CASE and value != getattr(default, key, None)}
        model = {"model": {"effects": effects}} if effects else {}
        document = {"kind": "layers", "title": title, "placement": stated, **model, "measurement": {"file": str(data or source)}}
        return folders.to_toml(document)

    def files(self, folder):
        """{name: bytes} of what keeps the model in a folder of results: its experiment file, and its data where they lie
        elsewhere, so that the file can be used as it is."""
        data, kept = Path(self.source[1]) if self.source else Path(), {}
        below, name = Path(os.path.realpath(folder)), None
        if data.is_relative_to(below):
            name = data.relative_to(below).as_posix()
        elif data.is_absolute():
            name, kept = MEASURED, {MEASURED: read_bytes(data, str(data), MOST_BYTES, "thin the file out")}
        return kept | {"model.toml": self.to_toml(name).encode()}


def model_of(measurement):
    """The LayerModel of a LayerMeasurement, with the effects its file lists under [model]."""
    source = measurement.file.title, Path(measurement.file.data_file).resolve()  # a file of the model may lie in another folder
    model = LayerModel(measurement.test, source=source)
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

    store: file of finished runs, None = `default_store()`; workers: processes; progress: show a bar on a terminal; function:
    the simulation of one test (must be importable), `layer_coefficients_of` unless tests want something quicker.
    """

    def __init__(self, store=None, workers=None, progress=False, function=layer_coefficients_of):
        self.store, self.workers, self.progress, self.function = store or default_store(), workers, progress, function
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


def default_store():
    """Where simulations are kept: $HLCS_CACHE, or hlcs under the user's cache folder or, failing that, the temporary one."""
    chosen = os.environ.get("HLCS_CACHE")
    folder = Path(chosen) if chosen else Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "hlcs"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        usable = os.access(folder, os.W_OK)
    except OSError:
        usable = False
    return (folder if usable or chosen else Path(tempfile.gettempdir()) / "hlcs") / "layers.sqlite"


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
