"""What other sets of effects would cost, foreseen from one fit: signatures of all candidates in one Gram matrix.

At a fit every candidate has a signature: the white change of the observations for a change of its numbers, initial states
projected out. Beside the signatures of what is in the model they make one linear model, in which adding an effect, adding two,
replacing and dropping one are choices of columns, and cost what `Fit.cost` says of a fit.
"""

from dataclasses import dataclass
from functools import partial
from itertools import combinations
from typing import NamedTuple

import numpy as np

from hlcs.effects import Free
from hlcs.estimation.least_squares import least_squares
from hlcs.estimation.linearization import Fit, occam
from hlcs.selection.eligibility import lacks_drag
from hlcs.selection.thresholds import EQUAL
from hlcs.simulation.model import Term
from minibullet.errors import InputError

FAR = 0.3  # part of its range over which a number is varied that shows nothing nearer: a rebound goes with its square
NEARLY_FREE = 0.01  # weight of the belief in a first estimate: data decide where it is looked at
# how much of a law that is never absent is there, as a number of its own: all of it is expected
AMPLITUDE = Free("amplitude", "1", low=0.0, high=1.0, null=0.0, start=1.0, stated=1.0, error=1.0)


class Proposal(NamedTuple):
    """A set of effects that was not fitted yet."""

    cost: float  # foreseen
    effects: frozenset
    numbers: dict  # effect -> {number: value} from where to fit it
    parent: Fit  # that it was foreseen from
    fall: float = 0.0  # of the misfit and the surprise together that is foreseen from there


@dataclass(frozen=True)
class Column:
    """One number of the linear model, in units of its spread from where it stands."""

    effect: str
    free: object  # Free
    value: float  # where it stands

    @property
    def absent(self):
        """The way from where it stands to the null value, in spreads; nan where no value says that the effect is absent."""
        return np.nan if self.free.null is None else (self.free.null - self.value) / self.free.spread

    @property
    def ends(self):
        """The lowest and the highest step that its law allows."""
        return (self.free.least - self.value) / self.free.spread, (self.free.most - self.value) / self.free.spread


def signatures(problem, fit, entry, at):
    """[(values while absent, white signatures (n_i, p))] of a candidate at a fit, one for each way to be absent; [] where none.

    at: numbers that are known of it beforehand, {number: value}: a derivative is then the way there, else a small one.
    """
    if lacks_drag(entry, fit.model.kinds):
        return []

    def columns(view):
        def slope(free):
            def moved(value):
                return fit.model.with_term(Term(entry, tuple((view | {free.name: value}).items())))

            known, states, to = (lambda: fit.linearization), fit.initial_states, at.get(free.name)
            return problem.derivative(entry.name, free, free.null, moved, known, states, reach=FAR, to=to)[0]

        parts = problem.batched([partial(slope, free) for free in entry.free if free.null is not None])
        return [np.column_stack(part) for part in zip(*parts, strict=True)]

    def law():  # one that is never absent: the change that it makes at its usual numbers
        plus = fit.model.with_term(Term(entry, tuple(entry.start.items())))
        return [part[:, None] for part in problem.signature(fit.model, fit.initial_states, plus)]

    try:
        views = problem.batched([partial(columns, view) for view in entry.views])
        return list(zip(entry.views, views, strict=True)) or [(None, law())]
    except InputError:
        return []


