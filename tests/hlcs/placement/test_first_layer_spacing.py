"""On which grids first-layer units can stand: facts of geometry, what is refused, how the first layer is then laid."""

import re

import numpy as np
import pytest

import minibullet as mb
from hlcs import InputError, PlacementTest
from hlcs.placement import first_layer_spacing, layer_placement
from hlcs.placement.units import Cube, Cubipod

FLAT = (3, 3), (0.0, 0.0)


def headings(unit, shape, triangular, x, y):
    return first_layer_spacing.headings_on(unit, shape, triangular, *FLAT, x, y)


@pytest.mark.parametrize("side", [0.04, 1.0, 30.0])
def test_cubes_stand_from_one_dn_on_whatever_their_size(side):
    """A cube's footprint is 1 x 1 Dn; less than half a hundredth is rounding of the spacing, not overlap."""
    unit = Cube(side=side)
    assert headings(unit, "pieces", False, 1.0, 1.0) == (0.0, np.pi)
    assert headings(unit, "pieces", False, 0.996, 1.0) and headings(unit, "hull", False, 1.7, 1.0)
    assert not headings(unit, "pieces", False, 0.99, 1.0) and not headings(unit, "pieces", False, 1.7, 0.85)


@pytest.mark.parametrize("shape", ["pieces", "hull"])
def test_the_project_s_grids_are_feasible_and_rpg_only_just(shape):
    """RPG is the Cubipod's own footprint, 1.404 x 1.298 Dn, printed to a hundredth; TPG leaves headings free."""
    unit = Cubipod(side=1.0)
    assert headings(unit, shape, False, 1.40, 1.30) == (0.0, np.pi)
    assert not headings(unit, shape, False, 1.39, 1.30)
    assert headings(unit, shape, True, 1.58, 1.27)
    assert bool(headings(unit, shape, False, 1.40, 1.28)) == (shape == "pieces")  # the hull fills what the true unit leaves free


def test_cubes_on_a_triangular_grid_stand_in_bricks_or_in_columns():
    """Rows of 1 Dn, shifted or not, fit at a = 1; two rows 0.5 Dn apart fit when a = 2, each unit beside a gap."""
    unit = Cube(side=1.0)
    assert headings(unit, "pieces", True, 1.0, 1.0) and headings(unit, "pieces", True, 2.0, 0.5)
    assert not headings(unit, "pieces", True, 1.0, 0.95) and not headings(unit, "pieces", True, 1.9, 0.5)


@pytest.mark.parametrize(
    ("settings", "x", "y"),
    [
        ({"armour": "cube", "grid": "1.7,0.85"}, (1.00, 1.00), (1.70, 1.00)),
        ({"armour": "cube", "grid": "0.6,0.6"}, (1.00, 1.00), (1.00, 1.00)),
        ({"armour": "cube", "grid": "0.9,0.5,triangular"}, None, None),
        ({"grid": "1.3,1.3", "shape": "hull"}, (1.40, 1.30), (1.40, 1.30)),
        ({"grid": "1.4,0.7"}, None, None),
    ],
)
def test_a_grid_too_narrow_is_refused_with_spacings_that_will_do(settings, x, y):
    """The named pairs are feasible, and a hundredth less is not: least they are."""
    test = PlacementTest(layers=1, rows=4, columns=4, **settings)
    with pytest.raises(InputError, match="smallest feasible spacing_x") as refusal:
        test.run()
    words = str(refusal.value)
    assert "\n" not in words and settings["grid"] in words
    numbers = [float(number) for number in re.findall(r"spacing_[xy](?: is)? (\d+\.?\d*)", words)]
    first, second = (numbers[0], numbers[1]), (numbers[3], numbers[2])
    assert (x, y) == (None, None) or (first, second) == (pytest.approx(x), pytest.approx(y))
    place = test.unit, test.shape, test.grid.triangular
    for pair, less in ((first, (first[0] - 0.01, first[1])), (second, (second[0], second[1] - 0.01))):
        assert headings(*place, *pair) and not headings(*place, *np.round(less, 2))


def test_one_row_asks_for_no_spacing_of_rows():
    result = PlacementTest(armour="cube", grid="1.2,0.3", rows=1, columns=3, layers=1).run()
    assert result.layer_coefficients[0] == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize(
    "settings", [{"armour": "cube", "grid": "1.1,1.0,triangular"}, {"grid": "1.35,1.2,triangular", "shape": "hull"}]
)
def test_where_chance_finds_no_headings_the_units_take_one_that_fits(settings):
    """They stand where they are aimed (but for the rounding of a spacing a unit), and nothing overlaps."""
    test = PlacementTest(rows=4, columns=4, layers=1, **settings)
    unit, dn = test.unit, test.unit.nominal_diameter
    world = mb.World([mb.Gravity(9.81)], test.settings)
    test.bottom.add_to(world)
    aims = test.grid.centres(4, 4, 1) * dn
    handles = layer_placement.lay_first_layer(
        world, unit, layer_placement.load_of(unit, test), aims, test.bottom, test, np.random.default_rng(1)
    )
    off = np.array([handle.position[:2] for handle in handles]) - aims
    assert np.abs(off).max() < 4 * first_layer_spacing.ROUNDING * dn
    assert not world.overlaps(1e-4)


def test_a_margin_pushes_the_first_layer_apart_and_that_is_told():
    """RPG with a margin of 0.008 Dn: three gaps in x between four units are each short by 1.404 + 0.016 - 1.40 Dn; the outermost
    unit moves by half of all three, 0.030 Dn, a little more where a corner yields in y as well."""
    result = PlacementTest(grid="RPG", margin=0.008, layers=1, rows=4, columns=4).run()
    pushed = result.to_dict()["pushed_over_dn"]
    assert 0.030 < pushed < 0.060
    assert "pushed apart" in result.summary()
    # in x every unit needs 1.420 Dn, in y between 1.30 (where its faces miss the neighbour's) and 1.314 Dn
    assert 0.999 / (1.420 * 1.314) < result.achieved_packing_density < 1.001 / (1.420 * 1.30)
    assert result.to_dict()["packing_density"] == pytest.approx(1 / (1.40 * 1.30))
