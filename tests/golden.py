"""Hashes of results, to be compared before and after a change that must not change any.

    python -m tests.golden --out before.json
    python -m tests.golden --against before.json [--only heaps placements mysteries blind layers]

Numbers, names and verdicts are hashed bit by bit; times, versions and sentences are left out. Hashes of one machine hold for
that machine and the versions of its libraries.
"""

import argparse
import hashlib
import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import hlcs
import minibullet as mb
from hlcs import mystery
from tests.blind import generate

SENTENCES = {"text", "why", "notes", "source", "title", "wall_seconds", "wall_seconds_per_test", "versions"}
BLIND_CASES = 8  # of the small suite, whose seed is open


def heaps():
    """Twelve Cubipods dropped on a floor: each shape, each solver, with and without restitution, two seconds."""
    for shape in ("hull", "pieces"):
        for solver in ("exact", "gauss_seidel", "sequential_impulse"):
            for restitution in (0.0, 0.4):
                yield f"heap {shape} {solver} e={restitution}", heap(shape, solver, restitution)


def heap(shape, solver, restitution):
    """Positions, orientations and velocities of the heap, (12, 13)."""
    world = mb.World([mb.Gravity(9.81)], mb.Settings(solver=solver, restitution=restitution, iterations=50))
    world.add_plane()
    unit, generator = hlcs.Cubipod(1.0).shape(shape), np.random.default_rng(13)
    for number in range(12):
        place = (1.8 * (number % 2), 1.8 * (number // 2 % 2), 1.8 * (number // 4) + 1.2)
        world.add(unit, density=2300.0, position=place, orientation=mb.rotations.random(generator, 1)[0])
    world.run(2.0)
    return [np.concatenate([b.position, b.orientation, b.velocity, b.angular_velocity]) for b in world.bodies]


def placements():
    """One placement test a grid, and one on a slope, blindly aimed."""
    for words in ({"grid": "TPG"}, {"grid": "RPG"}, {"bottom": "slope:0.04", "reference": "blind", "shape": "hull"}):
        yield f"place {words}", hlcs.PlacementTest(layers=3, rows=6, columns=6, **words).run().to_dict()


def mysteries():
    """The diagnosis of every packaged data set."""
    for name in mystery.names():
        with TemporaryDirectory() as folder:
            yield f"mystery {name}", hlcs.diagnose(mystery.copy(name, folder), progress=False).to_json()


def blind():
    """Diagnoses of the first cases of the small hidden-effect suite."""
    with TemporaryDirectory() as folder:
        generate.generate(folder, generate.SMALL_SEED, generate.SMALL)
        for file in sorted(Path(folder).glob("cases/*/experiment.toml"))[:BLIND_CASES]:
            yield f"blind {file.parent.name}", hlcs.diagnose(file, progress=False).to_json()


def layers():
    """Table 3 with two small tests, by the plan that `hlcs reproduce` uses."""
    from hlcs.paper import reproduce

    plan = reproduce.Plan({"rows": 5, "columns": 5, "layers": 3}, repeats=2, workers=1)
    yield "table3", reproduce.table3(plan)


PARTS = {part.__name__: part for part in (heaps, placements, mysteries, blind, layers)}


def bare(value):
    """A value without sentences and times, floats with all their bits."""
    if isinstance(value, dict):
        return {str(key): bare(item) for key, item in value.items() if key not in SENTENCES}
    if isinstance(value, list | tuple | np.ndarray):
        return [bare(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return value.hex() if isinstance(value, float) else value


def digest(value):
    """Short hash of what `bare` leaves."""
    return hashlib.sha256(json.dumps(bare(value), sort_keys=True).encode()).hexdigest()[:16]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", help="file for the hashes")
    parser.add_argument("--against", help="file of hashes to compare with")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS))
    given = parser.parse_args()
    found = {}
    for part in given.only:
        for name, value in PARTS[part]():
            found[name] = digest(value)
            print(found[name], name, flush=True)
    if given.out:
        Path(given.out).write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    if given.against:
        known = json.loads(Path(given.against).read_text(encoding="utf-8"))
        other = [name for name in found if found[name] != known.get(name)]
        print(f"{len(found)} results, {len(other)} differ" + "".join(f"\n  {name}" for name in other))
        sys.exit(bool(other))


if __name__ == "__main__":
    main()
