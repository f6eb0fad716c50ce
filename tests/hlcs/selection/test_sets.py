"""From fitted sets to what is told of them: which stand, which do as well, their weights, and intervals over several sets."""

from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from linear_models import LAWS, Bend, Line, model, sets
from scipy import stats

from hlcs.effects import Free, class_named
from hlcs.estimation.cross_validation import CrossValidation
from hlcs.estimation.fitting import fit_at, with_values
from hlcs.selection.found_numbers import doubts_of, interval, parameters_of
from hlcs.selection.held_out import HeldOut
from hlcs.selection.search import Search
from hlcs.selection.sets import FittedSets
from hlcs.selection.thresholds import TIED
from hlcs.selection.verdict import _described, adequate_ones, best_set, finals, law_first, learned_law, reading_first
from hlcs.simulation.model import Model


def test_laws_that_look_alike_share_the_weight_and_take_each_others_place(generator):
    alike = sets(0.0, generator)
    assert {frozenset(members) for members in alike.tied} == {frozenset({name}) for name in LAWS}
    assert sorted(alike.inclusion.values()) == pytest.approx([0.5, 0.5], abs=0.02) and sum(
        alike.weights.values()
    ) == pytest.approx(1)
    ((name, others),) = alike.alternatives().items()
    assert {name, *others} == set(LAWS)


def test_what_does_as_much_in_the_place_of_the_best_is_set_beside_it_not_beside_nothing(generator):
    """Laws that look alike, one of which held-out data fail to prove by chance: it still does as well as the one they prove."""
    alike = sets(0.0, generator)

    class OneProved(FittedSets):
        def broken(self, effects, name):
            return "by chance" if name == "spin_decay" else None

    told = OneProved(alike.search, alike.cross_validation)
    assert told.tied == [{"linear_drag"}, {"spin_decay"}]
    assert sorted(told.weights.values())[-2:] == pytest.approx([0.5, 0.5], abs=0.02)
    told = OneProved(alike.search, alike.cross_validation, 2.0)  # where nothing explains the data it may only absorb
    assert {"spin_decay"} not in told.tied


def test_laws_that_the_data_tell_apart_do_not(generator):
    clear = sets(0.3, generator)
    assert clear.tied == [frozenset({"linear_drag"})] and clear.inclusion["linear_drag"] > 0.99
    assert clear.ordered(clear.best) == ("linear_drag",) and clear.worth(clear.best, "linear_drag") > 1000


def test_a_set_that_is_fitted_better_meanwhile_is_judged_anew_on_held_out_data(generator, monkeypatch):
    """What was fitted to judge another set may take its place among the fits; each fit is judged once."""
    told, law, judged = sets(0.3, generator), frozenset({"linear_drag"}), []
    monkeypatch.setattr("hlcs.selection.sets.held_out", lambda problem, validation, *fits: judged.append(fits) or HeldOut())
    base, stuck = told.search.base, told.search.fits[law]
    better = replace(stuck)  # a Fit of its own, whatever it holds
    for fit in (stuck, stuck, better):
        told.search.fits[law] = fit
        told.held_out(law, "linear_drag")
    assert judged == [(base, stuck), (base, better)]


def test_what_does_not_hold_out_does_not_stand(generator):
    """One law with another sign in each half of the recordings: whatever it gains, it predicts nothing."""
    times = [np.linspace(0.0, 2.0, 25) for _ in range(4)]
    slopes = (3.0, 1.0, 3.0, 1.0)
    values = [slope * (t - 1.0) ** 2 + 0.05 * generator.standard_normal(25) for slope, t in zip(slopes, times, strict=True)]
    problem = Bend(times, values, 0.05, ["a", "b", "a", "b"])
    fitted = FittedSets(Search(problem, LAWS.values(), problem.fit(Model())).run(), CrossValidation(problem.trials, "group"))
    assert fitted.best == frozenset()


