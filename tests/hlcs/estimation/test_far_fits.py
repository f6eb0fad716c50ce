"""Fits that begin far from the data, where turns have gone round many times by the end."""

import numpy as np
import pytest
from experiments import measured
from throws import G, csv

from hlcs.kinds.trajectories.preparation import prepare
from hlcs.selection.eligibility import candidates_for
from hlcs.simulation.model import Term
from minibullet import rotations

RADIUS, TILT, SIGMA = 0.02, 0.08, 0.001
BALL = f"""kind = "trajectory"
[body]
shape = "sphere"
radius = {RADIUS}
mass = 0.26
[surroundings]
gravity = {G}
friction = 0.6
floor = {{ height = 0.0 }}
[measurement]
noise = {{ position = {SIGMA}, orientation = 0.01 }}
"""


def test_a_tilt_is_found_that_rolls_a_ball_round_many_times(tmp_path, generator):
    """A solid ball rolls down by 5/7 g sin(tilt): after 1.2 s and 0.4 m it has turned by 20 rad. The file says a level floor, and
    its ball starts with the spin that fits best: a fast one. Tolerance: five standard errors of the tilt, 1 mm in 0.4 m."""
    times, text = np.arange(0, 1.2, 1 / 60), BALL
    for k in range(3):
        way = 5 / 7 * G * np.sin(TILT) * times**2 / 2
        seen = np.column_stack([way, 0 * times, RADIUS + 0 * times]) + SIGMA * generator.standard_normal((len(times), 3))
        turns = np.column_stack([0 * times, way / RADIUS, 0 * times])
        shaken = rotations.exponential(0.01 * generator.standard_normal(turns.shape))
        table = np.hstack([seen, rotations.product(shaken, rotations.exponential(turns))])
        (tmp_path / f"{k}.csv").write_text(csv(times, table, ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")))
        text += f'[[trial]]\nfile = "{k}.csv"\nstart = {{ position = [0, 0, {RADIUS}], velocity = [0, 0, 0] }}\n'
    (tmp_path / "e.toml").write_text(text)
    prepared = prepare(recordings := measured(tmp_path / "e.toml"))
    (entry,) = candidates_for(recordings, True, ("tilted_gravity",))[0]
    level = prepared.base.model.with_term(Term(entry, (("angle_x", 0.0), ("angle_y", 0.0))))
    fit = prepared.problem.fit(level, prepared.base.initial_states)
    assert fit.chi2_per_freedom < 1.2 and abs(fit.model.numbers["tilted_gravity"]["angle_y"]) == pytest.approx(TILT, abs=5e-4)
