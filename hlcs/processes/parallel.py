"""Independent runs in several processes. What comes back depends on the tasks alone, never on how many workers did them."""

import logging
import multiprocessing
import os
import signal
import sys
import threading
import time
import warnings
from concurrent.futures import FIRST_COMPLETED, CancelledError, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool

from hlcs.processes import interrupts
from minibullet.errors import InputError, RunError

UNGUARDED = 79  # exit status of a worker that met, in the script it read, the call it is to work for; no other meaning has it
ENDING = 5.0  # how long the workers of a broken pool may take to end [s]
DESERTED = 30.0  # how long a Dask scheduler may be without workers; one that starts again is there in a few seconds [s]
GUARD = (
    "a worker process ended before its work was done: it read the script again and met the same call there. Put what calls "
    'hlcs under `if __name__ == "__main__":`'
)


def cores():
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def each(function, tasks, workers=None, most=None):
    """Yield (index, function(task)) for every task, in the order they end; workers: processes, None = as many as processors.

    function must be importable (a plain function of a module). tasks may be a generator: the next one is drawn when a worker
    is free; `most` is then how many it has at most. Processes are started afresh ("spawn"), so nothing of this process leaks
    into a run; for that Python reads the script that called again, so its calls belong under `if __name__ == "__main__":`
    (InputError where they do not). The first exception ends everything; so does leaving the loop early. RunError where a
    worker was killed.
    """
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        raise SystemExit(UNGUARDED)  # a worker that reads the script met the call it is to work for; who started it says so
    if most is None:
        tasks = list(tasks)
        most = len(tasks)
    if workers is not None and (isinstance(workers, bool) or workers != int(workers) or workers < 1):
        raise InputError(f"workers = {workers!r}; must be a whole number >= 1")
    workers = min(int(workers or cores()), most)
    if workers <= 1:
        for index, task in enumerate(tasks):
            interrupts.check()
            yield index, function(task)
        return
    executor = ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"), initializer=_obey)
    before, children = set(multiprocessing.active_children()), set()
    try:
        yield from _drawn(
            executor, function, tasks, lambda: workers, lambda: children.update(set(multiprocessing.active_children()) - before)
        )
    except BaseException as problem:
        for child in children:
            child.terminate()
        executor.shutdown(wait=False, cancel_futures=True)
        if isinstance(problem, BrokenProcessPool):
            raise _ended(children) from None
        raise
    executor.shutdown()


def each_on_dask(address, function, tasks):
    """Like `each`, on the workers of the Dask scheduler at `address`; RunError where it is lost."""
    try:
        from distributed import Client
        from distributed.scheduler import KilledWorker
    except ImportError:
        how = "python -m pip install -e '.[sweep]' in the folder of the project"
        raise InputError(f"--dask needs the extra 'sweep': {how}") from None
    try:
        client = Client(address, timeout=10)
    except (OSError, ValueError, TimeoutError) as problem:
        raise InputError(f"dask: no scheduler answers at '{address}' ({problem}); start one with: dask scheduler") from None

    for name in ("distributed", "distributed.client"):  # what it has to say of a lost scheduler is said below, in one line
        logging.getLogger(name).setLevel(logging.CRITICAL)
    met = time.monotonic()

    def room():
        return 2 * sum(client.nthreads().values())  # one in work and one at hand for each thread

    def alive():
        nonlocal met
        if client.status != "running":
            raise RunError(f"dask: the scheduler at '{address}' is lost; start it and its workers again")
        if room():
            met = time.monotonic()
        elif time.monotonic() - met > DESERTED:
            raise RunError(f"dask: '{address}' has had no worker for {DESERTED:.0f} s; start one with: dask worker {address}")

    try:
        yield from _drawn(client.get_executor(pure=False), function, tasks, room, alive)
    except (OSError, TimeoutError, CancelledError, KilledWorker) as problem:
        alive()
        raise RunError(f"dask: the workers of '{address}' are lost ({type(problem).__name__}: {problem})") from None
    finally:
        client.close(timeout=2)


def in_order(function, tasks, workers=None, done=None):
    """[function(task) for task in tasks], in several processes; ``done()`` is called as each one ends."""
    tasks = list(tasks)
    values = [None] * len(tasks)
    for index, value in each(function, tasks, workers):
        values[index] = value
        if done is not None:
            done()
    return values


def _drawn(executor, function, tasks, room, look):
    """Yield (index, result) in the order they end. As many tasks are drawn as `room()` says; `look()` is called now and then."""
    tasks, running = enumerate(tasks), {}
    while True:
        while len(running) < room() and (drawn := next(tasks, None)) is not None:
            with interrupts.kept_from_children():  # a process that starts here would complain of Ctrl-C until `_obey` is reached
                running[executor.submit(function, drawn[1])] = drawn[0]
            look()
        if not running:
            if room():
                return
            time.sleep(1.0)
        ended, _ = wait(running, timeout=1.0, return_when=FIRST_COMPLETED)
        interrupts.check()
        look()
        for future in ended:
            yield running.pop(future), future.result()


def _ended(children):
    """What to say when a worker is gone: InputError where the script is to blame, RunError where not."""
    end = time.monotonic() + ENDING
    while any(child.exitcode is None for child in children) and time.monotonic() < end:
        time.sleep(0.01)  # a join that meets one of the pool's own returns before the status is known
    codes = {child.exitcode for child in children} - {None, 0}
    if UNGUARDED in codes:
        return InputError(GUARD)
    others = {-signal.SIGTERM, 1}  # are ended when the first one is gone, or lose their pipe to the pool as they start
    codes = codes - others or codes - {-signal.SIGTERM} or codes
    code = min(codes, default=0)
    how = f"was killed (signal {-code})" if code < 0 else f"ended with status {code}; what it printed stands above"
    memory = ", as the system does when memory runs out: take fewer workers" if code == -getattr(signal, "SIGKILL", 9) else ""
    return RunError(f"a worker process {how}{memory}")


def _obey():
    """What a worker does first: leave Ctrl-C, which reaches every process of a terminal, to the first one, and end with it; its
    warnings are one line each, as the command's own."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    warnings.showwarning = lambda message, *_, **__: print(f"hlcs: warning: {message}", file=sys.stderr, flush=True)
    threading.Thread(target=_end_with, args=(multiprocessing.parent_process(),), daemon=True).start()


def _end_with(parent):
    """End this process when its parent has ended, however it was killed: nobody would ever fetch the result."""
    parent.join()
    os._exit(1)