@pytest.mark.parametrize("adequate", [True, False])
def test_what_leaves_nothing_but_noise_stands_where_the_data_contradict_all_that_held_out_data_prove(generator, adequate):
    """A rise that three short recordings show together and that none of them foretells of the others: without it the data are
    not explained. Where it does not explain them either, it does not stand."""
    times = [np.linspace(0.0, 2.0, 4) for _ in range(3)]
    search = Search(
        problem := Bend(times, [1.0 * t + 0.3 * generator.standard_normal(4) for t in times], 0.3, ["a", "b", "c"]),
        [LAWS["linear_drag"]],
        problem.fit(Model()),
    ).run()
    law = frozenset({"linear_drag"})

    class Unproved(FittedSets):
        def broken(self, effects, name):
            return None if effects in self.adequate else "held-out data are too few"

    def finished(effects):
        return None, search.fits[effects], SimpleNamespace(adequate=adequate and effects == law, overdispersion=2.0)

    sets, told = best_set(partial(Unproved, search, CrossValidation(problem.trials, "group")), finished)
    assert sets.best == (law if adequate else frozenset()) and told[1] is search.fits[sets.best]


@pytest.mark.parametrize(
    ("final", "without", "seen"),
    [
        ({}, True, True),
        ({"covariance": np.array([[100.0]])}, True, False),  # 3 +- 10
        ({"covariance": np.array([[100.0]])}, False, True),
        ({"withheld": {("linear_drag", "rate"): "only one segment tells it"}}, True, False),
    ],
)
def test_an_effect_whose_final_number_does_not_show_it_does_not_stand_beside_an_adequate_set_without_it(
    generator, final, without, seen
):
    """A rise of 3 a second that 100 readings show to 0.01: the disagreement of segments may tell less than their costs do."""
    times = [np.linspace(0.0, 2.0, 25) for _ in range(4)]
    values = [3.0 * t + 0.05 * generator.standard_normal(25) for t in times]
    search = Search(problem := Bend(times, values, 0.05, ["a", "b", "a", "b"]), [LAWS["linear_drag"]], problem.fit(Model())).run()
    fitted, law = partial(FittedSets, search, CrossValidation(problem.trials, "group")), frozenset({"linear_drag"})

    def finished(effects):
        return (
            problem,
            replace(search.fits[effects], **final if effects else {}),
            SimpleNamespace(adequate=effects == law or without),
        )

    sets, told = best_set(fitted, finished)
    assert sets.best == (law if seen else frozenset()) and told[2].adequate
    assert sets.tied == [sets.best] and sets.weights[sets.best] == pytest.approx(1)


@pytest.mark.parametrize("proved", [True, False])
@pytest.mark.parametrize(("second", "told"), [(0.06, {"linear_drag"}), (0.2, {"linear_drag", "spin_decay"})])
def test_a_second_effect_does_not_stand_beside_an_adequate_set_without_it_that_does_as_well(generator, second, told, proved):
    """A rise with a bend that held-out data prove, or that nothing proves but what is left without it, of 4 units of cost or of
    156: 4 are odds of less than 20 to 1."""
    t = np.linspace(0.0, 2.0, 25)
    noise = 0.05 * generator.standard_normal((4, 25))
    noise -= noise.mean(0)  # what is drawn speaks for no law
    problem = Bend([t] * 4, list(3.0 * t + second * t**2 + noise), 0.05, ["a", "b", "a", "b"])
    problem.bend = 1.0
    search = Search(problem, LAWS.values(), problem.fit(Model())).run()

    class Proved(FittedSets):
        def broken(self, effects, name):
            return None if proved or effects in self.adequate else "held-out data are too few"

    def finished(effects):
        return problem, search.fits[effects], SimpleNamespace(adequate=bool(effects), overdispersion=1.0)

    fitted = partial(Proved, search, CrossValidation(problem.trials, "group"))
    assert fitted(1.0).best == ({"linear_drag", "spin_decay"} if proved else set())
    found = best_set(fitted, finished)[0]
    both = frozenset(LAWS)
    assert found.best == told and {frozenset(told), both} == set(found.tied)
    assert found.inclusion["spin_decay"] == pytest.approx(found.weights[both]) and found.weights[both] > 0.5


def test_sets_without_each_effect_are_begun_in_one_batch_as_they_would_be_one_by_one(generator):
    t = np.linspace(0.0, 2.0, 25)
    problem = Bend([t] * 4, list(3.0 * t + 0.2 * t**2 + 0.05 * generator.standard_normal((4, 25))), 0.05, ["a", "b", "a", "b"])
    problem.bend = 1.0
    search = Search(problem, LAWS.values(), problem.fit(Model())).run()
    both, parts = frozenset(LAWS), [frozenset({name}) for name in sorted(LAWS)]
    search.fits = {effects: search.fits[effects] for effects in (frozenset(), both)}
    beside, alone = (FittedSets(search, CrossValidation(problem.trials, "group")) for _ in range(2))
    beside.fit_without(both, sorted(LAWS))
    assert list(beside.started) == parts[::-1] and not search.fits_for_verdict
    found = [beside.fit(part).chi2 for part in parts]
    assert not beside.started and len(search.fits_for_verdict) == 2
    search.fits_for_verdict.clear()
    assert found == [alone.fit(part).chi2 for part in parts]


