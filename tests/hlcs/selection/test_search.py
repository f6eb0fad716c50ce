"""The search over sets of effects: it ends with the law or with nothing, and what it costs is what the formula says."""

from dataclasses import replace
from functools import partial
from itertools import combinations, product
from types import SimpleNamespace

import numpy as np
import pytest
from linear_models import LAWS, RATE, Bend, Line, sets

from hlcs.data.experiment_file import Body, Surroundings
from hlcs.data.rigid_body import rigid_body
from hlcs.effects import candidate
from hlcs.estimation.budget import Budget
from hlcs.estimation.cross_validation import CrossValidation
from hlcs.estimation.fitting import fit_at
from hlcs.selection.prediction import Proposal
from hlcs.selection.preview import HERE, misfit
from hlcs.selection.refitting import refit
from hlcs.selection.renewal import affordable, due, kept, renewed
from hlcs.selection.search import Search
from hlcs.selection.sets import FittedSets
from hlcs.selection.thresholds import FORESEEN, ODDS, REACH, TIED
from hlcs.simulation.model import Model
from minibullet import effects
from minibullet.errors import InputError

TIMES = [np.linspace(0.0, 1.0 + k, 10) for k in range(4)]
SXX = sum((t - t.mean()) @ (t - t.mean()) for t in TIMES)


def searched(slope, sigma=0.1, noise=0.0, generator=None):
    """Four lines of one slope, in two groups, searched for the one candidate that is their law."""
    values = [slope * t + (noise * generator.standard_normal(10) if noise else 0.0) for t in TIMES]
    problem = Line(TIMES, values, sigma, ["a", "b", "a", "b"])
    return Search(problem, [RATE], problem.fit(Model())).run()


def test_a_law_is_found_where_it_is():
    search = searched(3.0)
    best = search.ranked()[0]
    assert best == {"linear_drag"} and search.fits[best].estimate[0] == pytest.approx(3.0, rel=1e-3)
    assert search.noise_alone(search.fits[best]) and not search.noise_alone(search.base)


def test_nothing_is_found_where_there_is_only_noise(generator):
    """The set with the law is foreseen to cost more than without it, so it is not even fitted."""
    search = searched(0.0, noise=0.1, generator=generator)
    assert search.ranked() == [frozenset()] and search.foreseen[frozenset({"linear_drag"})].cost > search.cost(frozenset())


def test_a_set_costs_its_misfit_its_numbers_what_is_believed_of_them_and_the_odds():
    """chi2 falls by slope^2 Sxx / sigma^2; paid are log n, 2 log(1 + (3/5)^2) and the odds; of a linear law that is foreseen."""
    search = searched(3.0)
    law = frozenset({"linear_drag"})
    paid = np.log(40) + 2 * np.log(1 + 0.36) + ODDS
    assert search.cost(frozenset()) - search.cost(law) == pytest.approx(9 * SXX / 0.1**2 - paid, rel=1e-4)
    assert search.foreseen[law].cost == pytest.approx(search.cost(law), abs=0.01)


def test_forms_of_a_law_stand_beside_each_other_where_they_go_with_other_powers_of_the_speed():
    """A brake in proportion to the speed and a sail that goes with its square are one drag of two parts; two brakes are not, nor
    is a curve that has both parts and one of them."""
    ball, water = rigid_body(Body("sphere", radius=0.01, mass=0.01)), Surroundings(fluid_density=1000.0, fluid_viscosity=1e-3)
    kinds = (effects.LinearDrag, effects.StokesDrag, effects.SphereDrag, effects.QuadraticDrag, effects.DragCrisis)
    problem = Line(TIMES, TIMES)
    search = Search(problem, [candidate(kind, water, ball, True) for kind in kinds], problem.fit(Model()))
    beside = {frozenset(pair) for pair in combinations(search.candidates, 2) if search.compatible(set(pair))}
    viscous, inertial = ("linear_drag", "stokes_drag"), ("quadratic_drag", "drag_crisis")
    assert beside == {frozenset(pair) for pair in product(viscous, inertial)}


def test_a_law_that_holds_another_pays_the_odds_twice():
    """A drag crisis has the quadratic drag as a special case."""
    ball = rigid_body(Body("sphere", radius=0.1, mass=1.0))
    laws = [candidate(kind, Surroundings(), ball, True) for kind in (effects.QuadraticDrag, effects.DragCrisis, effects.Magnus)]
    problem = Line(TIMES, TIMES)
    search = Search(problem, laws, problem.fit(Model()))
    assert search.price({"quadratic_drag"}) == search.price({"magnus"}) == ODDS and search.price({"drag_crisis"}) == 2 * ODDS
    assert search.compatible({"quadratic_drag", "magnus"}) and not search.compatible({"quadratic_drag", "drag_crisis"})


