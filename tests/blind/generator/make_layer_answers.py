"""What causes do to layers in pybullet: `python tests/blind/generator/make_layer_answers.py [--workers N]` writes
layer_answers.csv beside itself (Linux, Python 3.11: where pybullet has wheels; some 40 CPU minutes).

Five layers of 64 to 16 Cubipods as in the study: the first laid in the low pose, each next one dropped from 0.25 Dn at random
orientations over the hollows of the layer below, which is fixed once it rests. Contact friction 0.36, no restitution, 60 steps
a second, 10 iterations, 4 s a layer, the default path (the other one ignores the margins of compounds). Units that would overlap
their neighbours are lifted. Every cause is run with the same seeds as the model without it.

A plate of 2 Dn that rests on units lies on the highest of all planes through three of their corners under it, so that its
centre is as low as can be: the facet of the corners' upper hull that its centre is over. Nine a layer, over its inner part.
"""

import argparse
import csv
import sys
from concurrent.futures import ProcessPoolExecutor
from importlib.metadata import version
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull
from tqdm import tqdm

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))
import engines
import geometry
import scenes

HERE = Path(__file__).resolve().parent
DN = scenes.NOMINAL_DIAMETER
GRIDS = {"TPG": (1.58, 1.27), "RPG": (1.40, 1.30)}
FRICTION, LAYERS, FIRST, SECONDS, RATE = 0.36, 5, 8, 4, 60
CAUSES = {  # name, amplitude -> what it changes
    ("none", 0.0): {},
    ("convex_hull_shape", 1.0): {"shape": "hull"},
    ("margin_offset", 0.01): {"margin": 0.01},
    ("margin_offset", 0.02): {"margin": 0.02},
    ("grid_spacing", -0.02): {"wider": -0.02},
    ("grid_spacing", 0.03): {"wider": 0.03},
    ("placement_scatter", 0.15): {"scatter": 0.15},
    ("placement_scatter", 0.30): {"scatter": 0.30},
    ("loose_lower_layers", 1.0): {"loose": True},
    ("friction", 0.16): {"friction": 0.16},
    ("friction", 0.60): {"friction": 0.60},
}
SEEDS = 16


def places(grid, wider):
    """Centres (m, m, 2) [m] of each layer, row by row: over the hollows of the layer below."""
    a, b = (1.0 + wider) * DN * np.array(GRIDS[grid])
    row, column = np.indices((FIRST, FIRST))
    layers = [np.stack([a * (column + (0.5 * (row % 2) if grid == "TPG" else 0.0)), b * row], axis=-1)]
    while len(layers) < LAYERS:
        below, upper = layers[-1], len(layers) % 2 == 0
        if grid == "RPG":
            centres = below[:-1, :-1] + 0.5 * np.array([a, b])
        else:  # over triangles whose base is in the lower row, then, a layer up, over those whose base is in the upper one
            base = below[1:] if upper else below[:-1]
            centres = 0.5 * (base[:, 1:] + base[:, :-1]) + np.array([0.0, -b / 3 if upper else b / 3])
        layers.append(centres)
    return [layer.reshape(-1, 2) for layer in layers]


def first_layer(form, centres, grid, generator):
    """(position, orientation) of units in the low pose; on the triangular grid their headings are free."""
    if grid == "TPG":
        return scenes.bed(form, centres, generator)
    return np.column_stack([centres, np.full(len(centres), scenes.LOW_POSE_HEIGHT)]), scenes.low_pose(np.zeros(len(centres)))


def lifted(pieces, position, orientation):
    """Positions (n, 3) of units of which the later of two that overlap is lifted until it is free."""
    position, moving = position.copy(), np.ones(len(position), bool)
    while len(overlaps := geometry.pair_separations(pieces, position, orientation, 0.01, moving)):
        moving = np.isin(np.arange(len(position)), overlaps[:, 1].astype(int))
        position[moving, 2] += 0.05
    return position


