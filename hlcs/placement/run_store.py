"""One SQLite file of runs, one row a run: what was killed and started again goes on, and several may work on it at once.

A row is found by the hash of its settings and the hash of the code that made it (`hlcs.placement.code_hash`). Rows of other
code, and of stores from before that hash was kept, stay in the file and are never handed out. A run that somebody works on is
claimed; the claim of a process that is no more, or that has not said for a while that it is, counts for nothing. Claims save
work, no more: a run done twice by the same code gives the same numbers.
"""

import datetime
import hashlib
import json
import os
import platform
import secrets
import sqlite3
import tempfile
import threading
import time
from contextlib import closing, contextmanager
from pathlib import Path

from hlcs.files import folders
from hlcs.files.versions import versions
from hlcs.placement.code_hash import code_hash
from minibullet.errors import InputError, RunError
from minibullet.files.writing import refused

RUNS = """
CREATE TABLE {runs} (
    key TEXT NOT NULL,         -- sha256 of the settings
    code TEXT NOT NULL,        -- hash of the code that made it; empty: made before that was kept
    settings TEXT NOT NULL,    -- JSON
    result TEXT NOT NULL,      -- JSON
    versions TEXT NOT NULL,    -- JSON: what computed it
    finished TEXT NOT NULL,    -- ISO time, UTC
    PRIMARY KEY (key, code)
) WITHOUT ROWID
"""
CLAIMS = """
CREATE TABLE IF NOT EXISTS claims (
    key TEXT NOT NULL,
    code TEXT NOT NULL,
    host TEXT NOT NULL,        -- who works on it
    process INTEGER NOT NULL,
    owner TEXT NOT NULL,
    seen REAL NOT NULL,        -- when its owner last said so, s since 1970
    PRIMARY KEY (key, code)
) WITHOUT ROWID
"""
FIRST = ("key", "settings", "result", "versions", "finished")  # columns of the first stores
BUSY = 10.0  # longest wait for others that write; every change takes milliseconds [s]
BEAT = 2.0  # how often an owner says that it lives [s]
LATE = 15 * BEAT  # silence after which it counts as dead; a busy machine delays a beat by a few seconds [s]
# what the file that the user named is to blame for; all else (a full disk, a lock) is not the input's fault
INPUT = (sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_READONLY, sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_PERM)


def key_of(settings):
    """The hash of settings: a dictionary of plain values; the order of its keys does not matter."""
    return hashlib.sha256(json.dumps(settings, sort_keys=True, allow_nan=False).encode()).hexdigest()


def default_store(name):
    """Path of a store of that name where simulations are kept: in $HLCS_CACHE, or in hlcs under the user's cache folder or,
    failing that, under the temporary one."""
    chosen = os.environ.get("HLCS_CACHE")
    folder = Path(chosen) if chosen else Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "hlcs"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        usable = os.access(folder, os.W_OK)
    except OSError:
        usable = False
    return (folder if usable or chosen else Path(tempfile.gettempdir()) / "hlcs") / name


def _dictionary(row):
    """The row itself, where it is what every result is."""
    if not isinstance(row, dict):
        raise TypeError
    return row


