"""Ctrl-C while the compiler works: not raised there, where it may crash the interpreter, but a moment later."""

import signal
import sys
import threading
import time

import numba
import pytest

from hlcs.processes import interrupts


@pytest.mark.parametrize("depth", [0, 1])
def test_ctrl_c_waits_until_the_compiler_is_done(depth):
    """Nothing is raised in a function of Numba, nor in one that it called; where the program goes on it is, once."""
    before = signal.getsignal(signal.SIGINT)
    frames = eval("[look(0), call(look)]", {"__name__": numba.core.__name__, "look": sys._getframe, "call": lambda look: look(0)})
    try:
        interrupts.listen()
        interrupts._interrupt(signal.SIGINT, frames[depth])
        assert interrupts.seen()
        with pytest.raises(KeyboardInterrupt):
            time.sleep(30)
        interrupts.answered()
        assert not interrupts.seen()
        time.sleep(4 * interrupts.AGAIN)  # it does not come a second time
    finally:
        signal.signal(signal.SIGINT, before)
    assert threading.current_thread() is threading.main_thread()
