"""Every place where a command touches the disk or a store, made to fail: one place a run, as SQLite's own tests do it.

A point is one call to the system in the folder of the trial: opening a file for writing, writing, closing, making a folder,
renaming, flushing to disk, removing, and every call of SQLite.
"""

import builtins
import contextlib
import errno
import io
import os
import signal
import sqlite3
import threading

CALLS = {
    "mkdir": errno.ENOSPC,
    "rename": errno.ENOSPC,
    "replace": errno.ENOSPC,
    "fsync": errno.ENOSPC,
    "unlink": errno.EIO,
    "remove": errno.EIO,
    "rmdir": errno.EIO,
}
REMOVALS = ("unlink", "remove", "rmdir")
ROOMLESS = (*REMOVALS, "rename", "replace", "close")  # what a full disk still does
MODES = ("once", "full", "killed")


class Faults:
    """Counts points under a folder; at point `at` (from 1) something happens, once or from then on.

    mode: "once": that call fails; "full": it fails and so do all later ones that need room; "killed": the process ends as by
    kill -9. at = 0: nothing happens, points are counted.
    """

    def __init__(self, folder, at=0, mode="once"):
        self.folder, self.at, self.mode, self.count, self.what = str(folder), at, mode, 0, None

    def __enter__(self):
        self._stack = contextlib.ExitStack()
        real = {name: getattr(os, name) for name in CALLS}
        for name in CALLS:
            self._patch(os, name, self._call(name, real[name]))
        opened = io.open
        for module in (builtins, io):
            self._patch(module, "open", lambda file, mode="r", *rest, **words: self._open(opened, file, mode, *rest, **words))
        connect, faults = sqlite3.connect, self

        class Connection(sqlite3.Connection):
            def execute(self, text, *values):
                faults._sql(text)
                return super().execute(text, *values)

        self._patch(
            sqlite3,
            "connect",
            lambda *places, **words: (faults._sql("connect"), connect(*places, factory=Connection, **words))[1],
        )
        return self

    def __exit__(self, *_):
        self._stack.close()

    def _patch(self, module, name, value):
        before = getattr(module, name)
        setattr(module, name, value)
        self._stack.callback(setattr, module, name, before)

    def _due(self, what):
        """Whether the call that is about to be made fails."""
        if threading.current_thread() is not threading.main_thread():
            return False  # the beat of a store's owner comes when it comes
        self.count += 1
        if self.count == self.at:
            self.what = what
            if self.mode == "killed":
                os.kill(os.getpid(), signal.SIGKILL)
            return True
        return self.mode == "full" and 0 < self.at < self.count and what.split(" ")[0] not in ROOMLESS

    def _here(self, path):
        return isinstance(path, str | os.PathLike) and os.path.abspath(path).startswith(self.folder)

    def _call(self, name, real):
        def call(path, *rest, **words):
            if (name == "fsync" or words.get("dir_fd") is not None or self._here(path)) and self._due(f"{name} {path}"):
                raise OSError(CALLS[name], os.strerror(CALLS[name]), str(path))
            return real(path, *rest, **words)

        return call

    def _open(self, real, file, mode, *rest, **words):
        if not self._here(file) or not set(mode) & set("wax+"):
            return real(file, mode, *rest, **words)
        if self._due(f"open {file}"):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(file))
        return Written(real(file, mode, *rest, **words), self)

    def _sql(self, text):
        if self._due(f"sqlite {text.split()[0]}"):
            raise sqlite3.OperationalError("database or disk is full")


class Written:
    """A file that is written to: half of a failing write arrives, as on a disk that fills up."""

    def __init__(self, file, faults):
        self._file, self._faults = file, faults

    def __getattr__(self, name):
        return getattr(self._file, name)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def write(self, data):
        if self._faults._due(f"write {self._file.name}"):
            self._file.write(data[: len(data) // 2])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(self._file.name))
        return self._file.write(data)

    def close(self):
        due = self._faults._due(f"close {self._file.name}")
        self._file.close()
        if due:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(self._file.name))
