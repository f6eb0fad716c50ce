"""Saved worlds, changed at random: each is refused in one line or loads and steps; nothing crashes, hangs or shows a traceback.

    python -m tests.fuzz.worlds --count 2000 --seed 1

A mutant is loaded and stepped three times in a process of its own kind, so that a crash of the interpreter is seen.
"""

import argparse
import copy
import io
import json
import struct
import subprocess
import sys
import tempfile
import zipfile
from collections import Counter
from pathlib import Path

import numpy as np

import minibullet as mb
from minibullet.scene import saving

SECONDS = 10  # after which a mutant hangs
ROOM = 4_000_000_000  # bytes of address space of the process that loads: a file of kilobytes must not need more
VALUES = (0, -1, 1, 2, 7, 10**6, 2**31, 2**62, -(2**63), 0.5, -0.5, 1e-300, 1e17, 1e300, np.nan, np.inf, -np.inf)
JSON_VALUES = (*VALUES, None, True, "", "x", "\ud800", [], [1], {}, {"kind": "box"}, 10**400, [[[[1]]]], "9" * 5000)
CHILD = """
import faulthandler, sys, warnings
try:
    import resource
    resource.setrlimit(resource.RLIMIT_AS, ({room}, {room}))
except ImportError:
    pass  # Windows has no such limit
import numpy as np
import minibullet as mb
warnings.simplefilter("ignore")
for line in sys.stdin:
    path = line.rstrip("\\n")
    faulthandler.dump_traceback_later({seconds}, exit=True)
    try:
        world = mb.World.load(path)
        try:
            world.step(3)
            found = "stepped"
        except mb.InputError as error:
            found = "stopped " + str(error)
    except mb.InputError as error:
        found = "refused " + str(error)
    except BaseException as error:
        found = "traceback " + type(error).__name__ + " " + str(error)
    faulthandler.cancel_dump_traceback_later()
    print("\\\\n".join(found.splitlines()).encode("ascii", "backslashreplace").decode(), flush=True)
"""


def originals(folder):
    """Saved worlds to begin with, as bytes: a heap amid its fall with every kind of shape, a stack that was partly frozen, a
    world not yet stepped."""
    found = []
    for kind in range(3):
        settings = mb.Settings(friction=0.5, restitution=0.2 * (kind == 0))
        world = mb.World([mb.Gravity(9.81), mb.RollingFriction(arm=0.01)], settings)
        world.add_plane((0.05, 0.0, 1.0), restitution=0.1)
        wedge = mb.ConvexPiece(np.random.default_rng(kind).normal(size=(9, 3)) * 0.2)
        both = mb.Compound((mb.Box(0.4, 0.2, 0.2), mb.Box(0.2, 0.2, 0.4).pieces[0].moved((0.3, 0, 0))))
        shapes = (mb.Sphere(0.2), mb.Box(0.4, 0.3, 0.2), mb.Capsule(0.1, 0.4), mb.Cylinder(0.2, 0.3, 12), wedge, both)
        for k, shape in enumerate(shapes):
            place = (0.02 * k, 0.01 * k, 0.4 + 0.5 * k)
            world.add(shape, density=1000.0, position=place, group=None if k < 5 else 3, margin=0.001 * k, name=f"unit {k}")
        if kind < 2:
            world.step(60)
        if kind == 1:
            world.freeze(world.bodies[:2])
            world.add(mb.Box(0.1, 0.1, 0.1), mass=1.0, position=(1, 1, 1))
        world.save(Path(folder) / "original.npz")
        found.append((Path(folder) / "original.npz").read_bytes())
    return found


