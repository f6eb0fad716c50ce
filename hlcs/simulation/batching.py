"""Work that waits for simulations, many pieces at a time: what all of them ask for next is simulated in one go.

Each piece is a plain function. It runs in a thread of its own, but never two at once: a piece runs until it asks for a
simulation, then the next one does, in their order; when all wait, everything asked for is answered together. So what comes
back depends on the pieces alone.
"""

import threading

_here = threading.local()


class Abandoned(BaseException):
    """The work was given up: another piece failed, or the user pressed Ctrl-C."""


class Piece(threading.Thread):
    """One function on its way."""

    def __init__(self, function):
        super().__init__(daemon=True)
        self.function, self.result, self.error, self.ended = function, None, None, False
        self.requests = self.answers = None
        self._go, self._back = threading.Semaphore(0), threading.Semaphore(0)

    def run(self):
        """Body of the thread."""
        self._go.acquire()
        _here.piece = self
        try:
            if not isinstance(self.answers, Abandoned):
                self.result = self.function()
        except BaseException as error:  # handed on by `together`
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
        """Wait for the answers to requests (called by the piece itself)."""
        self.requests = requests
        self._back.release()
        self._go.acquire()
        if isinstance(self.answers, Abandoned):
            raise self.answers
        return self.answers


def asker():
    """The piece that is running, or None outside of `together`."""
    return getattr(_here, "piece", None)


def together(answer, functions):
    """[function() for function in functions], where what they ask for is answered together.

    answer: list of requests -> list of answers; a function asks by ``asker().ask(requests)``. The first exception, in the
    order of the functions, ends everything.
    """
    functions = list(functions)
    if len(functions) < 2:
        return [function() for function in functions]
    pieces = [Piece(function) for function in functions]
    for piece in pieces:
        piece.start()
    waiting = pieces
    try:
        while waiting:
            for piece in waiting:
                piece.advance()
                if piece.error is not None:
                    raise piece.error
            waiting = [piece for piece in waiting if not piece.ended]
            found = answer([request for piece in waiting for request in piece.requests]) if waiting else []
            place = 0
            for piece in waiting:
                piece.answers = found[place : place + len(piece.requests)]
                place += len(piece.requests)
    finally:
        for piece in pieces:
            if not piece.ended:
                piece.abandon()
    return [piece.result for piece in pieces]
