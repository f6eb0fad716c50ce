"""Ctrl-C where compiled code calls Python: not raised there, where it would crash, but a moment later."""

import signal
import threading
import time

import pytest
from numba.core import serialize

from hlcs.processes import interrupts


def test_ctrl_c_waits_until_compiled_code_has_the_class_of_its_answer():
    """In Numba's own function nothing is raised; where the program goes on it is, once."""
    before = signal.getsignal(signal.SIGINT)
    inside = compile("frame = __import__('sys')._getframe()", serialize.__file__, "exec")
    place = {}
    exec(inside, place)  # a frame whose code stands in Numba's file
    try:
        interrupts.listen()
        interrupts._interrupt(signal.SIGINT, place["frame"])
        assert interrupts.seen()
        with pytest.raises(KeyboardInterrupt):
            time.sleep(30)
        interrupts.answered()
        assert not interrupts.seen()
        time.sleep(4 * interrupts.AGAIN)  # it does not come a second time
    finally:
        signal.signal(signal.SIGINT, before)
    assert threading.current_thread() is threading.main_thread()