def test_what_is_foreseen_counts_by_the_share_that_fits_with_the_same_effect_found(generator):
    """A fall of 40 is foreseen to cost 10 less than the base. Where fits found half and none of such falls, beside all of it
    before any fit, a half counts and it costs 10 more; after one that found nothing as well, however much that promised. What
    was found of other effects, such as a wind whose columns are rough, says nothing of it."""
    search = searched(0.0, noise=0.1, generator=generator)
    proposal = Proposal(search.cost(frozenset()) - 10, frozenset({"another"}), {}, search.base, 40.0)
    assert search.promising(proposal, search.cost(frozenset()), False, search.costs_of_parts(frozenset()))
    for found, share in (([(10.0, 20.0), (0.0, 20.0)], 0.5), ([(0.0, 1e6)], 0.5), ([(20.0, 20.0)] + [(4.0, 20.0)] * 3, 0.2)):
        for name, counts in (("wind", False), ("another", True)):
            search.found[search.base] = [(frozenset({name}), *falls) for falls in found]
            assert search.share_found(search.base, {"another"}) == pytest.approx(share if counts else 1.0)
            assert search.share_found(search.base) == pytest.approx(share)
        assert search.likely(proposal) == pytest.approx(proposal.cost + (1 - share) * 40.0)
        assert not search.promising(proposal, search.cost(frozenset()), False, search.costs_of_parts(frozenset()))


def test_a_fit_that_got_stuck_is_made_again_where_another_fit_foresees_it(generator):
    """From the same one it would end at the same place."""
    search, law = searched(3.0, noise=0.1, generator=generator), frozenset({"linear_drag"})
    cheaper = search.foreseen[law]._replace(cost=search.cost(law) - 2 * REACH)
    for parent, again in ((search.parents[law][0], []), (search.fits[law], [law])):
        search.foreseen[law] = cheaper._replace(parent=parent)
        assert [proposal.effects for proposal in search.open_proposals()] == again


@pytest.mark.parametrize(("bend", "twins"), [(0.0, True), (1.0, False)])
def test_a_law_that_does_the_same_is_a_twin_of_what_was_found(generator, bend, twins):
    """On 0 to 2 s the square of the cosine of t and t + t^2 is 0.969, below 0.98: such a law is foreseen, and is no twin."""
    search = sets(bend, generator).search
    best = search.ranked()[0]
    assert (frozenset(LAWS) - best in search.twins) == twins and len(best) == 1


def test_what_is_told_beside_the_best_has_its_neighbours_foreseen_as_well(generator):
    """A twin of the second of two that do as well is no twin of the first."""
    search = sets(0.0, generator).search
    told = [effects for effects in search.ranked() if search.cost(effects) < search.cost(search.ranked()[0]) + TIED]
    search.models.clear()
    search.expand()
    assert len(told) == 2 and search.models.keys() == set(told)


@pytest.mark.parametrize(("more", "tried"), [(0.5, False), (1.5, True)])
def test_a_set_that_is_foreseen_to_do_no_more_than_a_part_of_it_that_was_fitted_is_not_tried(generator, more, tried):
    search = sets(0.0, generator).search
    part, base = search.ranked()[0], frozenset()
    fall = search.models[base].proposal(part).fall + more
    proposal = Proposal(-np.inf, frozenset(LAWS), {}, search.base, fall)  # cheaper than anything, were it as foreseen
    costs = search.costs_of_parts(part)
    assert search.promising(proposal, np.inf, True, costs) == tried


@pytest.mark.parametrize(("bend", "twins"), [(0.0, True), (1.0, False)])
def test_a_twin_of_what_explains_the_data_is_fitted_when_the_time_is_over_as_well(generator, monkeypatch, bend, twins):
    """Else what came first would be told alone."""
    found = sets(bend, generator).search
    best = found.ranked()[0]
    search = Search(found.problem, LAWS.values(), found.base, first=[(found.fits[best].model.numbers, None)])
    monkeypatch.setattr(Budget, "spent", True)
    assert (frozenset(LAWS) - best in search.run().fits) == twins
    assert not twins or search.budget.notes() == ()  # nothing waits any more


@pytest.mark.parametrize(("dearer", "fitted"), [(0.0, True), (1e6, False)])
def test_past_its_limit_a_search_fits_no_twin_that_is_foreseen_far_off(generator, monkeypatch, dearer, fitted):
    """Through contacts a twin is of interest whatever is foreseen of it, as long as there is time."""
    found = sets(0.0, generator).search
    best = found.ranked()[0]
    twin = frozenset(LAWS) - best
    search = Search(found.problem, LAWS.values(), found.base, first=[(found.fits[best].model.numbers, None)])
    monkeypatch.setattr(found.problem.simulator, "contact", True)
    monkeypatch.setattr(Budget, "spent", True)
    search.budget.affordable = lambda numbers, most: list(range(len(numbers)))
    waiting = search.open_proposals
    monkeypatch.setattr(search, "open_proposals", lambda: [each._replace(cost=each.cost + dearer) for each in waiting()])
    assert (twin in search.run().fits) == fitted


