"""Dice poured into a box: the share of space that cubes fill, beside what was measured with plastic dice."""

import dice
import numpy as np
import pytest

import minibullet as mb

SEEDS = range(1, 7)
LOOSE, DENSE, SPREAD = 0.54, 0.67, 0.01  # cubes: Baker and Kudrolli, Phys. Rev. E 82 (2010) 061304, standard deviation about 0.01


def test_the_solid_fraction_of_a_lattice_is_known():
    """Cubes of edge 1 m at distances of 1.25 m fill 1/1.25^3 = 0.512. The interior is 5 x 5 x 5 m, four whole distances each way;
    100,000 points know the share to sqrt(0.512 x 0.488 / 100,000) = 0.0016, four times that allowed."""
    world, places = mb.World(), 1.25 * (np.arange(8) - 3.5)
    lattice = [(x, y, z + 4.625) for x in places for y in places for z in places]  # the highest centres at 9 m
    bodies = [world.add(mb.Box(1.0, 1.0, 1.0), density=1.0, position=place) for place in lattice]
    assert dice.solid_fraction(bodies, 9.0) == pytest.approx(1 / 1.25**3, abs=0.0064)


def test_a_pour_ends_with_every_cube_in_the_box():
    """45 cubes in a box of 5.6 edges: each reaches from its centre no farther than half its diagonal, so at least half an edge
    from every wall, less the overlap that a step leaves. 31 at most
    lie on the floor (5.6 x 5.6), so others lie on them and the highest centre is above 1.5 edges less that overlap."""
    world, bodies = dice.pour(45, 5.6, 1)
    places = np.array([body.position for body in bodies])
    assert np.abs(places[:, :2]).max() <= 2.3 + 0.01 and places[:, 2].min() >= 0.5 - 0.01
    assert places[:, 2].max() > 1.49 and world.last_step.penetration < 0.01
    assert np.median([np.linalg.norm(body.velocity) for body in bodies]) < 1e-3  # edges a second: a creep, no fall


def test_a_box_without_interior_is_told():
    world, die = mb.World(), mb.Box(1.0, 1.0, 1.0)
    with pytest.raises(ValueError, match="no interior"):
        dice.solid_fraction([world.add(die, density=1.0, position=(0, 0, 3))], 8.0)


@pytest.mark.validation
def test_poured_dice_fill_as_much_as_measured(record_case):
    """Nothing is tuned: friction 0.4 was chosen before the first run. The interval of the
    mean is Student's over pours, 95 %. Poured dice can be no looser than the loosest packing that stood, and no denser than
    dice that were vibrated until nothing changed: both of these were measured."""
    found, deepest = dice.poured(SEEDS)
    assert deepest < 0.01  # of an edge: no dice are pressed into each other
    mean, half = found.mean(), dice.half_interval(found)
    what = f"solid fraction of {len(found)} pours, {mean:.3f} +- {half:.3f}"
    record_case("dice", f"{what}: above the loosest measured, 0.54", mean - LOOSE, DENSE - LOOSE)
    inside = LOOSE - SPREAD - half <= mean <= DENSE + SPREAD + half
    record_case("dice", f"{what}: between loosest and densest measured", inside, claim="0.54 to 0.67")
