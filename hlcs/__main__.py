"""`python -m hlcs` is the command `hlcs`."""

import sys

from hlcs.cli import main

if __name__ == "__main__":
    sys.exit(main())