@pytest.mark.parametrize("segmented", [False, True])
def test_through_contacts_a_single_effect_may_do_more_than_is_foreseen(generator, monkeypatch, segmented):
    """By a fifth of its fall; of a pair, of what holds the best set, and of segments what is foreseen counts."""
    search = sets(0.3, generator).search
    best = search.ranked()[0]
    monkeypatch.setattr(search.problem.simulator, "contact", True)
    monkeypatch.setattr(search.problem, "segmented", segmented, raising=False)
    search.found = {}  # no fit has shown how much of a fall is found
    known = search.cost(best) + REACH, True, search.costs_of_parts(best)
    single = 0.0 if segmented else FORESEEN * 100.0
    for names, more in (({"another"}, single), ({"another", "third"}, 0.0), (best | {"another"}, 0.0)):
        proposal = Proposal(1000.0, frozenset(names), {}, search.base, 100.0)
        assert search.hoped(proposal, *known) == pytest.approx(1000.0 - more)


def test_a_fit_begins_no_farther_off_than_the_misfit_allows():
    """Slope 3: at 11 the misfit is seven times that at 0, at half of it less than there."""
    search = searched(3.0)
    for foreseen, begun in ((5.0, 5.0), (11.0, 5.5), (20.0, 5.0), (1e4, 0.0)):
        assert search.preview.nearer({"linear_drag": {"rate": foreseen}}, search.base) == {"linear_drag": {"rate": begun}}


def test_a_search_goes_farther_where_more_than_noise_is_left(generator):
    """Reach is 12, and 12 times what the best leaves per degree of freedom, or the overdispersion where that is judged."""
    search = searched(0.0, noise=0.1, generator=generator)
    assert search.reach() == REACH
    search = searched(0.0, noise=0.3, generator=generator)
    assert search.reach() == pytest.approx(REACH * search.base.chi2 / search.base.freedom) and search.reach() > 5 * REACH
    assert not search.wider(20.0) and search.reach() == 20 * REACH


def test_a_fit_is_of_interest_as_far_as_the_reach_of_the_best_also_of_those_that_are_fitted_beside_it(monkeypatch):
    """A line of slope 3: the law explains it at a cost of a few units, which bounds the fit that goes on in the same batch."""
    search = searched(3.0)
    law, other = frozenset({"linear_drag"}), frozenset({"spin_decay"})
    search = Search(search.problem, LAWS.values(), search.base)
    assert search.limit(other) == pytest.approx(search.cost(frozenset()) + search.reach() - ODDS)
    found = search.problem.fit(search.preview.model_with({"linear_drag": {"rate": 3.0}}))
    search.ended[law] = found
    assert search.limit(other) == pytest.approx(found.cost + REACH) and search.limit(frozenset()) == found.cost + ODDS + REACH
    limits = []
    monkeypatch.setattr(search.problem, "fit", lambda model, states, limit: (limits.append(limit()), found)[1])
    proposals = [Proposal(0.0, names, {next(iter(names)): {"rate": 1.0}}, search.base) for names in (law, other)]
    search.fit_sets(proposals)
    assert (
        limits[0] == pytest.approx(search.cost(frozenset()) + search.reach(search.base) - ODDS)
        and limits[-1] == found.cost + REACH
    )


def test_a_pair_waits_for_its_parts_and_leaves_the_batch_to_their_rivals():
    """Pairs with a strong law cost next to nothing more than the law; where they come first no other law is ever fitted."""
    ball = rigid_body(Body("sphere", radius=0.1, mass=1.0))
    kinds = effects.QuadraticDrag, effects.Magnus, effects.TiltedGravity, effects.DragCrisis
    laws = [candidate(kind, Surroundings(), ball, True) for kind in kinds]
    problem = Line(TIMES, TIMES)
    search = Search(problem, laws, problem.fit(Model()))
    costs = {("magnus", "tilted_gravity"): 100.0, ("magnus",): 101.0, ("drag_crisis",): 120.0, ("tilted_gravity",): 150.0}
    proposals = [
        Proposal(cost, frozenset(names), {name: search.candidates[name].expected for name in names}, search.base)
        for names, cost in costs.items()
    ]
    search.foreseen = {proposal.effects: proposal for proposal in proposals}
    batch = [sorted(proposal.effects) for proposal in search.parts_first(proposals, 200.0)]
    assert batch == [["magnus"], ["tilted_gravity"], ["quadratic_drag"]]


