"""Mutants of the TOML files that users write: each is read, or refused in one line, within seconds. Nothing else may happen.

    python -m tests.fuzz.tomls --count 2000             # readers, in one process
    python -m tests.fuzz.tomls --through-command 200    # whole commands, a process each

Mutant number k of a seed is the same on every machine; `--first k --count 1 --keep DIR` writes it to be looked at.
"""

import argparse
import collections
import contextlib
import json
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

from minibullet.errors import InputError

LONGEST = 10.0  # a file may be read in so many seconds, and a command ends so long after Ctrl-C [s]
ROOT = Path(__file__).resolve().parents[2]

FALL = "t_s,z_m\n" + "".join(f"{0.02 * k:.2f},{2 - 4.905 * (0.02 * k) ** 2 + 1e-3 * (-1) ** k:.5f}\n" for k in range(25))
DROPS = "height_m,fall_time_s,group\n" + "".join(f"{h},{(2 * h / 9.81) ** 0.5:.4f},a\n" for h in (0.5, 0.5, 1.0, 1.0, 2.0, 2.0))
LAYERS = "grid,layer,mean,cv,tests,campaign\n" + "".join(f"TPG,{j},{k},0.01,5,a\n" for j, k in ((1, 1.29), (2, 1.08)))
BED = "x_m,y_m,z_m\n" + "".join(f"{x},{y},0\n" for x in (-9, 0, 9) for y in (-9, 0, 9))
DATA = {
    "drop.csv": FALL,
    "rest.csv": "t_s,z_m\n" + "".join(f"{0.02 * k:.2f},{1e-3 * (-1) ** k}\n" for k in range(30)),
    "drops.csv": DROPS,
    "layers.csv": LAYERS,
    "bed.csv": BED,
}

BASES = {
    "trajectory": """kind = "trajectory"
title = "ball dropped in air"
[body]
shape = "sphere"
radius = 0.0335
mass = 0.0577
[surroundings]
gravity = 9.81
fluid_density = 1.2
floor = { height = -1.0, normal = [0.0, 0.0, 1.0] }
friction = 0.5
restitution = 0.0
[model]
effects = [{ name = "quadratic_drag", drag_coefficient = 0.47 }]
time_step = 0.0041666667
[measurement]
noise = { position = 0.02 }
static = "rest.csv"
[diagnose]
candidates = ["quadratic_drag", "tilted_gravity"]
hold_out = "none"
[[trial]]
file = "drop.csv"
group = "day 1"
mass = 0.06
start = { velocity = [0.0, 0.0, 0.0], orientation = [1, 0, 0, 0] }
""",
    "outcomes": """kind = "outcomes"
title = "fall times"
[body]
shape = "box"
size = [0.1, 0.1, 0.2]
mass = 1.0
[surroundings]
gravity = 9.81
[measurement]
file = "drops.csv"
noise = 0.003
[diagnose]
hold_out = "none"
""",
    "layers": """kind = "layers"
title = "two layers"
[placement]
shape = "hull"
side = 1.0
friction = 0.6
margin = 0.008
rows = 2
columns = 2
time_step = 0.016
settle_time = 1.0
[model]
effects = [{ name = "plate_bias", offset = 0.03 }]
[measurement]
file = "layers.csv"
[diagnose]
hold_out = "campaign"
""",
    "placement": """[placement]
grid = "TPG"
layers = 2
rows = 2
columns = 2
bottom = "bed.csv"
nominal_diameter = 1.07
stacking = "ABA"
effects = [{ name = "rolling_friction", arm = 0.02 }]
friction = 0.36
seed = 3
time_step = 0.016
settle_time = 1.0
sequential_placement = false
""",
    "sweep": """title = "friction"
[placement]
grid = "1.6,1.3,triangular"
layers = 1
rows = 2
columns = 2
time_step = 0.016
settle_time = 1.0
[sweep]
friction = [0.3, 0.6]
seed = [1, 2]
bottom = ["flat", "slope:0.04"]
""",
}
COMMANDS = {"trajectory": "compare", "outcomes": "compare", "layers": "compare", "placement": "place", "sweep": "sweep"}

VALUES = [
    "0",
    "-1",
    "1e300",
    "-1e300",
    "1e-300",
    "nan",
    "inf",
    "-inf",
    "1" + "0" * 400,
    "0x" + "f" * 5000,
    "1" * 5000,
    "true",
    "false",
    '""',
    '"x"',
    '"TPG"',
    "[]",
    "{}",
    "[[]]",
    "1979-05-27",
    "1979-05-27T07:32:00Z",
    "07:32:00",
    '"""\n\n"""',
    "[1, 'a', {}]",
    '"\\u0000"',
    '"\\u001b[31m"',
    '"\\u202e"',
    "'/etc/passwd'",
    "'../../etc/passwd'",
    "'.'",
    "'~'",
    "0.5",
    "9223372036854775807",
    "[0.0, 0.0, 0.0]",
    "[1, 2]",
    "{ name = 1 }",
    "[{}]",
    "'" + "a" * 300 + ".csv'",
    "1000000",
    "2.5",
]
LETTERS = ["é", "µ", "\u202e", "𝔘", "\u200c", "\ufeff", "ÿ", "\u0301", "\u00a0"]
DEEP = (20, 200, 3000, 50_000)