def test_what_is_adequate_is_looked_for_from_the_cheapest_set_on(generator):
    """Where the cheapest set is not adequate no other is judged; where it is, those that do as well are too."""
    alike, judged = sets(0.0, generator), []

    def finals_of(adequate):
        def finished(effects):
            judged.append(effects)
            return None, None, SimpleNamespace(adequate=effects in adequate)

        return finished

    first, second = alike.ranked[:2]
    alike.best = frozenset()  # held-out data proved nothing
    assert adequate_ones(alike, finals_of({second})) == frozenset() and judged == [first]
    assert adequate_ones(alike, finals_of({first, second})) == {first, second}


@pytest.mark.parametrize(("recordings", "judged"), [(1, 2), (0, 0)])
def test_a_number_for_each_recording_proves_nothing_by_what_it_leaves(generator, recordings, judged):
    """Golf balls let fall twice: nine numbers of three laws leave noise alone, and foretell one fall from the other to 5 m."""
    alike, asked = sets(0.0, generator), []
    alike.best, alike.search.problem.trials = frozenset(), alike.search.problem.trials[:recordings]

    def finished(effects):
        asked.append(effects)
        return None, None, SimpleNamespace(adequate=True)

    assert len(adequate_ones(alike, finished)) == len(asked) == judged


def test_a_set_that_was_given_up_is_fitted_again_though_no_larger_one_is_known(generator):
    alike, law = sets(0.0, generator), frozenset({"linear_drag"})
    fit = alike.search.fits[law]
    alike.search.fits = {frozenset(): alike.search.base, law: replace(fit, converged=False)}
    assert alike.fit(law).converged and alike.fit(law).chi2 == pytest.approx(fit.chi2)


@pytest.mark.parametrize(("overdispersion", "best"), [(1.0, {"linear_drag", "spin_decay"}), (5.0, {"linear_drag"})])
def test_where_nothing_explains_the_data_what_absorbs_a_part_beside_another_law_does_not_stand(generator, overdispersion, best):
    """A rise that bends, and a swing that no law has: the bend has a variance of (0.6 * 4 / sqrt(180))^2 = 0.032 beside 0.045 of
    the swing, 42 % of what is left without it."""
    times = [np.linspace(0.0, 2.0, 25) for _ in range(4)]
    values = [3 * t + 0.6 * t**2 + 0.3 * np.sin(3 * np.pi * t) + 0.05 * generator.standard_normal(25) for t in times]
    problem = Bend(times, values, 0.05, ["a", "b", "a", "b"])
    problem.bend = 1.0
    search = Search(problem, LAWS.values(), problem.fit(Model())).run()
    assert FittedSets(search, CrossValidation(problem.trials, "group"), overdispersion).best == best


def test_a_law_takes_away_what_its_special_case_leaves():
    """A drag leaves an excess of 1,000 of 10,000, a crisis 600: 94 % beside nothing, 40 % beside the plain drag that it holds."""
    drag = SimpleNamespace(holds=lambda other: False)
    crisis = SimpleNamespace(holds=lambda other: other is drag)
    left = {(): 10_000.0, ("drag",): 1_000.0, ("crisis",): 600.0}
    fits = {
        frozenset(names): SimpleNamespace(chi2=100.0 + excess, freedom=100.0, converged=True, contradicts=False)
        for names, excess in left.items()
    }
    search = SimpleNamespace(fits=fits, candidates={"drag": drag, "crisis": crisis}, compatible=lambda effects: True)
    told = FittedSets(search, None)
    assert told.share(frozenset({"drag"}), "drag") == pytest.approx(0.9)
    assert told.share(frozenset({"crisis"}), "crisis") == pytest.approx(0.4)


