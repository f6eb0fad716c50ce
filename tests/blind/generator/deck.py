"""Which case hides what: a deterministic, shuffled deck with fixed numbers of every kind, family and noise.

A judging deck of 480 cases fills every row of the score with at least 60 cases but for: layer tables (24 cases, 16 of them with
an effect; a verdict costs minutes), tumbling (12 cases; a verdict costs minutes), and the experiment asked for after an
ambiguous table or layer table (some 40 tables and 20 layer tables hide something; how many are ambiguous, the analyst says).
Tumbling needs pybullet, which exists for Linux and Python 3.11 (extra `oracle`): without it the deck goes on without those
cases and says so ("without" in answers.json).

One case counts in several rows: those of the library also judge every kind of noise, clear ones detection, and so on.
"""

from importlib.util import find_spec
from typing import NamedTuple

import numpy as np

from . import bounce, flight, layers, roll, sinking, slide, stack, tables, topple, tumble
from .build import Deal, Redraw, trajectory

ROOMS = {"flight": flight, "sinking": sinking, "bounce": bounce, "slide": slide, "roll": roll, "topple": topple, "stack": stack}
FAMILIES = (*ROOMS, "layers", "tumble")
WHOLE = 480
# of 480 cases: by kind where anything moves or a table is written, and those of layers and tumbling bodies
KINDS = {"null": 60, "outside": 61, "placebo": 61, "degenerate": 64, "clear": 62, "nested": 61, "joint": 62, "double": 13}
APART = {("layers", "single"): 16, ("layers", "null"): 4, ("layers", "outside"): 4, ("tumble", "single"): 12}
WEIGHTS = {"flight": 8, "sinking": 6, "bounce": 7, "slide": 7, "roll": 6, "topple": 4, "stack": 3}
TABLES = {"null": 0.12, "outside": 0.1, "degenerate": 0.35, "joint": 0.15, "double": 0.15}  # share of the kind
TABLED = {"flight": 1, "bounce": 1, "slide": 1}
STRENGTHS = {"degenerate": (0.6, 0.6, 1.2, 3.0), "nested": (1.2, 3.0, 8.0)}  # else:
USUAL = (1.2, 3.0)
PAIRS = ((1.2, 1.2), (3.0, 1.2), (1.2, 3.0), (3.0, 3.0))
JOINT = ((3.0, 3.0), (6.0, 6.0), (12.0, 12.0), (4.0, 3.0))  # each by itself; together much less
FAR = {"degenerate": 0.35, "clear": 0.4, "nested": 0.45}  # share with a number beyond its plausible range
IN_LIBRARY = ("null", "degenerate", "clear", "nested", "joint", "double")
NOISE = {"ar6": 62, "ar8": 62, "outliers": 62, "pixels": 62, "white": 30}  # tables, whose noise is white, make up the rest
ATTEMPTS = 40  # of one family
LAYER_STRENGTHS = (2.2, 3.0, 2.5)


class Dealt(NamedTuple):
    """What one case shall be. turn: the how-manieth of its kind and family."""

    kind: str
    family: str
    turn: int
    table: bool
    regime: str
    far: bool


def deal_all(seed, cases=WHOLE, family=None, kind=None):
    """[Dealt] of a deck: shares kept as exactly as whole numbers allow, order shuffled by the seed; of one family or one kind
    only where that is asked for."""
    rng = np.random.default_rng([seed, 7])
    pairs = _pairs(rng, cases, family, kind)
    rng.shuffle(pairs)
    noisy = [name in IN_LIBRARY and which not in ("layers",) and not table for name, which, table in pairs]
    inner, outer = iter(_shares(NOISE, sum(noisy), rng)), iter(_shares(NOISE, len(noisy) - sum(noisy), rng))
    far = {
        name: iter(_shares({True: share, False: 1 - share}, sum(pair[0] == name for pair in pairs), rng))
        for name, share in FAR.items()
    }
    turns, out = {}, []
    for (name, which, table), in_library in zip(pairs, noisy, strict=True):
        turns[name, which, table] = turns.get((name, which, table), -1) + 1
        regime = next(inner) if in_library else next(outer)
        out.append(Dealt(name, which, turns[name, which, table], table, regime, bool(next(far[name])) if name in far else False))
    return out


def _pairs(rng, cases, family, kind):
    """[(kind, family, whether an outcome table)] in no order."""
    apart = {pair: count for pair, count in APART.items() if family in (None, pair[0]) and kind in (None, pair[1])}
    if find_spec("pybullet") is None:
        apart = {pair: count for pair, count in apart.items() if pair[0] != "tumble"}
    kinds = {name: count for name, count in KINDS.items() if kind in (None, name)} if family not in ("layers", "tumble") else {}
    kinds = {name: count for name, count in kinds.items() if family is None or can(family, name)}
    if not kinds and not apart:
        raise ValueError(f"no case of kind {kind} in family {family}, or its engine is not installed")
    pairs = []
    for choice in _shares({**kinds, **apart}, cases if family or kind else min(cases, round(cases * _total() / WHOLE))):
        if isinstance(choice, tuple):
            pairs.append((choice[1], choice[0], False))
        else:
            pairs.append((choice, None, None))
    for name in kinds:
        mine = [i for i, pair in enumerate(pairs) if pair[:2] == (name, None)]
        tabled = round(TABLES.get(name, 0.0) * len(mine)) if family in (None, *TABLED) else 0
        places = _shares({one: share for one, share in TABLED.items() if family in (None, one)}, tabled, rng)
        weights = {one: share for one, share in WEIGHTS.items() if can(one, name) and family in (None, one)}
        rest = _shares(weights, len(mine) - tabled, rng)
        for i, (which, table) in zip(mine, [(one, True) for one in places] + [(one, False) for one in rest], strict=True):
            pairs[i] = name, which, table
    return pairs


