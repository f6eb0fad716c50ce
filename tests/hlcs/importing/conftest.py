"""Exports written by hand to the documented formats, imported into an empty folder."""

import csv

import pytest

import hlcs


@pytest.fixture
def imported(tmp_path, monkeypatch):
    """Import a text, bytes or {name: text} as a format; returns (Imported, {csv name: {column: [cells]}})."""
    monkeypatch.chdir(tmp_path)

    def run(files, form, **overrides):
        files = files if isinstance(files, dict) else {"drop.csv": files}
        for name, content in files.items():
            (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
        found = hlcs.import_measurements(list(files), form, "out", **overrides)
        tables = {}
        for name in found.files:
            with open(tmp_path / "out" / name, newline="") as stream:
                header, *rows = csv.reader(stream)
            tables[name] = {column: [row[k] for row in rows] for k, column in enumerate(header)}
        return found, tables

    return run


@pytest.fixture
def refused(imported):
    """The one line with which an import is refused; it holds all the words."""

    def run(files, form, *words, **overrides):
        with pytest.raises(hlcs.InputError) as problem:
            imported(files, form, **overrides)
        message = str(problem.value)
        assert "\n" not in message and all(word in message for word in words), message
        return message

    return run
