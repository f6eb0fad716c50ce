"""Placement grids: densities of the paper, 190 units in five layers, every unit over a hollow of the layer below."""

import numpy as np
import pytest

from hlcs.placement.grids import RPG, TPG, Grid, interior_density
from minibullet.errors import InputError

GRIDS = {"RPG": RPG, "TPG": TPG, "TPG ABA": TPG.stacked("ABA")}
EVERY_GRID = pytest.mark.parametrize("grid", GRIDS.values(), ids=GRIDS)


def nearest(points, others, count):
    """Distances of each point to its nearest `count` others, sorted: (n, count)."""
    return np.sort(np.linalg.norm(points[:, None] - others[None], axis=2), axis=1)[:, :count]


def test_packing_densities_of_the_paper():
    """0.55 and 0.50 in the text, 0.549 and 0.498 unrounded."""
    assert RPG.packing_density == pytest.approx(0.549, abs=5e-4)
    assert TPG.packing_density == pytest.approx(0.498, abs=5e-4)


@EVERY_GRID
def test_five_layers_are_190_units(grid):
    counts = [len(grid.centres(8, 8, layer)) for layer in range(1, 6)]
    assert counts == [64, 49, 36, 25, 16]
    assert counts == [grid.units(8, 8, layer) for layer in range(1, 6)]


@EVERY_GRID
@pytest.mark.parametrize("layer", range(1, 6))
def test_neighbours_in_a_layer_have_the_grid_s_spacings(grid, layer):
    centres = grid.centres(8, 8, layer)
    shortest = np.hypot(0.5 * grid.spacing_x, grid.spacing_y) if grid.triangular else grid.spacing_y
    assert nearest(centres, centres, 2)[:, 1] == pytest.approx(shortest, rel=1e-12)
    assert np.diff(np.unique(centres[:, 1].round(9))) == pytest.approx(grid.spacing_y, rel=1e-6)


def test_mean_area_of_a_unit_is_the_inverse_of_the_packing_density():
    """Counted in the middle 20 x 20 cells of a large layer; the rim of such a square may add 6 %."""
    for grid in GRIDS.values():
        centres = grid.centres(40, 40, 1)
        inside = np.all(np.abs(centres) < 10 * np.array([grid.spacing_x, grid.spacing_y]) - 1e-9, axis=1)
        area = 400 * grid.spacing_x * grid.spacing_y
        assert inside.sum() / area == pytest.approx(grid.packing_density, rel=0.06)


@pytest.mark.parametrize("layer", range(2, 6))
def test_rpg_units_sit_amid_four(layer):
    below, centres = RPG.centres(8, 8, layer - 1), RPG.centres(8, 8, layer)
    assert nearest(centres, below, 4) == pytest.approx(0.5 * np.hypot(1.40, 1.30), rel=1e-12)


@pytest.mark.parametrize("grid", [TPG, TPG.stacked("ABA")], ids=["ABC", "ABA"])
@pytest.mark.parametrize("layer", range(2, 6))
def test_tpg_units_sit_at_the_centroid_of_three(grid, layer):
    below, centres = grid.centres(8, 8, layer - 1), grid.centres(8, 8, layer)
    order = np.argsort(np.linalg.norm(centres[:, None] - below[None], axis=2), axis=1)[:, :3]
    np.testing.assert_allclose(below[order].mean(axis=1), centres, atol=1e-12)


def is_over(upper, lower):
    """Whether every centre of upper is a centre of lower."""
    return bool(np.all(nearest(upper, lower, 1) < 1e-9))


def test_abc_comes_back_after_three_layers_and_aba_after_two():
    abc = [TPG.centres(8, 8, layer) for layer in range(1, 6)]
    aba = [TPG.stacked("ABA").centres(8, 8, layer) for layer in range(1, 6)]
    assert (is_over(abc[2], abc[0]), is_over(abc[3], abc[0]), is_over(abc[4], abc[1])) == (False, True, True)
    assert (is_over(aba[2], aba[0]), is_over(aba[3], aba[1]), is_over(aba[4], aba[0])) == (True, True, True)
    assert is_over(RPG.centres(8, 8, 3), RPG.centres(8, 8, 1))


@EVERY_GRID
def test_the_first_layer_is_about_the_origin(grid):
    for rows, columns in ((8, 8), (3, 5), (1, 4)):
        centres = grid.centres(rows, columns, 1)
        np.testing.assert_allclose(centres.max(axis=0) + centres.min(axis=0), 0.0, atol=1e-12)


def test_grids_are_read_from_words():
    assert Grid.parse("TPG") is TPG
    assert Grid.parse(" rpg ") is RPG
    assert Grid.parse(TPG) is TPG
    assert Grid.parse("1.5, 1.3") == Grid("1.5,1.3", 1.5, 1.3, triangular=False)
    assert Grid.parse("1.58,1.27,triangular").triangular


