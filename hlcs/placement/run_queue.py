"""Runs that go through a store: what is missing is run, each result is stored as it ends, several processes share the rest."""

import time
from functools import partial

from hlcs.files import folders
from hlcs.placement.code_hash import code_hash
from hlcs.processes import interrupts, parallel
from minibullet.errors import InputError, RunError, how_many

PAUSE = 0.5  # between two looks at what others work on [s]


def finish(store, tests, function, settings_of, workers=None, dask=None, done=None, finished=0):
    """Run `tests`, a dictionary {key: test} of what a store does not hold; returns how many were run by this process.

    store: Store; function: one test in, a dictionary out, importable; settings_of: what a row keeps of a test; workers:
    processes; dask: address of a Dask scheduler in their place; done(): called as each run ends, here or elsewhere;
    finished: how many more the store holds already, for messages.
    A run that another process works on is not started; it is waited for, and taken over when that process is no more.
    """
    waiting, ran = dict(tests), 0
    while waiting:
        started = []
        each = partial(parallel.each_on_dask, dask) if dask else partial(parallel.each, workers=workers, most=len(waiting))
        try:
            for index, (code, result) in each(partial(_with_code_hash, function), _claimed(store, waiting, started)):
                if code != store.code:
                    raise RunError("a worker has another version of hlcs or of a library than this process; install the same")
                _add(store, settings_of(waiting[started[index]]), result)
                del waiting[started[index]]
                ran += 1
                done and done()
        except RunError as problem:
            total = finished + len(tests)
            raise _resumable(problem, store, total - len(waiting), total) from None
        for key in [key for key in waiting if key in store]:
            del waiting[key]
            done and done()
        if waiting:
            interrupts.check()
            time.sleep(PAUSE)
    return ran


def results(store, keys):
    """What the store holds of these runs, which have all been finished."""
    try:
        return [store.result(key) for key in keys]
    except RunError as problem:
        raise _resumable(problem, store, len(set(keys)), len(set(keys))) from None


def _resumable(problem, store, count, total):
    """The RunError `problem` with what is kept of the work and how to go on."""
    return RunError(
        f"{problem}; {count} of {total} runs are kept in '{store.path}', and the same command, typed again, goes on from there",
        problem.result,
    )


def unused_rows(store, keys):
    """What a user should know of the rows of these runs that are there and are not used; one line, or nothing."""
    others, damaged = store.rejected(keys)
    sentences = []
    if others:
        sentences.append(
            f"{how_many(others, 'run')} in the store made by other code (another version of hlcs or of a library): computed "
            "again, the earlier rows stay"
        )
    if damaged:
        sentences.append(f"{how_many(damaged, 'damaged row')} of the store: computed again")
    return "; ".join(sentences)


def _claimed(store, waiting, started):
    """Tests to start, each claimed when it is asked for; their keys go into `started`."""
    for key, test in list(waiting.items()):
        if store.claim(key):
            started.append(key)
            yield test


def _with_code_hash(function, test):
    """(hash of the code that runs here, result)."""
    return code_hash(), function(test)


def _add(store, settings, result):
    """Into the store; where the system refuses, RunError carries the result, which is nowhere else."""
    try:
        store.add(settings, result)
    except (RunError, InputError) as problem:
        raise RunError(f"{problem}; the run that had just ended is printed", folders.to_json(result)) from None