def run(grid, cause, seed):
    """Layer coefficients (5,) of one test. cause: an entry of CAUSES."""
    settings = CAUSES[cause]
    generator, margin = np.random.default_rng(seed), settings.get("margin", 0.0)
    form = scenes.cubipod(settings.get("shape", "pieces"))
    pieces = [geometry.polyhedron(points) for points in form.pieces]
    corners = np.vstack(form.pieces)
    layers = places(grid, settings.get("wider", 0.0))
    position, orientation = first_layer(form, layers[0], grid, generator)
    scene = scenes.Scene(
        "layers",
        form,
        position + (0.0, 0.0, margin * DN),
        orientation,
        np.zeros(len(position), bool),
        scenes.FLOOR,
        friction=settings.get("friction", FRICTION),
        margin=margin * DN,
        time_step=1 / RATE,
    )
    engine = engines.Pybullet(scene, maximal=False, iterations=10)
    heights, level, own, below = [], 0.0, np.arange(len(position)), np.empty(0, int)
    for layer, centres in enumerate(layers):
        if layer:
            position, orientation = engine.poses()
            top = position[:, 2] + geometry.highest(pieces, orientation)
            aims = centres + settings.get("scatter", 0.0) * DN * generator.normal(size=centres.shape)
            near = np.linalg.norm(aims[:, None] - position[None, :, :2], axis=2) < 1.5 * DN
            turned = scenes.random_orientations(generator, len(aims))
            start = np.where(near, top, 0.0).max(axis=1) + scenes.FALLING_DISTANCE - geometry.lowest(pieces, turned)
            if not settings.get("loose"):
                engine.freeze(below)
            own = engine.add(lifted(pieces, np.column_stack([aims, start]), turned), turned, np.zeros(len(aims), bool))
        engine.step(RATE * SECONDS)
        position, orientation = engine.poses()
        standing = own[position[own, 2] > level + 0.35 * DN]  # the others fell out of the layer
        level, below = float(np.median(position[standing, 2])), own
        turns = geometry.rotation_matrix(orientation[standing])
        points = (corners @ np.swapaxes(turns, -1, -2) + position[standing][:, None]).reshape(-1, 3)
        heights.append(np.nanmean(plates(points, centres)) + 2.0 * margin * DN)  # the unit's and the plate's
    engine.bullet.disconnect()
    return np.diff(heights, prepend=0.0) / DN


def plates(points, centres):
    """Heights (9,) of the centres of plates that rest on points (n, 3), nan over a hole."""
    low, high = centres.min(axis=0) + 0.75 * DN, centres.max(axis=0) - 0.75 * DN
    heights = []
    for x in np.linspace(low[0], high[0], 3):
        for y in np.linspace(low[1], high[1], 3):
            under = points[np.abs(points[:, :2] - (x, y)).max(axis=1) < DN]
            if not _around(under[:, :2], (x, y)):
                heights.append(np.nan)
                continue
            normal, offset = np.split(ConvexHull(under).equations, [3], axis=1)
            up = normal[:, 2] > 1e-9
            heights.append(np.min(-(normal[up, :2] @ (x, y) + offset[up, 0]) / normal[up, 2]))
    return heights


def _around(points, centre):
    """Whether the hull of points (n, 2) holds a centre: a plate would not tip there."""
    if len(points) < 4:
        return False
    normal, offset = np.split(ConvexHull(points).equations, [2], axis=1)
    return bool(np.all(normal @ centre + offset[:, 0] <= 0.0))


def _job(job):
    return run(*job)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--workers", type=int, default=1)
    jobs = [(grid, cause, seed) for cause in CAUSES for grid in GRIDS for seed in range(SEEDS)]
    with ProcessPoolExecutor(parser.parse_args().workers) as pool:
        runs = np.array(list(tqdm(pool.map(_job, jobs), total=len(jobs)))).reshape(len(CAUSES), len(GRIDS), SEEDS, LAYERS)
    with open(HERE / "layer_answers.csv", "w", newline="") as file:
        file.write(f"# pybullet {version('pybullet')}: {SEEDS} tests of every cause and grid, made by make_layer_answers.py\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["cause", "amplitude", "grid", "layer", "mean", "cv", "change", "change_error"])
        for (name, amplitude), of_cause in zip(CAUSES, runs, strict=True):
            for grid, tests, without in zip(GRIDS, of_cause, runs[0], strict=True):
                for layer, (values, before) in enumerate(zip(tests.T, without.T, strict=True), start=1):
                    change = values - before
                    numbers = values.mean(), values.std(ddof=1) / values.mean(), change.mean(), change.std(ddof=1) / SEEDS**0.5
                    writer.writerow([name, amplitude, grid, layer, *(f"{number:.4f}" for number in numbers)])


if __name__ == "__main__":
    main()
