"""Mesh files, changed at random: each is read or refused in one line; nothing crashes, hangs or shows a traceback.

    python -m tests.fuzz.meshes --count 2000 --seed 1

Mutants are made and read in a process of their own, so that a crash of the interpreter is seen; number k of a seed is always
the same file. Exit 1 after a crash, a traceback or a hang.
"""

import argparse
import faulthandler
import json
import re
import subprocess
import sys
import tempfile
import time
import warnings
from collections import Counter
from pathlib import Path

import numpy as np
import trimesh

import minibullet as mb

SECONDS = 10  # after which a mutant hangs
ROOM = 4_000_000_000  # bytes of address space of the process that reads: a file of kilobytes must not need more
NASTY = [
    b"nan",
    b"-inf",
    b"1e999",
    b"1e-320",
    b"-0",
    b"999999999999999999999",
    b"",
    b"\xff\xff\xff\x7f",
    b"\0\0\xc0\x7f",
    b"f 1 2 3\n",
    b"v 0 0 0\n",
    b"endloop\n",
    b"solid\n",
    b"o x\n",
    b"\\\n",
    b"#",
    b"1/2/3",
    b"-1",
    b"0",
    b"\n",
    b"\r",
    b"1e150",
    b"9" * 400,
    b"9" * 5000,
    b"0." + b"3" * 400,
    b"1_0",
    b"0x10",
    b"1 " * 100_010,
    b"\x1b[31m",
    b"\xb2",
    b"x" * 3_000_000,
]
COUNTS = ["-1", "0", "1", "3", "255", "65536", "99999", "100001", "1000000000", "18446744073709551616", "9" * 400, "1.5", "x"]
KINDS = ["char", "uchar", "int8", "uint8", "short", "ushort", "int", "uint", "float", "double", "float64", "list", "string"]