def _total():
    """Cases that can be made here of a whole deck."""
    return WHOLE - (0 if find_spec("pybullet") else sum(count for pair, count in APART.items() if pair[0] == "tumble"))


def can(family, kind):
    """Whether a family of moving bodies shows a kind."""
    return bool(getattr(ROOMS[family], kind.upper(), ())) if kind in ("degenerate", "nested", "joint") else True


def _shares(weights, cases, rng=None):
    """A list of `cases` names in proportion to the weights (largest remainders), shuffled when a generator is given."""
    total = sum(weights.values())
    exact = {name: cases * weight / total for name, weight in weights.items()}
    whole = {name: int(value) for name, value in exact.items()}
    for name in sorted(exact, key=lambda name: whole[name] - exact[name])[: cases - sum(whole.values())]:
        whole[name] += 1
    names = [name for name, number in whole.items() for _ in range(number)]
    return names if rng is None else [names[i] for i in rng.permutation(len(names))]


def draw(rng, dealt, attempt):
    """A deal; names and strengths go round in turn so that all are met, another name is taken when a draw fails again and
    again."""
    kind, family, turn, table, regime, far = dealt
    if family == "layers":
        names = list(layers.OUTSIDE if kind == "outside" else layers.EFFECTS)
        chosen = () if kind == "null" else (names[(turn + attempt // 4) % len(names)],)
        return Deal(family, kind, chosen, "table", (LAYER_STRENGTHS[turn % 3],) * len(chosen), "tests")
    if family == "tumble":
        return Deal(family, kind, ("friction",), "tumble", (np.nan,), regime)
    room = ROOMS[family]
    part = {
        name: getattr(tables, name)[family] if table else getattr(room, name)
        for name in ("HIDDEN", "OUTSIDE", "DOUBLES", "JOINT")
    }
    if kind == "null":
        return Deal(family, kind, (), "table" if table else str(rng.choice(room.STYLES)), (), "white" if table else regime)
    if kind in ("joint", "double"):
        pairs, strengths = (part["JOINT"], JOINT) if kind == "joint" else (part["DOUBLES"], PAIRS)
        first, second, style = pairs[(turn + attempt // 4) % len(pairs)]
        return Deal(family, kind, (first, second), style, strengths[(turn + attempt // 10) % len(strengths)], regime)
    strengths = STRENGTHS.get(kind, USUAL)
    strength = strengths[(turn + attempt // 10) % len(strengths)]  # another one where ten draws could not reach it
    if kind in ("degenerate", "nested"):
        choices = (tables if table else room).__dict__[kind.upper()]
        choices = choices[family] if table else choices
        name, style = choices[(turn + attempt // 2) % len(choices)]
        return Deal(family, kind, (name,), style, (strength,), regime, far=far)
    names = part["OUTSIDE" if kind == "outside" else "HIDDEN"]
    name = list(names)[(turn + turn // len(strengths) + attempt // (1 if kind == "clear" else 3)) % len(names)]
    return Deal(family, kind, (name,), str(rng.choice(names[name].styles)), (strength,), regime, far=far)


def make(seed, index, dealt, then=None):
    """Files and answer of one case; draws again until one can be made as dealt, of another family where that one cannot show it
    (never of another kind). then: (design, number of tests) of the experiment that a verdict asks for, which joins the case."""
    problems, others = [], [name for name in ROOMS if name != dealt.family and dealt.family in ROOMS and can(name, dealt.kind)]
    for attempt in range(ATTEMPTS * (1 + len(others))):
        if attempt >= ATTEMPTS:
            dealt = dealt._replace(family=others[attempt // ATTEMPTS - 1], table=False)
        rng = np.random.default_rng([seed, index, attempt])
        deal = draw(rng, dealt, attempt % ATTEMPTS)
        try:
            if dealt.family == "layers":
                files, answer = layers.case(deal, rng, then)
            elif dealt.family == "tumble":
                files, answer = tumble.case(deal, rng)
            elif dealt.table:
                files, answer = tables.case(deal, rng, then)
            else:
                files, answer = trajectory(deal, ROOMS[dealt.family], rng, then)
        except Redraw as problem:
            problems.append(f"{deal.names}: {problem}")
            continue
        answer["attempts"] = attempt + 1
        return files, answer
    raise RuntimeError(f"case {index} ({dealt}) could not be made: {problems[-6:]}")
