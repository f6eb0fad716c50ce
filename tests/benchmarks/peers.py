"""minibullet beside pybullet on the same scenes: `python tests/benchmarks/peers.py --json peers.json`.

Every run is a process of its own; the engines take turns; medians of wall times are compared. Both have the step 1/240 s,
at most 50 iterations, the same shapes, masses, inertias, margin and contact friction. Neither engine measures its own
quality: overlap is measured on the final poses by geometry.py. Needs pybullet (extra `oracle`).
"""

import argparse
import json
import platform
import statistics
import subprocess
import sys
import time
from importlib.metadata import version
from pathlib import Path

import engines
import geometry
import numpy as np
import scenes

REST_CHECK = 30  # steps between two looks at the velocities
GAUSS_SEIDEL = {"solver": "gauss_seidel"}
VARIANTS = {  # name: (engine class, keyword arguments)
    "minibullet": ("Minibullet", {**GAUSS_SEIDEL, "tolerance": 1e-4}),  # as hlcs places units
    "minibullet_fixed": ("Minibullet", {**GAUSS_SEIDEL, "residual_stop": False}),
    "minibullet_1e-3": ("Minibullet", {**GAUSS_SEIDEL, "tolerance": 1e-3}),
    "minibullet_1e-5": ("Minibullet", {**GAUSS_SEIDEL, "tolerance": 1e-5}),
    "minibullet_exact": ("Minibullet", {"tolerance": 1e-8}),  # the default of a World
    "minibullet_sequential": ("Minibullet", {"solver": "sequential_impulse"}),
    "pybullet": ("Pybullet", {}),
    "pybullet_fixed": ("Pybullet", {"residual_stop": False}),
    "pybullet_multibody_cone": ("Pybullet", {"maximal": False}),
    "pybullet_multibody_rows": ("Pybullet", {"maximal": False, "cone": False}),
}


def on_the_structure(engine, scene, numbers):
    """The numbers without the bodies that have rolled off what they were dropped on: those half a size or less above its
    lowest body. A lost unit rocks on the floor for as long as its shape and the engine's honesty about energy let it, and
    nobody waits for it when a layer is placed."""
    height = engine.heights()
    below = np.ones(len(height), bool)
    below[numbers] = False
    return numbers[height[numbers] > height[below].min() + 0.5 * scene.size] if below.any() else numbers


def at_rest(velocities, size):
    """No body moves faster than 0.5 % of the speed sqrt(g size)."""
    speed = np.linalg.norm(velocities[:, :3], axis=1) + 0.5 * size * np.linalg.norm(velocities[:, 3:], axis=1)
    return speed.max(initial=0.0) < 0.005 * np.sqrt(9.81 * size)


def settle(engine, scene, numbers):
    """Steps until the layer's bodies on the structure are at rest at two looks in a row, or the scene's duration is over;
    returns the steps done."""
    quiet = steps = 0
    while quiet < 2 and steps * scene.time_step < scene.duration:
        engine.step(REST_CHECK)
        steps += REST_CHECK
        heeded = on_the_structure(engine, scene, numbers)
        quiet = quiet + 1 if at_rest(engine.velocities()[heeded], scene.size) else 0
    return steps


def run_once(variant, name):
    """One run of one scene in this process; returns its times and qualities."""
    kind, options = VARIANTS[variant]
    make = getattr(engines, kind)
    if kind == "Minibullet":  # load the compiled kernels before the clock starts
        make(scenes.box_stack(2), **options).step(2)
    scene = scenes.SCENES[name]()
    engine = make(scene, **options)
    numbers, steps = np.flatnonzero(~scene.fixed), 0
    generator = np.random.default_rng(scene.seed + 1000)
    wall = cpu = 0.0
    for layer in range(max(len(scene.layers), 1)):
        if layer:  # where the next layer goes is the scene's affair and not on the clock
            position, orientation = engine.poses()
            placed = scenes.layer_above(scene.form, scene.layers[layer], position, orientation, generator)
        wall, cpu = wall - time.perf_counter(), cpu - time.process_time()
        if layer:
            engine.freeze(numbers)
            numbers = engine.add(*placed, np.zeros(len(placed[0]), bool))
        if scene.layers:
            steps += settle(engine, scene, numbers)
        else:
            steps = round(scene.duration / scene.time_step)
            engine.step(steps)
        wall, cpu = wall + time.perf_counter(), cpu + time.process_time()
    position, orientation = engine.poses()
    velocity = engine.velocities()[on_the_structure(engine, scene, numbers)]
    fixed = np.ones(len(position), bool)
    fixed[numbers] = False
    overlap = geometry.deepest_overlap(
        scene.form,
        scene.planes,
        engine.margin,
        position,
        orientation,
        fixed if not scene.layers else np.zeros(len(position), bool),
    )
    before = position[numbers]
    engine.step(round(1.0 / scene.time_step))
    drift = np.linalg.norm(engine.poses()[0][numbers] - before, axis=1)
    return {
        "wall": wall,
        "cpu": cpu,
        "steps": steps,
        "penetration": overlap / scene.size,
        "residual_speed": float(np.sqrt((velocity[:, :3] ** 2).sum(axis=1).mean())),
        "lost": len(numbers) - len(velocity),
        "drift": float(np.median(drift)),
        "mean_height": float(position[:, 2].mean()),
        **engine.counts(),
    }


