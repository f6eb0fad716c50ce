"""Make sealed cases: `python -m tests.blind.generate --out DIR --seed N --cases K [--family F] [--suite small|full]`.

DIR/cases/case_0001/ ... hold what a user would hand in; DIR/answers.json (only the scorer reads it) holds what is hidden;
DIR/commitment.json the SHA-256 of the answers and of the seed, and whether that seed was sealed before (tests/blind/seals.txt).
--placebo: every case has an effect, but what it adds is shuffled between the recordings, half of them with its sign turned;
nothing may be found.
"""

import argparse
import hashlib
import json
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from tqdm import tqdm

from .generator import deck, seal
from .generator.case import write_case

SMALL_SEED = 20210611  # of the small suite that the tests make afresh; open, since it judges nothing but health
SUITES = {"small": {"cases": 24, "strengths": (1.2, 3.0)}, "full": {"cases": 1000, "strengths": deck.STRENGTHS}}


def plain(value):
    """A value as JSON knows it."""
    if isinstance(value, dict):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(entry) for entry in value]
    if isinstance(value, np.floating | float):
        return float(value)
    if isinstance(value, np.integer):
        return int(value)
    return value


def _one(job):
    seed, index, dealt, strengths, folder, placebo = job
    files, answer = deck.make(seed, index, *dealt, strengths, placebo=placebo)
    write_case(folder, files)
    data = "layers" if "layers.csv" in files else "outcomes" if "outcomes.csv" in files else "trajectory"
    return {"case": folder.name, "kind_of_data": data, **answer}


def generate(out, seed, cases=None, family=None, suite="full", workers=1, quiet=True, placebo=False, kind=None):
    """Write the suite under `out`; the answers as {case name: answer}."""
    chosen = SUITES[suite]
    cases = cases or chosen["cases"]
    out = Path(out)
    dealt = deck.deal_all(seed, cases, family, kind)
    strengths = chosen["strengths"]
    if placebo:
        dealt = [("single", name if name != "layers" else "flight", turn) for _, name, turn in dealt]
        strengths = (1.2, 3.0)
    jobs = [(seed, index, deal, strengths, out / "cases" / f"case_{index + 1:04d}", placebo) for index, deal in enumerate(dealt)]
    if workers > 1:
        with ProcessPoolExecutor(workers) as pool:
            answers = list(tqdm(pool.map(_one, jobs), total=len(jobs), disable=quiet))
    else:
        answers = [_one(job) for job in tqdm(jobs, disable=quiet)]
    record = {"format": 1, "seed": seed, "suite": suite, "family": family, "kind": kind}
    record["cases"] = {answer.pop("case"): plain(answer) for answer in answers}
    text = json.dumps(record, indent=1)
    (out / "answers.json").write_text(text, encoding="utf-8")
    commitment = {
        "answers_sha256": hashlib.sha256(text.encode()).hexdigest(),
        "seed_sha256": seal.digest(seed),
        "sealed_as": seal.sealed(seed),
    }
    (out / "commitment.json").write_text(json.dumps(commitment, indent=1), encoding="utf-8")
    return json.loads(text)["cases"]


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", required=True)
    parser.add_argument("--seed", type=int, help="the seed; or --seed-file")
    parser.add_argument("--seed-file", help="file with a sealed seed (see generator/seal.py)")
    parser.add_argument("--cases", type=int)
    parser.add_argument("--family", choices=deck.FAMILIES)
    parser.add_argument("--suite", choices=SUITES, default="full")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--placebo", action="store_true")
    given = parser.parse_args(arguments)
    seed = int(Path(given.seed_file).read_text()) if given.seed_file else SMALL_SEED if given.seed is None else given.seed
    answers = generate(given.out, seed, given.cases, given.family, given.suite, given.workers, quiet=False, placebo=given.placebo)
    print(f"{len(answers)} cases in {given.out}/cases; answers in {given.out}/answers.json (seed {seal.digest(seed)[:16]}...)")


if __name__ == "__main__":
    main()
