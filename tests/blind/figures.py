"""The figures of the score: what share of the verdicts is right, each with its exact binomial bound.

A case without a verdict counts as a failure wherever all cases are counted (not where only accepted effects are). Bounds are
exact (Clopper-Pearson): one-sided 95 % on the bad side, and two-sided 95 % where a share must hold a value.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import beta

from .generator.layers import EFFECTS as LAYER_EFFECTS
from .generator.library import LABELS
from .generator.strength import NEAR

STRENGTH_SLACK = 0.99  # strengths are met to one per cent
FEASIBLE = 1000  # tests; a longer experiment separates nothing (issue of the deck)
NOISE = {"white": "white", "ar6": "AR 0.6", "ar8": "AR 0.8", "outliers": "3 % outliers", "pixels": "pixel steps"}
OUTSIDE_LAYERS = {
    "campaign_offset": "measurement",
    "length_scale": "measurement",
    "friction_pyramid": "numerics",
    "friction_combination": "numerics",
}
OUTSIDE_LAYERS |= dict.fromkeys(("time_step", "iterations", "damping", "sleeping", "slop", "error_reduction"), "numerics")
PLACING = ("falling_distance", "placement_offset", "orientation_bias", "yaw_constraint", "sequential_placement", "vibration")
OUTSIDE_LAYERS |= dict.fromkeys((*PLACING, "lost_units"), "placement")


@dataclass(frozen=True)
class Figure:
    """One line of the table: hits of n, or a number already worked out."""

    name: str
    must: str
    hits: int | None = None
    count: int = 0
    wanted: float | None = None  # share that must be reached (at_least) or not exceeded
    at_least: bool = True
    value: float | None = None
    note: str = ""
    ceiling: float = 1.0  # share that must not be exceeded where a band is wanted
    holds: float | None = None  # share that the two-sided 95 % interval must hold

    def bound(self):
        """One-sided 95 % bound of the share on the bad side; None without cases."""
        if not self.count or self.hits is None:
            return None
        low, high = interval(self.hits, self.count, 0.90)
        return low if self.at_least else high

    def met(self):
        """'met', 'missed', 'met, not sure' (the bound is on the other side), or '-' where nothing was measured."""
        if self.value is not None and self.wanted is not None:
            return "met" if (self.value >= self.wanted) == self.at_least or self.value == self.wanted else "missed"
        if not self.count or self.hits is None or self.wanted is None:
            return "-"
        share, bound = self.hits / self.count, self.bound()
        if share > self.ceiling or ((share < self.wanted) if self.at_least else (share > self.wanted)):
            return "missed"
        if self.holds is not None:
            low, high = interval(self.hits, self.count, 0.95)
            return "met" if low <= self.holds <= high else "missed"
        return "met" if ((bound >= self.wanted) if self.at_least else (bound <= self.wanted)) else "met, not sure"

    def cells(self):
        """What was measured, its bound, and whether it is met, as text cells."""
        if self.value is not None:
            return [f"{self.value:.3f}", f"n = {self.count}", self.met()]
        if self.hits is None or not self.count:
            return ["not run" if not self.note else self.note, "-", self.met()]
        if self.holds is not None:
            low, high = interval(self.hits, self.count, 0.95)
            bound = f"{100 * low:.1f}-{100 * high:.1f} %"
        else:
            bound = f"{'>=' if self.at_least else '<='} {100 * self.bound():.1f} %"
        return [f"{self.hits}/{self.count} = {100 * self.hits / self.count:.1f} %", bound, self.met()]


def interval(hits, count, level):
    """Exact (Clopper-Pearson) two-sided interval of a share."""
    tail = (1 - level) / 2
    low = float(beta.ppf(tail, hits, count - hits + 1)) if hits else 0.0
    return low, float(beta.ppf(1 - tail, hits + 1, count - hits)) if hits < count else 1.0


def reported(verdict):
    """Every effect that the verdict puts forward: accepted ones and the members of their sets; set labels are spelled out."""
    names = set(verdict.get("effects") or [])
    for members in verdict.get("ambiguous") or []:
        names |= set([members] if isinstance(members, str) else members)
    return names | {member for name in names for member in LABELS.get(name, ())}


def found(verdict):
    """Whether some effect was put forward."""
    return bool(verdict.get("effects")) or verdict.get("verdict") in ("effect", "ambiguous")


def weakest(answer):
    """Smallest strength among the hidden effects."""
    return min(answer["strengths"].values(), default=0.0) / STRENGTH_SLACK


def missing(verdict):
    """Whether there is no verdict."""
    return verdict["verdict"] == "missing"


def right_alone(answer, verdict):
    """What is hidden, and nothing else."""
    return verdict["verdict"] == "effect" and set(verdict["effects"]) == set(answer["effects"])


def inside(answer, verdict):
    """Whether what is hidden is among what is reported."""
    return set(answer["effects"]) <= reported(verdict)


def separates(verdict):
    """Whether the verdict names an experiment of feasible length that separates what it cannot tell apart."""
    experiment = verdict.get("next_experiment") or {}
    needed = experiment.get("tests_needed")
    return len(experiment.get("separates") or ()) >= 2 and needed is not None and needed <= FEASIBLE


def heaviest_families(verdict):
    """Families (physics, placement, measurement, numerics) of the heaviest set; of `effects` where no sets are told."""
    sets = verdict.get("sets") or []
    names = sets[0]["effects"] if sets else verdict.get("effects") or []
    return {LAYER_EFFECTS[name][0] if name in LAYER_EFFECTS else OUTSIDE_LAYERS.get(name, "physics") for name in names}


def wrongly_left(answer, verdict):
    """A truth of the library that is called unexplained, or complete although it is worth 0.6 sigma; or no verdict at all."""
    overlooked = (
        verdict["verdict"] == "complete" and answer["kind"] != "null" and answer["total_strength"] >= 0.6 * STRENGTH_SLACK
    )
    return overlooked or verdict["verdict"] in ("unexplained", "missing", "cannot_judge")


def share(name, must, wanted, cases, good, at_least=True, **more):
    """The figure of the cases for which good(answer, verdict) holds."""
    return Figure(name, must, sum(bool(good(*case)) for case in cases), len(cases), wanted, at_least, **more)


def groups(pairs):
    """Pairs by what they can judge: {name: [(answer, verdict)]}."""
    usual = [pair for pair in pairs if pair[0]["family"] not in ("layers", "tumble")]
    by = {
        kind: [pair for pair in usual if pair[0]["kind"] == kind] for kind in ("outside", "placebo", "double", "joint", "nested")
    }
    by["nulls"] = [pair for pair in pairs if pair[0]["kind"] == "null"]
    by["library"] = [pair for pair in usual if pair[0]["kind"] in ("single", "degenerate", "clear", "nested")]
    by["doubles"] = by["double"] + by["joint"]
    by["in_library"] = (
        [pair for pair in by["nulls"] if pair[0]["family"] not in ("layers", "tumble")] + by["library"] + by["doubles"]
    )
    by["layers"] = [pair for pair in pairs if pair[0]["family"] == "layers" and pair[0]["kind"] == "single"]
    by["tumble"] = [pair for pair in pairs if pair[0]["family"] == "tumble"]
    return by


def figures(pairs, again=None):
    """The table of figures from [(answer, verdict)]; a missing verdict is {"verdict": "missing"}; again: what came of the
    recommended experiments."""
    by = groups(pairs)
    return [*_alarms(by), *_names(by), *_sets(by, pairs, again), *_left_over(by), *_numbers(by), *_apart(by)]


def _alarms(by):
    """Nothing is found where nothing is hidden, and something where something is."""
    flagged = [pair for pair in by["nulls"] if (pair[1].get("adequate") or {}).get("before") is not None]
    faint = [pair for pair in by["library"] if 0.6 * STRENGTH_SLACK <= weakest(pair[0]) * STRENGTH_SLACK < 1.3]
    yield share("false alarm on nulls", "<= 5 %", 0.05, by["nulls"], lambda a, v: found(v) or missing(v), False)
    yield share(
        "adequacy test, false flag on nulls", "<= 5 %", 0.05, flagged, lambda a, v: v["adequate"]["before"] is False, False
    )
    yield share("placebo: `effects` empty", ">= 95 %", 0.95, by["placebo"], lambda a, v: not v["effects"] and not missing(v))
    yield share("some effect detected, 0.6 to 1.2", ">= 90 %", 0.90, faint, lambda a, v: found(v))
    strong = [pair for pair in by["outside"] if weakest(pair[0]) >= 1.2]
    yield share("outside the library: unexplained, >= 1.2", ">= 90 %", 0.90, strong, lambda a, v: v["verdict"] == "unexplained")


def _names(by):
    """The right names are found."""
    seen = [pair for pair in by["library"] if weakest(pair[0]) >= 0.6 and found(pair[1])]
    yield share("truth inside the reported set, >= 0.6", ">= 97 %", 0.97, seen, inside)
    beyond = [pair for pair in seen if pair[0]["beyond"]]
    yield share("of these, a number beyond its plausible range", ">= 97 %", 0.97, beyond, inside)
    apart = [p for p in by["library"] if weakest(p[0]) >= 1.2 and not p[0]["tied"] and p[0]["nearest"] >= NEAR]
    clear = [pair for pair in apart if pair[0]["largest_cosine"] < 0.9]
    yield share("unique and right, cosine < 0.9, >= 1.2", ">= 90 %", 0.90, clear, right_alone)
    yield share(f"unique and right, all rivals {NEAR:.0f} units behind, >= 1.2", ">= 90 %", 0.90, apart, right_alone)
    yield share("nested laws: the right form alone", ">= 90 %", 0.90, by["nested"], right_alone)
    told = [pair for pair in by["library"] + by["doubles"] + by["tumble"] if not missing(pair[1])]
    yield share(
        "unique but wrong",
        "<= 1 %",
        0.01,
        told,
        lambda a, v: v["verdict"] == "effect" and not set(v["effects"]) <= set(a["effects"]),
        False,
    )
    strong = [pair for pair in by["doubles"] if weakest(pair[0]) >= 1.2]
    yield share("two effects, both found, >= 1.2 each", ">= 95 %", 0.95, strong, inside)
    yield share("of these, joint pairs (neither alone announces itself)", ">= 95 %", 0.95, by["joint"], inside)


def _sets(by, pairs, again):
    """What cannot be told apart is told as a set, no larger than it is, with the experiment that would."""
    tied = [pair for pair in by["library"] if pair[0]["tied"] and weakest(pair[0]) >= 0.6 and found(pair[1])]
    yield share(
        "look-alike set reported whole",
        ">= 95 %",
        0.95,
        tied,
        lambda a, v: v["verdict"] in ("ambiguous", "unexplained") and {a["effects"][0], *a["tied"]} <= reported(v),
    )
    sizes = [len(reported(verdict)) for answer, verdict in by["library"] if verdict["verdict"] == "ambiguous"]
    yield Figure("median size of a reported set", "-", count=len(sizes), value=quantile(sizes, 0.5))
    for kind, word in (("trajectory", "recordings"), ("outcomes", "tables"), ("layers", "layer tables")):
        open_ = [pair for pair in pairs if pair[0]["kind_of_data"] == kind and pair[1]["verdict"] == "ambiguous"]
        yield share(f"ambiguous {word}: an experiment that separates", ">= 90 %", 0.90, open_, lambda a, v: separates(v))
    note = "" if again is not None else "needs `tests.blind.again`"
    done = [(one, None) for one in again or []]
    yield share("recommended experiment, done: settled", ">= 90 %", 0.90, done, lambda one, _: one["settled"], note=note)


def _left_over(by):
    """No truth of the library is left unexplained, or overlooked, whatever the noise."""
    for regime, word in NOISE.items():
        mine = [pair for pair in by["in_library"] if noise_of(pair[0]) == regime]
        yield share(f"in the library but unexplained or overlooked: {word}", "<= 3 %", 0.03, mine, wrongly_left, False)


def noise_of(answer):
    """The kind of noise of a case; replicates of a table scatter as white noise."""
    return {"replicates": "white"}.get(answer["noise"]["regime"], answer["noise"]["regime"])


def _numbers(by):
    """Coefficients, and the error that is left."""
    cases = by["library"] + by["doubles"]
    held = coverage(cases)
    yield Figure("coverage of the 90 % interval", "85-95 %, holds 90", sum(held), len(held), 0.85, ceiling=0.95, holds=0.90)
    removed, ratio = errors(cases)
    yield Figure("held-out error removed, median", ">= 0.9", count=len(removed), wanted=0.9, value=quantile(removed, 0.5))
    yield Figure(
        "held-out error removed, 10th percentile", ">= 0.7", count=len(removed), wanted=0.7, value=quantile(removed, 0.1)
    )
    final = quantile(ratio, 0.5)
    yield Figure("final error / oracle error, median", "<= 1.10", count=len(ratio), wanted=1.10, at_least=False, value=final)


def _apart(by):
    """Families of their own: layer tables, and a foreign engine's tumbling cubes."""
    strong = [pair for pair in by["layers"] if weakest(pair[0]) >= 2]

    def family(a, v):
        return bool(heaviest_families(v)) and heaviest_families(v) <= set(a["verdict_families"])

    yield share("layer table: family of the heaviest set, >= 2x detectable", ">= 80 %", 0.80, strong, family)
    yield share(
        "tumbling: no interval that misses the friction", ">= 85 %", 0.85, by["tumble"], lambda a, v: slid(a, v) is not False
    )
    yield share("tumbling: a number is given", ">= 60 %", 0.60, by["tumble"], lambda a, v: slid(a, v) is not None)


