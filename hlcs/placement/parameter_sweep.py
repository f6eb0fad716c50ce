"""Sweeps: every combination of some settings, each run kept as soon as it ends, so that a sweep can be killed and go on.

title = "how much does friction matter"
[placement]                     # what all runs share, as in `hlcs place TEST.toml`
grid = "TPG"
[sweep]                         # lists; every combination is run
friction = [0.3, 0.6]
seed = [1, 2, 3]
"""

import itertools
from dataclasses import dataclass

import numpy as np

from hlcs.files import folders
from hlcs.files.spreadsheets import csv_text
from hlcs.files.toml_files import TomlFile
from hlcs.files.versions import versions
from hlcs.placement import run_queue
from hlcs.placement.comparison import compare_layers, laboratory_for, repeated
from hlcs.placement.placement_file import (
    KEYS,
    check_value,
    checked_table,
    make_placement,
    with_armour,
    with_bottom,
    with_standing,
)
from hlcs.placement.procedure import PlacementTest
from hlcs.placement.run_store import Store, key_of
from hlcs.placement.settings_table import settings_of
from hlcs.placement.single_run import result_of
from hlcs.rendering import Result, table_of
from minibullet.errors import InputError, how_many, shown_value

MOST_RUNS = 100_000
SECTIONS = {"": ["title", "placement", "sweep"], "placement": list(KEYS), "sweep": list(KEYS)}


@dataclass(frozen=True)
class Sweep:
    """A sweep file, read and checked: names of what varies, and for each run its values and its test."""

    title: str
    names: tuple[str, ...]
    values: tuple[tuple, ...]  # of each run, one a name
    tests: tuple[PlacementTest, ...]


@dataclass(frozen=True, eq=False, repr=False)
class SweepResult(Result):
    """What the runs of a Sweep gave; outcome: as `run_sweep` returns it."""

    sweep: Sweep
    outcome: dict

    @property
    def rows(self):
        """One dictionary a run: its settings, and its numbers or its error."""
        return self.outcome["rows"]

    def to_dict(self):
        """The JSON of `hlcs sweep`."""
        return document(self.sweep, self.outcome)

    def to_dataframe(self, table="runs"):
        """A table of the sweep as a pandas frame: "runs", one row each, or "summary", runs that differ in the seed as one row."""
        return table_of({"runs": self.rows, "summary": summary_rows(self.sweep, self.rows)}, table)


def read_sweep_file(path, allow_outside=False):
    """The Sweep of a TOML file; InputError names file, line, key and remedy. allow_outside: surveys elsewhere are read."""
    file = TomlFile(path, SECTIONS, allow_outside)
    file.known(file.values, "")
    table = file.values.get("sweep")
    if not table:
        raise InputError(f"{file.path}: [sweep] is missing or empty; write lists under it, such as friction = [0.3, 0.6]")
    file.known(table, "sweep")
    for name, values in table.items():
        if not isinstance(values, list) or not values:
            file.fail(name, f"must be a list of one value or more, got {shown_value(values)}", "sweep")
        if name in file.values.get("placement", {}):
            file.fail(name, "stands under [placement] too; leave one of the two out", "sweep")
    count = int(np.prod([len(values) for values in table.values()], dtype=float))
    if count > MOST_RUNS:
        raise InputError(f"{file.path}: {count} runs; at most {MOST_RUNS}: shorten a list of [sweep]")
    for name, values in table.items():
        seen = set()
        if twice := [value for value in values if repr(value) in seen or seen.add(repr(value))]:
            file.fail(name, f"{shown_value(twice[0])} stands twice; a run is made once: leave one of the two out", "sweep")
    read = {**table}
    for name, reading in (("bottom", with_bottom), ("armour", with_armour), ("standing", with_standing)):
        if name in table:  # a survey or a mesh is read once, not for every run
            found = {word: reading({name: word}, file, "sweep")[name] for word in map(str, table[name])}
            read[name] = [found[str(word)] for word in table[name]]
    for name, values in read.items():
        for value in values if name != "layers" else ():
            check_value(file, "sweep", name, value)
    base = checked_table(file)
    runs = list(itertools.product(*table.values()))
    tests = []
    for run, settings in zip(runs, itertools.product(*read.values()), strict=True):
        try:
            tests.append(make_placement({**base, **dict(zip(table, settings, strict=True))}))
        except InputError as problem:
            words = ", ".join(f"{name} = {shown_value(value)}" for name, value in zip(table, run, strict=True))
            raise InputError(f"{file.path}: the run with {words}: {problem}") from None
    return Sweep(file.title(), tuple(table), tuple(runs), tuple(tests))


def check_store(path):
    """Open the store once: InputError or RunError where it cannot be used."""
    with Store(path, _row):
        pass


