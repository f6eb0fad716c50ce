"""Generate, diagnose, score: `python -m tests.blind.run --out DIR [--judge | --seed N] [--family F] [--analyst CHECKOUT]`.

--judge makes the judging deck of the frozen commit (generator/seal.py). --analyst PATH puts the same cases before the analyst of
another checkout. Verdicts go to DIR/verdicts, those of another analyst to DIR/verdicts-COMMIT, with the CPU time of each
process; the score shows all analysts side by side. Verdicts are stored before the answers are opened: a judging deck is scored
once all its cases were asked. A run may be done in pieces: families one after the other (--family; the deck stays whole), and
killed and started again it goes on where it stopped, cheap cases first. A case that failed or took too long stands in
CASE.error; delete that file to ask it again.
"""

import argparse
import json
import os
import subprocess
import sys
import time
import traceback
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

from tqdm import tqdm

from . import generate, score
from .generator import deck, seal

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")  # CPU time is that of one thread


def diagnose(experiment, out, limit, analyst=seal.ROOT):
    """Diagnose one experiment file by the analyst of a checkout, in a process of its own, and store its verdict with the time
    that the process took; returns an error text or None."""
    environment = {**os.environ, "PYTHONPATH": str(analyst), **dict.fromkeys(THREADS, "1")}
    command = [
        sys.executable,
        "-m",
        "hlcs",
        "diagnose",
        str(Path(experiment).resolve()),
        "--json",
        str(Path(out).resolve()),
        "-q",
    ]
    started, before = time.perf_counter(), os.times()
    try:
        done = subprocess.run(command, cwd=analyst, env=environment, capture_output=True, text=True, timeout=limit)
        problem = None if done.returncode == 0 else (done.stderr.strip().splitlines() or ["no message"])[-1]
    except subprocess.TimeoutExpired:
        problem = f"no verdict within {limit} s"
    after = os.times()
    if problem:
        out.unlink(missing_ok=True)
        out.with_suffix(".error").write_text(problem + "\n", encoding="utf-8")
        return f"{experiment.parent.name}: {problem}"
    out.with_suffix(".error").unlink(missing_ok=True)
    verdict = json.loads(out.read_text(encoding="utf-8"))
    verdict["seconds"] = round(time.perf_counter() - started, 2)
    verdict["cpu_seconds"] = round(sum(after[2:4]) - sum(before[2:4]), 2)  # of the children: one at a time in this process
    out.write_text(json.dumps(verdict, indent=1), encoding="utf-8")
    return None


# CPU seconds of a verdict, medians of an open deck (seed 20260001): 5, 5, 8, 20, 30, -, 35, some minutes; tables 4
CHEAP_FIRST = ("flight", "sinking", "topple", "slide", "roll", "stack", "bounce", "layers", "tumble")


def in_order(deck_folder, family=None):
    """Names of the cases of a deck, or of one family of it, cheap ones first."""
    answers = json.loads((Path(deck_folder) / "answers.json").read_text(encoding="utf-8"))["cases"]
    dear = {name: (one["kind_of_data"] != "outcomes", CHEAP_FIRST.index(one["family"])) for name, one in answers.items()}
    return sorted((name for name in dear if family in (None, answers[name]["family"])), key=lambda name: (dear[name], name))


def verdicts(cases, out, workers=2, limit=600, quiet=False, analyst=seal.ROOT, names=None):
    """Verdicts of the named cases under `cases`, in that order, or of all, that were not asked yet; a list of what went wrong."""
    out = Path(out)
    out.mkdir(parents=True, exist_ok=True)
    names = names if names is not None else sorted(file.parent.name for file in Path(cases).glob("case_*/experiment.toml"))
    files = [Path(cases) / name / "experiment.toml" for name in names if not score.was_asked(out, name)]
    problems = []
    with ProcessPoolExecutor(workers) as pool:
        jobs = [pool.submit(diagnose, file, out / f"{file.parent.name}.json", limit, analyst) for file in files]
        for job in tqdm(as_completed(jobs), total=len(jobs), disable=quiet):
            try:
                problems += [job.result()] if job.result() else []
            except Exception:  # a broken pool must not lose the verdicts already stored
                problems.append(traceback.format_exc(limit=1))
    return problems


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", required=True)
    parser.add_argument("--judge", action="store_true", help="the judging deck of the frozen commit")
    parser.add_argument("--seed", type=int, default=generate.SMALL_SEED, help="an open seed: judges nothing")
    parser.add_argument("--cases", type=int, default=generate.SMALL)
    parser.add_argument("--family", choices=deck.FAMILIES, help="a deck of this family; of a deck that is there, its cases")
    parser.add_argument("--kind", choices=(*deck.KINDS, "single"), help="hide this kind in every case")
    parser.add_argument("--analyst", type=Path, help="another checkout, whose analyst is asked")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--limit", type=float, default=900, help="seconds allowed per case")
    parser.add_argument("--markdown")
    given = parser.parse_args(arguments)
    out = Path(given.out)
    if not (out / "answers.json").exists():
        if given.judge:
            commit = seal.frozen()
            generate.generate(out, seal.seed_of(commit), None, None, None, given.workers, False, commit)
        else:
            generate.generate(out, given.seed, given.cases, given.family, given.kind, given.workers, False)
    analyst = (given.analyst or seal.ROOT).resolve()
    folder = out / (f"verdicts-{seal.commit_of(analyst)[:8]}" if given.analyst else "verdicts")
    names = in_order(out, given.family)
    for problem in verdicts(out / "cases", folder, given.workers, given.limit, analyst=analyst, names=names):
        print(problem, file=sys.stderr)
    (folder / "analyst.json").write_text(json.dumps({"commit": seal.commit_of(analyst)}), encoding="utf-8")
    record = json.loads((out / "answers.json").read_text(encoding="utf-8"))
    waiting = [name for name in record["cases"] if not score.was_asked(folder, name)]
    if waiting and seal.judges(record):
        print(f"{len(waiting)} of {len(record['cases'])} cases were not asked yet: a judging deck is scored when all are")
        return
    text = score.report(out)
    print(text)
    if given.markdown:
        Path(given.markdown).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