def originals():
    """[(ending, bytes)]: a box, a ball, two boxes, and a box of quadrangles in every format, of text and of bytes."""
    box = trimesh.creation.box()
    away = trimesh.creation.box().apply_translation((3.0, 0.0, 0.0))
    found = []
    for mesh in (box, trimesh.creation.icosphere(0), trimesh.util.concatenate([box, away])):
        found += [(kind[:3], mesh.export(file_type=kind)) for kind in ("stl", "stl_ascii", "obj", "ply", "off")]
        found.append(("ply", mesh.export(file_type="ply", encoding="ascii")))
    named = "".join(trimesh.exchange.stl.export_stl_ascii(mesh) + "\n" for mesh in (box, away))
    quads = "OFF\n8 6 12\n" + "".join(f"{x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1))
    quads += "4 0 1 3 2\n4 4 6 7 5\n4 0 4 5 1\n4 2 3 7 6\n4 0 2 6 4\n4 1 5 7 3\n"
    found += [("stl", named), ("off", quads)]
    return [(kind, data.encode() if isinstance(data, str) else data) for kind, data in found]


def mutant(generator, data):
    """Bytes with one accident or a few: changed, cut, doubled or repeated, numbers edited, headers that lie."""
    for _ in range(generator.geometric(0.6)):  # one in most files: so many go far before they are refused
        here = int(generator.integers(0, len(data) + 1))
        there = min(len(data), here + int(generator.integers(0, 40)))
        way = generator.integers(0, 9)
        if way == 0 and here < len(data):
            data = data[:here] + bytes([generator.integers(0, 256)]) + data[here + 1 :]
        elif way == 1:
            data = data[:here] + data[there:]
        elif way == 2:
            data = data[:there] + data[here:]
        elif way == 3:
            data = data[:here] if generator.random() < 0.5 else data[here:]
        elif way == 4:
            data = data[:here] + pick(generator, NASTY) + data[there:]
        elif way == 5:
            words = data.split(b" ")
            words[generator.integers(0, len(words))] = pick(generator, NASTY)
            data = b" ".join(words)
        elif way == 6:
            data = edited(generator, data)
        elif way == 7:
            data = lying(generator, data)
        elif len(data) < 1_000_000:
            rows = data.splitlines(keepends=True) or [b""]
            first = int(generator.integers(0, len(rows)))
            last = first + int(generator.integers(1, 12))
            rows[first:first] = rows[first:last] * int(pick(generator, [1, 2, 70, 3000]))
            data = b"".join(rows)
    return data


def pick(generator, choices):
    return choices[generator.integers(0, len(choices))]


def edited(generator, data):
    """One number of a text is another: a little changed, or of another size or sign."""
    places = [match.span() for match in re.finditer(rb"-?\d+(\.\d+)?(e[-+]?\d+)?", data[:100_000])]
    if not places:
        return data
    first, last = pick(generator, places)
    try:
        value = float(data[first:last])
    except ValueError:
        return data
    number = pick(generator, [value + 1, value - 1, -value, value * 1e-7, value * (1 + 1e-7), value * 1e30, value * 1e-30, 1 / 3])
    whole = abs(number) < 1e18 and generator.random() < 0.5
    return data[:first] + (str(int(number)) if whole else repr(number)).encode() + data[last:]


def lying(generator, data):
    """The header says another count, kind or order of bytes."""
    if data.startswith(b"ply"):
        head, end, body = data.partition(b"end_header")
        rows = [row.split(b" ") for row in head.split(b"\n")]
        row = pick(generator, rows)
        if row[0] == b"element":
            row[-1] = pick(generator, COUNTS).encode()
        else:
            row[generator.integers(0, len(row))] = pick(generator, [*KINDS, "binary_big_endian", "ascii", "x", "face"]).encode()
        return b"\n".join(b" ".join(row) for row in rows) + end + body
    if data[:3].lower() == b"off":
        rows = data.split(b"\n", 2)
        return b"\n".join([rows[0], " ".join(pick(generator, COUNTS) for _ in range(3)).encode(), *rows[2:]])
    if len(data) > 84 and b"\0" in data[:84]:
        return data[:80] + int(pick(generator, [0, 1, 13, 10**5 + 1, 2**32 - 1])).to_bytes(4, "little") + data[84:]
    return data


def outcome(path):
    """("read" | "refused" | "traceback", what was said) of one file; a solid that cannot be weighed is a traceback."""
    try:
        shape = mb.mesh_file(path)
    except mb.InputError as refusal:
        text = str(refusal)
        clean = text.startswith(f"mesh '{path.name}'") and text.isprintable() and len(text) < 1000
        return ("refused" if clean else "traceback"), text[:1000]
    except Exception as error:
        return "traceback", f"{type(error).__name__}: {error}"
    fine = shape.volume > 0 and np.isfinite(shape.inertia).all() and np.linalg.eigvalsh(shape.inertia)[0] > 0
    return ("read" if fine else "traceback"), repr(shape)


def peak():
    """The most memory of this process so far [MB], 0 where the system does not tell. (getrusage counts its parent's too.)"""
    try:
        return int(re.search(r"VmHWM:\s*(\d+)", Path("/proc/self/status").read_text())[1]) / 1e3
    except OSError:
        return 0.0


def work(seed, first, count, folder):
    """Read the mutants first ... first + count - 1 of a seed; a line of JSON for each."""
    warnings.simplefilter("error")
    try:
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (ROOM, ROOM))
    except ImportError:
        pass  # Windows has no such limit
    files = originals()
    for number in range(first, first + count):
        generator = np.random.default_rng((seed, number))
        kind, data = pick(generator, files)
        path = folder / f"a.{kind}"
        path.write_bytes(mutant(generator, data))
        faulthandler.dump_traceback_later(SECONDS, exit=True)
        began = time.process_time()
        told, text = outcome(path)
        faulthandler.cancel_dump_traceback_later()
        print(json.dumps([number, told, text, time.process_time() - began, peak(), path.stat().st_size]), flush=True)


def run(count, seed):
    """(Counter of outcomes, [(number, outcome, text)] of what must not be, most seconds, most MB, largest file)."""
    counts, wrong, most, number = Counter(), [], np.zeros(3), 0
    while number < count:
        with tempfile.TemporaryDirectory() as folder:
            words = [
                sys.executable,
                "-m",
                "tests.fuzz.meshes",
                "--in",
                folder,
                "--seed",
                str(seed),
                "--from",
                str(number),
                "--count",
                str(count - number),
            ]
            child = subprocess.run(words, capture_output=True, text=True, cwd=Path(__file__).parents[2])
        for number, told, text, *costs in map(json.loads, child.stdout.splitlines()):
            counts[told] += 1
            most = np.maximum(most, costs)
            if told == "traceback":
                wrong.append((number, told, text))
        number = number + 1 if child.stdout else number
        if child.returncode:
            told = "hang" if "Timeout" in child.stderr else "crash"
            counts[told] += 1
            wrong.append((number, told, child.stderr[-1000:]))
            number += 1
    return counts, wrong, most


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--from", type=int, default=0, dest="first", help=argparse.SUPPRESS)
    parser.add_argument("--in", type=Path, dest="folder", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.folder:
        return work(given.seed, given.first, given.count, given.folder)
    counts, wrong, most = run(given.count, given.seed)
    print(", ".join(f"{told}: {counts[told]}" for told in ("refused", "read", "crash", "traceback", "hang")))
    print(f"longest {most[0]:.2f} s of CPU, peak memory {most[1]:.0f} MB, largest file {most[2] / 1e6:.2f} MB")
    for number, told, text in wrong:
        print(f"seed {given.seed}, number {number}: {told}: {text}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