def run_sweep(sweep, store_path, workers=None, dask=None, progress=None):
    """Run what is not yet in the store; returns {"rows": one dictionary a run, "ran": how many now, "kept": found there or run
    by another sweep meanwhile, "told": one line on rows of the store that are not used, or nothing}.

    workers: processes; dask: address of a Dask scheduler in their place; progress(total, kept) gives the function to be
    called as each run ends. Several sweeps may work on one store at once; each run is done by one of them.
    """
    tests = {key_of(settings_of(test)): test for test in sweep.tests}
    with Store(store_path, _row) as store:
        missing = {key: test for key, test in tests.items() if key not in store}
        unused = run_queue.unused_rows(store, missing)
        finished = len(tests) - len(missing)
        done = progress(len(tests), finished) if progress else None
        ran = run_queue.finish(store, missing, result_of, settings_of, workers, dask, done, finished)
        results = run_queue.results(store, [key_of(settings_of(test)) for test in sweep.tests])
    rows = [dict(zip(sweep.names, values, strict=True)) | row for values, row in zip(sweep.values, results, strict=True)]
    return {"rows": rows, "ran": ran, "kept": len(tests) - ran, "told": unused}


def summary_rows(sweep, rows):
    """Repeats (runs that differ in the seed alone) as one row: the settings, tests, how many of them left no structure, mean and
    CV of every k of those that did, the error."""
    names = [name for name in sweep.names if name != "seed"]
    cases = {}
    for row, test in zip(rows, sweep.tests, strict=True):
        if "error" not in row:
            cases.setdefault(tuple(map(repr, (row[name] for name in names))), []).append((row, test))
    summaries = []
    for members in cases.values():
        first, test = members[0]
        runs = np.array([[row[f"k{j + 1}"] for j in range(test.layers)] for row, _ in members], dtype=float)
        stand = np.array([row["structure"] for row, _ in members])  # the others are counted, and in no mean
        model = repeated(np.where(stand[:, None], runs, np.nan))
        summary = {name: first[name] for name in names} | {"tests": len(members), "no_structure": int((~stand).sum())}
        summary |= {f"k{j + 1}": float(k) for j, k in enumerate(model.mean)}
        summary |= {f"cv{j + 1}": float(cv) for j, cv in enumerate(model.cv)}
        measured = laboratory_for(test)
        if measured is not None:
            comparison = compare_layers(model, measured)
            whole = comparison.known.all()  # a mean over fewer layers would rank a broken run before a whole one
            summary |= {
                "mean_relative_error": comparison.mean_relative_error if whole else np.nan,
                "signed_bias": comparison.signed_bias if whole else np.nan,
            }
        summary |= {"lost": sum(row["lost"] for row, _ in members), "unsettled": sum(row["unsettled"] for row, _ in members)}
        summaries.append(summary)
    return summaries


def summary_text(sweep, outcome):
    """What `hlcs sweep` prints."""
    import pandas as pd

    rows = summary_rows(sweep, outcome["rows"])
    failed = [row for row in outcome["rows"] if "error" in row]
    lines = [f"{sweep.title}: {how_many(len(sweep.tests), 'run')}, {outcome['ran']} now, {outcome['kept']} found in the store"]
    lines += [outcome["told"]] if outcome["told"] else []
    if rows:
        table = pd.DataFrame([{name: value for name, value in row.items() if not name.startswith("cv")} for row in rows])
        lines.append(table.to_string(index=False, na_rep="-", float_format=lambda value: f"{value:.4g}"))
    lines += [f"failed: {', '.join(f'{name} = {row[name]}' for name in sweep.names)}: {row['error']}" for row in failed]
    return "\n".join(lines)


def document(sweep, outcome):
    """The JSON of `hlcs sweep`."""
    return {
        "format": 1,
        "title": sweep.title,
        "runs": outcome["rows"],
        "summary": summary_rows(sweep, outcome["rows"]),
        "ran": outcome["ran"],
        "kept": outcome["kept"],
        "told": outcome["told"],
        "versions": versions(),
    }


def write_sweep(sweep, outcome, folder):
    """runs.csv, summary.csv and sweep.json into an existing folder."""
    import pandas as pd

    content = document(sweep, outcome)
    texts = {
        "runs.csv": csv_text(pd.DataFrame(content["runs"]).to_dict("list")),
        "summary.csv": csv_text(pd.DataFrame(content["summary"]).to_dict("list")),
        "sweep.json": folders.to_json(content),
    }

    def write(place):
        for name, text in texts.items():
            folders.write_text(place / name, text)

    folders.keep(write, folder, texts["sweep.json"])


def _row(result):
    """The numbers of a result that a table of runs shows, or why there are none."""
    if "error" in result:
        return {"error": str(result["error"])}
    layers = result["layers"]
    return {
        **{f"k{row['layer']}": row["k"] for row in layers},
        "structure": result.get("structure", True),  # rows of earlier versions do not say
        "height_over_dn": result["height_over_dn"],
        "porosity": result["porosity"],
        "lost": sum(row["lost"] for row in layers),
        "unsettled": sum(row["unsettled"] for row in layers),
        "max_penetration_over_dn": result["max_penetration_over_dn"],
        "wall_seconds": result["wall_seconds"],
    }
