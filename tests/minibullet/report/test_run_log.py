"""The journal of a run: what it keeps, says and writes."""

import csv

import pytest

import minibullet as mb


@pytest.fixture
def box_run():
    """A box that falls a little and lands; one sweep a step, so that some steps stay unsolved."""
    world = mb.World([mb.Gravity()], mb.Settings(solver="gauss_seidel", iterations=1))
    world.add_plane(name="floor")
    world.add(mb.Box(1.0, 1.0, 1.0), mass=2.0, position=(0, 0, 0.51), angular_velocity=(1.0, 0.5, 0.0), name="box")
    journal = mb.Journal()
    world.run(0.25, watch=journal)
    return world, journal


def test_a_journal_counts_what_the_world_counts_and_names_the_worst_step(box_run):
    """Unsolved steps and worst residual are the world's own; the worst contact is between floor and box."""
    world, journal = box_run
    found = journal.summary()
    assert found["steps"] == world.steps == 60 and found["unsolved_steps"] == world.unsolved_steps > 0
    assert found["worst_residual"] == world.worst_residual == journal.rows[found["worst_step"] - 1]["residual"]
    assert found["worst_contact"]["bodies"] == ("floor", "box") and found["reference_mass"] == 2.0
    assert str(journal).startswith(f"finished: {world.unsolved_steps} of 60 steps did not reach residual 1e-08 (worst ")


def test_a_journal_on_disk_has_one_line_a_step_and_the_work_of_every_effect(box_run, tmp_path):
    """The file read back: kinetic energy as published; in free flight gravity's work is the potential energy lost."""
    _, journal = box_run
    journal.write(tmp_path / "steps.csv")
    with open(tmp_path / "steps.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [int(row["step"]) for row in rows] == list(range(1, 61))
    assert [float(row["E_kin"]) for row in rows] == [row["E_kin"] for row in journal.rows]
    flight = sum(row["n_active"] == 0 for row in journal.rows[:5])
    fallen = journal.rows[0]["E_pot"] - journal.rows[flight - 1]["E_pot"]
    assert flight > 1 and sum(float(row["work_gravity"]) for row in rows[1:flight]) == pytest.approx(fallen, rel=1e-9)
    assert list(journal.to_dataframe().columns) == list(rows[0])


def test_a_blow_with_restitution_takes_energy_and_is_not_counted_as_a_gain():
    """A ball bounces with e = 0.5: every blow takes, and so no step gains; a step whose books say otherwise is counted."""
    world = mb.World([mb.Gravity()], mb.Settings(restitution=0.5))
    world.add_plane()
    world.add(mb.Sphere(0.1), mass=1.0, position=(0, 0, 0.5))
    journal = mb.Journal()
    world.run(1.0, watch=journal)
    assert min(row["work_normal"] for row in journal.rows) < -1.0 and journal.summary()["gaining_steps"] == 0
    journal.rows[3]["work_friction"] += 0.1
    assert journal.summary()["gaining_steps"] == 1


def test_a_journal_of_nothing_says_so():
    """No step, no table to speak of."""
    assert mb.Journal().summary() == {"steps": 0} and "no step" in str(mb.Journal())