@pytest.mark.parametrize(("slope", "batch"), [(0.0, ["first", "near", "cheapest"]), (3.0, ["first", "near", "half", "cheapest"])])
def test_a_batch_holds_what_is_foreseen_to_take_away_half_of_what_the_cheapest_does(slope, batch):
    """Of what costs more, and beyond reach, the fit of the cheapest may leave nothing to explain; the first is fitted always."""
    problem = Line(TIMES, [slope * t for t in TIMES], 0.1)
    search = Search(problem, [RATE], problem.fit(Model()))
    cost, reach = search.cost(frozenset()), search.reach()
    least = -20 * reach if slope else cost
    half = least + 0.45 * (cost - least) if slope else cost + 2 * reach
    costs = {"first": 2 * abs(cost) + 100 * reach, "near": least + 0.9 * reach, "half": half, "cheapest": least}
    costs["far"] = least + 0.55 * (cost - least) if slope else cost + 3 * reach
    proposals = [Proposal(cost, frozenset({name}), {}, search.base) for name, cost in costs.items()]
    found = search.first_ones(proposals, proposals)
    assert [name for proposal in found for name in proposal.effects] == batch
    waits = Proposal(-abs(cost) - 100 * reach, frozenset({"linear_drag", "spin_decay"}), {}, search.base)  # for the first one
    found = search.first_ones(proposals, [waits, *proposals])
    assert [name for proposal in found for name in proposal.effects] == ["first"]


@pytest.mark.parametrize(("alone", "borne_out"), [(1.0, True), (0.0, False)])
def test_a_law_that_only_changes_what_another_does_takes_no_place_of_it(generator, alone, borne_out):
    """At the fit of a drag spin_decay does what the drag does; where the drag is not it moves the data as much, or nothing."""

    class Beside(Bend):
        def shape(self, name, t):
            return t

        def residuals(self, model, initial_states):
            rates = {term.name: term.numbers["rate"] for term in model.terms}
            drag = rates.get("linear_drag", 0.0)
            rate = drag + rates.get("spin_decay", 0.0) * (alone + (1 - alone) * drag)
            return [y - state[0] - rate * t for t, y, state in zip(self.times, self.values, initial_states, strict=True)]

    times = [np.linspace(0.0, 2.0, 25) for _ in range(4)]
    problem = Beside(times, [3.0 * t + 0.05 * generator.standard_normal(25) for t in times], 0.05)
    search = Search(problem, LAWS.values(), problem.fit(Model()))
    drag = frozenset({"linear_drag"})
    search.expand()
    search.fit_sets([search.foreseen[drag]])
    search.expand()
    foreseen = search.models[drag].proposal(frozenset({"spin_decay"}))
    assert foreseen.cost < search.base.cost - 1000  # beside the drag it is foreseen to do all of its work
    assert search.borne_out(foreseen) == borne_out


def test_a_first_set_whose_fit_did_not_come_to_its_end_is_begun_from_the_states_of_the_model_under_test(monkeypatch):
    """From the states that were read off the data the fit stays where it began; nothing had foreseen what it would cost."""
    problem = Line(TIMES, [3.0 * t for t in TIMES], 0.1)
    states = problem.initial_guess() + 0.25
    search = Search(problem, [RATE], problem.fit(Model()), first=[({"linear_drag": {"rate": 1.0}}, states)])
    fit = problem.fit

    def stuck(model, begun, limit):
        if not np.array_equal(begun, states):
            return fit(model, begun, limit)
        return replace(fit_at(model, begun, problem.linearise(model, begun)), converged=False)

    monkeypatch.setattr(problem, "fit", stuck)
    search.fit_first()
    found = search.fits[frozenset({"linear_drag"})]
    assert found.converged and found.estimate[0] == pytest.approx(3.0, rel=1e-3)


@pytest.mark.parametrize("contact", [False, True])
def test_of_what_nothing_foresees_all_is_fitted_in_flight_and_through_contacts_until_one_explains_the_data(contact):
    """A line, and two laws of which the one that bends it a little leaves noise alone too. A fit of what is left out begins where
    it was said to, if it is made after all."""
    problem = Bend(TIMES, [3.0 * t for t in TIMES], 0.1)
    problem.bend, problem.simulator.contact = 0.01, contact
    first = [({name: {"rate": rate}}, None) for name, rate in (("linear_drag", 3.0), ("spin_decay", 0.1))]
    search = Search(problem, LAWS.values(), problem.fit(Model()), first=first)
    for name in LAWS:
        search.foreseen[frozenset({name})] = Proposal(0.0, frozenset({name}), {name: {"rate": 7.0}}, search.base)
    search.fit_first()
    assert len(search.fits) == 1 + (1 if contact else 2)
    begin = [search.foreseen[frozenset(numbers)].numbers for numbers, _ in first if frozenset(numbers) not in search.fits]
    assert begin == [numbers for numbers, _ in first if frozenset(numbers) not in search.fits]


