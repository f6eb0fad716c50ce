"""Score verdicts against sealed answers: `python -m tests.blind.score --cases DIR --verdicts DIR [--markdown docs/blind.md]`.

DIR of the cases holds answers.json; DIR of the verdicts holds one CASE.json per case as `hlcs diagnose --json` writes it.
A case without a verdict counts as a failure wherever all cases are counted (not where only accepted effects are).
Bounds are exact (Clopper-Pearson), one-sided 95 %, on the bad side.
"""

import argparse
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.stats import beta

from .generator import seal
from .generator.layers import EFFECTS as LAYER_EFFECTS
from .generator.library import LABELS

STRENGTH_SLACK = 0.99
FAMILY = {
    "plate_bias": "measurement",
    "campaign_offset": "measurement",
    "length_scale": "measurement",
    "margin_offset": "numerics",
    "friction_pyramid": "numerics",
    "friction_combination": "numerics",
    "convex_hull_shape": "numerics",
}
FAMILY |= dict.fromkeys(("time_step", "iterations", "damping", "sleeping", "slop", "error_reduction"), "numerics")
FAMILY |= dict.fromkeys(
    (
        "falling_distance",
        "grid_spacing",
        "placement_scatter",
        "placement_offset",
        "orientation_bias",
        "yaw_constraint",
        "sequential_placement",
        "loose_lower_layers",
        "vibration",
        "lost_units",
    ),
    "placement",
)


KINDNESS = """
What the generator grants that a laboratory may not: a static recording of the same tracker beside every set of recordings
(replicates in every table), so that sigma and its correlation can be learnt; wrong nominal inputs (mass 2 %, size 1 %, tilt
1 degree at most) shrunk until they stay far below the noise; hidden laws inside the library's bounds that differ from the
textbook form only as far as the textbook law still fits; strengths that are exact after the starts are fitted; a tracker
without lost bodies. Coefficients are scored against what an ideal fit of the textbook law to the noiseless data gives, the
floor of the error against that fit on the same noise. The author of the analyst had read the generator.
"""


@dataclass(frozen=True)
class Figure:
    """One line of the table: hits of n, or a number already worked out."""

    name: str
    must: str
    aim: str
    hits: int | None = None
    count: int = 0
    wanted: float | None = None  # share that must be reached (at_least) or not exceeded
    at_least: bool = True
    value: float | None = None
    note: str = ""
    ceiling: float = 1.0  # share that must not be exceeded where a band is wanted

    def bound(self):
        """One-sided 95 % bound of the share on the bad side; None without cases."""
        if not self.count or self.hits is None:
            return None
        if self.at_least:
            return float(beta.ppf(0.05, self.hits, self.count - self.hits + 1)) if self.hits else 0.0
        return float(beta.ppf(0.95, self.hits + 1, self.count - self.hits)) if self.hits < self.count else 1.0

    def met(self):
        """'met', 'missed', 'met, not sure' (the bound is on the other side), or '-' where nothing was measured."""
        if self.value is not None and self.wanted is not None:
            return "met" if (self.value >= self.wanted) == self.at_least or self.value == self.wanted else "missed"
        if not self.count or self.hits is None or self.wanted is None:
            return "-"
        share, bound = self.hits / self.count, self.bound()
        if share > self.ceiling or ((share < self.wanted) if self.at_least else (share > self.wanted)):
            return "missed"
        return "met" if ((bound >= self.wanted) if self.at_least else (bound <= self.wanted)) else "met, not sure"

    def cells(self):
        """The line as text cells."""
        if self.value is not None:
            measured, bound = f"{self.value:.3f}", f"n = {self.count}"
        elif self.hits is None or not self.count:
            measured, bound = "not run" if not self.note else self.note, "-"
        else:
            sign = ">=" if self.at_least else "<="
            measured, bound = (
                f"{self.hits}/{self.count} = {100 * self.hits / self.count:.1f} %",
                f"{sign} {100 * self.bound():.1f} %",
            )
        return [self.name, self.must, self.aim, measured, bound, self.met()]