@pytest.mark.parametrize(
    "text, words",
    [
        ("HPG", "grid 'HPG': not understood; give TPG, RPG, or two spacings"),
        ("1.5", "not understood"),
        ("1.5,x", "not understood"),
        ("1.5,1.3,round", "not understood"),
        ("1.5,-1.3", "spacing_y = -1.3"),
        ("nan,1.3", "spacing_x = nan"),
    ],
)
def test_what_is_no_grid_is_refused_by_name(text, words):
    with pytest.raises(InputError, match=words):
        Grid.parse(text)


@pytest.mark.parametrize(
    "rows, columns, layer, words",
    [
        (4, 8, 5, "layer 5 of 4 rows and 8 columns has no units"),
        (0, 8, 1, "rows = 0"),
        (8, 2.5, 1, "columns = 2.5"),
        (8, 8, 0, "layer = 0"),
    ],
)
def test_layers_without_units_are_refused(rows, columns, layer, words):
    with pytest.raises(InputError, match=words):
        TPG.centres(rows, columns, layer)


def test_unknown_stacking_is_refused():
    with pytest.raises(InputError, match="stacking = 'AAA'; it must be one of ABC, ABA; did you mean"):
        TPG.stacked("AAA")


@EVERY_GRID
@pytest.mark.parametrize("stretch", [1.0, 1.1])
def test_the_inner_density_of_a_whole_layer_is_that_of_its_grid(grid, stretch):
    """Every inner unit has a cell of a x b, wherever the edge is; stretched by 1.1 both ways the density falls by 1.21."""
    places = stretch * grid.centres(6, 6, 1)
    assert interior_density(places) == pytest.approx(grid.packing_density / stretch**2, rel=1e-9)


def test_a_unit_that_is_gone_leaves_its_area_to_its_neighbours():
    """Of 8 x 8 units on a rectangular grid the 36 inner ones have 36 cells; without one of them 35 units have the same area."""
    places = RPG.centres(8, 8, 1)
    assert interior_density(np.delete(places, 3 * 8 + 3, axis=0)) == pytest.approx(RPG.packing_density * 35 / 36, rel=1e-9)


@pytest.mark.parametrize("places", [np.empty((0, 2)), np.zeros((1, 2)), np.column_stack([np.arange(6.0), np.zeros(6)])])
def test_a_layer_without_an_inner_part_has_no_density(places):
    assert np.isnan(interior_density(places))


@pytest.mark.parametrize("text", ["1_5,1.3", "1.4,1_3,triangular"])
def test_a_number_with_an_underscore_is_not_another_number(text):
    """Python reads 1_5 as 15."""
    with pytest.raises(InputError, match="not understood"):
        Grid.parse(text)


@pytest.mark.parametrize("text", ["60,50", "1.4,1e308"])
def test_spacings_in_other_units_than_nominal_diameters_are_refused(text):
    with pytest.raises(InputError, match="nominal diameters"):
        Grid.parse(text)


@pytest.mark.parametrize("set_back", [0.5, 0.75])
def test_a_set_back_keeps_every_layer_that_far_from_the_edge_below(set_back):
    """Of the first layer's outline layer j leaves j - 1 set-backs free on every side, and no unit that may stay is left out."""
    grid, scale = TPG, np.array([TPG.spacing_x, TPG.spacing_y])
    first = grid.centres(8, 8, 1) / scale
    for layer in (2, 3, 4):
        plain, kept = (grid.centres(8, 8, layer, back) / scale for back in (0.0, set_back))
        back = (layer - 1) * set_back
        inside = np.all((plain >= first.min(axis=0) + back - 1e-6) & (plain <= first.max(axis=0) - back + 1e-6), axis=1)
        np.testing.assert_array_equal(kept, plain[inside])
        assert 0 < len(kept) < len(plain)


def test_between_walls_every_row_is_full_and_the_walls_are_half_a_spacing_away():
    """20 units of a = 1.58 Dn and half a spacing for the shifted rows: 20.5 a between the walls, in every layer."""
    wall = TPG.wall_distance(20)
    assert wall == pytest.approx(20.5 * 1.58 / 2, rel=1e-12)
    for layer in (1, 2, 3, 4, 5):
        centres = TPG.centres(7, 20, layer, walls=True)
        assert len(centres) == 20 * (8 - layer)
        assert wall - np.abs(centres[:, 0]).max() >= 0.5 * 1.58 - 1e-9
        rows = np.unique(centres[:, 1].round(9))
        open_centres = TPG.centres(7, 20, layer)
        np.testing.assert_allclose(rows, np.unique(open_centres[:, 1].round(9)))
        offset = (open_centres[0, 0] - centres[0, 0]) / 1.58  # the hollows are the same ones
        assert offset == pytest.approx(round(offset), abs=1e-9)
