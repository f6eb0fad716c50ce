"""Make cases: `python -m tests.blind.generate --out DIR --seed N [--cases K] [--family F] [--kind K] [--workers N]`.

DIR/cases/case_0001/ ... hold what a user would hand in; DIR/answers.json (only the scorer reads it) holds what is hidden, the
seed, and the commit that the seed was derived from (null: an open seed, which judges nothing; see generator/seal.py).
"""

import argparse
import json
import shutil
import time
from concurrent.futures import ProcessPoolExecutor
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from tqdm import tqdm

from .generator import deck
from .generator.case import write_case

SMALL_SEED, SMALL = 20210611, 24  # of the small deck that the tests make afresh; open, since it judges nothing but health


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
    seed, index, dealt, out = job
    name = f"case_{index + 1:04d}"
    kept = out / "made" / f"{name}.json"
    if kept.exists():
        return json.loads(kept.read_text(encoding="utf-8"))
    started = time.process_time()
    files, answer = deck.make(seed, index, dealt)
    write_case(out / "cases" / name, files)
    data = "layers" if "layers.csv" in files else "outcomes" if "outcomes.csv" in files else "trajectory"
    made = plain({"case": name, "kind_of_data": data, **answer}), time.process_time() - started
    write_case(kept.parent, {kept.name: json.dumps(made)})
    return made


def generate(out, seed, cases=None, family=None, kind=None, workers=1, quiet=True, commit=None):
    """Write a deck under `out`; the answers as {case name: answer}. The CPU seconds that each took go to seconds.json.
    Killed and started again it goes on where it stopped."""
    out = Path(out)
    cases = cases or deck.WHOLE
    dealt = deck.deal_all(seed, cases, family, kind)
    jobs = [(seed, index, deal, out) for index, deal in enumerate(dealt)]
    if workers > 1:
        with ProcessPoolExecutor(workers) as pool:
            made = list(tqdm(pool.map(_one, jobs), total=len(jobs), disable=quiet))
    else:
        made = [_one(job) for job in tqdm(jobs, disable=quiet)]
    record = {"format": 2, "seed": seed, "commit": commit, "asked": cases, "family": family, "kind": kind}
    record["without"] = [] if find_spec("pybullet") else ["tumble"]
    seconds = {answer["case"]: round(spent, 2) for answer, spent in made}
    record["cases"] = {answer.pop("case"): answer for answer, _ in made}
    text = json.dumps(record, indent=1)
    (out / "answers.json").write_text(text, encoding="utf-8")
    shutil.rmtree(out / "made")
    (out / "seconds.json").write_text(json.dumps(seconds), encoding="utf-8")
    return json.loads(text)["cases"]


def spent(out):
    """Lines (family, cases, mean and longest CPU seconds) of the making of a deck."""
    seconds = json.loads((Path(out) / "seconds.json").read_text(encoding="utf-8"))
    families = {name: answer["family"] for name, answer in json.loads((Path(out) / "answers.json").read_text())["cases"].items()}
    lines = []
    for family in dict.fromkeys(families.values()):
        mine = [seconds[name] for name in seconds if families[name] == family]
        lines.append(f"{family}: {len(mine)} cases, {np.mean(mine):.1f} s each, longest {max(mine):.1f} s")
    return lines


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", required=True)
    parser.add_argument("--seed", type=int, default=SMALL_SEED)
    parser.add_argument("--cases", type=int)
    parser.add_argument("--family", choices=deck.FAMILIES)
    parser.add_argument("--kind", choices=(*deck.KINDS, "single"), help="hide this kind in every case")
    parser.add_argument("--workers", type=int, default=1)
    given = parser.parse_args(arguments)
    answers = generate(given.out, given.seed, given.cases, given.family, given.kind, given.workers, quiet=False)
    if not find_spec("pybullet"):
        print("pybullet is not installed (extra 'oracle'; Linux, Python 3.11): no tumbling cases")
    print("\n".join([f"{len(answers)} cases in {given.out}/cases; answers in {given.out}/answers.json", *spent(given.out)]))


if __name__ == "__main__":
    main()
