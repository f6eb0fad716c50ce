"""What is told of every candidate of a search."""

import re
from dataclasses import replace

import numpy as np
import pytest
from linear_models import LAWS, Bend, sets

from hlcs.effects import Candidate, classes
from hlcs.effects.candidates import Free
from hlcs.effects.witnesses import INPUTS_OF
from hlcs.estimation.cross_validation import CrossValidation
from hlcs.records import Reason
from hlcs.selection.findings import candidate_findings, change_told, set_label
from hlcs.selection.found_numbers import annotated
from hlcs.selection.search import Search
from hlcs.selection.sets import FittedSets
from hlcs.selection.verdict import starts_share
from hlcs.simulation.model import Model, Term
from minibullet.errors import InputError


def told(found, absent=()):
    return candidate_findings(found, found.alternatives(), dict(absent))


def test_what_is_accepted_comes_first_and_what_was_not_tried_last(generator):
    """With a bend of 0.3 the second law misses by far: -3 t^2 / 10 cannot be seen in its place."""
    first, second, last = told(sets(0.3, generator), {"magnus": "the spin is unknown"})
    assert first.effect == "linear_drag" and first.accepted and first.reason is Reason.ACCEPTED and first.same_as == ()
    assert "held-out error falls by" in first.why and first.evidence > 100
    assert (second.effect, second.accepted) == ("spin_decay", False)
    assert (last.effect, last.evidence) == ("magnus", None) and last.why == "not tried: the spin is unknown"


def test_what_does_as_well_is_named_on_both_sides_with_its_likeness(generator):
    found = sets(0.0, generator)
    first, second = told(found)
    assert first.accepted and first.same_as == (second.effect,) and f"cannot be told from {second.effect}" in first.why
    assert second.reason is Reason.NOT_TOLD_APART and second.same_as == (first.effect,)
    assert first.cosines == {second.effect: pytest.approx(1.0)} and second.cosines == {first.effect: pytest.approx(1.0)}


def test_the_smallest_value_that_the_data_would_have_shown_has_its_unit(generator):
    assert all(re.fullmatch(r"rate 0\.\d+ 1/s", finding.visible_from) for finding in told(sets(0.3, generator)))


def test_the_smallest_change_says_from_what_and_to_which_side():
    """A drag is more than none, a ruler is too long or too short, and a density is off what is stated to both sides."""
    either, number = Free("relative", "1", -0.02, 0.02, 0.0, 0.0), Free("rate", "1/s", 0.0, 5.0, 0.0, 0.0)
    assert change_told(either, 0.0025) == "relative +-0.0025" and change_told(number, 0.02) == "rate 0.02 1/s"
    stated = Free("friction", "1", 0.0, 1.5, 0.5, 0.5)
    assert change_told(stated, 0.05) == "friction 0.05 more or less than 0.5"
    assert change_told(Free("scale", "m", 1.0, 2.0, 1.0, 1.0), 0.1) == "scale 0.1 m more than 1"


def test_sets_of_look_alikes_are_named_where_two_of_them_are_alike():
    buoyancy, clock, magnus = (Candidate(name, classes()[name], ()) for name in ("buoyancy", "time_scale", "magnus"))
    assert set_label(buoyancy, [clock]) == " (effective_gravity)" and set_label(buoyancy, [magnus]) == ""


def lines(slope, generator, bend=0.0, swing=0.0):
    """FittedSets of four recordings that rise by `slope` a second and swing at 1.5 Hz; noise 0.05."""
    times = [np.linspace(0.0, 2.0, 25) for _ in range(4)]
    values = [slope * t + swing * np.sin(3 * np.pi * t) + 0.05 * generator.standard_normal(25) for t in times]
    problem = Bend(times, values, 0.05, ["a", "b", "a", "b"])
    problem.bend = bend
    search = Search(problem, LAWS.values(), problem.fit(Model())).run()
    return FittedSets(search, CrossValidation(problem.trials, "group"))


def test_a_law_that_only_an_impossible_number_would_fit_is_said_to_be_beyond_its_end(generator):
    """A rate below zero is no drag: the lines fall, and nothing else is tried."""
    for finding in told(lines(-3.0, generator)):
        assert not finding.accepted and finding.reason is Reason.BEYOND_ITS_LAW
        share = re.search(
            r"the data would have rate below 0, where the law ends; then (\d+) % of the misfit would go", finding.why
        )
        assert int(share[1]) >= 99  # noise is 0.05 beside lines that fall by 6


def test_what_takes_less_than_half_of_the_misfit_is_not_said_to_fail_on_other_recordings(generator):
    """A swing of 0.5 has a variance of 0.125 beside 0.03 of a rise of 0.6 over 2 s, of which a swing may look like a part."""
    found = lines(0.3, generator, swing=0.5)
    found.overdispersion = 2.0  # of a swing, where nothing explains it
    assert found.best == frozenset()
    (finding,) = (finding for finding in told(found) if finding.effect == "linear_drag")
    share = re.search(r"the model as it is .*: (\d+) % of what is more than noise, too little", finding.why)
    assert 3 < int(share[1]) < 50


