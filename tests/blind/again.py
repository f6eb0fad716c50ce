"""Do the experiments that verdicts recommend, and diagnose again: `python -m tests.blind.again --out DIR [--workers N]`.

DIR is that of `tests.blind.run`, its verdicts stored. Only ambiguous verdicts whose report names an experiment with a number of
tests take part, but for those of tumbling cubes. Another throw, drop or body, more rows of a table, more tests of layers on a
grid: so many recordings, rows or tests of the same hidden cause join the case. A direct reading of a suspect: where it is what
is hidden the reading says so and nothing is left to ask; else the suspect is out, and the rest of the library is asked again.
Settled means: not both of the pair that the experiment was to separate are reported any more, and what is hidden still is if it
was. DIR/again.json holds the outcome for the scorer.
"""

import argparse
import json
import sys
from pathlib import Path

from . import run, score
from .figures import reported
from .generator import deck
from .generator.case import write_case

MOST = 30  # recordings that a laboratory would add; rows and tests of layers: as many as a verdict may ask for
HIDDEN = ("single", "degenerate", "clear", "nested", "joint", "double")


def suspect(design):
    """The effect that a recommended reading measures directly, or None."""
    return design.get("witness")


def asked(answer, verdict):
    """(design, number of tests) of the recommended experiment, or None where none takes part in this round."""
    following = verdict.get("next_experiment") or {}
    design, tests = following.get("design") or {}, following.get("tests_needed")
    if verdict["verdict"] != "ambiguous" or answer["kind"] not in HIDDEN or answer["family"] == "tumble":
        return None
    if not design or not tests or (answer["kind_of_data"] == "trajectory" and tests > MOST):
        return None
    return design, tests


def settled(answer, verdict, new):
    """Does the second verdict report no longer both of the pair, and still what is hidden, if the first did?"""
    pair, hidden = set(verdict["next_experiment"]["separates"]), set(answer["effects"]) & reported(verdict)
    return not pair <= reported(new) and hidden <= reported(new)


def prepare(folder, index, dealt, record, design, tests):
    """Write the case of the second round under `folder`; KeyError where this laboratory cannot follow the design."""
    from hlcs.effects import classes

    files, _ = deck.make(record["seed"], index, dealt, then=None if suspect(design) else (design, tests))
    if suspect(design):
        rest = [name for name in classes() if name != suspect(design)]
        line = f"[diagnose]\ncandidates = {json.dumps(rest)}\n"
        if "[diagnose]\n" in files["experiment.toml"]:
            files["experiment.toml"] = files["experiment.toml"].replace("[diagnose]\n", line, 1)
        else:
            files["experiment.toml"] += "\n" + line
    write_case(folder, files)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", required=True)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--limit", type=float, default=900, help="seconds allowed per case")
    given = parser.parse_args(arguments)
    out = Path(given.out)
    pairs, record = score.load(out, out / "verdicts")
    dealt = deck.deal_all(record["seed"], record["asked"], record["family"], record["kind"])
    outcome, waiting = {}, {}
    for index, (answer, verdict) in enumerate(pairs):
        name, wanted = f"case_{index + 1:04d}", asked(answer, verdict)
        if wanted is None:
            continue
        if suspect(wanted[0]) in answer["effects"]:
            outcome[name] = {"settled": True, "how": "read directly"}
            continue
        folder = out / "again" / "cases" / name
        if not folder.exists():
            try:
                prepare(folder, index, dealt[index], record, *wanted)
            except KeyError as problem:
                print(f"{name}: this laboratory cannot change {problem}", file=sys.stderr)
                continue
        waiting[name] = answer, verdict, "ruled out" if suspect(wanted[0]) else " and ".join(wanted[0])
    for problem in run.verdicts(out / "again" / "cases", out / "again" / "verdicts", given.workers, given.limit):
        print(problem, file=sys.stderr)
    for name, (answer, verdict, how) in waiting.items():
        file = out / "again" / "verdicts" / f"{name}.json"
        new = json.loads(file.read_text(encoding="utf-8")) if file.exists() else None
        outcome[name] = {"settled": new is not None and settled(answer, verdict, new), "how": how}
    (out / "again.json").write_text(json.dumps(dict(sorted(outcome.items())), indent=1), encoding="utf-8")
    print(f"{sum(one['settled'] for one in outcome.values())} of {len(outcome)} recommended experiments settle it")


if __name__ == "__main__":
    main()
