"""The model under test: an experiment's settings and a list of effects in it -> what the measurement would have shown."""

import html
from dataclasses import dataclass, replace

import numpy as np

from hlcs.effects import Candidate, build, build_entry, class_named
from hlcs.effects.contract import Change, in_sessions
from hlcs.files.documents import to_toml
from hlcs.simulation.simulator import Simulator
from minibullet.effects import Effect, Gravity, compose
from minibullet.effects.contract import law_of, parameters

MOTION = (  # what the laws of effects enter, and their letters
    "  m dv/dt = m g + sum of F,  I d(omega)/dt + omega x I omega = sum of M",
    "  w: velocity v relative to the fluid, A: mean projected area, V: volume, r: radius of a sphere of that volume,",
    "  rho: density of the fluid, mu: friction of the pair",
)


@dataclass(frozen=True)
class Term:
    """One effect in the model with its numbers."""

    candidate: Candidate
    values: tuple[tuple[str, float], ...]

    @property
    def name(self):
        return self.candidate.name

    @property
    def numbers(self):
        """The numbers as a dictionary name -> value."""
        return dict(self.values)

    def at(self, numbers):
        """The same term with other numbers."""
        return Term(self.candidate, tuple((key, float(value)) for key, value in numbers.items()))


class Terms:
    """What any model can do with the effects in it, `terms`: each method makes another model."""

    def with_term(self, term):
        """The model with one more effect."""
        return replace(self, terms=(*self.terms, term))

    def without(self, index):
        """The model without its term number `index`."""
        return replace(self, terms=self.terms[:index] + self.terms[index + 1 :])

    def with_at(self, index, numbers):
        """The model with other numbers in its term number `index`."""
        return replace(self, terms=self.terms[:index] + (self.terms[index].at(numbers),) + self.terms[index + 1 :])

    @property
    def by_session(self):
        """Is a number another one in each session?"""
        return any(in_sessions(entry) for entry in self.entries)

    def held(self):
        """The model with all its numbers held where they are."""
        return replace(self, terms=tuple(replace(term, candidate=replace(term.candidate, free=())) for term in self.terms))

    @property
    def numbers(self):
        """The numbers of its effects, {effect: {number: value}}."""
        return {term.name: term.numbers for term in self.terms}

    def terms_named(self, name):
        """The number of the term of that name."""
        return [term.name for term in self.terms].index(name)

    def _repr_html_(self):
        return f"<pre>{html.escape(str(self))}</pre>"

    def _told(self, ground, laws, known):
        """The model in lines: what it stands on, then each effect with its law and its numbers; laws: {name: sentence}; known:
        {name: {number: (its unit, what it means)}}."""
        lines = [f"Model: {', '.join([ground, *laws])}" + ("" if laws else " alone")]
        for entry in self.entries:
            numbers = [_number_told(key, value, known[entry["name"]]) for key, value in entry.items() if key != "name"]
            said = "; ".join(filter(None, (laws[entry["name"]], ", ".join(numbers))))
            lines.append(f"  {entry['name']}" + (f": {said}" if said else ""))
        return lines


def _number_told(name, value, known):
    """A number of an effect with its unit and what it means: "offset = -0.104 s (from the stamp of the release to the release)".

    name: that of one session too, "offset A"; known: {number: (unit, what it means)}.
    """
    unit, about = known.get(name) or known.get(name.partition(" ")[0], ("", ""))
    return f"{name} = {value:.4g}" + f" {unit}" * (unit not in ("", "-", "1")) + f" ({about})" * bool(about)


@dataclass(frozen=True)
class Carried(Effect):
    """A level table that carries a body without friction (a puck on air): its push takes up all that acts along z."""

    loads: tuple = ()  # the other effects
    isotropic = False

    def forces(self, bodies, time):
        push = np.zeros((len(bodies.mass), 6))
        push[:, 2] = -sum(effect.forces(bodies, time)[:, 2] for effect in self.loads)
        return push


@dataclass(frozen=True)
class Model(Terms):
    """What is believed to happen: gravity, the floor, and these effects. A value: `with_term` makes another one."""

    terms: tuple[Term, ...] = ()
    fixed: tuple[dict, ...] = ()  # effects of the experiment file, as written
    own: tuple[type, ...] = ()  # the user's classes, to look names up
    time_step: float = 1 / 240  # of the model with contacts [s]

    def changes(self, surroundings):
        """(effects for the engine with gravity first, changes of the set-up, changes of the recording) in these surroundings.

        Changes act in the order of their names, however they are listed: a late clock, then a slow one, true(factor t - offset).
        """
        stated = {entry["name"] for entry in self.fixed}
        built = [(entry["name"], build_entry(entry, surroundings, self.own)) for entry in self.entries[: len(self.fixed)]]
        terms = [term for term in self.terms if term.name not in stated]
        built += [(term.name, build(term.candidate.kind, term.numbers, surroundings)) for term in terms]
        acting = [effect for _, effect in built if isinstance(effect, Effect)]
        changes = [change for _, change in sorted(built, key=lambda each: each[0]) if isinstance(change, Change)]
        acting = compose((Gravity(acceleration=surroundings.gravity), *acting))
        if surroundings.planar and surroundings.floor_height is None:
            acting = (*acting, Carried(acting))
        return (
            acting,
            [c for c in changes if type(c).setup is not Change.setup],
            [c for c in changes if type(c).look is not Change.look or type(c).read is not Change.read],
        )

    @property
    def names(self):
        """Names of all effects in it."""
        return tuple(entry["name"] for entry in self.entries)

    @property
    def kinds(self):
        """Classes of all effects in it."""
        found = {term.name: term.candidate.kind for term in self.terms}
        return tuple(found.get(name) or class_named(name, self.own) for name in self.names)

    @property
    def entries(self):
        """What [model] effects of an experiment file holds of it: name and numbers of each effect.

        A term that has the name of an effect of the file says that its numbers are others: it stands in its place.
        """
        found = {term.name: term.numbers for term in self.terms}
        written = [entry | found.pop(entry["name"], {}) for entry in self.fixed]
        return *written, *({"name": name, **numbers} for name, numbers in found.items())

    def __str__(self):
        """Its equations of motion in words and letters, with its numbers."""
        laws = {name: law_of(kind) for name, kind in zip(self.names, self.kinds, strict=True)}
        known = {
            name: {key: (number.unit, number.about) for key, number in parameters(kind).items()}
            for name, kind in zip(self.names, self.kinds, strict=True)
        }
        return "\n".join([*self._told("gravity", laws, known), *MOTION])

    def to_toml(self):
        """The [model] section of an experiment file that holds these effects."""
        return to_toml({"model": {"effects": list(self.entries), "time_step": self.time_step}}, inline=True)

    def run(self, trial, start, times):
        """Positions (n, 3) and orientations (n, 4) of one trial at the times (n,), from a start (13,): x, v, q, w."""
        trial = replace(trial, times=np.asarray(times, dtype=float), accelerations=None)
        contact = trial.surroundings.floor_height is not None
        simulator = Simulator(self, (trial,), np.array([0.0]), contact, self.time_step)
        (motion,) = simulator.simulate(self, np.asarray(start, dtype=float)[None], np.zeros(1, int))
        return motion.position, motion.orientation
