"""Which case hides what: a deterministic, shuffled deck with fixed shares of nulls, outside effects, degenerate pairs and
doubles."""

import numpy as np

from . import bounce, flight, layers, roll, sinking, slide, stack, tables, topple
from .build import Deal, Redraw, trajectory

ROOMS = {
    "flight": flight,
    "sinking": sinking,
    "bounce": bounce,
    "slide": slide,
    "roll": roll,
    "topple": topple,
    "stack": stack,
    "layers": layers,
}
FAMILIES = tuple(ROOMS)
# of 50 cases; single includes many that turn out to have a twin, which the answer then says
KINDS = {"null": 11, "outside": 12, "degenerate": 5, "double": 6, "single": 16}
WEIGHTS = {"flight": 8, "sinking": 6, "bounce": 7, "slide": 7, "roll": 6, "topple": 4, "stack": 3, "layers": 3}
TABLE_SHARE = {"flight": 0.15, "bounce": 0.35, "slide": 0.35}
STRENGTHS = (0.3, 0.6, 1.2, 3.0)
PAIRS = ((1.2, 1.2), (3.0, 1.2), (1.2, 3.0), (3.0, 3.0), (0.6, 1.2))
REGIMES = ("white", "ar6", "ar8_outliers")
LAYER_STRENGTHS = (0.5, 2.2, 3.0)


def deal_all(seed, cases, family=None, kind=None):
    """(kind, family, turn) for every case: shares kept as exactly as whole numbers allow, order shuffled by the seed; of one
    family or one kind only where that is asked for."""
    rng = np.random.default_rng([seed, 7])
    kinds = [kind] * cases if kind else _shares(KINDS, cases)
    families = [family] * cases if family else _shares(WEIGHTS, cases, rng)
    rng.shuffle(kinds)
    turns, out = {}, []
    for kind, name in zip(kinds, families, strict=True):
        if kind == "degenerate" and not ROOMS[name].DEGENERATE:
            kind = "single"
        if name == "layers" and kind == "double":
            kind = "single"
        turns[kind, name] = turns.get((kind, name), -1) + 1
        out.append((kind, name, turns[kind, name]))
    return out


def _shares(weights, cases, rng=None):
    """A list of `cases` names in proportion to the weights (largest remainders), shuffled when a generator is given."""
    total = sum(weights.values())
    exact = {name: cases * weight / total for name, weight in weights.items()}
    whole = {name: int(value) for name, value in exact.items()}
    for name in sorted(exact, key=lambda name: whole[name] - exact[name])[: cases - sum(whole.values())]:
        whole[name] += 1
    names = [name for name, number in whole.items() for _ in range(number)]
    if rng is not None:
        rng.shuffle(names)
    return names


def draw(rng, kind, family, turn, attempt, strengths=STRENGTHS, tabled=True):
    """A deal; names and strengths go round in turn so that all are met, another name is taken when a draw fails again and
    again."""
    room = ROOMS[family]
    regime = str(rng.choice(REGIMES))
    if family == "layers":
        names = list(layers.OUTSIDE if kind == "outside" else layers.EFFECTS)
        chosen = () if kind == "null" else (names[(turn + attempt // 4) % len(names)],)
        return Deal(family, kind, chosen, "table", (LAYER_STRENGTHS[(turn // 2) % 3],) * len(chosen), "tests")
    if tabled and kind != "degenerate" and rng.random() < TABLE_SHARE.get(family, 0.0):
        room_hidden, room_outside, doubles = tables.HIDDEN[family], tables.OUTSIDE[family], tables.DOUBLES[family]
        styles = ("table",)
    else:
        room_hidden, room_outside, doubles, styles = room.HIDDEN, room.OUTSIDE, room.DOUBLES, room.STYLES
    strength = strengths[(turn + attempt // 10) % len(strengths)]  # another one where ten draws could not reach it
    if kind == "null":
        return Deal(family, kind, (), str(rng.choice(styles)), (), regime)
    if kind == "degenerate":
        name, style = room.DEGENERATE[(turn + attempt) % len(room.DEGENERATE)]
        return Deal(family, kind, (name,), style, (strength,), regime)
    if kind == "double":
        first, second, style = doubles[(turn + attempt) % len(doubles)]
        return Deal(family, kind, (first, second), style, PAIRS[turn % len(PAIRS)], regime)
    table = room_outside if kind == "outside" else room_hidden
    name = list(table)[(turn + turn // len(strengths) + attempt // 3) % len(table)]
    return Deal(family, kind, (name,), str(rng.choice(table[name].styles)), (strength,), regime)


def make(seed, index, kind, family, turn, strengths=STRENGTHS, placebo=False, then=None):
    """Files and answer of one case; draws again (never another kind or family) until one can be made as dealt. then: see
    `trajectory`."""
    problems = []
    for attempt in range(40):
        rng = np.random.default_rng([seed, index, attempt])
        deal = draw(rng, kind, family, turn, attempt, strengths, not placebo)
        try:
            if family == "layers":
                files, answer = layers.case(deal, rng)
            elif deal.style == "table":
                files, answer = tables.case(deal, rng)
            else:
                files, answer = trajectory(deal, ROOMS[family], rng, placebo, then)
        except Redraw as problem:
            problems.append(f"{deal.names}: {problem}")
            continue
        answer["attempts"] = attempt + 1
        return files, answer
    raise RuntimeError(f"case {index} ({kind}, {family}) could not be made: {problems[-3:]}")
