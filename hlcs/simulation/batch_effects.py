"""Runs of several models in one World: every run feels the effects of its own model and no other's.

A step of the engine costs a fifth of a millisecond before the first body moves, so many small runs side by side are far
cheaper than one after the other. Runs never touch each other (groups), so what acts on one says nothing of the next.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from minibullet.bodies import Bodies, ContactLaw, Contacts
from minibullet.effects.contract import Effect, checked_answer, checked_law, overrides


def rows_of(places):
    """Places that rise as rows of an array; a slice where they follow one another, which copies nothing."""
    return slice(places[0], places[-1] + 1) if places[-1] - places[0] < len(places) else np.array(places)


def holders(entries):
    """{(effect, how many equal ones stand before it): [numbers of the entries, lists of effects, that hold it]}: two alike act
    twice."""
    found = {}
    for number, effects in enumerate(entries):
        for place, effect in enumerate(effects):
            found.setdefault((effect, effects[:place].count(effect)), []).append(number)
    return found


class Assignment:
    """Which run each row of a World belongs to; filled in once its rows are known."""

    run_of_row = run_of_moving = np.full(0, -1)  # run of every row, -1 = a floor (n,); the same without floors

    def take(self, run_of_row):
        """Note the run of every row (n,)."""
        self.run_of_row, self.run_of_moving = run_of_row, run_of_row[run_of_row >= 0]


@dataclass(frozen=True)
class Subset:
    """An effect that acts on some of the runs."""

    effect: Effect
    members: np.ndarray  # does run b belong, boolean (runs,)


@dataclass(frozen=True)
class SharedEffect(Effect):
    """What effects of several models do together."""

    subsets: tuple = field(default=(), compare=False)
    assignment: Assignment | None = field(default=None, compare=False)

    @cached_property
    def rows(self):
        """Rows of each subset among the bodies that move."""
        return [rows_of(np.flatnonzero(subset.members[self.assignment.run_of_moving])) for subset in self.subsets]

    def summed(self, answer, bodies, shape):
        """Sum of answer(effect, bodies) over effects, each for the bodies of the runs that have it, (n, *shape)."""
        total = np.zeros((len(bodies.mass), *shape))
        for subset, rows in zip(self.subsets, self.rows, strict=True):
            part = Bodies(*[values[rows] for values in bodies])
            total[rows] += checked_answer(subset.effect, answer(subset.effect, part), len(part.mass), shape)
        return total


class SharedForces(SharedEffect):
    """Forces of several models."""

    def forces(self, bodies, time):
        return self.summed(lambda effect, part: effect.forces(part, time), bodies, (6,))


class SharedMass(SharedEffect):
    """Added masses of several models."""

    def added_mass(self, bodies):
        return self.summed(lambda effect, part: effect.added_mass(part), bodies, (6, 6))


class SharedLaw(SharedEffect):
    """Contact laws of several models. A law acts on what those before it in its list left: it is asked once for all runs whose
    lists are the same up to it, a subset that stands after those of the laws before it."""

    @cached_property
    def places(self):
        """Place of each run in an order in which the runs of every subset follow one another (runs,), and in it the first of
        each subset and the one after its last (2, subsets)."""
        place = np.argsort(np.lexsort([~subset.members for subset in reversed(self.subsets)]))
        inside = [place[subset.members] for subset in self.subsets]
        return place, np.array([[its.min() for its in inside], [its.max() + 1 for its in inside]])

    def contact_law(self, contacts, bodies, law):
        run = np.maximum(self.assignment.run_of_row[contacts.body_a], self.assignment.run_of_row[contacts.body_b])
        place, ends = self.places
        order = np.argsort(place[run], kind="stable")  # of one subset, arrays are slices then, not copies
        contacts, law = Contacts(*[values[order] for values in contacts]), [values[order] for values in law]
        ends = np.searchsorted(place[run[order]], ends).tolist()
        for effect, first, end in zip((subset.effect for subset in self.subsets), *ends, strict=True):
            if first == end:
                continue
            some, its = Contacts(*[values[first:end] for values in contacts]), ContactLaw(*[values[first:end] for values in law])
            for values, changed in zip(law, checked_law(effect, effect.contact_law(some, bodies, its), some), strict=True):
                values[first:end] = changed
        for values in law:
            values[order] = values.copy()
        return ContactLaw(*law)


def shared_effects(effects):
    """(effects for one World, Assignment to fill in or None) for runs with the effects (tuple of values) listed, one entry a run.

    Where all runs have the same effects, these are passed on as they are.
    """
    if all(entry is effects[0] or entry == effects[0] for entry in effects):
        return effects[0], None
    assignment, acting = Assignment(), []
    for kind, method in ((SharedForces, "forces"), (SharedMass, "added_mass"), (SharedLaw, "contact_law")):
        parts = [tuple(effect for effect in entry if overrides(effect, method)) for entry in effects]
        # runs share an effect that is summed where both have it, a law where both have the same laws before it too
        parts = [[part[k * (kind is not SharedLaw) : k + 1] for k in range(len(part))] for part in parts]
        subsets = tuple(Subset(its[-1], np.isin(range(len(effects)), runs)) for (its, _), runs in holders(parts).items())
        if subsets:
            acting.append(kind(subsets, assignment))
    return tuple(acting), assignment