def test_a_first_set_that_leaves_noise_alone_is_fitted_from_no_other_start(monkeypatch):
    """A line from its own slope, and from one far off."""
    problem = Line(TIMES, [3.0 * t for t in TIMES], 0.1)
    first = [({"linear_drag": {"rate": rate}}, None) for rate in (3.0, 50.0)]
    search, fit, begun = Search(problem, [RATE], problem.fit(Model()), first=first), problem.fit, []

    def counted(model, *given):
        begun.append(model.numbers)
        return fit(model, *given)

    monkeypatch.setattr(problem, "fit", counted)
    search.fit_first()
    assert begun == [{"linear_drag": {"rate": 3.0}}] and search.noise_alone(search.fits[frozenset({"linear_drag"})])


def test_a_fit_that_leaves_more_than_without_one_of_its_effects_is_begun_where_that_is_absent(monkeypatch):
    """Foreseen at slope 50, and stuck there from both starts, where 47 t are left in place of 3 t: a look had promised less."""
    problem = Line(TIMES, [3.0 * t for t in TIMES], 0.1)
    search, fit = Search(problem, [RATE], problem.fit(Model())), problem.fit

    def stuck(model, states, limit):
        far = model.numbers["linear_drag"]["rate"] > 5.0
        return replace(fit_at(model, states, problem.linearise(model, states)), converged=False) if far else fit(model, states)

    monkeypatch.setattr(problem, "fit", stuck)
    monkeypatch.setattr(search.preview, "left_at", lambda numbers, parent: 0.0)
    monkeypatch.setitem(search.readings, "linear_drag", {"rate": 60.0})
    found = refit(search, Proposal(10.0, frozenset({"linear_drag"}), {"linear_drag": {"rate": 50.0}}, search.base, 1e4))
    assert found.converged and found.estimate[0] == pytest.approx(3.0, rel=1e-3)


@pytest.mark.parametrize(("contact", "begun"), [(True, 1), (False, 2)])
def test_a_fit_through_contacts_that_is_given_up_is_not_begun_elsewhere(monkeypatch, contact, begun):
    """Foreseen at slope 2 and given up there; in flight it is begun once more, from where it is expected, to no better end."""
    problem, tried = Line(TIMES, [3.0 * t for t in TIMES], 0.1), []
    problem.simulator.contact = contact
    search = Search(problem, [RATE], problem.fit(Model()))

    def given_up(model, states, limit):
        tried.append(model.numbers["linear_drag"]["rate"])
        return replace(fit_at(model, states, problem.linearise(model, states)), converged=False)

    monkeypatch.setattr(problem, "fit", given_up)
    refit(search, Proposal(10.0, frozenset({"linear_drag"}), {"linear_drag": {"rate": 2.0}}, search.base, 1e4))
    assert tried == [2.0, RATE.expected["rate"]][:begun]


@pytest.mark.parametrize(("starts", "found"), [((), 1.0), ((0.5, 3.5), 4.0)])
def test_a_law_that_names_several_starts_is_fitted_from_each_while_more_than_noise_is_left(starts, found):
    """Slopes off by 1 + (r - 1)^2 up to r = 2, and by 4 - r from there on: two valleys, of which the first was foreseen, as good
    as it is."""

    class Valleys(Line):
        def residuals(self, model, initial_states):
            r = model.terms[0].numbers["rate"] if model.terms else 0.0
            off = 1 + (r - 1) ** 2 if r < 2 else 4 - r
            return [off * t - state[0] for t, state in zip(self.times, initial_states, strict=True)]

        def linearise(self, model, initial_states, only=None):
            linear = super().linearise(model, initial_states, only)
            r = model.terms[0].numbers["rate"] if model.terms else 0.0
            slope = 2 * (1 - r) if r < 2 else 1.0
            return replace(linear, parameter_columns=[slope * part for part in linear.parameter_columns])

    problem = Valleys(TIMES, TIMES, 0.1)
    law = replace(RATE, free=(replace(RATE.free[0], starts=starts),))
    search = Search(problem, [law], problem.fit(Model()))
    fit = refit(search, Proposal(1e9, frozenset({"linear_drag"}), {"linear_drag": {"rate": 0.9}}, search.base))
    assert fit.estimate[0] == pytest.approx(found, abs=0.01)