def reported(verdict):
    """Every effect that the verdict puts forward: accepted ones and the members of their sets; set labels are spelled out."""
    names = set(verdict.get("effects") or [])
    for members in verdict.get("ambiguous") or []:
        names |= set([members] if isinstance(members, str) else members)
    return names | {member for name in names for member in LABELS.get(name, ())}


def found(verdict):
    """Whether some effect was accepted."""
    return bool(verdict.get("effects")) or verdict.get("verdict") in ("effect", "ambiguous")


def weakest(answer):
    """Smallest strength among the hidden effects."""
    return min(answer["strengths"].values(), default=0.0) / STRENGTH_SLACK


def _family(name):
    return LAYER_EFFECTS[name][0] if name in LAYER_EFFECTS else FAMILY.get(name, "physics")


def _share(name, must, aim, wanted, cases, good, at_least=True, note=""):
    return Figure(name, must, aim, sum(bool(good(*case)) for case in cases), len(cases), wanted, at_least, note=note)


def figures(pairs, again=None):
    """The table of figures from [(answer, verdict)]; a missing verdict is {"verdict": "missing"}; again: what came of the
    recommended experiments."""
    motion = [pair for pair in pairs if pair[0]["family"] != "layers"]
    nulls = [pair for pair in pairs if pair[0]["kind"] == "null"]
    library = [pair for pair in motion if pair[0]["kind"] in ("single", "degenerate")]
    outside = [pair for pair in motion if pair[0]["kind"] == "outside"]
    doubles = [pair for pair in motion if pair[0]["kind"] == "double"]
    table = [
        _share("false alarm on nulls", "<= 5 %", "<= 2 %", 0.05, nulls, lambda a, v: found(v) or v["verdict"] == "missing", False)
    ]
    for strength, wanted, aim in ((0.6, 0.90, "95 %"), (0.3, 0.50, "80 %")):
        some = [pair for pair in library if abs(weakest(pair[0]) * STRENGTH_SLACK - strength) < 0.05]
        table.append(
            _share(f"some effect detected at {strength}", f">= {100 * wanted:.0f} %", aim, wanted, some, lambda a, v: found(v))
        )
    seen = [pair for pair in library if weakest(pair[0]) >= 0.6 and found(pair[1])]
    table.append(
        _share(
            "truth inside the reported set, >= 0.6", ">= 95 %", "98 %", 0.95, seen, lambda a, v: a["effects"][0] in reported(v)
        )
    )
    clear = [pair for pair in library if weakest(pair[0]) >= 1.2 and pair[0]["largest_cosine"] < 0.9 and not pair[0]["tied"]]
    table.append(
        _share(
            "unique and right, cosine < 0.9, >= 1.2",
            ">= 85 %",
            "95 %",
            0.85,
            clear,
            lambda a, v: v["verdict"] == "effect" and v["effects"] == a["effects"],
        )
    )
    table.append(
        _share(
            "unique but wrong",
            "<= 2 %",
            "<= 1 %",
            0.02,
            [pair for pair in library + doubles if pair[1]["verdict"] != "missing"],
            lambda a, v: v["verdict"] == "effect" and not set(v["effects"]) <= set(a["effects"]),
            False,
        )
    )
    tied = [pair for pair in library if pair[0]["tied"] and weakest(pair[0]) >= 0.6 and found(pair[1])]
    table.append(
        _share(
            "degenerate set reported whole",
            ">= 95 %",
            "98 %",
            0.95,
            tied,
            lambda a, v: v["verdict"] in ("ambiguous", "unexplained") and {a["effects"][0], *a["tied"]} <= reported(v),
        )
    )
    table.append(
        _share(
            "recommended experiment settles it",
            ">= 90 %",
            "95 %",
            0.90,
            [(one, None) for one in again or []],
            lambda one, _: one["settled"],
            note="" if again is not None else "needs `tests.blind.again`",
        )
    )
    for strength, wanted, aim in ((1.2, 0.90, "95 %"), (0.6, 0.60, "80 %")):
        some = [pair for pair in outside if (weakest(pair[0]) >= 1.2 if strength == 1.2 else abs(weakest(pair[0]) - 0.6) < 0.05)]
        table.append(
            _share(
                f"outside the library: unexplained at {'>= ' if strength == 1.2 else ''}{strength}",
                f">= {100 * wanted:.0f} %",
                aim,
                wanted,
                some,
                lambda a, v: v["verdict"] == "unexplained",
            )
        )
    judged = [
        pair for pair in nulls if isinstance(pair[1].get("adequate"), dict) and pair[1]["adequate"].get("before") is not None
    ]
    table.append(
        _share(
            "adequacy test, false flag on nulls",
            "<= 5 %",
            "2 %",
            0.05,
            judged,
            lambda a, v: v["adequate"]["before"] is False,
            False,
        )
    )
    inside = _coverage(library + doubles)
    coverage = Figure("coverage of the 90 % interval", "85-95 %", "88-92 %", sum(inside), len(inside), 0.85, ceiling=0.95)
    table.append(coverage)
    removed, ratio = _errors(library + doubles)
    table.append(
        Figure("held-out error removed, median", ">= 0.9", "0.95", count=len(removed), wanted=0.9, value=_quantile(removed, 0.5))
    )
    table.append(
        Figure(
            "held-out error removed, 10th percentile",
            ">= 0.7",
            "-",
            count=len(removed),
            wanted=0.7,
            value=_quantile(removed, 0.1),
        )
    )
    table.append(
        Figure(
            "final error / oracle error, median",
            "<= 1.10",
            "1.03",
            count=len(ratio),
            wanted=1.10,
            at_least=False,
            value=_quantile(ratio, 0.5),
        )
    )
    both = [pair for pair in doubles if weakest(pair[0]) >= 1.2]
    table.append(
        _share(
            "two effects, both found, >= 1.2 each", ">= 80 %", "90 %", 0.80, both, lambda a, v: set(a["effects"]) <= reported(v)
        )
    )
    layers = [pair for pair in pairs if pair[0]["family"] == "layers" and pair[0]["kind"] == "single"]
    table.append(
        _share(
            "layer table: right family, >= 2x detectable",
            ">= 80 %",
            "90 %",
            0.80,
            [p for p in layers if weakest(p[0]) >= 2],
            lambda a, v: bool({_family(name) for name in reported(v)} & set(a["verdict_families"])),
        )
    )
    table.append(
        _share(
            "layer table: refused below 1x",
            "refuse",
            "-",
            0.80,
            [p for p in layers if weakest(p[0]) < 1],
            lambda a, v: not found(v),
        )
    )
    placebo = [pair for pair in pairs if pair[0]["kind"] == "placebo"]
    table.append(
        _share("placebo: no effect", ">= 95 %", "all", 0.95, placebo, lambda a, v: not found(v) and v["verdict"] != "missing")
    )
    return table


