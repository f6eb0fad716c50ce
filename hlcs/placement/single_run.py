"""What one run of a placement test leaves in a store: plain functions of a test, which any process can be asked for.

`hlcs.placement.code_hash` follows the imports from this module: what it reaches can change a stored result, and nothing else can.
"""

import os
import signal
import threading
from contextlib import contextmanager
from functools import cache

import numpy as np

from hlcs.placement.procedure import PlacementTest
from minibullet.errors import InputError

# processor time for a test of 190 units, ten times what one takes: a candidate that stalls the physics is given up [s]
LIMIT = 40.0
COMPILER = f"{os.sep}numba{os.sep}"  # in the file names of Numba's own code
AGAIN = 0.1  # after which the limit strikes again: what it raised may be lost in a callback, where nobody can pass it on [s]


def result_of(test):
    """The result of one run as a dictionary; a run that physics refuses gives its complaint under "error"."""
    try:
        return test.run().to_dict()
    except InputError as problem:
        return {"error": str(problem)}


def layer_coefficients_of(test):
    """Layer coefficients (nan where no plate found support) and lost units of one test, or the complaint of the physics: plain
    values for the store."""
    _warm()
    units = sum(len(test.centres(layer)) for layer in range(1, test.layers + 1))
    try:
        with at_most(LIMIT * max(1.0, units / 190.0)):
            result = test.run()
    except InputError as problem:
        return {"error": str(problem)}
    return {"k": [float(k) for k in result.layer_coefficients], "lost": int(np.sum(result.lost))}


@cache
def _warm():
    """Compile, once a process, before time is taken."""
    PlacementTest(layers=2, rows=2, columns=2, time_step=1.0 / 60.0, settle_time=0.5).run()


def _callers(frame):
    """A frame and all that it was called from."""
    while frame is not None:
        yield frame
        frame = frame.f_back


@contextmanager
def at_most(seconds):
    """InputError when the block has taken so much processor time; where that cannot be had (no POSIX, a thread), no limit."""
    if not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
        yield
        return

    over = []

    def stop(number, frame):
        if any(COMPILER in each.f_code.co_filename for each in _callers(frame)):
            return  # compiled code is taking its arguments, where an exception would crash it; the limit strikes again
        over.append(InputError(f"took more than {seconds:.0f} s of processor time"))
        raise over[-1]

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds, AGAIN)
    try:
        yield
    except Exception:  # compiled code hands a signal's complaint on as SystemError, a check of numbers as one of its own
        if over:
            raise over[-1] from None
        raise
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
