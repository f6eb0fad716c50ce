"""Ctrl-C that is never lost.

Python raises KeyboardInterrupt wherever the program happens to be. Inside a callback that a C library makes, such as the
compiler's as it reads its cache, nobody can pass it on: it is printed and forgotten, and the run goes on. So the command
remembers it here, and long work asks at safe places.
"""

import signal
import sys
import threading

_seen = threading.Event()


def listen():
    """Remember Ctrl-C from now on, besides raising KeyboardInterrupt; of one that gets lost in a callback nothing is printed."""
    _seen.clear()
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, _interrupt)
        sys.unraisablehook = _unraisable


def check():
    """KeyboardInterrupt where one was lost."""
    if _seen.is_set():
        raise KeyboardInterrupt


def _interrupt(number, frame):
    _seen.set()
    raise KeyboardInterrupt


def _unraisable(what):
    if not issubclass(what.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(what)