def _coverage(pairs):
    """For every scored parameter of a rightly accepted effect: whether its interval holds the value an ideal fit would give."""
    inside = []
    for answer, verdict in pairs:
        for name, law in answer["parameters"].items():
            told = (verdict.get("parameters") or {}).get(name, {}) if name in (verdict.get("effects") or []) else {}
            for key, true in law.items():
                interval = told.get(key)
                if isinstance(interval, dict) and interval.get("low") is not None and interval.get("high") is not None:
                    inside.append(interval["low"] <= true <= interval["high"])
    return inside


def _errors(pairs):
    """(share of the held-out error removed, final over oracle error) where an effect of >= 1.2 visible in the positions is
    hidden."""
    removed, ratio = [], []
    for answer, verdict in pairs:
        oracle, held = answer.get("oracle"), (verdict.get("error") or {}).get("held_out")
        if not oracle or oracle["before"] < 1.1 * oracle["after"] or weakest(answer) < 1.2 or not held or not held.get("before"):
            continue
        best = (
            oracle["after"] * held["before"] / oracle["before"]
        )  # the oracle on the analyst's scale (its RMS may be defined otherwise)
        removed.append((held["before"] - held["after"]) / (held["before"] - best))
        ratio.append(held["after"] / best)
    return removed, ratio


