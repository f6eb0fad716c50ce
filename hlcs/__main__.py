"""`hlcs` and `python -m hlcs`. Nothing but the net is imported before it hangs."""

import os
import sys

from hlcs import interrupts, net


def main():
    """Run the command; returns the exit status."""
    status = net.under(_command)
    if interrupts.seen():  # all is tidied up and said; Python itself would end as killed where Ctrl-C had passed through `exec`
        os._exit(status)
    return status


def _command():
    from hlcs import cli

    return cli.run()


if __name__ == "__main__":
    sys.exit(main())
