"""How kernels are compiled: the only room that knows Numba.

``kernel`` compiles a function of numbers and arrays. ``leaf`` does the same for a function that makes no arrays, and calls only
such functions: it takes part in no reference counting, which can cost a small function that is handed rows of arrays more
than its arithmetic (Numba keeps that option to itself, `_nrt`; without it everything runs the same, more slowly). And it is
compiled into its callers, so that a record of arrays costs nothing to hand on: a sweep takes half the time.

Compiled code is kept on disk, in a folder named after the hash of this package. Numba alone asks only whether the file of the
kernel itself has changed: after an upgrade it would run the new step with a function of the old one inside.
"""

import hashlib
import os
import shutil
import warnings
from functools import cache
from pathlib import Path

import numba
from numba.extending import register_jitable

KEPT = 3  # folders of compiled code that stay: of this version, and of others whose programs may still run


def kernel(function, **options):
    """The function, compiled when it is first called; its compiled code is kept for later runs."""
    before = numba.config.CACHE_DIR
    folder = _folder(before)
    numba.config.CACHE_DIR = folder or before
    try:
        return numba.njit(cache=bool(folder), **options)(function)
    finally:
        numba.config.CACHE_DIR = before


def leaf(function):
    """The same for a function that makes no arrays."""
    return kernel(function, _nrt=False, forceinline=True)


def inlined(function):
    """The function, to be written into the kernels that call it: to hand records of many arrays over to a small function costs
    more than its work. Python itself runs it as it stands, uncompiled."""
    return register_jitable(_nrt=False, forceinline=True, no_cpython_wrapper=True, no_cfunc_wrapper=True)(function)


def cold():
    """Is no code of this version kept yet, where it can be? Then a first step waits for the compiler, and later ones need not."""
    folder = None if numba.config.DISABLE_JIT else _folder(numba.config.CACHE_DIR)
    return bool(folder) and not any(Path(folder).rglob("*.nbi"))


@cache
def _folder(chosen):
    """Where compiled code is kept: in the folder that NUMBA_CACHE_DIR chose; else beside this file or, where nothing can be
    written, in the user's cache. Where neither can be it is not kept, "": a folder that others may write would be theirs to fill
    with code."""
    package, digest = Path(__file__).resolve().parent, hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        digest.update(path.read_bytes())
    home = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    places = [Path(chosen)] if chosen else [package / "__pycache__", Path(home, "minibullet")]
    for place in places:
        folder = place / f"kernels-{digest.hexdigest()[:16]}"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            os.utime(folder)
            others = sorted(place.glob("kernels-*"), key=lambda other: other.stat().st_mtime)
        except OSError:
            continue
        for old in others[:-KEPT]:
            shutil.rmtree(old, ignore_errors=True)
        return str(folder)
    tried = " or ".join(map(str, places))
    warnings.warn(
        f"compiled code cannot be kept in {tried}: each run compiles anew, for a minute or more; set NUMBA_CACHE_DIR to a folder "
        "that you may write",
        stacklevel=2,
    )
    return ""