@pytest.mark.parametrize(("rate", "first"), [(4.0, True), (0.001, False)])
def test_a_law_of_which_one_look_shows_more_than_is_foreseen_is_fitted_first(rate, first):
    """A path that goes with r + r^2: from no law on, its slope of 20 t at r = 4 is foreseen at r = 20, where it is 420 t. A small
    one is foreseen as it is."""

    class Curves(Line):
        def residuals(self, model, initial_states):
            r = model.terms[0].numbers["rate"] if model.terms else 0.0
            return [y - (r + r**2) * t - state[0] for t, y, state in zip(self.times, self.values, initial_states, strict=True)]

    problem = Curves(TIMES, [(rate + rate**2) * t for t in TIMES], 0.0001)
    search = Search(problem, [RATE], problem.fit(Model()))
    search.expand()
    assert [sorted(numbers) for numbers, _ in search.first] == [["linear_drag"]] * first


def test_a_first_set_that_cannot_be_simulated_loses_no_search():
    """What is read off the data, or stated, may be nothing that can be: the search goes on without it."""

    class Refusing(Line):
        def residuals(self, model, initial_states):
            if any(term.numbers["rate"] > 100.0 for term in model.terms):
                raise InputError("not finite")
            return super().residuals(model, initial_states)

    problem = Refusing(TIMES, [3.0 * t for t in TIMES], 0.1)
    law, base = frozenset({"linear_drag"}), problem.fit(Model())
    search = Search(problem, [RATE], base, first=[({"linear_drag": {"rate": 1e6}}, None)]).run()
    assert search.fits[law].estimate[0] == pytest.approx(3.0, rel=1e-3)  # what is believed of it pulls by less


def test_what_the_file_implies_is_what_the_data_would_show_beside_the_best_fit(generator):
    """A law that is stated for certain moves what the model under test foretells, and nothing beside the drag that explains the
    data: what it was worth beside a worse fit proves nothing."""

    class Hidden(Bend):
        def residuals(self, model, initial_states):
            rates = {term.name: term.numbers["rate"] for term in model.terms}
            drag = rates.get("linear_drag", 0.0)
            rate = drag + rates.get("spin_decay", 0.0) * max(1 - drag / 3.0, 0.0)
            return [y - state[0] - rate * t for t, y, state in zip(self.times, self.values, initial_states, strict=True)]

    (free,) = LAWS["spin_decay"].free
    stated = replace(LAWS["spin_decay"], free=(replace(free, stated=1.0, error=0.5, certain=True),))
    times = [np.linspace(0.0, 2.0, 25) for _ in range(4)]
    problem = Hidden(times, [3.0 * t + 0.05 * generator.standard_normal(25) for t in times], 0.05)
    search = Search(problem, [LAWS["linear_drag"], stated], problem.fit(Model()))
    search.expand()
    assert search.implied == {"spin_decay"}
    search.fit_sets([search.foreseen[frozenset({"linear_drag"})]])
    search.expand()
    assert search.ranked()[0] == {"linear_drag"} and search.implied == frozenset()


@pytest.mark.parametrize("contact", [False, True])
def test_a_search_stops_where_what_is_most_promising_is_not_worth_the_best(contact):
    """It is asked with the best set and with what another one is foreseen to cost, through contacts with the least that it may
    cost, before that one is fitted."""
    problem = Line(TIMES, [3.0 * t for t in TIMES], 0.1)
    problem.simulator.contact = contact
    search, asked, law = Search(problem, [RATE], problem.fit(Model())), [], frozenset({"linear_drag"})
    search.unsure = {law: 500.0}
    search.run(lambda best, promised: asked.append((best, promised)) or True)
    least = search.foreseen[law].cost - contact * 500.0
    assert asked == [(frozenset(), pytest.approx(least))] and list(search.fits) == [frozenset()]


@pytest.mark.parametrize(("part", "doubted"), [(0.05, False), (0.2, True)])
def test_a_number_that_the_file_states_is_doubted_first_where_it_is_foreseen_to_do_a_good_part(part, doubted):
    """A tenth of the excess is asked of it, as of every set that is seen through contacts before any fit."""
    problem = Line(TIMES, [3.0 * t for t in TIMES], 0.1)
    search = Search(problem, [replace(RATE, setting=True)], problem.fit(Model()))
    fall = part * search.excess(search.base)
    assert search.doubted(Proposal(search.base.chi2 - fall, frozenset({"linear_drag"}), {}, search.base, fall)) == doubted


def test_numbers_that_the_file_states_are_doubted_each_and_then_together():
    """Each of two laws does a good part of a line that bends, and one alone would take up what the other one does."""
    problem = Bend(TIMES, [2.0 * t + 2.0 * (t + 0.5 * t**2) for t in TIMES], 0.1)
    problem.bend, problem.simulator.contact = 0.5, True
    search = Search(problem, [replace(law, setting=True) for law in LAWS.values()], problem.fit(Model()))
    search.expand()
    assert [sorted(numbers) for numbers, _ in search.first] == [["linear_drag"], ["spin_decay"], ["linear_drag", "spin_decay"]]