def slid(answer, verdict):
    """Whether the interval of the friction meets what the engine's impacts show (their middle four fifths: the engine's friction
    is a number no better than that); None where no number is given. A missing verdict misses."""
    told = ((verdict.get("parameters") or {}).get("friction") or {}).get("coefficient") or {}
    if missing(verdict):
        return False
    if told.get("low") is None or told.get("high") is None:
        return None
    _, low, high = answer["read_off"]["friction"]
    return told["low"] <= high and told["high"] >= low


def coverage(pairs):
    """For every scored parameter of a rightly accepted effect: whether its interval holds the value an ideal fit would give."""
    held = []
    for answer, verdict in pairs:
        for name, law in answer["parameters"].items():
            told = (verdict.get("parameters") or {}).get(name) if name in (verdict.get("effects") or []) else None
            for key, true in law.items():
                number = (told or {}).get(key)
                if isinstance(number, dict) and number.get("low") is not None and number.get("high") is not None:
                    held.append(number["low"] <= true <= number["high"])
    return held


def errors(pairs):
    """(share of the held-out error removed, final over oracle error) where an effect of >= 1.2 visible in the positions is
    hidden."""
    removed, ratio = [], []
    for answer, verdict in pairs:
        oracle, held = answer.get("oracle"), (verdict.get("error") or {}).get("held_out")
        if not oracle or oracle["before"] < 1.1 * oracle["after"] or weakest(answer) < 1.2 or not held or not held.get("before"):
            continue
        best = oracle["after"] * held["before"] / oracle["before"]  # on the analyst's scale: its RMS may be defined otherwise
        removed.append((held["before"] - held["after"]) / (held["before"] - best))
        ratio.append(held["after"] / best)
    return removed, ratio


def quantile(values, q):
    """Quantile of the values, None of none."""
    return float(np.quantile(values, q)) if len(values) else None
