"""Generate, diagnose, score: `python -m tests.blind.run --out DIR [--suite small|full] [--cases K] [--workers N]`.

Verdicts are stored before the answers are opened. Killed and started again it goes on where it stopped.
"""

import argparse
import importlib
import json
import subprocess
import sys
import time
import traceback
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

from tqdm import tqdm

from . import generate, score
from .generator import deck


def diagnose(experiment, out, limit):
    """Diagnose one experiment file in a process of its own and store its verdict; returns an error text or None."""
    started = time.perf_counter()
    try:
        done = subprocess.run(
            [sys.executable, "-m", "tests.blind.run", "--one", str(experiment), str(out)],
            capture_output=True,
            text=True,
            timeout=limit,
        )
        problem = None if done.returncode == 0 else (done.stderr.strip().splitlines() or ["no message"])[-1]
    except subprocess.TimeoutExpired:
        problem = f"no verdict within {limit} s"
    if problem:
        out.with_suffix(".error").write_text(problem + "\n", encoding="utf-8")
        return f"{experiment.parent.name}: {problem}"
    out.with_suffix(".error").unlink(missing_ok=True)
    verdict = json.loads(out.read_text(encoding="utf-8"))
    out.write_text(json.dumps({**verdict, "seconds": round(time.perf_counter() - started, 2)}, indent=1), encoding="utf-8")
    return None


def one(experiment, out):
    """Store the verdict of hlcs.diagnose on an experiment file as JSON."""
    import hlcs

    call = hlcs.diagnose if callable(getattr(hlcs, "diagnose", None)) else importlib.import_module("hlcs.diagnose").diagnose
    Path(out).write_text(json.dumps(generate.plain(call(experiment).to_json())), encoding="utf-8")


def verdicts(cases, out, workers=2, limit=600, quiet=False, first=None):
    """Verdicts of all cases under `cases` (of the first so many where that is given) that have none yet; a list of what went
    wrong."""
    out = Path(out)
    out.mkdir(parents=True, exist_ok=True)
    files = [
        file
        for file in sorted(Path(cases).glob("case_*/experiment.toml"))[:first]
        if not (out / f"{file.parent.name}.json").exists()
    ]
    problems = []
    with ProcessPoolExecutor(workers) as pool:
        jobs = [pool.submit(diagnose, file, out / f"{file.parent.name}.json", limit) for file in files]
        for job in tqdm(as_completed(jobs), total=len(jobs), disable=quiet):
            try:
                problems += [job.result()] if job.result() else []
            except Exception:  # a broken pool must not lose the verdicts already stored
                problems.append(traceback.format_exc(limit=1))
    return problems


def main(arguments=None):
    arguments = sys.argv[1:] if arguments is None else arguments
    if arguments[:1] == ["--one"]:
        one(arguments[1], arguments[2])
        return
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", required=True)
    parser.add_argument("--suite", choices=generate.SUITES, default="small")
    parser.add_argument("--seed", type=int)
    parser.add_argument("--seed-file")
    parser.add_argument("--cases", type=int)
    parser.add_argument("--family")
    parser.add_argument("--kind", choices=deck.KINDS, help="hide this kind in every case")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--limit", type=float, default=600, help="seconds allowed per case")
    parser.add_argument("--placebo", action="store_true", help="residuals shuffled between recordings instead of the suite")
    parser.add_argument("--first", type=int, help="diagnose and score the first so many cases of the deck only")
    parser.add_argument("--markdown")
    given = parser.parse_args(arguments)
    out = Path(given.out)
    if not (out / "answers.json").exists():
        seed = (
            int(Path(given.seed_file).read_text())
            if given.seed_file
            else generate.SMALL_SEED
            if given.seed is None
            else given.seed
        )
        generate.generate(out, seed, given.cases, given.family, given.suite, given.workers, False, given.placebo, given.kind)
    for problem in verdicts(out / "cases", out / "verdicts", given.workers, given.limit, first=given.first):
        print(problem, file=sys.stderr)
    text, _ = score.report(out, out / "verdicts", given.first)
    print(text)
    if given.markdown:
        Path(given.markdown).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
