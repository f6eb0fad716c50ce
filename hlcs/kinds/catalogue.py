"""The whole catalogue of what may be missing from a model: the library of effects, and what only tests of layers know."""

import numpy as np

from hlcs.effects import classes
from hlcs.effects.catalogue import FAMILIES, EffectFacts, NumberFacts, catalogue, facts_named
from hlcs.effects.library import with_own
from hlcs.kinds.layers.candidates import LOOKS_LIKE, library
from hlcs.kinds.layers.data import LayerSet
from hlcs.placement.grids import TPG
from hlcs.placement.procedure import PlacementTest
from hlcs.placement.statistics import Sample
from minibullet.errors import InputError, if_alike

GROUPS = {"physics": "physics", "placement": "placement", "measurement": "plates", "numerics": "numerics"}  # of a family
SWITCH = "It is there or not; there is no number to be found."
SIMULATED = "Depends on grid, bottom and friction: `hlcs diagnose` simulates the test with it and without."
TOLD_APART = "Known to tests of layers alone. A verdict on layers tells families apart, and often not the members of one."


def whole_catalogue(own=()):
    """EffectFacts of all effects, the user's own among them, in the order of FAMILIES, then by name."""
    found = [*catalogue(own), *layer_facts().values()]
    return sorted(found, key=lambda facts: (list(FAMILIES).index(facts.group), facts.name))


def named(name, own=()):
    """The EffectFacts of that name; InputError with the nearest known names."""
    if name in with_own(own):
        return facts_named(name, own)
    known = layer_facts()
    if name in known:
        return known[name]
    raise InputError(f"unknown effect '{name}'{if_alike(name, [*with_own(own), *known])} (all names: hlcs effects)")


def layer_facts():
    """{name: EffectFacts} of what has no class of its own, with the ranges of the default placement test."""
    candidates = {entry.name: entry for entry in library(PlacementTest(), two_campaigns()) if entry.name not in classes()}
    return {name: _facts(entry, candidates.values()) for name, entry in candidates.items()}


def two_campaigns():
    """Layers that two campaigns read, without which offsets between campaigns are no candidate."""
    sample = Sample(np.ones(1), np.zeros(1), np.ones(1))
    return [LayerSet(TPG, 0.0, campaign, sample) for campaign in ("1", "2")]


def _facts(entry, others):
    """The EffectFacts of a LayerCandidate; others: all that it may look like."""
    alike = tuple(other.name for other in others if other is not entry and entry.alike and other.alike == entry.alike)
    return EffectFacts(
        name=entry.name,
        class_name="",
        called=entry.words,
        group=GROUPS[entry.family],
        law=f"{entry.words[:1].upper()}{entry.words[1:]}.",
        formula="",
        symbols=(),
        numbers=tuple(_number(number) for number in entry.free),
        looks_like=LOOKS_LIKE.get(entry.name, SIMULATED),
        confused_with=alike,
        details=TOLD_APART if entry.free else f"{SWITCH} {TOLD_APART}",
    )


def _number(free):
    """The NumberFacts of a Free."""
    return NumberFacts(free.name, free.name, "", free.unit, free.start, free.low, free.high, "", free.null, False, (), "")