class LinearModel:
    """The linear model at a fit: columns of its own numbers, and of all candidates that can join it."""

    def __init__(self, fit, views, price):
        """views: candidate -> its signatures (see `signatures`); price: of a set of names."""
        self.fit, self.price, self.count, self.spared = fit, price, fit.count, fit.linearization.spared()
        self.entries = {}  # name of a candidate that can join it -> its numbers while absent
        r = np.concatenate(fit.linearization.projected[0])
        parts = [np.concatenate(fit.linearization.projected[1])]
        self.columns = [Column(*number) for number in fit.numbers]
        self.present = tuple(term.name for term in fit.model.terms)
        for entry, choices in views.items():
            looks = [(view, np.concatenate(fit.linearization.without_states(signature))) for view, signature in choices]
            if looks:
                view, its = max(looks, key=lambda look: least_squares(look[1], r).gain)
                self.entries[entry.name] = entry.start | (view or {})
                varied = [free for free in entry.free if free.null is not None] if view else [AMPLITUDE]
                self.columns += [Column(entry.name, free, free.null if view else 0.0) for free in varied]
                parts.append(its)
        spread = np.array([column.free.spread for column in self.columns])
        table = np.nan_to_num(np.hstack(parts) * spread)
        self.gram, self.dots, self.total = table.T @ table, table.T @ r, float(r @ r)
        self.places = {
            name: [place for place, column in enumerate(self.columns) if column.effect == name]
            for name in (*self.present, *self.entries)
        }

    def proposals(self, most, compatible, implied=frozenset()):
        """Proposals of all sets one or two effects away, and one away beside all that the file implies, of at most so many
        effects beside that; compatible: may names stand together?"""
        present = frozenset(self.present)
        absent = [name for name in self.entries if self.visible(name)]
        sets = [present | {name} for name in absent]
        for name in self.present:
            if self.droppable(name):
                sets += [present - {name}, *(present - {name} | {other} for other in absent)]
                sets += [present - {name} | set(pair) for pair in combinations(absent, 2)]
        if implied <= self.places.keys():
            sets += [names | {name for name in implied if compatible(names | {name})} for names in (present, *sets)]
        sets += [present | set(pair) for pair in combinations(absent, 2)]
        if len(implied & present) > 1:  # these have null values, or nothing would imply them
            sets.append(present - implied)  # one statement of the file may be wrong
        sets = dict.fromkeys(names for names in sets if names != present)
        return [self.proposal(names) for names in sets if len(names - implied) <= most and compatible(names)]

    def twins(self, alike):
        """Sets in which another effect takes the place of one that is in the model and does the same here: its columns make what
        that one changes on its way from its null value, to the part `alike` of its square."""
        found = set()
        for name in self.present:
            own = [place for place in self.places[name] if np.isfinite(self.columns[place].absent)]
            way = np.array([-self.columns[place].absent for place in own])
            if not own:
                continue
            size = way @ self.gram[np.ix_(own, own)] @ way
            for other in filter(self.visible, self.entries):
                its = self.places[other]
                dots = self.gram[np.ix_(its, own)] @ way
                if dots @ _solved(self.gram[np.ix_(its, its)], dots) > alike * size:
                    found.add(frozenset(self.present) - {name} | {other})
        return found

    def droppable(self, name):
        """Is it known how the model does without an effect that is in it? Not of one that acts at all of its numbers."""
        return any(np.isfinite(self.columns[place].absent) for place in self.places[name])

    def foresees(self, names):
        """Can a set of names be foreseen, its effects known here and those that are not in it droppable?"""
        return names <= self.places.keys() and all(map(self.droppable, set(self.present) - names))

    def visible(self, name):
        """Does a candidate move the observations at all, by more than a hundredth of their noise within its spread?"""
        return self.information(name) > 1e-4

    def information(self, name):
        """Largest information on one number of an effect, in units of its spread."""
        return max(self.gram[place, place] for place in self.places[name])

    def certain(self, odds, candidates):
        """(effects that the file states for certain, in the model or not, and that the data would show here at these odds; the
        same and, where the other numbers of the model would be off by more than EQUAL of their cost without them, all that the
        file states). candidates: {name: Candidate}; one that holds another one is there in its place, if at all.
        """
        frees = [column.free for column in self.columns]
        way = np.array([(free.expected - free.null) / free.spread if free.certain else 0.0 for free in frees])
        laws = [name for name, law in candidates.items() if not any(map(law.holds, candidates.values()))]
        stated = [name for name in laws if name in self.places and way[self.places[name]].any()]
        shown = [name for name in stated if self.information(name) * np.max(way[self.places[name]] ** 2) > odds]
        its = [place for name in stated for place in self.places[name]]
        others = [place for name in self.present if name not in stated for place in self.places[name]]
        dots = self.gram[np.ix_(others, its)] @ way[its]
        off = dots @ _solved(self.gram[np.ix_(others, others)], dots)
        return frozenset(shown), frozenset(filter(self.visible, stated) if off > EQUAL else shown)

    def proposal(self, names):
        """The Proposal of a set of names among those that are in the model or can join it."""
        gone = [place for name in self.present if name not in names for place in self.places[name]]
        kept = [place for name in sorted(names) for place in self.places[name]]
        back = np.nan_to_num([self.columns[place].absent for place in gone])  # what has no null value stays: where a drag drops
        dots = self.dots[kept] - self.gram[np.ix_(kept, gone)] @ back
        total = self.total - 2 * self.dots[gone] @ back + back @ self.gram[np.ix_(gone, gone)] @ back
        step, fall = self._step(kept, dots)
        cost = total - fall + occam(self.gram[np.ix_(kept, kept)], self.count) - self.spared + self.price(names)
        standing = [self.columns[place] for name in self.present for place in self.places[name]]
        before = self.total + sum(column.free.surprise(column.value) for column in standing)
        numbers = {name: dict(self.entries.get(name, {})) for name in names}
        for place, move in zip(kept, step, strict=True):
            column = self.columns[place]
            if column.free is not AMPLITUDE:
                numbers[column.effect][column.free.name] = column.free.inside(column.value + move * column.free.spread)
        return Proposal(float(cost), frozenset(names), numbers, self.fit, float(before - total + fall))

    def _step(self, kept, dots):
        """(best step of the numbers `kept` in spreads, by how much the misfit and the surprise fall together)."""
        gram = self.gram[np.ix_(kept, kept)]
        aside = np.array([self.columns[place].free.aside(self.columns[place].value) for place in kept])
        believed = np.array([self.columns[place].free.period is None for place in kept], float)
        low, high = np.array([self.columns[place].ends for place in kept]).reshape(-1, 2).T
        weight, step = NEARLY_FREE * believed, np.zeros(len(kept))
        for _ in range(3):  # a Cauchy law is a normal one whose width follows the estimate
            step = _solved(gram + np.diag(weight), dots - weight * aside)
            outside = (step < low) | (step > high)
            if outside.any():
                fixed, free = np.clip(step, low, high), ~outside
                rest = dots - weight * aside - gram @ np.where(outside, fixed, 0.0)
                fixed[free] = _solved((gram + np.diag(weight))[np.ix_(free, free)], rest[free])
                step = np.clip(fixed, low, high)
            weight = 2 * believed / (1 + (aside + step) ** 2)
        surprise = float(2 * np.log1p((aside + step) ** 2) @ believed)
        return step, float(2 * dots @ step - step @ gram @ step) - surprise


def _solved(matrix, right):
    """Solution of normal equations (n, n), each number in units of its own error: a belief counts where the data tell no two of
    them apart, though one of them may be known a million times better than it was believed."""
    size = np.sqrt(np.where(np.diag(matrix) > 0, np.diag(matrix), 1.0))
    return np.linalg.lstsq(matrix / np.outer(size, size), right / size, rcond=1e-10)[0] / size
