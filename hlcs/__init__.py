"""The laboratory: place armour units, measure layers, compare with data, find the missing effect.

import hlcs

result = hlcs.PlacementTest(grid=hlcs.TPG, layers=5, seed=1).run()
print(hlcs.compare(result, hlcs.laboratory("table2", grid="TPG")))
experiment = hlcs.Experiment.read("drop.toml")
diagnosis = hlcs.diagnose(experiment)
print(diagnosis, hlcs.compare(diagnosis.apply(experiment)))
"""

import importlib
import os
import sys
from types import ModuleType

# Threads of the linear algebra library cost more than they give on matrices of a few hundred rows, and fifty times more on a busy
# machine; it reads this when NumPy is first imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Each name is imported when it is first asked for: loading NumPy and the compiler takes a second, and the command must be able to
# answer Ctrl-C, or a missing folder, before that (`hlcs.cli.error_handling`).
HOMES = {
    "Cube": "hlcs.placement.units",
    "Cubipod": "hlcs.placement.units",
    "Experiment": "hlcs.kinds.experiment",
    "compare": "hlcs.compare",
    "diagnose": "hlcs.diagnose",
    "predict": "hlcs.compare",
    "import_measurements": "hlcs.importing.importer",
    "MeshUnit": "hlcs.placement.mesh_units",
    "example_unit": "hlcs.placement.example_units",
    "PlacementTest": "hlcs.placement.procedure",
    "RPG": "hlcs.placement.grids",
    "TPG": "hlcs.placement.grids",
    "StandingUnits": "hlcs.placement.standing_units",
    "Grid": "hlcs.placement.grids",
    "PlacementResult": "hlcs.placement.placement_result",
    "design_layer_coefficients": "hlcs.placement.printed_tables",
    "laboratory": "hlcs.placement.printed_tables",
    "paper_numerical": "hlcs.placement.printed_tables",
    "reproduce": "hlcs.paper.reproduction",
    "reveal": "hlcs.reveal",
    "InputError": "minibullet.errors",
    "InputWarning": "minibullet.errors",
}
ROOMS = ("course", "effects", "mystery")  # modules that users ask for
__all__ = sorted(HOMES)


class _Package(ModuleType):
    """`hlcs.compare`, `hlcs.diagnose` and `hlcs.reveal` are the functions, whoever imports the modules of the same name, and
    whenever."""

    def __setattr__(self, name, value):
        if not (name in HOMES and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


def __getattr__(name):
    if name in HOMES:
        value = getattr(importlib.import_module(HOMES[name]), name)
        setattr(sys.modules[__name__], name, value)
        return value
    try:
        return importlib.import_module(f"{__name__}.{name}")
    except ModuleNotFoundError as problem:
        if problem.name != f"{__name__}.{name}":
            raise
        told = f"module '{__name__}' has no attribute '{name}'"
        raise AttributeError(told, name=name, obj=sys.modules[__name__]) from None


def __dir__():
    return sorted([*__all__, *ROOMS, "__all__", "__doc__", "__file__", "__name__", "__path__"])


sys.modules[__name__].__class__ = _Package
