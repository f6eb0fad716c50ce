"""Eqs. 1 to 3, 13 and 14: against numbers of the paper and of the Rock Manual, and against each other."""

import numpy as np
import pytest

from hlcs import Cubipod
from hlcs.placement import layer_equations as equations
from hlcs.placement.printed_tables import laboratory
from minibullet.errors import InputError


def test_equation_1_dn_of_the_prototype_and_the_thickness_of_a_double_layer():
    """A unit of 2.3 Dn^3 tonnes and Dn = 1.07 m; two layers of tetrapods, k = 1.02 (CIRIA, CUR, CETMEF 2007, in section 2.3)."""
    unit = Cubipod(side=1.0)
    diameter = equations.nominal_diameter(unit.mass() * 9.81, 2300.0 * 9.81)
    assert diameter == pytest.approx(unit.nominal_diameter, rel=1e-12) and round(diameter, 2) == 1.07
    assert equations.armour_thickness(2, 1.02, 2.0) == pytest.approx(4.08)


def test_equation_2_and_its_inverse_give_the_grid_s_packing_density():
    """TPG: phi = 0.498 of one layer, height 5.304 Dn of five, porosity 0.530 (the laboratory's; 0.0005 is the third digit)."""
    table = laboratory("table2", grid="TPG")
    packing = 1.0 / (table.spacing_x * table.spacing_y)
    porosity = equations.nominal_porosity(5, table.height_over_dn, packing)
    assert porosity == pytest.approx(0.530, abs=5e-4)
    per_square_metre = equations.placing_density(5, table.mean.mean(), porosity, 1.07)
    assert per_square_metre * 1.07**2 == pytest.approx(5 * packing, rel=1e-12)
    assert np.isnan(equations.nominal_porosity(5, np.nan, packing))


def test_equation_3_and_14_undo_each_other():
    """Differences of heights sum to the last height; what was not read has no coefficient and leaves none to the next."""
    heights = [1.298, 2.4, 3.35]
    assert equations.structure_height(equations.layer_coefficients(heights), 1.07) == pytest.approx(3.35 * 1.07)
    np.testing.assert_array_equal(np.isnan(equations.layer_coefficients([1.3, np.nan, 3.3, 4.3])), [False, True, True, False])


def test_equation_13_is_as_printed():
    np.testing.assert_array_equal(equations.estimated_layer_coefficients("TPG"), [1.30, 1.10, 0.99, 0.99, 0.99])
    np.testing.assert_array_equal(equations.estimated_layer_coefficients("RPG"), [1.30, 1.07, 0.93, 0.93, 0.93])


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: equations.nominal_diameter(-1.0, 2e4), "weight = -1.0"),
        (lambda: equations.armour_thickness(0, 1.0, 1.0), "layers = 0"),
        (lambda: equations.placing_density(2, 1.0, 1.0, 1.0), "porosity = 1.0"),
        (lambda: equations.estimated_layer_coefficients("1.5,1.3"), "RPG and TPG"),
    ],
)
def test_bad_input_is_named(call, words):
    with pytest.raises(InputError, match=words):
        call()
