"""Score verdicts against sealed answers: `python -m tests.blind.score --cases DIR [--also DIR] [--markdown docs/blind.md]`.

DIR holds answers.json and, in `verdicts` and `verdicts-COMMIT`, one CASE.json per case as `hlcs diagnose --json` writes it: the
analyst of this checkout and others asked with `run --analyst`, scored side by side on the cases that all were asked. A case that
was asked and has no verdict (CASE.error) counts as a failure. What `again` and `peers` left there is told too.
"""

import argparse
import json
from pathlib import Path

import numpy as np

from .figures import NOISE, coverage, figures, found, groups, noise_of, reported, weakest
from .generator import seal

KINDNESS = """
What the generator grants that a laboratory may not: a static recording of the same tracker beside every set of recordings, or
its sigma stated (replicates in every table), so that sigma and its correlation can be learnt; wrong nominal inputs (mass 2 %,
size 1 %, tilt 1 degree at most) shrunk until they stay far below the noise; hidden laws that differ from the textbook form only
as far as the textbook law still fits; strengths that are exact after the starts are fitted; a tracker without lost bodies.
Hidden numbers reach twice the library's plausible ranges, look-alikes are those of the laws and not of the ranges. Coefficients
are scored against what an ideal fit of the textbook law to the noiseless data gives, the floor of the error against that fit on
the same noise; the friction of a foreign engine's tumbling cube against its own impacts.
"""


def breakdown(pairs):
    """Lines (family, kind, cases, verdict counts) for orientation."""
    lines = []
    for family in dict.fromkeys(answer["family"] for answer, _ in pairs):
        for kind in dict.fromkeys(answer["kind"] for answer, _ in pairs):
            some = [verdict["verdict"] for answer, verdict in pairs if (answer["family"], answer["kind"]) == (family, kind)]
            if some:
                tally = ", ".join(f"{name} {some.count(name)}" for name in sorted(set(some)))
                lines.append([family, kind, str(len(some)), tally])
    return lines


def by_noise(pairs):
    """Lines (noise, cases of the library, unexplained, complete though something is hidden, no verdict)."""
    lines, mine = [], groups(pairs)["in_library"]
    for regime, word in NOISE.items():
        some = [(answer["kind"], verdict["verdict"]) for answer, verdict in mine if noise_of(answer) == regime]
        overlooked = sum(verdict == "complete" and kind != "null" for kind, verdict in some)
        counts = [sum(verdict == name for _, verdict in some) for name in ("unexplained", "missing")]
        lines.append([word, str(len(some)), str(counts[0]), str(overlooked), str(counts[1])])
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
        some = [(a, v) for a, v in pairs if name in a["effects"] and weakest(a) >= 0.6 and a["kind"] != "placebo"]
        if some:
            covered = coverage([({**a, "parameters": {name: a["parameters"].get(name, {})}}, v) for a, v in some])
            counts = [len(some), sum(found(v) for _, v in some), sum(name in reported(v) for _, v in some)]
            lines.append([name, *map(str, counts), f"{sum(covered)}/{len(covered)}"])
    return lines


def times(analysts):
    """Lines (family, then for each analyst: median and longest CPU seconds of a verdict, and how many have none)."""
    lines = []
    first = next(iter(analysts.values()))
    for family in dict.fromkeys(answer["family"] for answer, _ in first):
        cells = [family]
        for pairs in analysts.values():
            mine = [verdict for answer, verdict in pairs if answer["family"] == family]
            spent, none = [v["cpu_seconds"] for v in mine if "cpu_seconds" in v], sum(v["verdict"] == "missing" for v in mine)
            count = f"n = {len(spent)}" + (f", {none} without a verdict" if none else "")
            cells.append(f"{np.median(spent):.1f}, {max(spent):.1f} ({count})" if spent else f"- ({count})")
        lines.append(cells)
    return lines


def markdown_table(header, lines):
    """A Markdown table as text."""
    rows = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(rows + ["| " + " | ".join(line) + " |" for line in lines]) + "\n"


def peers_table(told):
    """The table of `peers.py` as Markdown text, from what it stores."""
    lines = [[row, *(cells.get(peer, "-") for peer in told["verdicts"])] for row, cells in told["rows"].items()]
    return markdown_table([f"{told['cases']} recordings of flight and sinking", *told["verdicts"]], lines)


def was_asked(verdicts, name):
    """Whether a case was put before the analyst whose verdicts stand in a folder, with a verdict or without."""
    return any((Path(verdicts) / f"{name}.{end}").exists() for end in ("json", "error"))


def load(cases, verdicts):
    """[(answer, verdict)] and the deck's record; the verdict is "missing" where it failed, "not asked" where it is to come."""
    record = json.loads((Path(cases) / "answers.json").read_text(encoding="utf-8"))
    pairs = []
    for name, answer in record["cases"].items():
        file = Path(verdicts) / f"{name}.json"
        verdict = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
        none = "missing" if was_asked(verdicts, name) else "not asked"
        pairs.append((answer, {**verdict, "effects": verdict.get("effects") or [], "verdict": verdict.get("verdict", none)}))
    return pairs, record


def in_common(analysts):
    """{name: [(answer, verdict)]} of the cases that all analysts were asked."""
    asked = [all(verdict["verdict"] != "not asked" for _, verdict in row) for row in zip(*analysts.values(), strict=True)]
    return {name: [pair for pair, kept in zip(pairs, asked, strict=True) if kept] for name, pairs in analysts.items()}