def test_what_does_as_well_in_the_place_of_a_weak_effect_is_told_beside_it_though_nothing_costs_less():
    """A line whose law gains one unit over nothing, and another law that leaves 2 of 12 more: it costs one more than nothing, and
    is as probable as the first one to a factor of three."""
    problem = Bend(TIMES, [0.0 * t for t in TIMES], 0.1, ["a", "b", "a", "b"])
    law, other = frozenset({"linear_drag"}), frozenset({"spin_decay"})
    paid = ODDS + np.log(40)
    slope = 0.1 * np.sqrt((paid + 1.0) / SXX)
    problem.values = [slope * t for t in TIMES]
    shares = []
    for bend in np.linspace(-0.3, 0.0, 301):  # part of the square of the one law that the other one has
        columns = [np.concatenate([x - x.mean() for x in (t, t + bend * t**2)]) for t in TIMES]
        one, two = (np.concatenate([c[k * 10 : k * 10 + 10] for c in columns]) for k in (0, 1))
        shares.append((abs((one @ two) ** 2 / (one @ one) / (two @ two) - (1 - 2.0 / (paid + 1.0))), bend))
    problem.bend = min(shares)[1]
    search = Search(problem, LAWS.values(), problem.fit(Model())).run()
    assert search.cost(law) < search.cost(frozenset()) < search.cost(other) < search.cost(law) + TIED
    found = FittedSets(search, CrossValidation(problem.trials, "none"))
    assert found.best == law and other in found.tied


def test_what_a_simulation_through_contacts_leaves_counts_where_it_is_less_than_foreseen():
    """The law bends the line only where it begins, which its derivative there does not know: at 2.4 of 3 a line of 0.6 is left,
    0.04 of the square, where 0.2 was foreseen."""
    aside = [np.sqrt(0.25 * (t - t.mean()) @ (t - t.mean()) / 10) * np.tile([1.0, -1.0, -1.0, 1.0, 0.0], 2) for t in TIMES]

    class Begins(Line):
        def residuals(self, model, initial_states):
            rate = model.terms[0].numbers["rate"] if model.terms else 0.0
            told = zip(self.times, self.values, initial_states, aside, strict=True)
            return [y - rate * t - min(rate, 0.01) * bend * np.sqrt(10 / 8) - state[0] for t, y, state, bend in told]

    problem = Begins(TIMES, [3.0 * t for t in TIMES], 0.1)
    search = Search(problem, [RATE], problem.fit(Model()))
    search.expand()
    proposal = search.foreseen[frozenset({"linear_drag"})]
    fit, (seen,) = proposal.parent, search.preview.looked([proposal], HERE)
    left = [misfit(fit) - each.fall - search.preview.believed(each.numbers) for each in (proposal, seen)]
    assert left[0] == pytest.approx(0.2 * fit.chi2, rel=0.05) and left[1] == pytest.approx(0.04 * fit.chi2, rel=0.15)
    assert seen.cost == pytest.approx(proposal.cost + left[1] - left[0])


@pytest.mark.parametrize("contact", [True, False])
def test_a_search_that_begins_anew_through_contacts_keeps_what_was_foreseen(contact):
    """Lines of slope 3, then of 2.9: what the model leaves less is left less in what was foreseen from it too. What another fit
    foresaw of a set that was not fitted is foreseen from there still, from what that one leaves now, and no dearer."""
    problem = Line(TIMES, [3.0 * t for t in TIMES], 0.1)
    problem.simulator.contact = contact
    search = Search(problem, [RATE], problem.fit(Model()))
    search.expand()
    law = frozenset({"linear_drag"})
    search.fit_sets([search.foreseen[law]])
    problem.values = [2.9 * t for t in TIMES]
    base = problem.fit(Model())
    other = frozenset({"spin_decay"})
    search.foreseen[other] = Proposal(1e9, other, {"spin_decay": {"rate": 3.0}}, search.fits[law], -10.0)
    after = renewed(search, partial(Search, problem, LAWS.values(), base))
    assert [numbers for numbers, _ in after.first] == [search.fits[law].model.numbers]
    assert set(after.models) == ({frozenset()} if contact else set())
    if contact:
        moved = base.chi2 - search.base.chi2
        assert after.foreseen[law].parent is base
        assert after.foreseen[law].cost == pytest.approx(search.foreseen[law].cost + moved)
        parent = after.foreseen[other].parent
        left = 0.1**2 * SXX / 0.1**2  # slope 3 on lines of 2.9, but for what is believed of it
        assert parent.model == search.fits[law].model and parent.chi2 == pytest.approx(left, rel=0.01)
        assert after.foreseen[other] == search.foreseen[other]._replace(parent=parent)
        assert after.found == {base: search.found[search.base]}  # of what was foreseen from the other one nothing was fitted
    assert after.run().fits[law].estimate[0] == pytest.approx(2.9, rel=1e-3)


