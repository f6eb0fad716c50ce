"""One SQLite file of runs, one row a run, keyed by the hash of its settings: what was killed and started again goes on."""

import datetime
import hashlib
import json
import sqlite3
from pathlib import Path

from hlcs import files
from minibullet.errors import InputError

CREATE = """
CREATE TABLE IF NOT EXISTS runs (
    key TEXT PRIMARY KEY,      -- sha256 of the settings
    settings TEXT NOT NULL,    -- JSON
    result TEXT NOT NULL,      -- JSON
    versions TEXT NOT NULL,    -- JSON: what computed it
    finished TEXT NOT NULL     -- ISO time, UTC
) WITHOUT ROWID
"""


def key_of(settings):
    """The hash of settings: a dictionary of plain values; the order of its keys does not matter."""
    return hashlib.sha256(json.dumps(settings, sort_keys=True, allow_nan=False).encode()).hexdigest()


class Store:
    """A file of finished runs. Only whole runs are ever in it; several processes may write to it."""

    def __init__(self, path):
        self.path = Path(path)
        if self.path.is_dir():
            raise InputError(f"store '{path}' is a folder; give the name of a file such as runs.sqlite")
        try:
            self.path.absolute().parent.mkdir(parents=True, exist_ok=True)
            self._connection = sqlite3.connect(self.path, timeout=60.0)
            with self._connection:
                self._connection.execute(CREATE)
            columns = {row[1] for row in self._connection.execute("PRAGMA table_info(runs)")}
        except (sqlite3.Error, OSError) as problem:
            raise InputError(f"store '{path}' cannot be used ({problem}); give a new file or an earlier store") from None
        if not {"key", "settings", "result", "versions", "finished"} <= columns:
            raise InputError(f"store '{path}' holds another program's table 'runs'; give a new file or an earlier store")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._connection.close()

    def __len__(self):
        return self._connection.execute("SELECT count(*) FROM runs").fetchone()[0]

    def __contains__(self, key):
        return self._connection.execute("SELECT 1 FROM runs WHERE key = ?", (key,)).fetchone() is not None

    def result(self, key):
        """The result of a run as a dictionary, None where it is not there yet."""
        row = self._connection.execute("SELECT result FROM runs WHERE key = ?", (key,)).fetchone()
        return None if row is None else json.loads(row[0])

    def add(self, settings, result):
        """Keep a finished run; one that is there already stays as it is."""
        row = (key_of(settings), json.dumps(settings, sort_keys=True), files.to_json(result), files.to_json(files.versions()),
               datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"))
        try:
            with self._connection:
                self._connection.execute("INSERT OR IGNORE INTO runs VALUES (?, ?, ?, ?, ?)", row)
        except sqlite3.Error as problem:
            raise InputError(f"store '{self.path}' cannot be written ({problem}); free some space or give another file") from None