def spawn(variant, name):
    """run_once in a fresh process."""
    done = subprocess.run([sys.executable, __file__, "--one", variant, name], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{variant} on {name} failed:\n{done.stderr}")
    return json.loads(done.stdout.splitlines()[-1])


def compare(name, ours, peer, repeats):
    """Alternating runs of two variants on one scene -> one row of the result."""
    runs = {ours: [], peer: []}
    for _ in range(repeats):
        for variant in (ours, peer):
            runs[variant].append(spawn(variant, name))

    def middle(variant, key):
        values = [run[key] for run in runs[variant]]
        return None if values[0] is None else statistics.median(values)

    row = {
        "scene": name,
        "variant": ours,
        "peer": peer,
        "ratio": middle(ours, "wall") / middle(peer, "wall"),
        "minibullet_s": middle(ours, "wall"),
        "peer_s": middle(peer, "wall"),
        "cpu_ratio": middle(ours, "cpu") / middle(peer, "cpu"),
        "ratio_per_step": middle(ours, "wall") / middle(ours, "steps") * middle(peer, "steps") / middle(peer, "wall"),
    }
    for key in ("penetration", "residual_speed", "lost", "drift", "mean_height", "steps"):
        row[key], row[f"peer_{key}"] = middle(ours, key), middle(peer, key)
    return row | {
        key: middle(ours, key)
        for key in ("fcl_calls_per_step", "iterations_per_step", "where_the_time_goes")
        if key in runs[ours][0]
    }


def cost_slope(rows, key):
    """Slope of log(time) against log(number of units) over the scaling scenes."""
    found = [(int(row["scene"].split("_")[1]), row[key]) for row in rows if row["scene"].startswith("scaling")]
    if len(found) < 2:
        return None
    number, seconds = np.array(found).T
    return float(np.polyfit(np.log(number), np.log(seconds), 1)[0])


def suitable(name):
    """Variants of ours worth running on a scene: on the single layers every solver and the price of a small residual."""
    if name.startswith("scaling"):
        return ["minibullet"]
    if name.startswith("layer"):
        return ["minibullet", "minibullet_fixed", "minibullet_1e-5", "minibullet_exact", "minibullet_sequential"]
    if name.startswith("box_stack"):
        return ["minibullet_exact", "minibullet", "minibullet_fixed"]  # ten bodies high: sweeps alone do not carry it
    return ["minibullet", "minibullet_fixed"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=Path, help="write all rows to this file")
    parser.add_argument("--scenes", nargs="*", default=list(scenes.SCENES), choices=list(scenes.SCENES), metavar="SCENE")
    parser.add_argument(
        "--ours",
        nargs="*",
        choices=list(VARIANTS),
        metavar="VARIANT",
        help="default: the one that places units, and what suits the scene beside it",
    )
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--one", nargs=2, metavar=("VARIANT", "SCENE"), help="a single run, printed as JSON")
    arguments = parser.parse_args()
    if arguments.one:
        print(json.dumps(run_once(*arguments.one)))
        return
    rows = []
    for name in arguments.scenes:
        for ours in arguments.ours or suitable(name):
            peer = "pybullet_fixed" if "fixed" in ours else "pybullet"
            repeats = 1 if name == "scaling_3000" or ours == "minibullet_exact" else arguments.repeats
            rows.append(compare(name, ours, peer, repeats))
            row = rows[-1]
            print(
                f"{name:20} {ours:28} {row['minibullet_s']:8.3f} s  {peer:15} {row['peer_s']:8.3f} s  ratio {row['ratio']:.2f}"
                f"  overlap {row['penetration']:.1e} / {row['peer_penetration']:.1e}"
                f"  speed {row['residual_speed']:.1e} / {row['peer_residual_speed']:.1e} m/s",
                flush=True,
            )
    slopes = {key: cost_slope(rows, key) for key in ("minibullet_s", "peer_s")}
    print("slope of log time to log number of units:", slopes)
    versions = {package: version(package) for package in ("pybullet", "numpy", "numba", "python-fcl")}
    result = {
        "rows": rows,
        "slopes": slopes,
        "machine": platform.machine(),
        "python": platform.python_version(),
        "versions": versions,
    }
    if arguments.json:
        arguments.json.write_text(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
