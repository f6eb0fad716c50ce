"""The laboratory: place armour units, measure layers, compare with data, find the missing effect.

    import hlcs

    result = hlcs.PlacementTest(grid=hlcs.TPG, layers=5, seed=1).run()
    print(hlcs.compare(result, hlcs.laboratory("table2", grid="TPG")))
    print(hlcs.diagnose("drop.toml"))
"""

import os

# Threads of the linear algebra library cost more than they give on matrices of a few hundred rows, and fifty times more on a busy
# machine; it reads this when NumPy is first imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


from hlcs.armour import Cube, Cubipod

# the functions, not the modules of the same name: imported here, once and for all, they keep the name
from hlcs.compare import compare
from hlcs.diagnose import diagnose
from hlcs.experiment import PlacementTest
from hlcs.grids import RPG, TPG, Grid
from hlcs.placement_result import PlacementResult
from hlcs.tables import laboratory, paper_numerical
from minibullet.errors import InputError

__all__ = ["RPG", "TPG", "Cube", "Cubipod", "Grid", "InputError", "PlacementResult", "PlacementTest", "compare", "diagnose",
           "laboratory", "paper_numerical"]
