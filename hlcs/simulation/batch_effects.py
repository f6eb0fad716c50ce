"""Runs of several models in one World: every run feels the effects of its own model and no other's.

A step of the engine costs a fifth of a millisecond before the first body moves, so many small runs side by side are far
cheaper than one after the other. Runs never touch each other (groups), so what acts on one says nothing of the next.
"""

from dataclasses import dataclass, field

import numpy as np

from minibullet.bodies import Bodies, ContactLaw, Contacts
from minibullet.effects.contract import Effect, checked_answer, checked_law


class Seats:
    """Who sits where in the rows of a World; filled in once its rows are known."""

    def __init__(self, runs):
        self.run_of_row = np.full(0, -1)  # run of every body of the World, -1 = a floor (n,)
        self.runs = runs  # number of runs

    def take(self, run_of_row):
        """Note the run of every row (n,)."""
        self.run_of_row = np.asarray(run_of_row)
        self.run_of_moving = self.run_of_row[self.run_of_row >= 0]


@dataclass(frozen=True)
class Portion:
    """Effects that act, in this order, on some of the runs."""

    effects: tuple
    member: np.ndarray  # does run b belong, boolean (runs,)


@dataclass(frozen=True)
class SharedForces(Effect):
    """Forces of several models: those of each effect on the bodies of the runs that have it."""

    portions: tuple = field(default=(), compare=False)
    seats: Seats | None = field(default=None, compare=False)

    def forces(self, bodies, time):
        total = np.zeros((len(bodies.mass), 6))
        for portion, rows, part in _parts(self, bodies):
            for effect in portion.effects:
                total[rows] += checked_answer(effect, effect.forces(part, time), len(part.mass), (6,))
        return total


@dataclass(frozen=True)
class SharedMass(Effect):
    """Added masses of several models."""

    portions: tuple = field(default=(), compare=False)
    seats: Seats | None = field(default=None, compare=False)

    def added_mass(self, bodies):
        total = np.zeros((len(bodies.mass), 6, 6))
        for portion, rows, part in _parts(self, bodies):
            for effect in portion.effects:
                total[rows] += checked_answer(effect, effect.added_mass(part), len(part.mass), (6, 6))
        return total


@dataclass(frozen=True)
class SharedLaw(Effect):
    """Contact laws of several models."""

    portions: tuple = field(default=(), compare=False)
    seats: Seats | None = field(default=None, compare=False)

    def contact_law(self, contacts, bodies, law):
        run = np.maximum(self.seats.run_of_row[contacts.body_a], self.seats.run_of_row[contacts.body_b])
        found = [np.array(values, dtype=float) for values in law]
        for portion in self.portions:
            inside = np.flatnonzero(portion.member[run])
            if len(inside) == 0:
                continue
            some, its = Contacts(*(values[inside] for values in contacts)), ContactLaw(*(values[inside] for values in found))
            for effect in portion.effects:
                its = checked_law(effect, effect.contact_law(some, bodies, its), some)
            for values, changed in zip(found, its, strict=True):
                values[inside] = changed
        return ContactLaw(*found)


def _parts(shared, bodies):
    """(portion, rows, their Bodies) of the moving bodies, for every portion that has any."""
    run = shared.seats.run_of_moving
    for portion in shared.portions:
        inside = portion.member[run]
        if inside.all():
            yield portion, slice(None), bodies
        elif inside.any():
            rows = np.flatnonzero(inside)
            yield portion, rows, Bodies(*(values[rows] for values in bodies))


def shared(effects):
    """(effects for one World, Seats to fill in or None) for runs with the effects (tuple of values) listed, one entry a run.

    Where all runs have the same effects, these are passed on as they are.
    """
    if all(entry is effects[0] or entry == effects[0] for entry in effects):
        return effects[0], None
    seats, acting = Seats(len(effects)), []
    for kind, method in ((SharedForces, "forces"), (SharedMass, "added_mass")):  # sums: each effect by itself
        member = {}
        for run, entry in enumerate(effects):
            for place, effect in enumerate(entry):
                if getattr(type(effect), method) is not getattr(Effect, method):
                    count = sum(other == effect for other in entry[:place])  # two alike count twice
                    member.setdefault((count, effect), np.zeros(len(effects), bool))[run] = True
        if member:
            acting.append(kind(tuple(Portion((effect,), runs) for (_, effect), runs in member.items()), seats))
    member = {}
    for run, entry in enumerate(effects):  # laws act one on what the other left: each list by itself
        laws = tuple(effect for effect in entry if type(effect).contact_law is not Effect.contact_law)
        if laws:
            member.setdefault(laws, np.zeros(len(effects), bool))[run] = True
    if member:
        acting.append(SharedLaw(tuple(Portion(laws, runs) for laws, runs in member.items()), seats))
    return tuple(acting), seats
