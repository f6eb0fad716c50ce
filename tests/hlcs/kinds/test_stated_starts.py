"""A start that is stated wrongly is told from a missing effect: falls by closed form, the truth of the starts known."""

import numpy as np
import pytest
from throws import G

import hlcs

SIGMA = 0.001  # m
EARLY = np.array([0.002, 0.016, 0.007, 0.011])  # time before the first stamp at which each ball is let go [s]


def falls(folder, early, stated=True, late=0.0):
    """The file of four falls from rest in a vacuum, seen at 60 Hz; early: time of release before the first stamp (4,) [s]; late:
    cubic term of the way, which no start has [m/s3]."""
    generator = np.random.default_rng(4)
    text = (
        f'kind = "trajectory"\n[body]\nshape = "sphere"\nradius = 0.0125\nmass = 0.064\n[measurement]\nnoise.position = {SIGMA}\n'
    )
    times = np.arange(30) / 60
    for k, before in enumerate(early):
        way = G * (times + before) ** 2 / 2 - late * times**3
        rows = np.column_stack([times, 1.5 - way + SIGMA * generator.standard_normal(len(times))])
        np.savetxt(folder / f"r{k}.csv", rows, delimiter=",", header="t_s,z_m", comments="", fmt="%.6f")
        text += f'[[trial]]\nfile = "r{k}.csv"\n' + "start.velocity = [0.0, 0.0, 0.0]\n" * stated
    (folder / "e.toml").write_text(text)
    return folder / "e.toml"


def test_bodies_let_go_before_the_first_stamp_are_told_by_their_starts_and_no_effect_is(tmp_path):
    """The velocity at the first stamp is g times the time since the release; 30 samples tell it to about 3 mm/s."""
    found = hlcs.diagnose(falls(tmp_path, EARLY))
    differ = found.starts_shown["differ"]["velocity"]
    assert found.verdict == "unexplained" and found.effects == () and found.starts_shown["effects"] == []
    assert (differ["least"], differ["most"]) == pytest.approx((G * EARLY.min(), G * EARLY.max()), abs=0.012)  # four sigma
    assert hlcs.diagnose(falls(tmp_path, EARLY, stated=False)).verdict == "complete"  # what it advises


def test_what_no_data_show_of_a_start_is_not_said_to_differ(tmp_path):
    path = falls(tmp_path, EARLY)
    path.write_text(path.read_text().replace("start.velocity", "start.angular_velocity = [0.0, 0.0, 0.0]\nstart.velocity"))
    assert hlcs.compare(path).starts_shown["differ"].keys() == {"velocity"}


def test_a_comparison_tells_it_as_well(tmp_path):
    found = hlcs.compare(falls(tmp_path, EARLY))
    assert not found.adequate and found.starts_shown["differ"].keys() == {"velocity"}


def test_a_comparison_says_what_it_did_and_names_the_command_that_searches(tmp_path):
    """It looks for no effect, so it cannot say that none explains the data."""
    path = falls(tmp_path, EARLY)
    told = " ".join(str(hlcs.compare(path)).split())
    assert "Or something is missing. To know it," in told and "library" not in told
    assert f"Which effect is missing, if the file is right: hlcs diagnose {path}" in told


def test_right_starts_are_not_doubted_whatever_else_is_missing(tmp_path):
    assert hlcs.compare(falls(tmp_path, 0 * EARLY)).starts_shown is None
    missed = hlcs.compare(falls(tmp_path, 0 * EARLY, late=1.0))
    assert not missed.adequate and missed.starts_shown is None
