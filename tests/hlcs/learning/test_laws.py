"""Laws as the effects that they are written as."""

import numpy as np
import pytest

import minibullet as mb
from hlcs.learning.laws import TRIED, VARIABLES, Ranges, knots_of, laws, one_law, seen

RANGES = Ranges(np.array([[-1.0, -1.0, 0.2], [1.0, 1.0, 2.0]]), 1.0, 1.5, 12.0)
VALUES = {name: np.linspace(0.5, 3.0, 40) for name in VARIABLES}
ALL = laws(VALUES, RANGES)


@pytest.mark.parametrize("law", ALL, ids=lambda law: f"{law.variable}-{law.way}-{law.form}")
def test_every_law_is_an_effect_that_keeps_the_contract(law):
    """As it is fitted, and as it is written with numbers; the numbers in which it is linear are absent at zero."""
    written = law.at(np.full(len(law.linear), 0.3), np.asarray(law.begins[0]))
    report = mb.check_effect(written.kind()())
    assert "null" in report.rules
    assert len([line for line in written.source().splitlines() if line.startswith("        ") and "=" in line]) <= 10


@pytest.mark.parametrize(
    "law",
    [law for law in ALL if law.variable in ("speed", "height", "time") and law.form in ("power", "exponential", "switch")],
    ids=lambda law: f"{law.variable}-{law.way}-{law.form}",
)
def test_what_is_drawn_of_a_law_is_the_force_of_its_effect(law):
    """Per mass, as long as its vector: along x, y and z it has one shape, whatever the strengths."""
    written = law.at(np.array([0.3, -0.2, 0.6])[: len(law.linear)], np.asarray(law.begins[0]))
    bodies, time = mb.effects.samples.sample_bodies(), 0.05
    bodies = bodies._replace(position=np.abs(bodies.position) + 0.1)
    moving = np.linalg.norm(bodies.twist[:, :3], axis=1) > 0.0  # what stands has no direction along its velocity
    force = np.linalg.norm(written.kind()().forces(bodies, time)[:, :3], axis=1) / bodies.mass
    np.testing.assert_allclose(written.force_at(seen(bodies, time)[law.variable])[moving], force[moving], rtol=1e-12)


def test_only_what_is_seen_is_tried():
    assert {law.variable for law in ALL} == set(TRIED) == set(VARIABLES)
    known = {name: values for name, values in VALUES.items() if name != "spin"}
    assert "spin" not in {law.variable for law in laws(known, RANGES)}


@pytest.mark.parametrize(("measured", "free"), [("z", ()), ("xz", ("elevation",)), ("xyz", ("azimuth", "elevation"))])
def test_a_force_acts_along_axes_that_were_measured(measured, free):
    """Of the others nothing is known: no angle of a direction among them is searched. It was, and told as 4.8 +- 8.6 rad."""
    law = one_law("time", "table", "axes", VALUES["time"], RANGES._replace(measured=measured))
    assert tuple(number.name for number in law.searched) == free
    for begin in law.begins:
        turned = law.at(np.ones(len(law.linear)), begin)
        force = turned.kind()().forces(mb.effects.samples.sample_bodies(), 0.1)[:, :3]
        unseen = ["xyz".index(axis) for axis in "xyz" if axis not in measured]
        np.testing.assert_allclose(force[:, unseen], 0.0, atol=1e-15 * np.abs(force).max())
        np.testing.assert_allclose(turned.direction[unseen], 0.0, atol=1e-15)


def test_a_table_is_the_force_at_its_knots():
    """Straight lines between the values; 1e-3 relative is the rounding of the knots in the file."""
    law = one_law("height", "table", "axes", VALUES["height"], RANGES)
    values = np.sin(knots_of(VALUES["height"]))
    effect = law.at(values, [0.0, np.pi / 2]).kind()()
    bodies = mb.effects.samples.sample_bodies()
    bodies = bodies._replace(position=np.column_stack([np.zeros((7, 2)), np.linspace(0.6, 2.9, 7)]))
    force = effect.forces(bodies, 0.0)
    expected = np.interp(bodies.position[:, 2], knots_of(VALUES["height"]), values)
    np.testing.assert_allclose(force[:, 2], bodies.mass * expected, rtol=1e-3, atol=1e-3 * bodies.mass.max())
