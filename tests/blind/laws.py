"""Forces that no library knows, hidden in recordings: 60 that are functions of one variable, 60 placebos, and the score.

Run by hand: `python -m tests.blind.laws --seed 1 [--only speed_power] [--placebos]`. Everything here is made by Runge-Kutta in
steps of 1 ms and by closed forms, never by the code under test.

The rule of a design in which the variable can be told at all: every case has throws of unlike headings (spread round the
circle), speeds (3 : 1), elevations, places (a square of 3 m) and heights (lowest points from 0.3 m to 1.5 m), so that no
variable is a function of another one along all recordings. Laws of the heading have six to eight throws, the others three to
eight; no throw passes a magnet within 0.3 m. Nothing is drawn again because it turned out hard.
"""

import argparse
import json
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

from minibullet.errors import InputError

G, STEP = 9.81, 1e-3
NOISES = (0.0, 0.6, 0.8)
FORMS = (
    "speed_power",
    "speed_power",
    "speed_exponential",
    "speed_bump",
    "height_power",
    "height_exponential",
    "x_power",
    "y_bump",
    "heading_harmonic",
    "distance_power",
    "distance_power",
    "time_shake",
    "time_own_phases",
    "time_switch",
    "time_exponential",
    "spin_power",
)
# what shuffling between recordings destroys: a law of time is the same in all of them
DESTROYED = tuple(name for name in FORMS if not name.startswith("time"))


def unit(vectors):
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)


def direction(rng):
    """A random direction, not near the vertical: (3,)."""
    heading, rise = rng.uniform(0, 2 * np.pi), rng.uniform(-0.6, 0.6)
    return np.array([np.cos(rise) * np.cos(heading), np.cos(rise) * np.sin(heading), np.sin(rise)])


def law(rng, name, flown):
    """(function (x, v, spin, t) -> acceleration (n, 3) of unit size, truth) of a hidden force; flown: without it (.., 3)."""
    variable, form = name.split("_", 1)
    truth = {"variable": variable, "form": {"bump": "table", "harmonic": "table", "shake": "oscillation"}.get(form, form)}
    sign = rng.choice([-1.0, 1.0])
    if name == "speed_power":
        n = truth["exponent"] = float(
            rng.choice([rng.uniform(-1.0, -0.4), rng.uniform(0.3, 0.7), rng.uniform(1.3, 1.7), rng.uniform(2.4, 3.5)])
        )
        return lambda x, v, w, t: -((speed(v) / 4) ** n) * unit(v), truth
    if name == "speed_exponential":
        k = truth["rate"] = float(rng.uniform(0.4, 1.0))
        return lambda x, v, w, t: -np.exp(k * (speed(v) - 4)) * unit(v), truth
    if name == "speed_bump":
        middle, width = rng.uniform(3, 5), rng.uniform(0.7, 1.2)
        return lambda x, v, w, t: -np.exp(-(((speed(v) - middle) / width) ** 2)) * unit(v), truth
    if name == "height_power":
        n = truth["exponent"] = float(rng.choice([rng.uniform(-2.5, -1), rng.uniform(1, 3)]))
        return lambda x, v, w, t: sign * (np.maximum(x[:, 2:], 0.25) / 1.5) ** n * np.array([0, 0, 1.0]), truth
    if name == "height_exponential":
        k = truth["rate"] = float(rng.uniform(0.8, 2.0) * rng.choice([-1, 1]))
        return lambda x, v, w, t: -np.exp(k * (x[:, 2:] - 1.5)) * unit(v), truth
    if name == "x_power":
        n, d = float(rng.uniform(1, 3)), direction(rng)
        truth["exponent"] = n
        return lambda x, v, w, t: np.sign(x[:, :1]) * np.abs(x[:, :1]) ** n * d, truth
    if name == "y_bump":
        middle, width, d = rng.uniform(-1, 1), rng.uniform(0.5, 1.0), direction(rng)
        return lambda x, v, w, t: np.exp(-(((x[:, 1:2] - middle) / width) ** 2)) * d, truth
    if name == "heading_harmonic":
        phase, order = rng.uniform(0, 2 * np.pi), rng.integers(1, 3)
        return lambda x, v, w, t: -(1 + 0.8 * np.cos(order * np.arctan2(v[:, 1:2], v[:, :1]) - phase)) * unit(v), truth
    if name == "distance_power":
        n = truth["exponent"] = float(rng.choice([rng.uniform(-3, -1), 1.0, 2.0], p=[0.7, 0.15, 0.15]))
        while True:  # no ball flies through a magnet
            point = np.array([*rng.uniform(-2, 2, 2), rng.uniform(0, 2)])
            if np.linalg.norm(flown - point, axis=-1).min() > 0.3:
                break
        truth["point"] = point.tolist()

        def pull(x, v, w, t):
            gap = point - x
            distance = np.maximum(np.linalg.norm(gap, axis=1, keepdims=True), 0.05)
            return sign * distance ** (n - 1) * gap

        return pull, truth
    if name == "time_shake":
        f, amplitudes, phases = float(rng.uniform(2.5, 7)), rng.uniform(0.4, 1, 3), rng.uniform(0, 6.28, 3)
        truth["frequency_hz"] = f
        return lambda x, v, w, t: np.tile(amplitudes * np.cos(2 * np.pi * f * t + phases), (len(x), 1)), truth
    if name == "time_own_phases":  # of the camera: acts on what is seen
        truth["frequency_hz"], truth["amplitudes"], truth["form"] = (
            float(rng.uniform(2.5, 7)),
            rng.uniform(0.4, 1, 3).tolist(),
            "oscillation",
        )
        return None, truth
    if name == "time_switch":
        start, length, d = rng.uniform(0.15, 0.35), rng.uniform(0.15, 0.35), direction(rng)
        truth["start_s"], truth["end_s"] = float(start), float(start + length)
        return lambda x, v, w, t: np.tile(d * (start <= t < start + length), (len(x), 1)), truth
    if name == "time_exponential":
        k, d = float(rng.uniform(4, 9) * rng.choice([-1, 1])), direction(rng)
        truth["rate"] = k
        return lambda x, v, w, t: np.tile(d * np.exp(k * (t - 0.4)), (len(x), 1)), truth
    n = truth["exponent"] = float(rng.uniform(0.5, 3))
    return lambda x, v, w, t: sign * (np.linalg.norm(w, axis=1, keepdims=True) / 20) ** n * unit(np.cross(w, v)), truth