def mutant(generator, data):
    """One changed file (bytes) of a saved world (bytes)."""
    way = generator.integers(10)
    if way == 0:
        return flipped(generator, data)
    if way == 1:
        return cut(generator, data)
    if way == 2:
        return rezipped(generator, data)
    if way == 3:
        return claiming(generator, data)
    with np.load(io.BytesIO(data)) as file:
        arrays = {key: file[key] for key in file.files}
    header = json.loads(str(arrays["header"]))
    for _ in range(generator.integers(1, 4)):
        if way <= 7:
            edit_array(generator, arrays)
        else:
            edit_json(generator, header)
    text = json.dumps(header)
    if generator.random() < 0.02:
        text = "[" * 100_000
    if "header" in arrays:
        arrays["header"] = np.array(text)
    if generator.random() < 0.9 and "checksum" in arrays:  # what an attacker does, and what lets a mutant come further
        kept = {key: arrays[key] for key in saving.ARRAYS if key in arrays}
        arrays["checksum"] = np.array(saving.checksum(text, kept))
    buffer = io.BytesIO()
    (np.savez_compressed if generator.random() < 0.05 else np.savez)(buffer, **arrays)
    return buffer.getvalue()


def flipped(generator, data):
    """Some bytes are others."""
    data = bytearray(data)
    for place in generator.integers(len(data), size=generator.integers(1, 20)):
        data[place] = generator.integers(256)
    return bytes(data)


def cut(generator, data):
    """Bytes are missing, doubled or strange."""
    first, end = sorted(generator.integers(len(data), size=2).tolist())
    return (data[:first], data[:first] + data[end:], data[:end] + data[first:], data[first:],
            data[:first] + generator.bytes(50) + data[first:])[generator.integers(5)]  # fmt: skip


def rezipped(generator, data):
    """The same arrays in another archive: packed, doubled, renamed, left out, with wrong sizes in the list."""
    with zipfile.ZipFile(io.BytesIO(data)) as file:
        members = [(name, file.read(name)) for name in file.namelist()]
    way, buffer = generator.integers(5), io.BytesIO()
    if way == 0:
        members.append(members[generator.integers(len(members))])
    if way == 1:
        members[generator.integers(len(members))] = ("../other.npy", b"x")
    if way == 2:
        del members[generator.integers(len(members))]
    packing = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA)[generator.integers(4)]
    with zipfile.ZipFile(buffer, "w", packing) as file:
        for name, content in members:
            file.writestr(name, content + bytes(10**7) if way == 3 and generator.random() < 0.2 else content)
    result = bytearray(buffer.getvalue())
    if way == 4:  # the list at the end of the archive lies
        place = result.find(b"PK\x01\x02")
        result[place + 20 : place + 28] = struct.pack("<II", *generator.integers(2**32, size=2, dtype=np.uint64).tolist())
    return bytes(result)


def claiming(generator, data):
    """An array's header claims what its bytes are not."""
    shape = ((10**12,), (-1, 3), (2**40, 3), (3, 2**62), (0, 10**30), (7, 3), ())[generator.integers(7)]
    kind = ("<f8", "|O", "<i8", "<U1000000000", ">f8", "<c16", "|V8", "<f4", "[('a', '<f8')]")[generator.integers(9)]
    kind, in_columns = kind if kind[0] == "[" else repr(kind), bool(generator.integers(2))
    claim = f"{{'descr': {kind}, 'fortran_order': {in_columns}, 'shape': {shape}, }}"
    if generator.random() < 0.1:
        claim = "(" * 5000
    claim = claim.encode() + b" " * 20 + b"\n"
    buffer = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as file:
        names = file.namelist()
        lying = names[generator.integers(len(names))]
        with zipfile.ZipFile(buffer, "w") as other:
            for name in names:
                content = file.read(name)
                if name == lying:
                    length = int.from_bytes(content[8:10], "little")
                    content = content[:8] + len(claim).to_bytes(2, "little") + claim + content[10 + length :]
                other.writestr(name, content)
    return buffer.getvalue()