def test_a_law_takes_away_what_is_left_without_it_by_numbers_that_the_file_allows():
    """A liquid of 15 kg/m3 where the file states air leaves 1,100 of 10,000 without the drag: that takes 90 % all the same."""
    left = {(): (10_000.0, False), ("lift",): (1_100.0, True), ("drag", "lift"): (1_000.0, False)}
    fits = {
        frozenset(names): SimpleNamespace(chi2=100.0 + excess, freedom=100.0, converged=True, contradicts=contradicts)
        for names, (excess, contradicts) in left.items()
    }
    laws = dict.fromkeys(("drag", "lift"), SimpleNamespace(holds=lambda other: False))
    search = SimpleNamespace(fits=fits, base=fits[frozenset()], candidates=laws, compatible=lambda effects: True)
    assert FittedSets(search, None).share(frozenset({"drag", "lift"}), "drag") == pytest.approx(0.9)


@pytest.mark.parametrize("implied", [frozenset(), frozenset({"linear_drag"})])
def test_what_absorbs_most_is_kept_aside_where_nothing_stands(generator, implied):
    """A rise of 0.3 a second, variance 0.03, beside a swing of 0.125: too little to stand, and the only thing that helps; also
    where the file implies it."""
    times = [np.linspace(0.0, 2.0, 25) for _ in range(4)]
    values = [0.3 * t + 0.5 * np.sin(3 * np.pi * t) + 0.05 * generator.standard_normal(25) for t in times]
    problem = Bend(times, values, 0.05, ["a", "b", "a", "b"])
    search = Search(problem, [LAWS["linear_drag"]], problem.fit(Model())).run()
    search.implied = implied
    fitted = FittedSets(search, CrossValidation(problem.trials, "group"), 2.0)
    assert fitted.best == frozenset() and fitted.absorbing == [{"linear_drag"}]
    assert FittedSets(search, CrossValidation(problem.trials, "group")).absorbing == []


@pytest.mark.parametrize(("kind", "best"), [("linear_drag", set()), ("spin_decay", set()), ("friction", {"linear_drag"})])
def test_impacts_are_a_second_witness_of_a_law_of_contact_and_what_a_flight_shows_of_a_drag_is_none(generator, kind, best):
    """A rise of 0.3 a second beside a swing, too little to stand by the misfit: what impacts show of its number lets it stand."""
    times = [np.linspace(0.0, 2.0, 25) for _ in range(4)]
    values = [0.3 * t + 0.5 * np.sin(3 * np.pi * t) + 0.05 * generator.standard_normal(25) for t in times]
    problem = Bend(times, values, 0.05, ["a", "b", "a", "b"])
    law = replace(LAWS["linear_drag"], kind=class_named(kind))
    search = Search(problem, [law], problem.fit(Model()), readings={"linear_drag": {"rate": 0.3}}).run()
    problem.simulator.contact = True
    assert FittedSets(search, CrossValidation(problem.trials, "group"), 2.0).best == best


def test_a_number_of_what_absorbs_is_told_by_its_final_fit(generator):
    """As of what is accepted: here it lies 0.1 beyond that of the search, with twice its error. Each fit is made final once."""
    times = [np.linspace(0.0, 2.0, 25) for _ in range(4)]
    values = [0.3 * t + 0.5 * np.sin(3 * np.pi * t) + 0.05 * generator.standard_normal(25) for t in times]
    problem = Bend(times, values, 0.05, ["a", "b", "a", "b"])
    search = Search(problem, [LAWS["linear_drag"]], problem.fit(Model())).run()
    sets, made = FittedSets(search, CrossValidation(problem.trials, "group"), 2.0), []

    def polished(fit):
        made.append(fit)
        return problem, replace(fit, estimate=fit.estimate + 0.1, covariance=4 * fit.covariance)

    experiment = SimpleNamespace(judge=lambda problem, fit: (None, None))
    finished = finals(experiment, search, polished)
    (absorbing,) = sets.absorbing
    fit, told = search.fits[absorbing], {members: finished(members)[1] for members in (sets.best, absorbing, absorbing)}
    number = parameters_of(sets, told, sets.absorbing)["linear_drag"]["rate"]
    assert len(made) == 2 and number["value"] == fit.estimate[0] + 0.1
    # twice the error, and the square root of the overdispersion, 2
    reach = stats.t.ppf(0.95, told[sets.best].freedom)
    assert number["high"] - number["value"] == pytest.approx(reach * 2 * np.sqrt(2 * fit.covariance[0, 0]), rel=1e-3)


