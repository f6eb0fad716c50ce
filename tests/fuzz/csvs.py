"""Damaged CSV files of every kind that is read: each is read or refused in one line, never a traceback, never a hang.

python -m tests.fuzz.csvs --count 2000    # counts of files read, refused, tracebacks, hangs; exit 1 after one of the last two
"""

import argparse
import os
import random
import signal
import sys
import tempfile
import traceback
from pathlib import Path

import hlcs
from hlcs.data.experiment_file import read_experiment_file
from hlcs.data.outcome_tables import read_outcomes
from hlcs.data.recordings import read_recordings
from hlcs.files.csv_files import MOST_BYTES
from hlcs.kinds.layers.data import read_layer_sets
from hlcs.placement.sea_bottom import Survey
from minibullet.errors import InputError

SECONDS = 10  # beyond which a file hangs
BODY = '[body]\nshape = "sphere"\nradius = 0.03\nmass = 0.05\n'
RECORDING = "t_s,x_m,z_m,qw,qx,qy,qz\n" + "".join(
    f"{0.1 * k:.1f},{0.3 * k:.2f},{4 + 0.8 * k - 0.049 * k * k:.4f},1,0,0,0\n" for k in range(14)
)
OUTCOMES = "height_m,group,fall_time_s\n" + "".join(f"{1 + k // 2},day {k % 2},{0.45 + 0.19 * (k // 2):.3f}\n" for k in range(8))
LAYERS = "grid,spacing_x,spacing_y,bottom_slope,layer,mean,cv,tests,campaign\n" + "".join(
    f'{grid},,,0,{k},{1.3 - 0.2 * (k > 1):.3f},0.01,5,"spring"\n' for grid in ("TPG", "RPG") for k in (1, 2, 3)
)
SURVEY = "x_m,y_m,z_m\n" + "".join(f"{x},{y},{0.04 * y}\n" for y in range(4) for x in range(5))
TOKENS = (
    '"',
    '""',
    "'",
    ",",
    ",,,",
    ";",
    "\t",
    "\r",
    "\r\n",
    "\n",
    "\n\n",
    "\0",
    "\x1b[31m",
    "\x1b]0;title\x07",
    "\u202e",
    "\ufeff",
    "\u2028",
    "nan",
    "inf",
    "-inf",
    "1e999",
    "-",
    ".",
    "e",
    "1_0",
    "0x10",
    "\u0661",
    "9" * 400,
    "0." + "3" * 400,
    "1e-400",
    "# note",
    "#",
    "=1+1",
    "true",
    "a" * 5000,
    "9" * 200_000,
    '"' + "x" * 200_000,
    "," * 3000,
    "x" * 3_000_000,
    "\n" * 300_000,
    " ",
    "\u3000",
    "-0",
    "1e308",
    "0.1,5",
    "\ud7ff",
    "t_s",
    "grid",
    "0,0,0\n",
)


def _recording(path):
    experiment = path.parent / "recording.toml"
    experiment.write_text('kind = "trajectory"\n' + BODY + f'[[trial]]\nfile = "{path.name}"\n')
    return read_recordings(read_experiment_file(experiment))


def _outcomes(path):
    experiment = path.parent / "outcomes.toml"
    experiment.write_text('kind = "outcomes"\n' + BODY + f'[measurement]\nfile = "{path.name}"\n')
    return read_outcomes(read_experiment_file(experiment))


def _imported(form):
    """A reader of exports of a format: read, and written as an experiment."""
    return lambda path: hlcs.import_measurements(path, form, path.parent / "imported")


TRACKER = "#multi:\n,ball A,,ball B,,\nt,x,y,x,y,\n" + "".join(
    f"{k / 10},0.1,{1.5 - k / 50},,{1.2 + k / 50},\n" for k in range(12)
)
MOTIVE = (
    "Format Version,1.23,Take Name,drop,Capture Frame Rate,100.0,Rotation Type,Quaternion,Length Units,Millimeters\n\n"
    ",,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body\n,,ball,ball,ball,ball,ball,ball,ball\n"
    ",,1,1,1,1,1,1,1\n,,Rotation,Rotation,Rotation,Rotation,Position,Position,Position\nFrame,Time (Seconds),X,Y,Z,W,X,Y,Z\n"
) + "".join(f"{k},{k / 100:.2f},0,0.6,0,0.8,{k},{1500 - k * k},3\n" for k in range(12))
PHONE = '"Time (s)","Acceleration x (m/s^2)","Acceleration z (m/s^2)"\n' + "".join(f"{k / 100:.2E},0.1,NaN\n" for k in range(12))
SOUNDS = '"Event time (s)","Interval (s)"\n' + "".join(f"{1 + k / 3:.6E},{1 / 3:.6E}\n" for k in range(6))
SPREADSHEET = "Zeit [s];Höhe [cm]\n" + "".join(f"0,{k:02d};{150 - k}\n" for k in range(12))
KINDS = {
    "tracker": (TRACKER, _imported("tracker")),
    "optitrack": (MOTIVE, _imported("optitrack")),
    "phone": (PHONE, _imported("phyphox")),
    "sounds": (SOUNDS, _imported("phyphox")),
    "spreadsheet": (SPREADSHEET, _imported("csv")),
    "recording": (RECORDING, _recording),
    "outcomes": (OUTCOMES, _outcomes),
    "layers": (LAYERS, read_layer_sets),
    "survey": (SURVEY, Survey.from_csv),
}


