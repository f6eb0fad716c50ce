"""Tasks that wait for simulations: what all of them ask for next is simulated in one batch.

Each task is a plain function. It runs in a thread of its own, but never two at once: a task runs until it asks for a simulation,
then the next one does, in their order; when all wait, everything asked for is answered in one batch. So what comes back depends
on the tasks alone.
"""

import threading
from contextvars import copy_context
from itertools import islice

_here = threading.local()


class Abandoned(BaseException):
    """The work was given up: another task failed, or the user pressed Ctrl-C."""


class Task(threading.Thread):
    """One function on its way."""

    def __init__(self, function):
        super().__init__(daemon=True)
        self.function, self.result, self.error, self.ended = function, None, None, False
        self.requests = self.answers = None
        self._context = copy_context()  # what NumPy does with an overflow is as its caller wants it
        self._go, self._back = threading.Semaphore(0), threading.Semaphore(0)

    def run(self):
        """Body of the thread."""
        self._go.acquire()
        _here.task = self
        try:
            if not isinstance(self.answers, Abandoned):
                self.result = self._context.run(self.function)
        except BaseException as error:  # handed on by `run_tasks`
            self.error = error
        self.ended = True
        self._back.release()

    def advance(self):
        """Let it run until it asks again or ends (called by whoever waits for it)."""
        self._go.release()
        self._back.acquire()

    def abandon(self):
        """Make it end where it waits."""
        self.answers = Abandoned()
        self._go.release()

    def ask(self, requests):
        """Wait for the answers to requests (called by the task itself)."""
        self.requests = requests
        self._back.release()
        self._go.acquire()
        if isinstance(self.answers, Abandoned):
            raise self.answers
        return self.answers


def current_task():
    """The task that is running, or None outside of `run_tasks`."""
    return getattr(_here, "task", None)


def run_tasks(answer, functions):
    """[function() for function in functions], where what they ask for is answered together.

    answer: list of requests -> list of answers; a function asks by ``current_task().ask(requests)``. The first exception, in the
    order of the functions, ends everything.
    """
    functions = list(functions)
    if len(functions) < 2:
        return [function() for function in functions]
    tasks = [Task(function) for function in functions]
    for task in tasks:
        task.start()
    waiting = tasks
    try:
        while waiting:
            for task in waiting:
                task.advance()
                if task.error is not None:
                    raise task.error
            waiting = [task for task in waiting if not task.ended]
            answers = iter(answer([request for task in waiting for request in task.requests]) if waiting else [])
            for task in waiting:
                task.answers = list(islice(answers, len(task.requests)))
    finally:
        for task in tasks:
            if not task.ended:
                task.abandon()
    return [task.result for task in tasks]