def _quantile(values, q):
    return float(np.quantile(values, q)) if values else None


def breakdown(pairs):
    """Lines (family, kind, cases, verdict counts) for orientation."""
    lines = []
    for family in dict.fromkeys(answer["family"] for answer, _ in pairs):
        for kind in ("null", "single", "degenerate", "double", "outside", "placebo"):
            some = [verdict["verdict"] for answer, verdict in pairs if (answer["family"], answer["kind"]) == (family, kind)]
            if some:
                tally = ", ".join(f"{name} {some.count(name)}" for name in sorted(set(some)))
                lines.append([family, kind, str(len(some)), tally])
    return lines


def by_design(again):
    """Lines (experiment, times done, times that it settled the question)."""
    lines = []
    for how in sorted({one["how"] for one in again.values()}):
        some = [one["settled"] for one in again.values() if one["how"] == how]
        lines.append([how, str(len(some)), str(sum(some))])
    return lines


def by_effect(pairs):
    """Lines (hidden effect, cases >= 0.6, detected, truth inside, intervals that hold the truth)."""
    lines = []
    for name in sorted({effect for answer, _ in pairs for effect in answer["effects"] if not answer["outside"]}):
        some = [pair for pair in pairs if name in pair[0]["effects"] and weakest(pair[0]) >= 0.6]
        if some:
            covered = _coverage([({**a, "parameters": {name: a["parameters"].get(name, {})}}, v) for a, v in some])
            lines.append(
                [
                    name,
                    str(len(some)),
                    str(sum(found(v) for _, v in some)),
                    str(sum(name in reported(v) for _, v in some)),
                    f"{sum(covered)}/{len(covered)}",
                ]
            )
    return lines


def markdown_table(header, lines):
    """A Markdown table as text."""
    return (
        "\n".join(
            ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)] + ["| " + " | ".join(line) + " |" for line in lines]
        )
        + "\n"
    )


def load(cases, verdicts):
    """[(answer, verdict)] and the suite's record."""
    record = json.loads((Path(cases) / "answers.json").read_text(encoding="utf-8"))
    pairs = []
    for name, answer in record["cases"].items():
        file = Path(verdicts) / f"{name}.json"
        verdict = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
        pairs.append((answer, {"effects": [], "ambiguous": [], **verdict, "verdict": verdict.get("verdict", "missing")}))
    return pairs, record


