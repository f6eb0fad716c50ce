"""A ground that is not level."""

import numpy as np
import pytest

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


def test_on_a_stated_slope_the_grades_add_to_its_rise_over_run_and_the_floor_below_the_origin_stays():
    """A plane of normal n at distance d: z = (d - n_x x - n_y y) / n_z."""
    angle, height = np.deg2rad(20.0), 0.3
    stated = Surroundings(floor_height=height * np.cos(angle), floor_normal=(-np.sin(angle), 0.0, np.cos(angle)))
    found = BottomSlope(grade_x=0.02, grade_y=-0.05).setup(Setup(Body(shape="sphere", radius=0.1), stated)).surroundings
    normal = np.array(found.floor_normal)
    assert -normal[:2] / normal[2] == pytest.approx((np.tan(angle) + 0.02, -0.05), rel=1e-12)
    assert np.linalg.norm(normal) == pytest.approx(1.0) and found.floor_height / normal[2] == pytest.approx(height, rel=1e-12)
