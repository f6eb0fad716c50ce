"""Curves show the numbers of the run: what is drawn is read back from the Axes; what shows itself has units."""

import numpy as np
import pytest

import minibullet as mb

WEIGHT = 2.0 * 9.81  # [N]


@pytest.fixture(scope="module")
def slide():
    """A box of 2 kg that slides at 1 m/s on a floor of friction 0.6, and the journal of its first 0.1 s."""
    world = mb.World([mb.Gravity(9.81)], mb.Settings(friction=0.6))
    world.add_plane()
    world.add(mb.Box(1.0, 1.0, 1.0), mass=2.0, position=(0.0, 0.0, 0.5), velocity=(1.0, 0.0, 0.0), name="<box>")
    journal = mb.Journal()
    world.run(0.1, watch=journal)
    return world, journal


def lines(ax):
    return {line.get_label(): np.asarray(line.get_ydata()) for line in ax.get_lines()}


def test_contacts_of_a_sliding_box_lie_on_the_limit_of_friction(slide):
    """Coulomb: friction force = 0.6 of the normal force at every corner; together they carry the weight. 1e-6: the tolerance."""
    world, _ = slide
    ax = world.contacts.plot()
    drawn = lines(ax)
    assert drawn["friction force"] == pytest.approx(drawn["limit: friction x normal force"], rel=1e-6)
    assert drawn["friction force"].sum() == pytest.approx(0.6 * WEIGHT, rel=1e-6)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("normal force [N]", "friction force [N]")
    assert world.contacts.plot(ax) is ax


def test_the_bars_of_a_step_are_its_work_by_line(slide):
    """Their sum is the change of kinetic energy, m (v1^2 - v0^2)/2 with v = v0 - mu g dt; 1e-6: the tolerance."""
    world, _ = slide
    step = world.last_step
    widths = [bar.get_width() for bar in step.plot().patches]
    v1 = step.after.twist[step.after.mass == 2.0, 0][0]
    v0 = v1 + 0.6 * 9.81 * step.time_step
    assert sum(widths) == pytest.approx(v1**2 - v0**2, rel=1e-6) and widths == list(step.work.values())


def test_a_journal_draws_energy_and_residual_over_time(slide):
    """Kinetic energy of the sliding box: (v0 - mu g t)^2 m/2 at every step; 1e-6: the tolerance."""
    _, journal = slide
    energy, residual = journal.plot()
    times = energy.get_lines()[0].get_xdata()
    assert lines(energy)["kinetic"] == pytest.approx((1.0 - 0.6 * 9.81 * times) ** 2, rel=1e-6)
    assert lines(residual)["tolerance"][0] == 1e-8 and energy.get_ylabel() == "energy [J]"


def test_a_film_draws_the_heights_of_a_fall():
    """Free fall: h - g t^2/2 exactly, as each step takes the mean velocity; 1e-12 is rounding."""
    world = mb.World([mb.Gravity(9.81)], mb.Settings(time_step=0.01))
    world.add(mb.Sphere(0.1), mass=1.0, position=(0.0, 0.0, 3.0))
    film = world.record(0.2)
    (drawn,) = film.plot().get_lines()
    assert drawn.get_ydata() == pytest.approx(3.0 - 0.5 * 9.81 * film.times**2, abs=1e-12)
    assert repr(film) == "<Film of 1 body: 6 frames from 0 to 0.2 s>"


def test_contacts_and_steps_show_themselves_with_units_and_no_markup_of_a_name(slide):
    world, journal = slide
    assert repr(world.contacts).startswith("<4 contacts: normal force up to ") and " N, penetration up to " in repr(
        world.contacts
    )
    shown = world.contacts._repr_html_()
    assert shown.count("<tr>") == 5 and "normal force [N]" in shown and "&lt;box&gt;" in shown and "<box>" not in shown
    assert repr(world.last_step).startswith("<Step 24 to t = 0.1 s: 4 contacts, residual ") and repr(world.last_step).endswith(
        " m>"
    )
    assert "<td>kinetic energy</td>" in world.last_step._repr_html_() and "<td>J</td>" in world.last_step._repr_html_()
    assert repr(journal).startswith("<Journal of 24 steps; finished: 0 of 24 steps") and "<td>m</td>" in journal._repr_html_()


def test_a_world_before_its_first_step_has_no_contacts():
    table = mb.World().contacts
    assert repr(table) == "<no contacts: no step was made>" and "no contacts" in table._repr_html_()
    assert not len(lines(table.plot())["friction force"])
    assert "no step was made" in repr(mb.Journal()) and "<td>steps</td><td>0</td>" in mb.Journal()._repr_html_()