def report(cases, verdicts, first=None, placebo=None, also=None):
    """The whole score as Markdown text, and the figures; of the first so many cases of the deck where that is given; placebo,
    also: folders of decks of their own."""
    pairs, record = load(cases, verdicts)
    deck, pairs = len(pairs), pairs[:first]
    done = Path(cases) / "again.json"
    again = json.loads(done.read_text(encoding="utf-8")) if done.exists() else None
    shuffled, other = load(placebo, Path(placebo) / "verdicts") if placebo else ([], None)
    table = figures(pairs + shuffled, None if again is None else list(again.values()))
    sealed = seal.sealed(record["seed"])
    missing = sum(verdict["verdict"] == "missing" for _, verdict in pairs)
    text = "# Hidden-effect suite\n\n"
    part = f", the first of a shuffled deck of {deck}" if len(pairs) < deck else ""
    text += f"{len(pairs)} cases{part}, suite `{record['suite']}`, seed SHA-256 `{seal.digest(record['seed'])}` "
    text += f"({'sealed beforehand' if sealed else 'not sealed'}), {missing} without a verdict. Bounds: exact binomial, "
    families = sorted({answer["family"] for answer, _ in pairs})
    text += f"one-sided 95 %. Families in this run: {', '.join(families)}."
    if placebo:
        text += f" The placebo is a deck of its own, {len(shuffled)} cases, seed SHA-256 `{seal.digest(other['seed'])}` "
        text += f"({'sealed beforehand' if seal.sealed(other['seed']) else 'not sealed'})."
    text += "\n\n"
    text += markdown_table(["figure", "must", "aim", "measured", "bound", "result"], [figure.cells() for figure in table])
    if placebo:
        partly = sum(found(verdict) and verdict["verdict"] == "unexplained" for _, verdict in shuffled)
        text += f"\nOf the placebo cases with an effect {partly} are `unexplained`: it takes up a part, as the report says.\n"
    if also:
        more, its = load(also, Path(also) / "verdicts")
        whole = len(more)
        while more and more[-1][1]["verdict"] == "missing":  # a run that was stopped
            more.pop()
        part = f", the first of a shuffled deck of {whole}" if len(more) < whole else ""
        title = f"A deck of kind `{its['kind']}`" if its.get("kind") else "Another deck"
        text += f"\n## {title}, drawn on its own\n\n{len(more)} cases{part}, seed SHA-256 "
        text += f"`{seal.digest(its['seed'])}` ({'sealed beforehand' if seal.sealed(its['seed']) else 'not sealed'}).\n\n"
        lines = [figure.cells() for figure in figures(more) if figure.count]
        text += markdown_table(["figure", "must", "aim", "measured", "bound", "result"], lines)
    text += commands(record, deck, other, its | {"first": len(more)} if also else None)
    text += KINDNESS
    if again is not None:
        text += "\n## The recommended experiments, done\n\nA direct reading is taken to be right: where it rules a suspect "
        text += "out, what is measured is that what is hidden is still found.\n\n"
        text += markdown_table(["experiment", "done", "settled"], by_design(again))
    text += "\n## Verdicts by family\n\n" + markdown_table(["family", "hidden", "cases", "verdicts"], breakdown(pairs))
    text += "\n## By hidden effect, strength >= 0.6\n\n"
    text += markdown_table(["effect", "cases", "something found", "truth inside", "intervals right"], by_effect(pairs))
    return text, table


def commands(record, cases, placebo=None, also=None):
    """How anyone makes the page again, now that the seeds may be known; Markdown text."""
    only = "".join(f" --{key} {record[key]}" for key in ("family", "kind") if record.get(key))
    suite = f"--suite {record['suite']} --cases {cases}{only} --seed {record['seed']}"
    lines = [f"python -m tests.blind.run {suite} --out DIR", "python -m tests.blind.again --out DIR"]
    score = "python -m tests.blind.score --cases DIR --verdicts DIR/verdicts"
    if placebo:
        suite = f"--suite {placebo['suite']} --cases {len(placebo['cases'])} --seed {placebo['seed']}"
        lines.append(f"python -m tests.blind.run {suite} --placebo --out PLACEBO")
        score += " --placebo PLACEBO"
    if also:
        only = f" --kind {also['kind']}" if also.get("kind") else ""
        suite = f"--suite {also['suite']} --cases {len(also['cases'])}{only} --first {also['first']}"
        lines.append(f"python -m tests.blind.run {suite} --seed {also['seed']} --out ALSO")
        score += " --also ALSO"
    return "\nTo make this page again:\n\n" + "".join(f"    {line}\n" for line in [*lines, score + " --markdown docs/blind.md"])


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", required=True)
    parser.add_argument("--verdicts", required=True)
    parser.add_argument("--markdown")
    parser.add_argument("--first", type=int, help="score the first so many cases of the deck only")
    parser.add_argument("--placebo", help="folder of a deck made with --placebo, its verdicts stored")
    parser.add_argument("--also", help="folder of another deck, its verdicts stored")
    given = parser.parse_args(arguments)
    text, _ = report(given.cases, given.verdicts, given.first, given.placebo, given.also)
    print(text)
    if given.markdown:
        Path(given.markdown).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