def mutant(kind, number, seed=0):
    """The text (bytes) of a mutant of a base: one to three changes, drawn from the seed and the number alone."""
    dice = random.Random(f"{seed} {kind} {number}")
    text = BASES[kind]
    for _ in range(dice.choice((1, 1, 1, 2, 3))):
        text = dice.choice(CHANGES)(text, dice)
    data = text.encode("utf-8", "surrogatepass")
    if dice.random() < 0.05:
        data = bytearray(data)
        data[dice.randrange(len(data))] = dice.randrange(256)
    return bytes(data)


# ------------------------------------------------------------------------------------------------------------------ changes
def _edit(text, dice):
    """A few letters taken out, doubled, or put in."""
    place, length = dice.randrange(len(text) + 1), dice.randint(1, 12)
    put = dice.choice(["", text[place : place + length] * 2, dice.choice("[]{}=\"'.,#\n\t\\-+0") * dice.randint(1, 3)])
    return text[:place] + put + text[place + length :]


def _line(text, dice):
    """A line dropped, doubled, or moved."""
    lines = text.split("\n")
    line = lines.pop(dice.randrange(len(lines)))
    for _ in range(dice.randint(0, 2)):
        lines.insert(dice.randint(0, len(lines)), line)
    return "\n".join(lines)


def _rename(text, dice):
    """A key of another name."""
    keys = list(re.finditer(r"[a-z_]+(?=\s*=)", text))
    if not keys:
        return text
    key, other = dice.choice(keys), dice.choice(keys)[0]
    name = dice.choice(
        [
            key[0][:-1],
            key[0] + "s",
            key[0].upper(),
            other,
            '""',
            '"a b"',
            "a" * 100_000,
            f"{key[0]}.{other}",
            '"\\u001b[2J"',
            ".".join("a" * dice.choice(DEEP)),
            "x.'y'.\"z\"",
        ]
    )
    return text[: key.start()] + name + text[key.end() :]


def _value(text, dice):
    """A value of another kind or size."""
    found = list(re.finditer(r"(?<== )[^\n]+?(?=\s*[,}\n])|(?<=[\[ ])-?[0-9][0-9.e-]*", text))
    if not found:
        return text
    value = dice.choice(found)
    return text[: value.start()] + dice.choice(VALUES) + text[value.end() :]


def _number(text, dice):
    """A number of another size, mostly one that can be meant."""
    found = list(re.finditer(r"(?<=[\[ ])-?[0-9][0-9.]*", text))
    if not found:
        return text
    number = dice.choice(found)
    factor = dice.choice([0.5, 0.9, 1.1, 2, -1, 0, 10, 1e3, 1e-3, 1e-6, 1e12])
    size = float(number[0].rstrip(".")) if number[0].count(".") < 2 else 1.0
    return text[: number.start()] + repr(size * factor) + text[number.end() :]


def _nest(text, dice):
    """A value, or a table, deep inside of others."""
    depth = dice.choice(DEEP)
    put = dice.choice(
        [
            f"x = {'[' * depth}1{']' * depth}\n",
            f"y = {'{ a = ' * depth}1{' }' * depth}\n",
            f"[{'.'.join('a' * depth)}]\n",
            f"{'.'.join('a' * depth)} = 1\n",
            f"z = [{'1, ' * depth}]\n",
            f"w = '{' ' * depth}'\n",
            f"[{' ' * depth}\n",
            "[[trial]]\nfile = 'drop.csv'\n" * min(depth, 3000),
        ]
    )
    place = dice.choice([0, len(text), text.find("[")])
    return text[:place] + put + text[place:]


def _letters(text, dice):
    """Letters of other writings, and such as steer a terminal."""
    place = dice.randrange(len(text) + 1)
    return text[:place] + dice.choice(LETTERS) * dice.randint(1, 3) + text[place:]


def _kind(text, dice):
    """Another kind of experiment, or sections of another file."""
    other = BASES[dice.choice(sorted(BASES))]
    if "kind" in text and dice.random() < 0.5:
        return re.sub(r'kind = "\w+"', f'kind = "{dice.choice(["trajectory", "outcomes", "layers"])}"', text, count=1)
    sections = f"\n{other}".split("\n[")
    return text + "\n[" + dice.choice(sections[1:])


CHANGES = (_edit, _line, _rename, _rename, _value, _value, _value, _number, _number, _number, _nest, _letters, _kind)


