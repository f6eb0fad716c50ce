"""The engine's kernels compiled before its first step, in two processes at once."""

import sys

from hlcs.processes import parallel
from minibullet import compilation, kernels


def compile_engine(quiet=False):
    """Compile the kernels of a step where nothing has been compiled yet of this version, and say so in one line."""
    if not kernels.cold() or parallel.cores() < 2:
        return  # on one core it is compiled as it is called, in the same time
    if not quiet:
        print(
            "hlcs: compiling the engine for this machine, once: about a minute of computing, two on a slow machine",
            file=sys.stderr,
            flush=True,
        )
    for _ in parallel.each(_compile, range(len(compilation.PARTS))):
        pass


def _compile(part):
    compilation.PARTS[part]()
