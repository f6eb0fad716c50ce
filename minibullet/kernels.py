"""How kernels are compiled: the only room that knows Numba.

``kernel`` compiles a function of numbers and arrays. ``leaf`` does the same for a function that makes no arrays, and calls only
such functions: it takes part in no reference counting, which can cost a small function that is handed rows of arrays more
than its arithmetic. Numba keeps that option to itself (`_nrt`); without it everything runs the same, more slowly.
"""

from numba import njit

kernel = njit(cache=True)
leaf = njit(cache=True, _nrt=False)
