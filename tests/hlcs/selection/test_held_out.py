"""What an effect is worth on recordings that it was not fitted to."""

import numpy as np
import pytest
from linear_models import Line, model

from hlcs.estimation.cross_validation import CrossValidation
from hlcs.selection.held_out import HeldOut, beaten, fall, held_out
from hlcs.selection.reasons import Rule
from hlcs.simulation.model import Model

TIMES = [np.linspace(0.0, 1.0 + k, 10) for k in range(4)]


def fits(slopes, noise, generator, groups=("a", "b", "a", "b")):
    values = [slope * t + noise * generator.standard_normal(10) for slope, t in zip(slopes, TIMES, strict=True)]
    problem = Line(TIMES, values, noise, list(groups))
    return problem, problem.fit(Model()), problem.fit(model(1.0))


def test_a_law_that_holds_for_all_predicts_the_other_half(generator):
    """The error falls from that of lines about their mean to the noise, in both directions."""
    problem, base, fit = fits((3.0,) * 4, 0.1, generator)
    worth = held_out(problem, CrossValidation(problem.trials, "group"), base, fit)
    assert worth.p < 1e-6 and min(worth.directions) > 0.8 and not worth.broken(few=True, count=40)
    assert problem.error(fit.linearization.projected[0]) == pytest.approx(0.1, rel=0.3)  # 40 readings less 5


def test_a_law_that_holds_for_one_half_alone_is_refused(generator):
    problem, base, fit = fits((3.0, -2.0, 3.0, -2.0), 0.1, generator)
    worth = held_out(problem, CrossValidation(problem.trials, "group"), base, fit)
    assert max(worth.directions) <= 0 and worth.broken(True, 40).reason is Rule.BOTH_DIRECTIONS
    assert worth.broken(False, 40).reason is Rule.NO_CHANCE


def test_an_error_of_zero_cannot_fall():
    assert fall(2.0, 1.5) == 0.25 and fall(0.0, 0.0) == 0.0 and fall(0.0, 1e-9) == -1.0


def test_many_candidates_ask_for_more():
    """p = 0.01 is enough for four candidates, not for forty; and a fall of a thousandth is none."""
    worth = HeldOut(0.01, (0.05, 0.05), 0.05, 0.05)
    assert not worth.broken(False, 4) and worth.broken(False, 40).reason is Rule.NO_CHANCE
    assert HeldOut(0.0, (0.001, 0.001), 0.001, 0.001).broken(False, 4).reason is Rule.HELD_OUT_ERROR


def test_a_fall_in_one_half_needs_little_in_the_other_where_chance_is_out():
    """Of few recordings one half may hardly show an effect: 10 % and 1 % at p = 1e-30 count, not at 0.01, nor 10 and -1."""
    assert not HeldOut(1e-30, (0.10, 0.01), 0.08, 0.08).broken(True, 40)
    for p, directions in ((0.01, (0.10, 0.01)), (1e-30, (0.10, -0.01))):
        assert HeldOut(p, directions, 0.08, 0.08).broken(True, 40).reason is Rule.BOTH_DIRECTIONS


def test_where_nothing_can_be_held_out_nothing_is_broken(generator):
    problem, base, fit = fits((3.0,) * 4, 0.1, generator, ("a",) * 4)
    alone = CrossValidation(problem.trials, "group")
    assert held_out(problem, alone, base, fit) == HeldOut() and not HeldOut().broken(True, 40)
    assert not beaten(alone, fit, base)


def test_a_worse_law_is_beaten_and_an_equal_one_is_not(generator):
    problem, base, fit = fits((3.0,) * 4, 0.1, generator)
    halves = CrossValidation(problem.trials, "group")
    assert beaten(halves, fit, base) and not beaten(halves, fit, fit) and not beaten(halves, base, fit)


def test_a_number_that_one_half_hardly_tells_does_not_beat_its_law():
    """Of a slope that is not zero, told twenty times worse by the short half: it predicts the long one badly, and says so."""
    times = [np.linspace(0.0, length, 10) for length in (0.2, 4.0, 0.2, 4.0)]
    for seed in range(20):
        noise = 0.1 * np.random.default_rng(seed).standard_normal((4, 10))
        problem = Line(times, [0.2 * t + part for t, part in zip(times, noise, strict=True)], 0.1, ["a", "b", "a", "b"])
        halves = CrossValidation(problem.trials, "group")
        assert not beaten(halves, problem.fit(Model()), problem.fit(model(1.0)))
