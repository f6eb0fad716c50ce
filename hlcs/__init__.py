"""The laboratory: place armour units, measure layers, compare with data, find the missing effect."""

from hlcs.armour import Cube, Cubipod
from hlcs.experiment import PlacementResult, PlacementTest
from hlcs.grids import RPG, TPG, Grid
from hlcs.tables import laboratory, paper_numerical
from minibullet.errors import InputError
