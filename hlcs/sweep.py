"""Sweeps: every combination of some settings, each run kept as soon as it ends, so that a sweep can be killed and go on.

    title = "how much does friction matter"
    [placement]                     # what all runs share, as in `hlcs place TEST.toml`
    grid = "TPG"
    [sweep]                         # lists; every combination is run
    friction = [0.3, 0.6]
    seed = [1, 2, 3]
"""

import hashlib
import itertools
from dataclasses import dataclass

import numpy as np

from hlcs import files, parallel
from hlcs.experiment import PlacementTest
from hlcs.layer_compare import compare_layers, laboratory_for, repeated
from hlcs.placement_files import (
    KEYS,
    SURVEY_FILE,
    bottom_words,
    check_value,
    checked_table,
    make_placement,
    placement_table,
    survey_csv,
    with_bottom,
)
from hlcs.spreadsheets import csv_text
from hlcs.store import Store, key_of
from hlcs.toml_files import TomlFile, quoted
from minibullet.errors import InputError

MOST_RUNS = 100_000
SECTIONS = {"": ["title", "placement", "sweep"], "placement": list(KEYS), "sweep": list(KEYS)}


@dataclass(frozen=True)
class Sweep:
    """A sweep file, read and checked: names of what varies, and for each run its values and its test."""

    title: str
    names: tuple[str, ...]
    values: tuple[tuple, ...]  # of each run, one a name
    tests: tuple[PlacementTest, ...]


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
            file.fail(name, f"must be a list of one value or more, got {quoted(values)}", "sweep")
        if name in file.values.get("placement", {}):
            file.fail(name, "stands under [placement] too; leave one of the two out", "sweep")
    count = int(np.prod([len(values) for values in table.values()], dtype=float))
    if count > MOST_RUNS:
        raise InputError(f"{file.path}: {count} runs; at most {MOST_RUNS}: shorten a list of [sweep]")
    read = {**table}
    if "bottom" in table:  # a survey is read once, not for every run
        bottoms = {word: with_bottom({"bottom": word}, file, "sweep")["bottom"] for word in map(str, table["bottom"])}
        read["bottom"] = [bottoms[str(word)] for word in table["bottom"]]
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
            words = ", ".join(f"{name} = {quoted(value)}" for name, value in zip(table, run, strict=True))
            raise InputError(f"{file.path}: the run with {words}: {problem}") from None
    return Sweep(file.title(), tuple(table), tuple(runs), tuple(tests))


def settings_of(test):
    """What the key of a run is made of: every setting, and for a surveyed bed the hash of its points."""
    table = placement_table(test)
    if bottom_words(test.bottom) == SURVEY_FILE:
        table["bottom"] = "survey:" + hashlib.sha256(survey_csv(test.bottom).encode()).hexdigest()
    return table


def run_one(test):
    """The result of one run as a dictionary; a run that physics refuses gives its complaint under "error"."""
    try:
        return test.run().to_dict()
    except InputError as problem:
        return {"error": str(problem)}


def run_sweep(sweep, store_path, workers=None, dask=None, progress=None):
    """Run what is not yet in the store; returns {"rows": one dictionary a run, "ran": how many now, "kept": found there}.

    workers: processes; dask: address of a Dask scheduler in their place; progress(total, kept) gives the function to be
    called as each run ends.
    """
    keys = [key_of(settings_of(test)) for test in sweep.tests]
    with Store(store_path) as store:
        waiting = {key: test for key, test in zip(keys, sweep.tests, strict=True) if key not in store}
        kept = len(set(keys)) - len(waiting)
        tests = list(waiting.values())
        done = progress(len(set(keys)), kept) if progress else None
        each = parallel.each(run_one, tests, workers) if dask is None else _on_dask(run_one, tests, dask)
        failed = {}
        for index, result in each:
            if "error" in result:
                failed[key_of(settings_of(tests[index]))] = result["error"]
            else:
                store.add(settings_of(tests[index]), result)
            if done is not None:
                done()
        rows = []
        for key, values in zip(keys, sweep.values, strict=True):
            found = {"error": failed[key]} if key in failed else _row(store.result(key))
            rows.append(dict(zip(sweep.names, values, strict=True)) | found)
    return {"rows": rows, "ran": len(tests), "kept": kept}