def test_the_numbers_of_a_set_are_those_of_the_fit_that_is_told_of_it(generator):
    """What the search found, made final, has its number 0.1 farther; it costs what it did among the sets."""
    times = [np.linspace(0.0, 2.0, 25) for _ in range(4)]
    problem = Bend(times, [0.3 * t + 0.05 * generator.standard_normal(25) for t in times], 0.05, ["a", "b", "a", "b"])
    search = Search(problem, [LAWS["linear_drag"]], problem.fit(Model())).run()
    sets = FittedSets(search, CrossValidation(problem.trials, "group"))
    fit = search.fits[sets.best]
    told = replace(fit, model=with_values(fit.model, fit.estimate + 0.1))
    entry = _described(sets, sets.best, told, lambda fit: 0.0, {})
    assert entry["parameters"] == {"linear_drag": {"rate": fit.estimate[0] + 0.1}} and entry["chi2"] == fit.chi2


def test_an_interval_over_two_sets_is_that_of_their_mixture():
    """Two sets of equal weight at 0 and 1, each known to 0.1: 5 % lie below the lower end, 95 % below the upper one."""
    free = Free("number", "m", -1.0, 1.0, 0.0, 0.0)
    told = interval([(0.5, 0.0, 0.1), (0.5, 1.0, 0.1)], free, 1000)
    for end, share in (("low", 0.05), ("high", 0.95)):
        assert np.mean(stats.t.cdf((told[end] - np.array([0.0, 1.0])) / 0.1, 1000)) == pytest.approx(share, abs=1e-6)
    assert told["value"] == 0.0


def test_an_interval_of_one_set_is_students_and_ends_where_the_law_ends():
    free = Free("friction", "1", 0.0, 1.0, 0.0, 0.0)
    told = interval([(1.0, 0.05, 0.1)], free, 8)
    assert told["low"] == 0.0 and told["high"] == pytest.approx(0.05 + stats.t.ppf(0.95, 8) * 0.1)


@pytest.mark.parametrize(
    ("other", "dearer", "first"),
    [
        ("curve", 0.8, "scale"),
        ("curve", 1.2, "curve"),
        ("curve", -0.1, "scale"),
        ("clock", 0.8, "scale"),
        ("clock", 1.2, "clock"),
    ],
)
def test_at_equal_evidence_the_fewest_numbers_are_named_first_and_plausible_ones(other, dearer, first):
    """A scale of one number beside a curve of five, or a clock that is off beyond what is plausible: equal evidence is a
    difference of 1, odds of 1 to 1.6."""
    costs = {(other,): 10.0, ("scale",): 10.0 + dearer, (): 200.0}
    by_cost = {frozenset(names): cost for names, cost in costs.items()}
    counts = {"curve": (5, 0), "clock": (1, 1), "scale": (1, 0)}
    fits = {}
    for names, cost in costs.items():
        count, implausible = counts.get("".join(names), (0, 0))
        fits[frozenset(names)] = SimpleNamespace(
            numbers=[None] * count, implausible=implausible, tempered=lambda overdispersion, cost=cost: cost, contradicts=False
        )
    laws = dict.fromkeys((other, "scale"), SimpleNamespace(holds=lambda other: False))
    search = SimpleNamespace(fits=fits, fits_for_verdict={}, candidates=laws, price=lambda effects, fit: 0.0, implied=frozenset())
    judged = FittedSets(search, SimpleNamespace(possible=False))
    judged.stands = lambda effects: True
    assert judged.best == {first}
    assert max(judged.weights.values()) == judged.weights[min(by_cost, key=by_cost.get)] > 0.5


def test_what_was_fitted_to_judge_a_set_may_be_the_best():
    """Of two laws that were fitted together one adds nothing: the other alone, fitted to see that, stands."""
    costs = {("friction", "restitution"): 20.0, ("friction",): 21.0, (): 200.0}
    fits = {frozenset(names): SimpleNamespace(tempered=lambda overdispersion, cost=cost: cost) for names, cost in costs.items()}
    alone = frozenset({"friction"})
    search = SimpleNamespace(fits={names: fit for names, fit in fits.items() if names != alone}, fits_for_verdict={})
    search.price = lambda effects, fit: 0.0
    judged = FittedSets(search, None)

    def stands(effects):
        if len(effects) == 2:
            search.fits_for_verdict[alone] = fits[alone]
        return len(effects) < 2

    judged.stands = stands
    assert judged.cheapest == alone


