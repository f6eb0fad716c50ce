"""Versions of what computed a result."""

import importlib.metadata
import platform
from functools import cache

REPORTED = ("hlcs", "numpy", "numba", "python-fcl", "trimesh", "matplotlib", "scipy", "pandas", "tqdm", "click")


def versions():
    """Versions of Python, the platform, this program and its dependencies; None for what is not installed."""
    here = {"python": platform.python_version(), "platform": f"{platform.system()} {platform.machine()}"}
    return here | {name: _version(name) for name in REPORTED}


@cache
def _version(name):
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None