# ------------------------------------------------------------------------------------------------------------------ readers
def read(kind, path):
    """Everything that is read before any work begins."""
    from hlcs.data.experiment_file import read_experiment_file
    from hlcs.data.outcome_tables import read_outcomes
    from hlcs.data.recordings import read_recordings
    from hlcs.effects import check_names
    from hlcs.kinds.layers.data import read_layers
    from hlcs.kinds.layers.model import model_of
    from hlcs.placement.parameter_sweep import read_sweep_file
    from hlcs.placement.placement_file import read_placement_file

    if kind == "placement":
        return read_placement_file(path)
    if kind == "sweep":
        return read_sweep_file(path)
    file = read_experiment_file(path)
    if file.kind == "layers":
        return model_of(read_layers(file))
    check_names(file)
    return (read_outcomes if file.kind == "outcomes" else read_recordings)(file)


class _TooLong(BaseException):
    """Nothing catches it but what set the alarm."""


@contextlib.contextmanager
def _within(seconds):
    """_TooLong in the block after so many seconds."""

    def over(number, frame):
        raise _TooLong

    before = signal.signal(signal.SIGALRM, over)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def outcome(kind, path):
    """("read", "refused", "traceback" or "hang", what was said)."""
    try:
        with _within(LONGEST), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            read(kind, path)
    except InputError as problem:
        text = str(problem)
        named = "\n" not in text and str(path.parent) in text  # this file, or one that it names
        return ("refused", text) if named else ("traceback", f"no line that names a file: {text}")
    except _TooLong:
        return "hang", ""
    except BaseException as problem:
        return "traceback", f"{type(problem).__name__}: {problem}"
    return "read", ""


def command_outcome(kind, path):
    """The same of the whole command, each in its own process; one that works on for LONGEST seconds is asked to end by Ctrl-C."""
    process = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "hlcs",
            COMMANDS[kind],
            path.name,
            "--json",
            "out.json",
            *(["--workers", "1"] if kind == "sweep" else []),
        ],
        cwd=path.parent,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        env=os.environ | {"PYTHONPATH": str(ROOT), "HLCS_CACHE": str(path.parent)},
    )
    asked = False
    try:
        errors = process.communicate(timeout=LONGEST)[1]
    except subprocess.TimeoutExpired:
        asked = True
        process.send_signal(signal.SIGINT)
        try:
            errors = process.communicate(timeout=LONGEST)[1]
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            return "hang", ""
    lines = filter(None, errors.decode(errors="replace").splitlines())  # a blank one stands after ^C
    said = [line for line in lines if not line.startswith("hlcs: warning: ")]
    expected = {0: ("read", 0), 2: ("refused", 1), 1: ("worked, ended by Ctrl-C", 1)}.get(process.returncode, ("", -1))
    good = len(said) == expected[1] and (process.returncode != 1 or asked)
    return expected[0] if good else "traceback", " / ".join(said)


def run(count, seed=0, first=0, through_command=False, tell=None, keep=None):
    """Counter of outcomes of `count` mutants, all kinds in turn, and a list of those that should not be: (kind, number, words).

    tell: called with every outcome; keep: folder for the mutants that should not be.
    """
    counts, bad, kinds = collections.Counter(), [], sorted(BASES)
    with tempfile.TemporaryDirectory() as folder:
        for name, text in DATA.items():
            Path(folder, name).write_text(text)
        for number in range(first, first + count):
            kind = kinds[number % len(kinds)]
            path = Path(folder, "mutant.toml")
            path.write_bytes(mutant(kind, number, seed))
            found, words = (command_outcome if through_command else outcome)(kind, path)
            counts[found] += 1
            if found in ("traceback", "hang"):
                bad.append((kind, number, words))
                if keep:
                    Path(keep).mkdir(parents=True, exist_ok=True)
                    Path(keep, f"{kind}_{number}.toml").write_bytes(path.read_bytes())
            if tell:
                tell(number, found)
    return counts, bad


def main():
    """Count, and tell what should not be; exit status 1 if anything."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=0, help="mutants for the readers")
    parser.add_argument("--through-command", type=int, default=0, help="mutants for whole commands")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0, help="number of the first mutant")
    parser.add_argument("--keep", help="folder for mutants that should not be")
    given = parser.parse_args()
    failed = False
    for count, through in ((given.count, False), (given.through_command, True)):
        if count:
            started = time.perf_counter()
            counts, bad = run(count, given.seed, given.first, through, keep=given.keep)
            failed = failed or bool(bad)
            for kind, number, words in bad:
                print(f"{kind} {number}: {words[:300]}")
            print(
                json.dumps(
                    {
                        "through_command": through,
                        "mutants": count,
                        **dict(sorted(counts.items())),
                        "seconds": round(time.perf_counter() - started, 1),
                    }
                )
            )
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