@pytest.mark.parametrize(("share", "left_out", "can"), [(0.3, 0, True), (0.5, 0, False), (0.3, 1, False)])
def test_a_search_of_segments_begins_anew_with_what_is_simpler_too_and_where_it_can_be_fitted(share, left_out, can):
    """A friction along a direction, 20 below the plain one that it holds: both are kept, what costs more is not. Three numbers
    were fitted, 0.15 of the limit each: once more, and the model under test, they take 0.6."""
    plain, directed, other = (frozenset({name}) for name in ("plain", "directed", "other"))
    law = SimpleNamespace(holds=lambda entry: False)
    laws = {"plain": law, "other": SimpleNamespace(holds=law.holds)}
    laws["directed"] = SimpleNamespace(holds=lambda entry: entry is law)
    costs = {frozenset(): 5000.0, plain: 4900.0, directed: 4880.0, other: 4950.0}
    budget = Budget(SimpleNamespace(simulator=SimpleNamespace(body_steps=0.0), contact=True, segmented=True))
    budget.left_out = left_out
    budget.simulator.body_steps = 0.45 * budget.limit
    budget.fitted(3, 0.0)
    budget.simulator.body_steps = share * budget.limit
    search = SimpleNamespace(fits=costs, cost=costs.get, ranked=lambda: sorted(costs, key=costs.get), candidates=laws)
    search.implied, search.budget, search.count = frozenset(), budget, lambda effects: 2 if effects == directed else 1
    search.contact = True
    search.parts = partial(Search.parts, search)
    assert kept(search) == [directed, plain]
    assert affordable(search) == can


def test_a_search_of_flights_begins_anew_with_what_the_best_explains_no_half_of():
    """A clock slowed a hundred times leaves 500 beyond noise, the drag of a liquid 900, alone or with a wind, foreseen
    beside, and a scale 1100. Where the best leaves noise alone, what does as well is all there is to be kept."""
    clock, drag, windy, scale = (frozenset(names.split()) for names in ("clock", "drag", "drag wind", "scale"))
    left = {frozenset(): 1e9, clock: 500.0, drag: 900.0, windy: 890.0, scale: 1100.0}
    search = SimpleNamespace(fits={each: each for each in left}, cost=left.get, ranked=lambda: sorted(left, key=left.get))
    search.excess, search.parts = left.get, lambda effects: []
    search.contact = False
    assert kept(search) == [clock, drag]
    left[clock] = -10.0
    assert kept(search) == [clock]


@pytest.mark.parametrize(
    ("excess", "promised", "by_step", "time"),
    [
        (600.0, 0.0, 0.0, False),
        (400.0, 0.0, 0.0, True),
        (400.0, 150.0, 0.0, True),
        (400.0, 250.0, 0.0, False),
        (400.0, 250.0, 150.0, False),
        (400.0, 250.0, 250.0, True),
        (600.0, 0.0, 600.0, False),
        (-50.0, 80.0, 0.0, True),
    ],
)
def test_samples_are_looked_at_anew_where_less_than_half_is_left_and_no_law_but_the_step_of_time_explains_half_of_that(
    excess, promised, by_step, time
):
    """The model under test leaves an excess of 1000; where noise alone is left, nothing comes before a look."""
    law = frozenset({"linear_drag"})
    search = SimpleNamespace(fits={frozenset(): 1000.0, law: excess}, excess=lambda fit: fit, cost=lambda effects: 5000.0)
    assert due(search, [frozenset()], law, 5000.0 - promised, lambda fit: by_step) == time


def test_air_that_no_file_states_is_not_missed_and_counts_as_one_effect_with_all_that_it_does():
    search = searched(0.0)
    lift, along = (
        replace(RATE, name=name, kind=kind) for name, kind in (("lift", effects.Buoyancy), ("along", effects.AddedMass))
    )
    for presumed, without, beside in ((True, 1, 2), (False, 2, 1)):
        law = LAWS["linear_drag"]
        search.candidates = {"drag": law} | {each.name: replace(each, presumed=presumed) for each in (lift, along)}
        search.implied = search.implied_alone = frozenset({"lift", "along"})
        assert search.price(frozenset({"drag"})) == without * ODDS
        assert search.price(frozenset({"drag", "lift", "along"})) == beside * ODDS
    search.candidates = {each.name: replace(each, presumed=True) for each in (lift, along)}
    assert search.price(frozenset()) == 0.0 and search.price(frozenset({"lift"})) == ODDS