def analysts_of(cases):
    """{name: [(answer, verdict)]} of all analysts whose verdicts stand beside the cases, this checkout's first; the record."""
    found_, record = {}, {}
    for folder in [Path(cases) / "verdicts", *sorted(Path(cases).glob("verdicts-*"))]:
        if folder.is_dir():
            told = folder / "analyst.json"
            commit = json.loads(told.read_text(encoding="utf-8"))["commit"] if told.exists() else ""
            pairs, record = load(cases, folder)
            found_[f"{'this' if folder.name == 'verdicts' else 'other'} analyst {commit[:8]}".strip()] = pairs
    return found_, record


def deck_text(record, analysts, register):
    """What deck this is, and which were opened before it; Markdown text."""
    if seal.judges(record):
        lines = seal.opened(record, register)
        place = lines.index(f"{record['commit']} {len(record['cases'])}")
        text = f"Judging deck of commit `{record['commit']}`: its seed is the SHA-256 of that name. Judging decks opened so far: "
        text += f"{len(lines)}; this is number {place + 1}, the first one counts (tests/blind/opened.txt)."
    else:
        text = f"An open seed ({record['seed']}): this deck judges nothing."
    text += f" {len(record['cases'])} cases"
    text += f", without {', '.join(record['without'])} (pybullet is not installed). " if record["without"] else ". "
    compared = in_common(analysts)
    text += f"Every figure is of the {len(next(iter(compared.values())))} cases that all analysts were asked.\n\n"
    tally = []
    for name, pairs in analysts.items():
        said = [verdict["verdict"] for _, verdict in pairs]
        failed = sum(verdict["verdict"] == "missing" for _, verdict in compared[name])
        tally.append([name, str(len(said) - said.count("not asked")), str(said.count("not asked")), str(failed)])
    text += markdown_table(["analyst", "asked", "not asked yet", "of the compared: without a verdict"], tally)
    return text + "\nBounds: exact binomial, one-sided 95 %.\n\n"


def report(cases, also=None, register=seal.REGISTER):
    """The whole score of a deck as Markdown text; also: the folder of another deck."""
    analysts, record = analysts_of(cases)
    done = Path(cases) / "again.json"
    again = json.loads(done.read_text(encoding="utf-8")) if done.exists() else None
    text = "# Hidden-effect suite\n\n" + deck_text(record, analysts, register)
    analysts = in_common(analysts)
    tables = []
    for number, pairs in enumerate(analysts.values()):
        tables.append(figures(pairs, list(again.values()) if again is not None and number == 0 else None))
    header = ["figure", "must"] + [cell for name in analysts for cell in (name, "bound", "result")]
    lines = [
        [one[0].name, one[0].must, *(cell for figure in one for cell in figure.cells())] for one in zip(*tables, strict=True)
    ]
    text += markdown_table(header, lines)
    text += "\n## CPU seconds per verdict: median, longest\n\n" + markdown_table(["family", *analysts], times(analysts))
    text += commands(record) + KINDNESS
    if (beside := Path(cases) / "peers.json").exists():
        told = json.loads(beside.read_text(encoding="utf-8"))
        text += "\n## Simpler tools\n\nWhat they are is told in `tests/blind/peers.py`.\n\n" + peers_table(told)
    if again is not None:
        text += "\n## The recommended experiments, done\n\nA direct reading is taken to be right: where it rules a suspect "
        text += "out, what is measured is that what is hidden is still found.\n\n"
        text += markdown_table(["experiment", "done", "settled"], by_design(again))
    pairs = next(iter(analysts.values()))
    text += "\n## Verdicts by family\n\n" + markdown_table(["family", "hidden", "cases", "verdicts"], breakdown(pairs))
    text += "\n## Truth in the library, by noise\n\n"
    text += markdown_table(["noise", "cases", "unexplained", "overlooked", "no verdict"], by_noise(pairs))
    text += "\n## By hidden effect, strength >= 0.6\n\n"
    text += markdown_table(["effect", "cases", "something found", "truth inside", "intervals right"], by_effect(pairs))
    return text + ("\n" + report(also, None, register).replace("# Hidden", "# Another deck: hidden", 1) if also else "")


def commands(record):
    """How anyone makes the page again; Markdown text."""
    only = "".join(f" --{key} {record[key]}" for key in ("family", "kind") if record.get(key))
    if seal.judges(record):
        first = f"git checkout {record['commit']} && python -m tests.blind.run --judge --out DIR"
    else:
        first = f"python -m tests.blind.run --cases {record['asked']}{only} --seed {record['seed']} --out DIR"
    lines = [first, "python -m tests.blind.run --out DIR --analyst OTHER_CHECKOUT", "python -m tests.blind.again --out DIR"]
    lines.append("python -m tests.blind.peers --cases DIR --verdicts DIR/verdicts --out DIR/peers.json")
    lines.append("python -m tests.blind.score --cases DIR --markdown docs/blind.md")
    return "\nTo make this page again:\n\n" + "".join(f"    {line}\n" for line in lines)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", required=True, help="folder of a deck, its verdicts stored")
    parser.add_argument("--markdown")
    parser.add_argument("--also", help="folder of another deck, its verdicts stored")
    given = parser.parse_args(arguments)
    text = report(given.cases, given.also)
    print(text)
    if given.markdown:
        Path(given.markdown).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
