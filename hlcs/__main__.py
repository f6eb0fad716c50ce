"""`hlcs` and `python -m hlcs`. Nothing but the handling of errors is imported before it is in place."""

import os
import sys

try:
    import atexit
    import signal
    import threading

    from hlcs.cli import error_handling
    from hlcs.processes import interrupts
except KeyboardInterrupt:  # some milliseconds after the start, with nothing done
    os.write(2, b"hlcs: interrupted\n")
    os._exit(1)


def main():
    """Run the command; returns the exit status."""
    ended = []
    atexit.register(_end, ended)  # what registers first runs last
    ended.append(error_handling.handled(_command))
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # all is done and said
    if any(not thread.daemon for thread in threading.enumerate() if thread is not threading.main_thread()):
        # Python would wait for them, and one that an effects file started may never end
        atexit._run_exitfuncs()
        error_handling.flush()
        os._exit(ended[0])
    return ended[0]


def _command():
    from hlcs.cli import commands

    return commands.run()


def _end(ended):
    """After Ctrl-C, when all is tidied up: Python itself would end as if killed where it had passed through `exec`."""
    if interrupts.seen():
        os._exit(*ended or (1,))


if __name__ == "__main__":
    sys.exit(main())
