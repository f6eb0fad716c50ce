"""A number of recordings in segments is read off the curves of all segments; their disagreement is its error."""

import numpy as np
import pytest
from experiments import measured
from tosses import write_tosses

from hlcs.estimation.fitting import fit_at
from hlcs.estimation.multiple_shooting import chi2_over
from hlcs.estimation.segment_profiles import ALONE, Line, along, best, descended, profiled, read
from hlcs.kinds.trajectories.preparation import prepare
from hlcs.selection.eligibility import candidates_for
from hlcs.simulation.model import Term

OFFSETS = np.linspace(-0.05, 0.05, 9)
FREEDOM = 100


def line_of(minima, errors, least=FREEDOM):
    """A Line whose segments have parabolas with these minima and standard errors."""
    chi2 = least + ((OFFSETS[:, None] - np.asarray(minima)) / np.asarray(errors)) ** 2
    return Line(OFFSETS, np.ones(1), chi2, np.zeros((9, chi2.shape[1], 13)))


def read_of(minima, errors, **options):
    return read(line_of(minima, errors, **options), np.full(len(minima), FREEDOM))


def test_segments_that_agree_give_their_weighted_mean_and_its_error():
    reading = read_of([0.01] * 5, [0.01, 0.02, 0.02, 0.01, 0.01])
    assert reading.offset == pytest.approx(0.01)
    assert reading.error == reading.bare == pytest.approx((3 / 0.01**2 + 2 / 0.02**2) ** -0.5, rel=0.02)  # two miss by a trace
    assert reading.alone == pytest.approx(1 / 3.5, rel=0.02)


def test_the_disagreement_of_segments_is_the_error():
    """90 % intervals of the mean of 6 segments that differ by 3 errors each hold the truth in 90 %: 2 % is chance in 1000."""
    generator, held = np.random.default_rng(3), 0
    for _ in range(1000):
        reading = read_of(0.012 * generator.standard_normal(6), [0.004] * 6, least=1.0)
        held += abs(reading.offset) < 1.645 * reading.error
    assert 0.88 < held / 1000 < 0.94  # no interval is narrower than the curvature gives, so a few are wider than need be


def test_a_segment_that_its_states_do_not_follow_counts_for_less():
    chi2 = np.column_stack([line_of([-0.01] * 3, [0.01] * 3).chi2, 4 * line_of([0.03], [0.01]).chi2])
    reading = read(line_of([0] * 4, [0.01] * 4)._replace(chi2=chi2), np.full(4, FREEDOM))
    assert reading.offset == pytest.approx(0.0, abs=1e-3)  # it weighs as one of them, not as four


def test_where_one_segment_tells_a_number_its_error_is_unknown():
    assert read_of([0.0, 0.0, 0.01], [0.005, 0.5, 0.5]).alone > ALONE
    assert read_of([0.0, 0.01, 0.0], [0.005, 0.01, 0.5]).alone < ALONE  # one that knows half as well already tells of errors


def test_curves_without_a_minimum_give_no_number():
    there = line_of([0.0, 0.0], [0.01, 0.01])
    assert read(there._replace(chi2=200 - there.chi2), np.full(2, FREEDOM)) is None
    there.chi2[2, 1] = np.inf
    assert read(there, np.full(2, FREEDOM)) is None


def test_each_segment_takes_the_initial_state_that_is_best_for_it():
    chi2, states = best([(np.array([1.0, 5.0]), np.zeros((2, 13))), (np.array([2.0, 3.0]), np.ones((2, 13)))])
    assert list(chi2) == [1.0, 3.0] and list(states[:, 0]) == [0.0, 1.0]


def with_friction(prepared, recordings, value):
    """The model of a Prepared with a friction to be fitted, at this value."""
    (friction,) = candidates_for(recordings, True, ["friction"], ())[0]
    return prepared.base.model.with_term(Term(friction, (("coefficient", value),)))


def test_a_number_walks_to_its_minimum_from_far_away(tmp_path):
    """Recorded with 0.2, begun at 0.5: each value begins with the initial states of the one before. A walk ends within one of its
    short steps, a twelfth of a tenth of the range of 1.5, and what two tosses tell, some 0.01."""
    recordings = measured(write_tosses(tmp_path, [1.8, 1.5], seconds=0.6))
    prepared = prepare(recordings)
    model, states = with_friction(prepared, recordings, 0.5), prepared.base.initial_states
    begun = fit_at(model, states, prepared.problem.linearise(model, states))
    fit = descended(prepared.problem, begun, 0)
    assert fit.estimate[0] == pytest.approx(0.2, abs=0.0125 + 0.01)
    assert fit.chi2 < begun.chi2


def test_along_a_line_no_segment_does_better_with_what_stands_at_another_value(tmp_path):
    """So what differs between two values is not which way of the body was found at each. The last digit of the value, grown from
    impact to impact, moves chi2 by 2e-7."""
    recordings = measured(write_tosses(tmp_path, [1.8, 1.5], seconds=0.6))
    prepared = prepare(recordings)
    problem, model = prepared.problem, with_friction(prepared, recordings, 0.25)
    fit = problem.fit(model, prepared.base.initial_states)
    line = along(problem, fit, 0, 0.02, thorough=True)
    everyone = np.arange(len(problem.trials))
    for offset, chi2 in zip(line.offsets, line.chi2, strict=True):
        there = model.with_at(0, {"coefficient": fit.estimate[0] + offset})
        for states in line.states:
            assert (chi2 <= chi2_over(problem, there, states, everyone, dict.fromkeys(everyone, slice(None))) + 1e-4).all()


@pytest.mark.slow
def test_the_friction_of_a_cut_toss_is_found_from_afar(tmp_path):
    """Recorded with 0.2, begun at 0.3; twice the half-width of the 90 % interval is not exceeded once in 1000."""
    recordings = measured(write_tosses(tmp_path, [1.8, 1.5]))
    prepared = prepare(recordings)
    model = with_friction(prepared, recordings, 0.3)
    fit = profiled(prepared.problem, prepared.problem.fit(model, prepared.base.initial_states))
    assert not fit.withheld
    assert abs(fit.estimate[0] - 0.2) < 2 * 1.645 * np.sqrt(fit.covariance[0, 0])


def test_a_number_of_which_the_data_tell_less_than_the_file_is_no_number_of_the_segments(tmp_path):
    """The lift of the stated air is 0.3 % of the weight, known to a few per cent: no line is laid through it."""
    path = write_tosses(tmp_path, [1.8, 1.5])
    path.write_text(path.read_text().replace("gravity = 9.81\n", "gravity = 9.81\nfluid_density = 1.2\n"))
    recordings = measured(path)
    prepared = prepare(recordings)
    (lift,) = candidates_for(recordings, True, ["buoyancy"], ())[0]
    model = prepared.base.model.with_term(Term(lift, (("fluid_density", 1.2),)))
    fitted = prepared.problem.fit(model, prepared.base.initial_states)
    before = prepared.problem.simulator.body_steps
    fit = profiled(prepared.problem, fitted)
    assert prepared.problem.segmented and prepared.problem.simulator.body_steps == before
    assert not fit.withheld and fit.estimate[0] == 1.2