def mutant(text, chance):
    """A damaged copy of a text, bytes: one to four changes of characters, tokens, cells or lines; chance: random.Random."""
    for _ in range(chance.randint(1, 4)):
        at, to = sorted(chance.randrange(len(text) + 1) for _ in range(2))
        lines = text.split("\n")
        line = chance.randrange(len(lines))
        kind = chance.randrange(9)
        if kind == 0:  # a token somewhere
            text = text[:at] + chance.choice(TOKENS) + text[at:]
        elif kind == 1:  # a token in place of a cell
            cells = lines[line].split(",")
            cells[chance.randrange(len(cells))] = chance.choice(TOKENS)
            lines[line] = ",".join(cells)
            text = "\n".join(lines)
        elif kind == 2:  # a part left out
            text = text[:at] + text[min(to, at + 40) :]
        elif kind == 3:  # a part twice
            text = text[:to] + text[at:to] + text[to:]
        elif kind == 4:  # cut off
            text = text[:to]
        elif kind == 5:  # a line elsewhere
            lines.insert(chance.randrange(len(lines)), lines.pop(line))
            text = "\n".join(lines)
        elif kind == 6:  # a line many times
            lines[line:line] = [lines[line]] * min(chance.choice((1, 100, 3000)), 1 + MOST_BYTES // (1 + len(lines[line])))
            text = "\n".join(lines)
        elif kind == 7:  # a column twice, or one without a name
            text = "\n".join(one + "," + one.split(",")[chance.choice((0, -1))] * chance.randint(0, 1) for one in lines)
        else:  # other ends of lines
            text = text.replace("\n", chance.choice(("\r", "\r\n", "\n\r", "\x0b", "\x85")))
    data = text.encode("utf-8", "surrogatepass")
    if chance.random() < 0.15 and data:  # bytes that are no text
        at = chance.randrange(len(data))
        data = data[:at] + bytes(chance.randrange(256) for _ in range(chance.randint(1, 6))) + data[at + 1 :]
    return data if chance.random() < 0.95 else data.decode("utf-8", "replace").encode(chance.choice(("utf-16", "utf-8-sig")))


def put(folder, name, data, chance):
    """Path of a file with the data, or now and then of something that is no such file."""
    path = folder / name
    if path.is_symlink() or path.exists():
        path.rmdir() if path.is_dir() and not path.is_symlink() else path.unlink()
    kind = chance.randrange(100)
    if kind == 0:
        path.mkdir()
    elif kind == 1:
        path.symlink_to(chance.choice(("/dev/zero", path)))
    elif kind == 2:
        os.mkfifo(path)
    elif kind == 3:
        return folder / ("n" * 300 + ".csv")
    else:
        path.write_bytes(data)
    return path


def _late(signum, frame):
    raise TimeoutError(f"no answer within {SECONDS} s")


def outcome(reader, path):
    """("read" | "refused" | "traceback" | "hang", message)."""
    before = signal.signal(signal.SIGALRM, _late)
    signal.setitimer(signal.ITIMER_REAL, SECONDS)
    try:
        reader(path)
    except InputError as refusal:
        message = str(refusal)
        if message.isprintable() and len(message) < 1000:
            return "refused", message
        return "traceback", f"message: {message!r:.300}"
    except TimeoutError as problem:
        return "hang", str(problem)
    except BaseException:
        return "traceback", traceback.format_exc()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    return "read", ""


def run(count, folder, seed=13):
    """({"read": .., "refused": .., "traceback": .., "hang": ..}, [(place, message)] of what went wrong) of so many files."""
    counts, wrong = dict.fromkeys(("read", "refused", "traceback", "hang"), 0), []
    for number in range(count):
        chance = random.Random(f"{seed} {number}")  # each file by itself: one that fails is made again from its number
        kind = list(KINDS)[number % len(KINDS)]
        text, reader = KINDS[kind]
        found, message = outcome(reader, put(folder, f"{kind}.csv", mutant(text, chance), chance))
        counts[found] += 1
        if found in ("traceback", "hang"):
            wrong.append((f"{kind} {seed} {number}", message))
    return counts, wrong


def main():
    """The long run, from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=13)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        counts, wrong = run(asked.count, Path(folder), asked.seed)
    for place, message in wrong:
        print(place, message, sep="\n")
    print(", ".join(f"{number} {name}" for name, number in counts.items()))
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