def summary_rows(sweep, rows):
    """Repeats (runs that differ in the seed alone) as one row: the settings, tests, mean and CV of every k, the error."""
    names = [name for name in sweep.names if name != "seed"]
    cases = {}
    for row, test in zip(rows, sweep.tests, strict=True):
        if "error" not in row:
            cases.setdefault(tuple(map(repr, (row[name] for name in names))), []).append((row, test))
    found = []
    for members in cases.values():
        first, test = members[0]
        model = repeated([[row[f"k{j + 1}"] for j in range(test.layers)] for row, _ in members])
        summary = {name: first[name] for name in names} | {"tests": len(members)}
        summary |= {f"k{j + 1}": float(k) for j, k in enumerate(model.mean)}
        summary |= {f"cv{j + 1}": float(cv) for j, cv in enumerate(model.cv)}
        measured = laboratory_for(test)
        if measured is not None:
            comparison = compare_layers(model, measured)
            summary |= {"mean_relative_error": comparison.mean_relative_error, "signed_bias": comparison.signed_bias}
        summary |= {"lost": sum(row["lost"] for row, _ in members), "unsettled": sum(row["unsettled"] for row, _ in members)}
        found.append(summary)
    return found


def summary_text(sweep, outcome):
    """What `hlcs sweep` prints."""
    import pandas as pd

    rows = summary_rows(sweep, outcome["rows"])
    failed = [row for row in outcome["rows"] if "error" in row]
    lines = [f"{sweep.title}: {len(sweep.tests)} runs, {outcome['ran']} now, {outcome['kept']} found in the store"]
    if rows:
        table = pd.DataFrame([{name: value for name, value in row.items() if not name.startswith("cv")} for row in rows])
        lines.append(table.to_string(index=False, float_format=lambda value: f"{value:.4g}"))
    lines += [f"failed: {', '.join(f'{name} = {row[name]}' for name in sweep.names)}: {row['error']}" for row in failed]
    return "\n".join(lines)


def document(sweep, outcome):
    """The JSON of `hlcs sweep`."""
    return {"format": 1, "title": sweep.title, "runs": outcome["rows"], "summary": summary_rows(sweep, outcome["rows"]),
            "ran": outcome["ran"], "kept": outcome["kept"], "versions": files.versions()}


def write_sweep(sweep, outcome, folder):
    """runs.csv, summary.csv and sweep.json into an existing folder."""
    import pandas as pd

    found = document(sweep, outcome)
    files.write_text(folder / "runs.csv", csv_text(pd.DataFrame(found["runs"])))
    files.write_text(folder / "summary.csv", csv_text(pd.DataFrame(found["summary"])))
    files.write_json(folder / "sweep.json", found)


def _row(result):
    """The numbers of a result that a table of runs shows."""
    layers = result["layers"]
    return {**{f"k{row['layer']}": row["k"] for row in layers}, "height_over_dn": result["height_over_dn"],
            "porosity": result["porosity"], "lost": sum(row["lost"] for row in layers),
            "unsettled": sum(row["unsettled"] for row in layers), "max_penetration_over_dn": result["max_penetration_over_dn"],
            "wall_seconds": result["wall_seconds"]}


def _on_dask(function, tasks, address):
    """Like `parallel.each`, on the workers of a Dask scheduler."""
    try:
        from distributed import Client, as_completed
    except ImportError:
        raise InputError("--dask needs the extra 'sweep': pip install 'hlcs[sweep]'") from None
    try:
        client = Client(address, timeout=10)
    except (OSError, ValueError, TimeoutError) as problem:
        raise InputError(f"dask: no scheduler answers at '{address}' ({problem}); start one with: dask scheduler") from None
    with client:
        numbers = {}
        for index, task in enumerate(tasks):
            numbers[client.submit(function, task, pure=False)] = index
        for future in as_completed(numbers):
            yield numbers[future], future.result()
