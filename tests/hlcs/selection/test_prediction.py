"""What other sets would cost, foreseen in one Gram matrix: as the fits themselves do where the law is linear."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from experiments import measured
from hard_cases import write_sinking
from throws import write_damped_drops, write_drops

import hlcs
from hlcs.effects import Candidate, Free, class_named
from hlcs.estimation.linearization import Fit, Linearization, occam
from hlcs.kinds.trajectories.preparation import prepare
from hlcs.selection.eligibility import candidates_for
from hlcs.selection.prediction import LinearModel
from hlcs.selection.search import Search
from hlcs.simulation.model import Model, Term

NAMES = ("buoyancy", "linear_drag", "magnus", "time_scale")


def entry(name):
    return Candidate(name, class_named(name), (Free("number", "1", -2.0, 2.0, 0.0, 0.0),))


def linear_model(generator, present=()):
    """(LinearModel of four candidates with random columns, the columns, the residual); present: those in the model, at 0.5."""
    columns = {name: 5 * generator.standard_normal((30, 1)) for name in NAMES}
    r = columns["buoyancy"][:, 0] + 0.5 * columns["magnus"][:, 0] + generator.standard_normal(30)
    model, inside = Model(tuple(Term(entry(name), (("number", 0.5),)) for name in present)), np.zeros((30, 0))
    if present:
        inside = np.hstack([columns[name] for name in present])
    left = r - 0.5 * inside.sum(axis=1)
    linear = Linearization([left], [left], [np.zeros((30, 0))], [inside])
    fit = Fit(model, np.zeros((1, 13)), linear, np.full(len(present), 0.5), np.zeros((len(present),) * 2))
    views = {entry(name): [({"number": 0.0}, [columns[name]])] for name in NAMES if name not in present}
    return LinearModel(fit, views, lambda names: 6.0 * len(names)), columns, r


def expected(columns, r, names):
    """The least of misfit and surprise over a fine grid, and what is paid beside."""
    if not names:
        return r @ r
    table = np.hstack([columns[name] for name in sorted(names)])
    axis = np.linspace(-0.5, 1.5, 401)
    grid = np.stack(np.meshgrid(*[axis] * len(names), indexing="ij"), axis=-1).reshape(-1, len(names))
    misfit = np.array([np.sum((r - table @ numbers) ** 2) for numbers in grid])
    return np.min(misfit + 2 * np.log1p(grid**2).sum(axis=1)) + occam(table.T @ table, 30) + 6.0 * len(names)


@pytest.mark.parametrize("present", [(), ("linear_drag",), ("magnus", "time_scale")])
def test_every_neighbour_costs_what_its_own_best_numbers_cost(generator, present):
    """Adding one, adding two, replacing and dropping from a model at any numbers; the grid is 0.005 fine: within 0.1 of chi2."""
    linear, columns, r = linear_model(generator, present)
    proposals = linear.proposals(2, lambda names: True)
    assert len({proposal.effects for proposal in proposals}) == len(proposals) > 3
    for proposal in proposals:
        assert proposal.cost == pytest.approx(expected(columns, r, proposal.effects), abs=0.1)
        assert set(proposal.numbers) == set(proposal.effects)


def test_a_law_makes_room_for_another_wherever_it_sets_in(generator):
    """A drag crisis is absent where its coefficients are, and its Reynolds number is no matter then: another drag may take its
    place. Random columns of both numbers, as above."""
    law = replace(entry("linear_drag"), free=(*entry("linear_drag").free, Free("place", "1", -2.0, 2.0, None, 0.0)))
    columns = {name: 5 * generator.standard_normal((30, 1)) for name in ("linear_drag", "magnus")}
    r = columns["magnus"][:, 0] + generator.standard_normal(30)
    left = r - 0.5 * columns["linear_drag"][:, 0]
    inside = np.hstack([columns["linear_drag"], generator.standard_normal((30, 1))])
    model = Model((Term(law, (("number", 0.5), ("place", 1.0))),))
    linear = Linearization([left], [left], [np.zeros((30, 0))], [inside])
    fit = Fit(model, np.zeros((1, 13)), linear, np.array([0.5, 1.0]), np.zeros((2, 2)))
    views = {entry("magnus"): [({"number": 0.0}, [columns["magnus"]])]}
    proposals = LinearModel(fit, views, lambda names: 6.0 * len(names)).proposals(2, lambda names: True)
    (alone,) = [proposal for proposal in proposals if proposal.effects == {"magnus"}]
    assert alone.cost == pytest.approx(expected(columns, r, ("magnus",)), abs=0.1)


def test_two_effects_may_take_the_place_of_one(generator):
    """What one law did alone two may do better, and neither of them does better alone or beside it."""
    proposals = linear_model(generator, ("linear_drag",))[0].proposals(2, lambda names: True)
    assert {"buoyancy", "magnus"} in [proposal.effects for proposal in proposals]


def test_what_the_file_implies_leaves_room_for_as_many_effects_as_without_it(generator):
    """Two effects are in the model and two can join it: of two at most none can, where the first two do not count both can."""
    linear, _, _ = linear_model(generator, ("magnus", "time_scale"))
    implied = (frozenset(), frozenset({"magnus"}), frozenset({"magnus", "time_scale"}))
    largest = [max(len(each.effects) for each in linear.proposals(2, lambda names: True, names)) for names in implied]
    assert largest == [2, 3, 4]


def test_what_one_statement_of_the_file_implies_may_be_dropped_together(generator):
    linear, _, _ = linear_model(generator, ("magnus", "time_scale"))
    alone, implied = (
        {each.effects for each in linear.proposals(3, lambda names: True, names)}
        for names in (frozenset(), frozenset({"magnus", "time_scale"}))
    )
    assert frozenset() in implied and frozenset() not in alone


def of_two_laws(alike, size, present):
    """LinearModel of a law stated for certain at 1 +- 0.1, which moves the observations by `size` sigma in all, and of another
    one whose column is like it to a cosine; and the candidates."""
    stated = replace(entry("buoyancy"), free=(Free("number", "1", 0.8, 1.2, 0.0, 0.0, stated=1.0, error=0.1, certain=True),))
    columns = {entry("linear_drag"): np.array([[10.0], [0.0]]), stated: size * np.array([[alike], [np.sqrt(1 - alike**2)]])}
    model = Model(tuple(Term(law, (("number", 0.5),)) for law in columns if law.name in present))
    inside = np.hstack([column for law, column in columns.items() if law.name in present] or [np.zeros((2, 0))])
    linear = Linearization([np.zeros(2)], [np.zeros(2)], [np.zeros((2, 0))], [inside])
    fit = Fit(model, np.zeros((1, 13)), linear, np.full(len(present), 0.5), np.zeros((len(present),) * 2))
    views = {law: [({"number": 0.0}, [column])] for law, column in columns.items() if law.name not in present}
    return LinearModel(fit, views, len), {law.name: law for law in columns}


@pytest.mark.parametrize("alike, size, shown, beside", [(1.0, 3.0, 1, 1), (0.9, 2.0, 0, 1), (0.2, 2.0, 0, 0), (0.9, 0.9, 0, 0)])
def test_what_the_file_states_for_certain_is_implied_where_data_show_it_or_numbers_are_off_without_it(alike, size, shown, beside):
    """Its chi2 is size^2, beside odds of 6; without it the number of the other law is off by alike * size standard errors, beside
    one of them. Where no other law is in the model no number is off."""
    names = [frozenset(), frozenset({"buoyancy"})]
    for present in (("linear_drag",), ("linear_drag", "buoyancy")):
        linear, laws = of_two_laws(alike, size, present)
        assert linear.certain(6.0, laws) == (names[shown], names[beside])
    linear, laws = of_two_laws(alike, size, ())
    assert linear.certain(6.0, laws) == (names[shown], names[shown])


def test_another_law_is_foreseen_beside_all_that_the_file_implies(generator):
    """From one drag to another with the two things that the fluid does: three changes in one step."""
    linear, _, _ = linear_model(generator, ("magnus",))
    implied = frozenset({"buoyancy", "time_scale"})
    proposed = {each.effects for each in linear.proposals(1, lambda names: True, implied)}
    assert {implied | {"linear_drag"}, implied | {"magnus"}, implied} <= proposed


def test_what_does_not_move_the_observations_is_not_proposed(generator):
    linear, _, _ = linear_model(generator)
    silent = SimpleNamespace(effect="silent")
    linear.places["silent"] = [len(linear.columns)]
    linear.gram = np.pad(linear.gram, (0, 1))
    assert silent.effect not in linear.entries and not linear.visible("silent") and linear.visible("magnus")


def test_a_rebound_is_seen_from_a_model_that_has_none(tmp_path):
    """Heights go with e^2, so the derivative at e = 0 shows nothing; a look from afar shows a good part of what a fit gains."""
    measurement = measured(write_drops(tmp_path, 0.006))  # no single blow can be read in these
    prepared = prepare(measurement)
    entries, _ = candidates_for(measurement, True, ["restitution"])
    search = Search(prepared.problem, entries, prepared.base).run()
    law = frozenset({"restitution"})
    gain, foreseen = (search.cost(frozenset()) - cost for cost in (search.cost(law), search.foreseen[law].cost))
    assert foreseen > 0.2 * gain > 8
    assert search.fits[law].estimate[0] == pytest.approx(0.5, abs=0.03)  # four standard errors


def test_a_look_far_from_the_data_tells_what_a_linear_model_can_foresee_there(tmp_path):
    """A scale of the length is linear in its factor: nothing more is to be had. A sphere that sinks without drag gets ever
    faster, so that drag is foreseen at tens of thousands more than a scale; it explains all."""
    measurement = measured(write_sinking(tmp_path, 2.6))
    prepared = prepare(measurement)
    entries, _ = candidates_for(measurement, True, ["quadratic_drag", "length_scale"])
    search = Search(prepared.problem, entries, prepared.base)
    search.expand()
    drag, scale = frozenset({"quadratic_drag"}), frozenset({"length_scale"})
    foreseen = {effects: search.foreseen[effects].cost for effects in (drag, scale)}
    assert foreseen[drag] > foreseen[scale] + 1e4
    assert foreseen[drag] - search.unsure[drag] < 0 and search.unsure[scale] < 1.0
    assert search.run().ranked()[0] == drag and scale not in search.fits


def test_a_law_that_changes_what_a_body_hits_is_looked_at_far_away(tmp_path):
    """Of balls that bounce with no drag in the model the slope foretells a small part of a drag of 8 1/s, and of the misfit to
    fall little: what they hit, and when, is another with it."""
    measurement = measured(write_damped_drops(tmp_path, 8.0))
    prepared = prepare(measurement)
    entries, _ = candidates_for(measurement, True, ["linear_drag", "restitution", "time_scale"])
    search = Search(prepared.problem, entries, prepared.base)
    search.expand()
    drag = frozenset({"linear_drag"})
    proposal, base = search.foreseen[drag], search.base
    slope = search.models[frozenset()].proposal(drag)
    assert slope.numbers["linear_drag"]["rate"] < 2.0 and slope.fall < 0.5 * base.chi2
    assert proposal.numbers["linear_drag"]["rate"] == pytest.approx(8.0, abs=4.0) and proposal.fall > 0.8 * base.chi2


def test_numerics_of_a_wrong_model_do_not_call_for_a_second_effect(tmp_path):
    """The error of the time step at balls that bounce on and on is not that of balls that a drag stops."""
    path = write_damped_drops(tmp_path, 8.0)
    diagnosis = hlcs.diagnose(path, candidates=["linear_drag", "time_scale"])
    assert diagnosis.effects == ("linear_drag",) and diagnosis.verdict == "effect"
    assert diagnosis.parameters["linear_drag"]["rate"]["value"] == pytest.approx(8.0, abs=0.02)
