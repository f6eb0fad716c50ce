"""`hlcs` and `python -m hlcs`. Nothing but the net is imported before it hangs."""

import atexit
import os
import sys

try:
    from hlcs import interrupts, net
except KeyboardInterrupt:  # some milliseconds after the start, with nothing done
    os.write(2, b"hlcs: interrupted\n")
    os._exit(1)


def main():
    """Run the command; returns the exit status."""
    atexit.register(_end)  # what registers first runs last
    return net.under(_command)


def _command():
    from hlcs import cli

    return cli.run()


def _end():
    """After Ctrl-C, when all is tidied up and said: Python itself would end as if killed where it had passed through `exec`."""
    if interrupts.seen():
        os._exit(1)


if __name__ == "__main__":
    sys.exit(main())