def test_an_effect_is_judged_beside_the_best_fit_without_it_though_the_search_gave_that_one_up(generator):
    """The law alone, left where the misfit is a thousand times the noise: beside that the other one would explain nearly all."""
    told = sets(0.3, generator)
    law, both, fits = frozenset({"linear_drag"}), frozenset(LAWS), told.search.fits
    end, model_with = fits[law], told.search.preview.model_with
    fits[both] = told.search.problem.fit(model_with({name: {"rate": 1.0} for name in LAWS}))
    away = model_with({"linear_drag": {"rate": 9.0}})
    given_up = fit_at(away, end.initial_states, told.search.problem.linearise(away, end.initial_states), converged=False)
    fits[law] = given_up
    told = FittedSets(told.search, told.cross_validation)
    assert given_up.chi2 > 100 * end.chi2 and told.fit(law).chi2 == pytest.approx(end.chi2, rel=1e-3)
    assert told.worth(both, "spin_decay") < 10 and told.best == law and fits[law].converged


def test_a_part_of_a_set_is_fitted_from_what_the_model_under_test_foresees_of_it_too(generator, monkeypatch):
    """A law that is stuck where it stood beside another one, as a friction that depends on the direction where it is the other
    way round: at a rate of 9 in place of 3."""
    told = sets(0.3, generator)
    search, problem, law = told.search, told.search.problem, frozenset({"linear_drag"})
    end, fit = search.fits.pop(law), problem.fit

    def stuck(model, initial_states):
        return fit_at(model, initial_states, problem.linearise(model, initial_states))

    beside = search.preview.model_with({"linear_drag": {"rate": 9.0}, "spin_decay": {"rate": 0.0}})
    search.fits[frozenset(LAWS)] = both = stuck(beside, end.initial_states)
    monkeypatch.setattr(search, "noise_alone", lambda fit: fit is both)
    monkeypatch.setattr(search.preview, "nearer", lambda numbers, parent: numbers)
    there = search.preview.model_with({"linear_drag": {"rate": 9.0}})
    monkeypatch.setattr(problem, "fit", lambda model, *states: (stuck if model == there else fit)(model, *states))
    assert told.fit(law).chi2 == pytest.approx(end.chi2, rel=1e-3)


@pytest.mark.parametrize(("overdispersion", "rate"), [(1.0, 1.4), (2000.0, 1.0)])
def test_a_number_that_the_file_states_is_left_where_a_misfit_that_hangs_together_drove_it(generator, overdispersion, rate):
    """A rate stated as 1.00 +- 0.05 in data that rise by 1.5 and swing: white noise would tell it to 0.009, and where 2,000
    residuals count as one to 0.4. There 8 errors aside cost 2 log(1 + 64) = 8, and as stated it loses (0.4 / 0.4)^2 = 1."""
    law = replace(LAWS["linear_drag"], free=(replace(LAWS["linear_drag"].free[0], stated=1.0, error=0.05),))
    times = [np.linspace(0.0, 2.0, 25) for _ in range(4)]
    values = [1.5 * t + 0.5 * np.sin(3 * np.pi * t) + 0.05 * generator.standard_normal(25) for t in times]
    problem = Bend(times, values, 0.05, ["a", "b", "a", "b"])
    search = Search(problem, [law], problem.fit(Model())).run()
    search.fits_for_verdict = dict(search.fits)  # what was fitted to judge others before takes no place of it
    fitted = FittedSets(search, CrossValidation(problem.trials, "group"), overdispersion).tempered()
    assert fitted.cheapest in search.fits
    (value,) = search.fits[frozenset({"linear_drag"})].estimate
    assert value == pytest.approx(rate, abs=0.1) and problem.overdispersion == overdispersion
    assert fitted.returned() == []