class Store:
    """A file of finished runs. Only whole runs are ever in it.

    path: the file, made where it is not there; read: what turns a stored dictionary into what `result` gives (a row it cannot
    read, KeyError, TypeError or ValueError, counts as not there); code: hash of the code whose rows are wanted.
    InputError where the file can be no store, RunError where the system fails.
    """

    def __init__(self, path, read=None, code=None):
        self.code = code or code_hash()
        self._read, self._owner, self._heart = read or _dictionary, secrets.token_hex(8), None
        self.path = Path(path).expanduser().absolute()
        with self._explained("used"):
            if self.path.is_dir():
                raise InputError(f"store '{path}' is a folder; give the name of a file such as runs.sqlite")
            if self.path.exists() and not self.path.is_file():
                raise InputError(f"store '{path}' is no regular file; give the name of a file such as runs.sqlite")
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._connection = self._connect()
            try:
                self._prepare()
            except BaseException:
                self._connection.close()
                raise

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self._heart is not None:
            self._heart.set()
            try:
                self._connection.execute("DELETE FROM claims WHERE owner = ?", (self._owner,))
            except sqlite3.Error:
                pass  # they end by themselves when they are late
        self._connection.close()

    def __len__(self):
        """Rows of this code."""
        with self._explained("read"):
            return self._connection.execute("SELECT count(*) FROM runs WHERE code = ?", (self.code,)).fetchone()[0]

    def __contains__(self, key):
        return self.result(key) is not None

    def result(self, key):
        """The result of a run as `read` gives it, None where it is not there yet or its row is damaged."""
        with self._explained("read"):
            row = self._connection.execute("SELECT result FROM runs WHERE key = ? AND code = ?", (key, self.code)).fetchone()
        try:
            return None if row is None else self._read(json.loads(row[0]))
        except (KeyError, TypeError, ValueError, RecursionError):
            return None

    def rejected(self, keys):
        """(how many of these runs are there from other code only, how many are there but damaged)."""
        with self._explained("read"):
            rows = [self._connection.execute("SELECT code FROM runs WHERE key = ?", (key,)).fetchall() for key in keys]
        ours = (self.code.encode(),)
        damaged = sum(ours in found and key not in self for key, found in zip(keys, rows, strict=True))
        return sum(bool(found) and ours not in found for found in rows), damaged

    def add(self, settings, result):
        """Keep a finished run; one that is there already stays as it is, unless it is damaged."""
        key = key_of(settings)
        row = (
            key,
            self.code,
            json.dumps(settings, sort_keys=True),
            folders.to_json(result),
            folders.to_json(versions()),
            datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        )
        with self._explained("written"), self._changing() as connection:
            if key not in self:
                connection.execute("INSERT OR REPLACE INTO runs VALUES (?, ?, ?, ?, ?, ?)", row)
            connection.execute("DELETE FROM claims WHERE key = ? AND code = ?", (key, self.code))

    def claim(self, key):
        """Take a run to work on; False where it is there already or another that lives works on it."""
        if key in self or self._taken(key):
            return False
        with self._explained("written"), self._changing() as connection:
            if key in self or self._taken(key):  # asked again, now that nobody else can write
                return False
            connection.execute(
                "INSERT OR REPLACE INTO claims VALUES (?, ?, ?, ?, ?, ?)",
                (key, self.code, platform.node(), os.getpid(), self._owner, time.time()),
            )
        if self._heart is None:
            self._heart = threading.Event()
            threading.Thread(target=self._beat, daemon=True).start()
        return True

    def _taken(self, key):
        """Whether somebody else who lives works on a run."""
        with self._explained("read"):
            found = self._connection.execute(
                "SELECT host, process, owner, seen FROM claims WHERE key = ? AND code = ?", (key, self.code)
            ).fetchone()
        if found is None:
            return False
        host, process, owner, seen = found
        here = host.decode(errors="replace") == platform.node()
        gone = abs(time.time() - seen) > LATE or here and not folders.runs(process)
        return owner.decode(errors="replace") != self._owner and not gone

    def _beat(self):
        """Say every now and then that the owner of our claims lives, until it has done with them."""
        while not self._heart.wait(BEAT):
            try:
                with closing(self._connect()) as connection:
                    connection.execute("UPDATE claims SET seen = ? WHERE owner = ?", (time.time(), self._owner))
            except (sqlite3.Error, OSError):
                pass  # at worst a run is done twice; what really ails the file is told where it is written

    def _connect(self):
        """A connection that begins no transaction by itself; texts come as bytes, since a damaged one may be no text."""
        connection = sqlite3.connect(self.path, timeout=BUSY, isolation_level=None)
        connection.text_factory = bytes
        return connection

    @contextmanager
    def _changing(self):
        """One change, whole or not at all, while nobody else can write."""
        connection = self._connection
        connection.execute("BEGIN IMMEDIATE")
        try:
            yield connection
            connection.execute("COMMIT")
        except BaseException:
            if connection.in_transaction:
                connection.rollback()
            raise

    def _prepare(self):
        """Make the tables where they are not there; give the rows of a first store a place for their code."""
        if self._columns("runs") >= {*FIRST, "code"} and self._columns("claims"):
            return
        with self._changing() as connection:
            columns = self._columns("runs")  # another process may have been quicker
            if not columns:
                connection.execute(RUNS.format(runs="runs"))
            elif not columns >= set(FIRST):
                raise InputError(f"store '{self.path}' holds another program's table 'runs'; give a new file or an earlier store")
            elif "code" not in columns:
                connection.execute(RUNS.format(runs="runs_by_code"))
                names = ", ".join(FIRST)
                connection.execute(f"INSERT INTO runs_by_code ({names}, code) SELECT {names}, '' FROM runs")
                connection.execute("DROP TABLE runs")
                connection.execute("ALTER TABLE runs_by_code RENAME TO runs")
            connection.execute(CLAIMS)

    def _columns(self, table):
        return {row[1].decode() for row in self._connection.execute(f"PRAGMA table_info({table})")}

    @contextmanager
    def _explained(self, what):
        """Turn what SQLite or the system refuses into one line."""
        try:
            yield
        except sqlite3.Error as problem:
            code = getattr(problem, "sqlite_errorcode", None)  # its lowest byte says what kind
            if code is not None and code & 0xFF in INPUT:
                raise InputError(
                    f"store '{self.path}' cannot be {what} ({problem}); give a new file or an earlier store, "
                    "or make this one writable"
                ) from None
            raise RunError(f"store '{self.path}' cannot be {what} ({problem})") from None
        except (OSError, ValueError) as problem:
            if isinstance(problem, InputError):
                raise
            raise refused(problem, f"store '{self.path}' cannot be {what}") from None
