"""A ground that is not level."""

import numpy as np

from hlcs.data.experiment_file import Body, Surroundings
from hlcs.effects.contract import Setup
from hlcs.effects.ground import BottomSlope

BOX = Body(shape="box", size=(0.1, 0.2, 0.4), mass=2.0)


def test_a_bottom_slope_leans_the_floor_and_needs_one():
    setup = Setup(BOX, Surroundings(floor_height=0.0))
    normal = np.array(BottomSlope(grade_x=0.02, grade_y=-0.05).setup(setup).surroundings.floor_normal)
    np.testing.assert_allclose(normal, np.array([-0.02, 0.05, 1]) / np.linalg.norm([0.02, 0.05, 1]), rtol=1e-14)
    nowhere = Setup(BOX, Surroundings())
    assert BottomSlope(grade_x=0.02).setup(nowhere) is nowhere
