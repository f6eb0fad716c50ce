"""Independent runs in several processes. What comes back depends on the tasks alone, never on how many workers did them."""

import multiprocessing
import os
import signal
import threading
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool

from hlcs import interrupts
from minibullet.errors import InputError

ENDED = ('a worker process ended before its work was done. In a script, put what calls hlcs under `if __name__ == "__main__":` '
         "(workers read the script again); otherwise it was killed or ran out of memory: take fewer workers")


def cores():
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def each(function, tasks, workers=None):
    """Yield (index, function(task)) for every task, in the order they end; workers: processes, None = as many as processors.

    function must be importable (a plain function of a module). Processes are started afresh ("spawn"), so nothing of this
    process leaks into a run; for that Python reads the script that called again, so its calls belong under
    `if __name__ == "__main__":` (InputError where they do not). The first exception ends everything; so does leaving the loop
    early.
    """
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        raise SystemExit(1)  # a worker that reads the script met the call it is to work for; whoever started it says so
    tasks = list(tasks)
    if workers is not None and (isinstance(workers, bool) or workers != int(workers) or workers < 1):
        raise InputError(f"workers = {workers!r}; must be a whole number >= 1")
    workers = min(int(workers or cores()), len(tasks))
    if workers <= 1:
        for index, task in enumerate(tasks):
            interrupts.check()
            yield index, function(task)
        return
    executor = ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"), initializer=_obey)
    before = set(multiprocessing.active_children())
    try:
        with interrupts.kept_from_children():  # which would complain of it, each for itself, until `_obey` is reached
            indices = {executor.submit(function, task): index for index, task in enumerate(tasks)}
        for future in as_completed(indices):
            interrupts.check()
            yield indices[future], future.result()
    except BaseException as problem:
        for child in set(multiprocessing.active_children()) - before:
            child.terminate()
        executor.shutdown(wait=False, cancel_futures=True)
        if isinstance(problem, BrokenProcessPool):
            raise InputError(ENDED) from None
        raise
    executor.shutdown()


def in_order(function, tasks, workers=None, done=None):
    """[function(task) for task in tasks], in several processes; ``done()`` is called as each one ends."""
    tasks = list(tasks)
    values = [None] * len(tasks)
    for index, value in each(function, tasks, workers):
        values[index] = value
        if done is not None:
            done()
    return values


def _obey():
    """What a worker does first: leave Ctrl-C, which reaches every process of a terminal, to the first one, and end with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(multiprocessing.parent_process(),), daemon=True).start()


def _end_with(parent):
    """End this process when its parent has ended, however it was killed: nobody would ever fetch the result."""
    parent.join()
    os._exit(1)