def test_what_is_not_seen_falls_short_of_its_price(generator):
    """Noise alone: the fall is what chance explains, and the sentence never says that a larger fall is less than a price."""
    for finding in told(lines(0.0, generator)):
        assert finding.reason in (Reason.NOT_SEEN, Reason.BEYOND_ITS_LAW)
        if finding.reason is Reason.NOT_SEEN:
            fall, short = map(
                float, re.search(r"would fall by ([\d.]+), which is ([\d.]+) less than the price", finding.why).groups()
            )
            assert fall < 12 and short > 0 and short == pytest.approx(-finding.evidence, abs=0.06)


def test_every_finding_tells_what_remains_with_it(generator):
    """With the right law noise alone, 1 +- sqrt(2/95); with the other, which bends, far more."""
    first, second = told(sets(0.3, generator))
    assert first.remains["effects"] == ["linear_drag"] and first.remains["chi2_per_freedom"] == pytest.approx(1.0, abs=0.45)
    assert not first.remains["foreseen"] and first.remains["error"] == first.fitted
    assert second.remains["chi2_per_freedom"] > 5 * first.remains["chi2_per_freedom"]
    assert first.called.startswith("air resistance") and first.lacking


def test_what_was_not_fitted_is_foreseen_by_the_model_under_test(generator):
    """Laws that are straight in their numbers: from there a fit finds what is foreseen, to a thousandth that the prior of its
    number takes; the best set, from which the way back to no drag is long, may promise what it will."""
    found, other = sets(0.3, generator), frozenset({"spin_decay"})
    search = found.search
    fitted = search.problem.fit(Model().with_term(Term(LAWS["spin_decay"], (("rate", 0.1),))), search.base.initial_states)
    better = {"fall": 0.9 * fitted.chi2, "parent": search.fits[found.best]}
    search.foreseen[other] = search.foreseen[other]._replace(**better)
    (finding,) = (finding for finding in told(found) if finding.effect == "spin_decay")
    assert finding.remains["foreseen"] and finding.remains["error"] is None
    assert finding.remains["chi2_per_freedom"] == pytest.approx(fitted.chi2_per_freedom, rel=1e-3)


def test_the_starts_take_their_share_of_the_noise(generator):
    """One constant fitted to 25 readings takes 1/25 of their variance."""
    found = sets(0.3, generator)
    assert starts_share(found.search.problem, found.search.base) == pytest.approx(1 / 25)


def test_a_number_tells_what_the_model_states_and_what_is_usual_where_it_is_not():
    law = LAWS["linear_drag"]
    (free,) = law.free
    number = {"value": 2.0, "low": 1.0, "high": 3.0, "unit": "1/s"}
    assert annotated(number, free, law) == number
    assert annotated(number, free, replace(law, setting=True)) == number | {"stated": 0.0}
    odd = annotated({"value": 20.0, "low": 19.0, "high": 21.0, "unit": "1/s"}, free, law)
    assert odd["rests_on"] == INPUTS_OF["linear_drag"]
    assert odd["usual"] == "0 to 10 1/s" and odd["beyond"] == "20 lies above what is plausible (0 to 10 1/s)"


@pytest.mark.parametrize(("low", "high", "beyond"), [(-0.21, 0.11, False), (-0.21, -0.04, False), (-0.09, -0.06, True)])
def test_a_number_is_beyond_what_is_plausible_only_where_all_of_its_interval_is(low, high, beyond):
    """Plausible is +-0.05: -0.05 +- 0.16 may be anything there, so the data do not give it, and contradict no input."""
    law = LAWS["linear_drag"]
    free = replace(law.free[0], low=-0.05, high=0.05)
    assert ("beyond" in annotated({"value": -0.075, "low": low, "high": high, "unit": "1/s"}, free, law)) == beyond


def test_what_cannot_be_simulated_is_not_told_to_be_hidden_by_others(generator):
    class Unbuilt(Bend):
        def residuals(self, model, states):
            if "spin_decay" in {term.name for term in model.terms}:
                raise InputError("cannot be built")
            return super().residuals(model, states)

    times = [np.linspace(0.0, 2.0, 25) for _ in range(4)]
    data = Unbuilt(times, [3 * t + 0.05 * generator.standard_normal(25) for t in times], 0.05, ["a", "b", "a", "b"])
    found = FittedSets(Search(data, LAWS.values(), data.fit(Model())).run(), CrossValidation(data.trials, "group"))
    (lost,) = [each for each in told(found) if each.effect == "spin_decay"]
    assert lost.reason is Reason.NOT_TRIED and "nothing can be simulated with it" in lost.why


def test_a_search_that_ends_by_its_number_of_fits_does_not_speak_of_time(generator, monkeypatch):
    monkeypatch.setattr("hlcs.selection.search.REFITS", 0)
    times = [np.linspace(0.0, 2.0, 25) for _ in range(4)]
    data = Bend(times, [3 * t + 0.05 * generator.standard_normal(25) for t in times], 0.05, ["a", "b", "a", "b"])
    data.bend = 0.3
    (note,) = Search(data, LAWS.values(), data.fit(Model())).run().budget.notes()
    assert "since so many were fitted" in note and "time" not in note