def edit_array(generator, arrays):
    """Something is wrong with one array, in place."""
    names = [key for key in arrays if key not in ("header", "checksum")]
    key = names[generator.integers(len(names))]
    array, way = arrays[key].copy(), generator.integers(14)
    if way <= 5 and array.size:  # mostly one number, so that the others let it pass
        value = VALUES[generator.integers(len(VALUES))]
        if array.dtype.kind == "i":
            value = int(np.clip(value if np.isfinite(value) else 0, -(2.0**62), 2.0**62))
        array.flat[generator.integers(array.size)] = value
    elif way == 6 and array.size:  # a number that would do elsewhere
        array.flat[generator.integers(array.size)] = array.flat[generator.integers(array.size)]
    elif way == 7 and array.size and array.dtype.kind == "i":
        array.flat[generator.integers(array.size)] += generator.integers(-3, 4)
    elif way == 8:
        array = array[generator.permutation(len(array))]
    elif way == 9:
        array = array[: generator.integers(len(array) + 1)]
    elif way == 10:
        array = np.concatenate([array, array[: generator.integers(len(array) + 1)]])
    elif way == 11:
        array = array.astype(("f4", "i4", "i8", "f8", "c16", "U8", "?")[generator.integers(7)])
    elif way == 12:
        array = (array.T, array.reshape(-1), array[None], np.asfortranarray(array))[generator.integers(4)]
    else:
        arrays.pop(key)
        return
    arrays[key] = array


def edit_json(generator, header):
    """Something is wrong with one value of the header, in place."""
    node = header
    while True:
        if isinstance(node, dict) and node:
            place = list(node)[generator.integers(len(node))]
        elif isinstance(node, list) and node:
            place = int(generator.integers(len(node)))
        else:
            return
        if isinstance(node[place], dict | list) and node[place] and generator.random() < 0.85:
            node = node[place]
            continue
        way = generator.integers(8)
        if way == 0:
            del node[place]
        elif way == 1 and isinstance(node, list):
            node.append(copy.deepcopy(node[place]))
        elif way == 2 and isinstance(node, dict):
            node["other"] = 1
        elif way == 3 and isinstance(node[place], int | float) and not isinstance(node[place], bool):
            node[place] = -node[place]
        else:
            node[place] = copy.deepcopy(JSON_VALUES[generator.integers(len(JSON_VALUES))])
        return


def outcomes(paths):
    """What became of each file: (path, "refused ..." | "stopped ..." | "stepped" | "traceback ..." | "crash ..." | "hang")."""
    paths, found = list(map(str, paths)), []
    command = [sys.executable, "-c", CHILD.format(room=ROOM, seconds=SECONDS)]
    while len(found) < len(paths):
        left = paths[len(found) :]
        child = subprocess.run(command, input="\n".join(left) + "\n", capture_output=True, text=True,
                               cwd=Path(__file__).resolve().parents[2])  # fmt: skip
        lines = child.stdout.splitlines()
        found += list(zip(left, lines, strict=False))
        if len(lines) < len(left):
            if not found and not lines and "Timeout" not in child.stderr and child.returncode == 1:
                raise RuntimeError(child.stderr)  # the process did not even begin
            what = "hang" if "Timeout" in child.stderr else f"crash {child.returncode} {child.stderr[-300:]!r}"
            found.append((left[len(lines)], what))
    return found


def run(count, seed, folder):
    """Outcomes of so many mutants, written into a folder."""
    generator, bases = np.random.default_rng(seed), originals(folder)
    paths = []
    for number in range(count):
        path = Path(folder) / f"mutant_{number:05d}.npz"
        path.write_bytes(mutant(generator, bases[generator.integers(len(bases))]))
        paths.append(path)
    return outcomes(paths)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", help="folder that keeps the mutants")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        place = Path(given.keep or folder)
        place.mkdir(parents=True, exist_ok=True)
        found = run(given.count, given.seed, place)
    for path, what in found:
        if what.split()[0] in ("traceback", "crash", "hang"):
            print(path, what)
    counts = Counter(what.split()[0] for _, what in found)
    print(", ".join(f"{name}: {counts[name]}" for name in ("refused", "stopped", "stepped", "traceback", "crash", "hang")))
    sys.exit(1 if counts["traceback"] + counts["crash"] + counts["hang"] else 0)


if __name__ == "__main__":
    main()