@pytest.mark.parametrize("beside", [False, True])
@pytest.mark.parametrize("overdispersion", [1.0, 8.0])
@pytest.mark.parametrize(("better", "left", "stands"), [(2 * TIED, 0.4, True), (TIED / 2, 0.4, False), (2 * TIED, 0.6, False)])
def test_a_law_learned_without_the_best_set_stands_where_it_does_better_not_where_it_does_as_well_or_absorbs(
    better, left, stands, overdispersion, beside
):
    """The best set costs 100, or with a law beside it 70, where `overdispersion` residuals count as one, and leaves a chi2
    of 1000 beyond noise; the law leaves a part of that."""
    best = frozenset({"tilted_frame"})

    def fit(cost, left=1.0):
        chi2 = 100.0 + 1000.0 * left
        return SimpleNamespace(tempered=lambda divided: cost * overdispersion / divided, chi2=chi2, freedom=100.0)

    fits = {best: fit(100.0), frozenset(): fit(900.0, 10.0)}
    search = SimpleNamespace(problem=SimpleNamespace(overdispersion=9.0), implied=frozenset(), fits=fits)
    alone = SimpleNamespace(fit=fit((70.0 if beside else 100.0) - better, left))
    of_best = SimpleNamespace(fit=fit(70.0, 0.0)) if beside else None
    experiment = SimpleNamespace(learn=lambda problem, fit, known: of_best if fit is fits[best] else alone)
    sets = SimpleNamespace(search=search, best=best, cost_of=lambda effects, fit: fit.tempered(overdispersion))
    assert learned_law(experiment, sets) is (alone if stands else of_best)


@pytest.mark.parametrize("left", [0.4, 0.6])
def test_a_law_learned_beside_the_best_set_takes_half_of_what_that_leaves_or_only_absorbs(left):
    """A chi2 of 1000 beyond noise without it."""
    fits = {frozenset(): SimpleNamespace(chi2=1100.0, freedom=100.0)}
    problem = SimpleNamespace(overdispersion=9.0)
    sets = SimpleNamespace(search=SimpleNamespace(problem=problem, implied=frozenset(), fits=fits), best=frozenset())
    law, counted = SimpleNamespace(fit=SimpleNamespace(chi2=100.0 + 1000.0 * left, freedom=100.0)), []

    def learn(problem, fit, best):
        counted.append(problem.overdispersion)
        return law

    assert learned_law(SimpleNamespace(learn=learn), sets) is (law if left < 0.5 else None)
    assert counted == [1.0] and problem.overdispersion == 9.0  # it is fitted with each residual as one, what follows as before


def test_ctrl_c_while_a_law_is_learned_loses_no_verdict(generator):
    def interrupted(problem, fit, best):
        raise KeyboardInterrupt

    clear = sets(0.3, generator)
    clear.search.budget.stopped, said = False, []
    clear.search.progress = said.append

    def finished(effects):
        return None, None, SimpleNamespace(adequate=False)

    assert law_first(SimpleNamespace(learn=interrupted), None, finished, clear) == (clear, None)
    assert clear.search.budget.stopped and "Ctrl-C again gives up" in said[-1]


def test_ctrl_c_while_a_reading_that_is_off_is_looked_for_loses_no_verdict(generator):
    def interrupted():
        raise KeyboardInterrupt

    clear = sets(0.3, generator)
    clear.search.budget.stopped = False
    found = {True: SimpleNamespace(adequate=True), False: SimpleNamespace(adequate=False, overdispersion=9.0)}
    assert reading_first(None, lambda effects: (None, None, found[bool(effects)]), clear, interrupted) is clear
    assert clear.best and clear.search.budget.stopped


def test_a_number_that_the_time_step_tells_worse_than_the_data_is_told_with_what_to_do():
    """An error of the step of two standard errors of the data, and one of half of it."""
    times = [np.arange(5.0)]
    fit = Line(times, [2.0 * times[0]]).fit(model(1.0))
    error = np.sqrt(fit.covariance[0, 0])
    told = [doubts_of(replace(fit, step_error=np.array([share * error])), {"linear_drag": {"rate": {}}}) for share in (-2.0, 0.5)]
    assert told[1] == () and "linear_drag.rate" in told[0][0] and "smaller time_step under [model]" in told[0][0]


def test_an_interval_has_the_error_of_each_side_on_its_side():
    """Known to 0.1 downwards and to 0.3 upwards: 1.645 of either, of a normal law; of two sets alike the mixture is the same."""
    free = Free("number", "m", -1.0, 1.0, 0.0, 0.0)
    for count in (1, 2):
        told = interval([(1.0, 0.2, np.array([0.1, 0.3]))] * count, free, 1e6)
        assert (told["low"], told["high"]) == (pytest.approx(0.2 - 0.1645, abs=1e-4), pytest.approx(0.2 + 0.4935, abs=2e-4))