def speed(v):
    return np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-9)


def fly(x, v, w, force, duration):
    """Positions (steps + 1, n, 3) of n bodies under gravity and a force per mass."""
    count = int(round(duration / STEP))
    track = np.empty((count + 1, *x.shape))

    def slope(x, v, t):
        return np.array([0, 0, -G]) + force(x, v, w, t)

    for k in range(count + 1):
        track[k], t, h = x, k * STEP, STEP
        a = slope(x, v, t)
        b = slope(x + h / 2 * v, v + h / 2 * a, t + h / 2)
        c = slope(x + h / 2 * v + h * h / 4 * a, v + h / 2 * b, t + h / 2)
        d = slope(x + h * v + h * h / 2 * b, v + h * c, t + h)
        x, v = x + h * v + h * h / 6 * (a + b + c), v + h / 6 * (a + 2 * b + 2 * c + d)
    return track


def throws(rng, count, duration):
    """Starts of `count` throws as the rule says: x, v, spin (count, 3) each."""
    heading = rng.uniform(0, 2 * np.pi) + 2 * np.pi * (np.arange(count) + rng.uniform(-0.3, 0.3, count)) / count
    speeds = rng.permutation(np.linspace(2.0, 6.0, count)) * rng.uniform(0.9, 1.1, count)
    rise = rng.uniform(-0.2, 1.1, count)
    v = speeds[:, None] * np.column_stack([np.cos(rise) * np.cos(heading), np.cos(rise) * np.sin(heading), np.sin(rise)])
    fall = np.minimum(0.0, v[:, 2] * duration - G * duration**2 / 2)  # the lowest points are the ends of the throws
    x = np.column_stack([rng.uniform(-1.5, 1.5, (count, 2)), rng.permutation(np.linspace(0.3, 1.5, count)) - fall])
    axis = np.column_stack([rng.uniform(-0.4, 0.4, (count, 2)), rng.choice([-1.0, 1.0], count)])
    return x, v, unit(axis) * rng.permutation(np.linspace(8, 32, count))[:, None]


def projected(times, change):
    """What is left of a change (n, r, 3) of the samples once starts are fitted."""
    q, _ = np.linalg.qr(np.column_stack([np.ones(len(times)), times]))
    flat = change.reshape(len(times), -1)
    return (flat - q @ (q.T @ flat)).reshape(change.shape)


def noise(rng, shape, sigma, rho):
    white = rng.normal(size=shape) * sigma
    white[1:] *= np.sqrt(1 - rho**2)
    return lfilter([1.0], [1.0, -rho], white, axis=0)


def make(rng, name, placebo=""):
    """One case: times, positions seen (n, r, 3), spin (r, 3), static (600, 3), truth; placebo: "", "noise" or "shuffled"."""
    count = int(rng.integers(6, 9) if name.startswith("heading") else rng.integers(3, 9))
    rho, rate, sigma = float(rng.choice(NOISES)), int(rng.choice([50, 100, 125])), float(rng.choice([0.001, 0.002, 0.004]))
    strength = float(np.exp(rng.uniform(np.log(1.2), np.log(10))))
    duration = float(rng.uniform(0.7, 1.1))
    x, v, w = throws(rng, count, duration)
    stride = round(1 / rate / STEP)
    times = np.arange(int(duration * rate) + 1) / rate
    base = fly(x, v, w, lambda x, v, w, t: 0.0, duration)[::stride][: len(times)]
    force, truth = law(rng, name, base)
    if force is None:
        phases = rng.uniform(0, 2 * np.pi, (count, 3))
        swing = np.array(truth["amplitudes"]) * np.cos(2 * np.pi * truth["frequency_hz"] * times[:, None, None] + phases)
        seen = base + swing * strength * sigma / np.sqrt(np.mean(projected(times, swing) ** 2))
    else:
        amplitude = 0.01
        for _ in range(6):
            seen = fly(x, v, w, lambda x, v, w, t, size=amplitude: size * force(x, v, w, t), duration)[::stride][: len(times)]
            size = np.sqrt(np.mean(projected(times, seen - base) ** 2)) / sigma
            amplitude *= strength / size
    if placebo == "noise":
        seen = base
    if placebo == "shuffled":  # what a force did to one recording is added to another: a law of what the body does there no more
        left = projected(times, seen - base)
        seen = base + left[:, np.roll(np.arange(count), 1 + int(rng.integers(count - 1)))]
    truth |= {"name": name, "strength": strength, "rho": rho, "recordings": count, "sigma": sigma, "frames": rate}
    seen = seen + noise(rng, seen.shape, sigma, rho)
    return times, seen, w, noise(rng, (600, 3), sigma, rho), truth


