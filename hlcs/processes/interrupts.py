"""Ctrl-C that is never lost.

Python raises KeyboardInterrupt wherever the program happens to be. Inside a callback that a C library makes nobody can pass it
on: it is printed and forgotten, and the run goes on; in the compiler it may crash the interpreter; in an import it may come out
as an error of another name. So the command remembers it here and raises it a moment later; and where what is finished is about
to be put in place, the work asks.
"""

import _thread
import signal
import sys
import threading
from contextlib import contextmanager

AGAIN = 0.05  # after so long one that was lost or must wait is raised once more [s]
COMPILER = ("numba", "llvmlite")  # packages that an exception must not leave halfway

_seen = threading.Event()
_lost = threading.Event()  # nobody could pass it on, or it must wait


def listen():
    """Remember Ctrl-C from now on, besides raising KeyboardInterrupt; of one that gets lost in a callback nothing is printed."""
    _seen.clear()
    _lost.clear()
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, _interrupt)
        sys.unraisablehook = _unraisable


def seen():
    """Whether Ctrl-C came since `listen`."""
    return _seen.is_set()


def answered():
    """Ctrl-C did what it was for, and the work goes on: nothing raises it once more. The next one counts anew."""
    _seen.clear()
    _lost.clear()


@contextmanager
def held_off():
    """No Ctrl-C while the last words are said: the first one is being answered, a second would only garble it."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    _lost.clear()
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def kept_from_children():
    """Processes that are started in this block never hear of Ctrl-C, from their first moment on; here it comes a little later."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # as it starts it would take the mask away
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def check():
    """KeyboardInterrupt where one was lost."""
    if _seen.is_set():
        _lost.clear()
        raise KeyboardInterrupt


def _interrupt(number, frame):
    _seen.set()
    if _in_compiler(frame):
        _soon()
    else:
        raise KeyboardInterrupt


def _in_compiler(frame):
    """Is Numba at work: compiling, loading what it compiled, or asked by compiled code for the class of an answer?

    An exception there leaves machine code half made or comes out as another error, and either may crash the interpreter.
    """
    while frame is not None and frame.f_globals.get("__name__", "").partition(".")[0] not in COMPILER:
        frame = frame.f_back
    return frame is not None


def _unraisable(what):
    if issubclass(what.exc_type, KeyboardInterrupt):
        _soon()
    elif not _seen.is_set():  # what Ctrl-C broke off, such as a half compiled function, may fail once more as it is thrown away
        sys.__unraisablehook__(what)


def _soon():
    """Raise Ctrl-C a moment later, where it can be passed on."""
    _lost.set()
    again = threading.Timer(AGAIN, _once_more)
    again.daemon = True
    again.start()


def _once_more():
    if _lost.is_set():
        _lost.clear()
        if hasattr(signal, "pthread_kill"):  # a real one ends a wait, too
            signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
        else:
            _thread.interrupt_main()
