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
from hlcs.kinds.layers.candidates import LayerCandidate, named
from hlcs.placement import work
from hlcs.placement.procedure import PlacementTest
from hlcs.placement.runs import simulate
from hlcs.placement.settings_file import placement_table
from hlcs.placement.store import Store, key_of
from hlcs.placement.sweep import settings_of
from minibullet.errors import InputError
from minibullet.files.reading import read_bytes, shown

MEASURED = "measured.csv"  # copy of the data in a folder of results
MOST_BYTES = 10_000_000  # of such a copy; a table of layers has some kilobytes
CASE = ("grid", "bottom", "layers", "seed", "stacking")  # settings that come with a measured set, not with the model


@dataclass(frozen=True)
class LayerTerm:
    """A candidate in the model, at a value."""

    candidate: LayerCandidate
    value: float

    @property
    def name(self):
        return self.candidate.name


@dataclass(frozen=True)
class LayerModel:
    """A placement test and the effects added to it; effects that only touch the reading are kept beside the test.

    base: PlacementTest; terms: what was added to it, in order. `placement` is the test with all of them that a test can hold.
    """

    base: PlacementTest
    terms: tuple[LayerTerm, ...] = ()
    source: object = field(default=None, repr=False, compare=False)  # (title, CSV) of the experiment file

    @property
    def effects(self):
        """Names of the effects added."""
        return tuple(term.name for term in self.terms)

    @property
    def placement(self):
        """The mended PlacementTest, ready to run."""
        return self._changed(self.base)

    def _changed(self, test):
        for term in self.terms:
            test = term.candidate.applied(test, term.value)
        return test

    def with_effect(self, candidate, value):
        """The same model with one effect more."""
        return replace(self, terms=(*self.terms, LayerTerm(candidate, float(value))))

    def test(self, one, seed):
        """The PlacementTest of one measured LayerSet."""
        return replace(self._changed(one.placed(self.base)), seed=int(seed))

    def read(self, coefficients, one):
        """Simulated layer coefficients (.., M) as this model says they are read."""
        for term in self.terms:
            coefficients = term.candidate.read(coefficients, term.value, one)
        return coefficients

    def run(self, seed=1, progress=None):
        """Run the mended placement test; returns a PlacementResult (readings that only the measurement changes are as placed)."""
        return replace(self.placement, seed=seed).run(progress)

    def to_toml(self, data=None):
        """An experiment file of this model: the settings under [placement], what acts on the reading or the grid in [model].

        data: how it names its CSV; left out: the full path, which is read from elsewhere with --allow-outside alone.
        """
        settings, effects = self.base, []
        for term in self.terms:
            changed = term.candidate.applied(settings, term.value)
            if term.candidate.look is None and changed.grid == settings.grid and changed.bottom == settings.bottom:
                settings = changed
            else:
                effects.append({"name": term.name, term.candidate.number: term.value})
        title, source = self.source or ("layers", None)
        default = PlacementTest()
        table = {
            key: value
            for key, value in placement_table(settings).items()
            if key not in CASE and value != getattr(default, key, None)
        }
        document = {"kind": "layers", "title": title, "placement": table}
        if effects:
            document["model"] = {"effects": effects}
        document["measurement"] = {"file": str(data or source)}
        return folders.to_toml(document)

    def files(self, folder):
        """{name: bytes} of what keeps the model in a folder of results: its experiment file, and its data where they lie
        elsewhere, so that the file can be used as it is."""
        data = Path(self.source[1]) if self.source else Path()
        below = Path(os.path.realpath(folder))
        if not data.is_absolute():
            return {"model.toml": self.to_toml().encode()}
        if data.is_relative_to(below):
            return {"model.toml": self.to_toml(data.relative_to(below).as_posix()).encode()}
        content = read_bytes(data, str(data), MOST_BYTES, "thin the file out")
        return {MEASURED: content, "model.toml": self.to_toml(MEASURED).encode()}


def model_of(measurement):
    """The LayerModel of a LayerMeasurement, with the effects its file lists under [model]."""
    source = measurement.title, Path(measurement.data_file).resolve()  # a file of the model may lie in another folder
    model = LayerModel(measurement.test, (), source)
    for entry in measurement.effects:
        numbers = {key: value for key, value in entry.items() if key != "name"}
        try:
            candidate = named(entry["name"], model.placement, measurement.sets)[0]
        except InputError as problem:
            raise InputError(f"{measurement.where}: {problem}") from None
        if not numbers and candidate.switch:
            numbers = {candidate.number: candidate.trial}
        if set(numbers) != {candidate.number}:
            raise InputError(
                f"{measurement.where}: {candidate.name} needs one number, {candidate.number}; got {shown(sorted(numbers))}"
            )
        value = numbers[candidate.number]
        if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
            raise InputError(
                f"{measurement.where}: {candidate.name}.{candidate.number} = {shown(repr(value))}; it must be a finite number"
            )
        model = model.with_effect(candidate, value)
    return model


# -------------------------------------------------------------------------------------------------------- simulations
class Simulator:
    """Runs tests that are not yet in the store.

    store: file of finished runs, None = `default_store()`; workers: processes; progress: show a bar on a terminal; function:
    the simulation of one test (must be importable), `simulate` unless tests want something quicker.
    """

    def __init__(self, store=None, workers=None, progress=False, function=simulate):
        self.store, self.workers, self.progress, self.function = store or default_store(), workers, progress, function
        self.ran, self.told = 0, []  # how many tests were run; what there was to say of rows that are not used
        self.refused = ""  # why the physics refused the first of the last tests that it refused

    def __call__(self, tests, words="simulating"):
        """[k (M,), nan where no plate found support, or None where the physics refused] of tests, each run once."""
        keyed = {key_of(self._settings(test)): test for test in tests}
        with Store(self.store, _coefficients) as store:
            missing = {key: test for key, test in keyed.items() if key not in store}
            if missing:
                self._run(missing, store, words, len(keyed) - len(missing))
            found = work.results(store, [key_of(self._settings(test)) for test in tests])
        self.refused = next((row["error"] for row in found if row["error"]), "")
        return [row["k"] for row in found]

    def _run(self, missing, store, words, held):
        from tqdm import tqdm

        told = work.told(store, missing)
        if self.progress and told:
            tqdm.write(told, file=sys.stderr)
        self.told += [told] if told else []
        with tqdm(total=len(missing), desc=words, unit="test", leave=False, disable=None if self.progress else True) as bar:
            self.ran += work.finish(store, missing, self.function, self._settings, self.workers, done=bar.update, held=held)

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
    if not usable and not chosen:
        folder = Path(tempfile.gettempdir()) / "hlcs"
    return folder / "layers.sqlite"


def coefficients(simulator, models, sets, seeds, words="simulating"):
    """[[k (seeds, M) as read, nan rows where the physics refused] for each set] for each model: all runs in one go."""
    tests = [model.test(one, seed) for model in models for one in sets for seed in seeds]
    found = iter(simulator(tests, words))
    table = []
    for model in models:
        rows = []
        for one in sets:
            runs = [next(found) for _ in seeds]
            runs = np.array([np.full(one.layers, np.nan) if run is None else run for run in runs])
            rows.append(model.read(runs, one))
        table.append(rows)
    return table