def write(folder, case, rng):
    """The experiment of a case in a folder; returns the path of its TOML."""
    times, seen, spin, static, truth = case
    turned = truth["variable"] == "spin"
    text = 'kind = "trajectory"\n[body]\nshape = "sphere"\nradius = 0.03\nmass = 0.05\n[surroundings]\nfluid_density = 0.0\n'
    text += '[measurement]\nstatic = "rest.csv"\n'
    for k in range(seen.shape[1]):
        angle = np.outer(times, spin[k])
        table(folder / f"throw_{k}.csv", times, seen[:, k], angle + 0.01 * rng.normal(size=angle.shape) if turned else None)
        text += f'[[trial]]\nfile = "throw_{k}.csv"\n'
    rest = np.arange(600) * (times[1] - times[0])
    table(folder / "rest.csv", rest, 1.0 + static, 0.01 * rng.normal(size=(600, 3)) if turned else None)
    path = folder / "case.toml"
    path.write_text(text)
    return path


def table(path, times, position, angle):
    """A CSV; angle: rotation vectors (n, 3) of the body, None = not seen."""
    columns, values = ["t_s", "x_m", "y_m", "z_m"], np.column_stack([times, position])
    if angle is not None:
        half = np.linalg.norm(angle, axis=1, keepdims=True) / 2
        q = np.hstack([np.cos(half), np.sin(half) * unit(angle)])
        columns, values = [*columns, "qw", "qx", "qy", "qz"], np.hstack([values, q])
    rows = [",".join(columns)] + [",".join(f"{value:.7f}" for value in row) for row in values]
    path.write_text("\n".join(rows) + "\n")


def run(folder, case, rng):
    """(what was learned, seconds) of one case."""
    from hlcs.data.experiment_file import read_experiment_file
    from hlcs.data.recordings import read_recordings
    from hlcs.kinds.trajectories.preparation import prepare
    from hlcs.learning import learn

    prepared = prepare(read_recordings(read_experiment_file(write(Path(folder), case, rng))))
    begun = time.process_time()
    found = learn(prepared.problem, prepared.base)
    return found, time.process_time() - begun


def judge(truth, found):
    """One line of the score: is the variable right, the form, the exponent within 0.2?"""
    row = {"name": truth["name"], "found": None if found is None else (found.variable, found.form)}
    row["variable"] = found is not None and found.variable == truth["variable"]
    row["form"] = row["variable"] and found.form == truth["form"]
    if "exponent" in truth:
        row["exponent"] = row["form"] and abs(found.numbers["exponent"]["value"] - truth["exponent"]) <= 0.2
    return row


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--only", default="")
    parser.add_argument("--placebos", action="store_true")
    arguments = parser.parse_args()
    rows = []
    for k in range(arguments.count):
        rng = np.random.default_rng([arguments.seed, k, arguments.placebos])
        name = arguments.only or FORMS[k % len(FORMS)]
        placebo = ("noise", "shuffled")[k % 2] if arguments.placebos else ""
        if placebo == "shuffled":
            name = DESTROYED[(k // 2) % len(DESTROYED)]
        case = make(rng, name, placebo)
        try:
            with tempfile.TemporaryDirectory() as folder:
                found, seconds = run(folder, case, rng)
        except InputError as error:  # counted as nothing said
            found, seconds = None, 0.0
            print(error)
        row = judge(case[-1], found) | {"seconds": round(seconds, 1), "placebo": placebo}
        rows.append(row)
        print(
            json.dumps(row),
            {key: case[-1][key] for key in case[-1] if key not in ("name", "variable")},
            found and found.text,
            flush=True,
        )
    right, formed = (sum(row[key] for row in rows) for key in ("variable", "form"))
    print(
        f"of {len(rows)}: variable right {right}, form right {formed}, some form {sum(row['found'] is not None for row in rows)}"
    )
    powers = [row["exponent"] for row in rows if "exponent" in row]
    print(f"exponent within 0.2: {sum(powers)} of {len(powers)}")


if __name__ == "__main__":
    main()
