"""What simpler tools say to the recordings of flight and sinking in a deck, in the rows of `score.py`:
`python -m tests.blind.peers --cases DIR [--verdicts DIR] [--first N] [--out FILE.json] [--markdown]`.

The plain script: every law of LAWS alone and every pair, fitted by scipy.optimize.least_squares to its own Runge-Kutta
trajectories with the start of every recording free, judged by BIC or AIC; residuals whitened as AR(1) or not; what stands
within TIES units of the best reported with it or not. pysindy (`pip install pysindy`; its column is left out where it is
absent) is given the accelerations that the model under test leaves over. Nothing here uses hlcs; `score.py` counts.
"""

import argparse
import json
import time
import tomllib
import warnings
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np
import pandas as pd
from numba import njit
from scipy import stats
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from . import score

try:
    import pysindy
except ImportError:
    pysindy = None

FAMILIES = ("flight", "sinking")
TIES = 6.0  # units of BIC or AIC: where the textbooks begin to call evidence strong
REFUSED = 0.01  # p of the test of the residual's variance below which a fit is called unexplained
STEP = 0.01  # s: a third of the shortest time in which the drags of the decks act; errs by some 1e-6 m there
LAWS = {  # every number and its null value
    "linear_drag": {"rate": 0.0},
    "quadratic_drag": {"drag_coefficient": 0.0},
    "buoyancy": {"fluid_density": 0.0},
    "added_mass": {"coefficient": 0.0},
    "uniform_flow": {"velocity_x": 0.0, "velocity_y": 0.0, "velocity_z": 0.0},
    "magnus": {"coefficient": 0.0},
    "spin_decay": {"rate": 0.0},
    "tilted_gravity": {"angle_x": 0.0, "angle_y": 0.0},
    "tilted_frame": {"angle_x": 0.0, "angle_y": 0.0},
    "length_scale": {"factor": 1.0},
    "time_scale": {"factor": 1.0},
    "clock_offset": {"offset": 0.0},
    "mass_offset": {"relative": 0.0},
    "size_error": {"relative": 0.0},
}
NUMBERS = [(law, number) for law, numbers in LAWS.items() for number in numbers]
NULL = np.array([LAWS[law][number] for law, number in NUMBERS])
FRAME, LENGTH, TIME, CLOCK, SPIN = (NUMBERS.index(key) for key in (
    ("tilted_frame", "angle_x"), ("length_scale", "factor"), ("time_scale", "factor"), ("clock_offset", "offset"),
    ("spin_decay", "rate")))  # fmt: skip
POSITIVE = ("linear_drag", "quadratic_drag", "buoyancy", "added_mass", "spin_decay")  # what a negative number would be absurd for
DRAGS = ("linear_drag", "quadratic_drag")
VARIANTS = {  # name: (whitened as AR(1), price of one number from the count of readings, ties reported)
    "BIC, AR(1), ties": (True, np.log, True),
    "BIC, AR(1)": (True, np.log, False),
    "BIC, ties": (False, np.log, True),
    "BIC": (False, np.log, False),
    "AIC, AR(1), ties": (True, lambda count: 2.0, True),
    "AIC": (False, lambda count: 2.0, False),
}


@njit(cache=True)
def accelerate(v, spin, n, body, out):
    """Acceleration of a sphere [m/s2] into out; n: numbers of all laws, body: mass, radius, gravity, density of the fluid."""
    rate, drag, buoyant, added, flow_x, flow_y, flow_z, magnus, _, tilt_x, tilt_y = n[:11]
    mass, radius, g, density = body[0] * (1 + n[16]), body[1] * (1 + n[17]), body[2], body[3]
    volume, gx, gy = 4 / 3 * np.pi * radius**3, -g * np.sin(tilt_y), g * np.sin(tilt_x)
    gz = -np.sqrt(max(g * g - gx * gx - gy * gy, 0.0))
    x, y, z = v[0] - flow_x, v[1] - flow_y, v[2] - flow_z
    k = 0.5 * density * drag * np.pi * radius**2 * np.sqrt(x * x + y * y + z * z) + mass * rate
    lift, weight = magnus * np.pi * density * radius**3, mass - buoyant * volume
    inertia = mass + added * density * volume
    out[0] = (weight * gx - k * x + lift * (spin[1] * z - spin[2] * y)) / inertia
    out[1] = (weight * gy - k * y + lift * (spin[2] * x - spin[0] * z)) / inertia
    out[2] = (weight * gz - k * z + lift * (spin[0] * y - spin[1] * x)) / inertia


@njit(cache=True)
def fly(times, place, velocity, spin, n, body):
    """Positions (k, 3) at the rising times [s] after the release at 0: Runge-Kutta of fourth order, cubics between the steps."""
    out, now, x, v, u, w = np.empty((len(times), 3)), 0.0, place.copy(), velocity.copy(), np.empty(3), np.empty(3)
    slopes, i, h = np.empty((4, 3)), 0, STEP
    while i < len(times):
        for stage, part in enumerate((0.0, 0.5, 0.5, 1.0)):
            slower = np.exp(-n[8] * (now + part * h))
            for j in range(3):
                u[j], w[j] = v[j] + (part * h * slopes[stage - 1, j] if stage else 0.0), spin[j] * slower
            accelerate(u, w, n, body, slopes[stage])
        first = i
        for j in range(3):
            way = h * v[j] + h * h / 6 * (slopes[0, j] + slopes[1, j] + slopes[2, j])
            faster = h / 6 * (slopes[0, j] + 2 * slopes[1, j] + 2 * slopes[2, j] + slopes[3, j])
            i = first
            while i < len(times) and times[i] <= now + h:
                s = (times[i] - now) / h
                out[i, j] = x[j] + s * s * (3 - 2 * s) * way + h * s * (1 - s) * ((1 - s) * v[j] - s * (v[j] + faster))
                i += 1
            x[j], v[j] = x[j] + way, v[j] + faster
        now += h
    return out


@dataclass
class Recording:
    """One trial as its files give it. seen: place [m] and, where it is recorded, the angle turned about the axis [rad]; start:
    position, velocity, angle, rate of spin; free: which of them are unknown."""

    times: np.ndarray
    seen: np.ndarray
    axis: np.ndarray
    body: np.ndarray
    group: str
    start: np.ndarray
    free: np.ndarray

    def misses(self, n, start):
        """What the model misses, shaped as seen."""
        times = np.maximum(self.times * n[TIME] - n[CLOCK], 0.0)
        frame = Rotation.from_euler("xy", n[FRAME : FRAME + 2]).as_matrix() if n[FRAME : FRAME + 2].any() else np.eye(3)
        spin = start[7] * (self.axis @ frame)
        model = n[LENGTH] * fly(times, start[:3], start[3:6], spin, n, self.body) @ frame.T
        if self.seen.shape[1] == 4:
            lasted = times if n[SPIN] == 0 else -np.expm1(-n[SPIN] * times) / n[SPIN]
            model = np.column_stack([model, start[6] + start[7] * lasted])
        return self.seen - model


def turned(frame):
    """(steps of turning (k - 1, 3) rad between the readings) of a table with quaternions."""
    turn = Rotation.from_quat(frame[["qx", "qy", "qz", "qw"]].to_numpy())
    return (turn[1:] * turn[:-1].inv()).as_rotvec()


def read_recording(folder, trial, common):
    frame = pd.read_csv(folder / trial["file"]).dropna(subset=["t_s", "x_m", "y_m", "z_m"])
    settings = {**common, **{key: value for key, value in trial.items() if key not in ("file", "group", "start")}}
    body = np.array([settings["mass"], settings["radius"], settings.get("gravity", 9.81), settings.get("fluid_density", 1.2)])
    times, seen = frame["t_s"].to_numpy(), frame[["x_m", "y_m", "z_m"]].to_numpy()
    known, start, free, axis = trial.get("start", {}), np.zeros(8), np.arange(8) < 6, np.array([0.0, 0.0, 1.0])
    start[:3], reach = seen[0], min(len(times) - 1, 5)
    start[3:6] = (seen[reach] - seen[0]) / times[reach] + 0.5 * times[reach] * np.array([0, 0, body[2]])
    for key, first in (("position", 0), ("velocity", 3)):
        if key in known:
            start[first : first + 3], free[first : first + 3] = known[key], False
    if "qw" in frame:  # a sphere turns about one axis: the mean of the steps, of which noise takes little
        steps = turned(frame)
        axis = steps.sum(axis=0) / np.linalg.norm(steps.sum(axis=0))
        seen = np.column_stack([seen, np.r_[0.0, np.cumsum(steps @ axis)]])
        start[7], free[6:] = seen[-1, 3] / times[-1], True
    return Recording(times, seen, axis, body, trial.get("group", trial["file"]), start, free)


class Case:
    """An experiment folder with recordings of a sphere off the ground: its data, its noise, and fits of laws to it."""

    def __init__(self, folder):
        file = tomllib.loads((folder / "experiment.toml").read_text(encoding="utf-8"))
        self.null = NULL.copy()
        self.given = {entry["name"]: entry for entry in file.get("model", {}).get("effects", [])}
        for i, (law, number) in enumerate(NUMBERS):
            self.null[i] = self.given.get(law, {}).get(number, NULL[i])
        header = (folder / file["trial"][0]["file"]).read_text(encoding="utf-8").splitlines()[0]
        common = {**file["body"], **file.get("surroundings", {})}
        self.recordings = [read_recording(folder, trial, common) for trial in file["trial"]]
        self.noise(folder, file.get("measurement", {}))
        known = any(not recording.free[3] for recording in self.recordings)
        left_out = (
            set(self.given) | (set() if "qw" in header else {"magnus", "spin_decay"}) | (set() if known else {"clock_offset"})
        )
        self.laws = [law for law in LAWS if law not in left_out]

    def noise(self, folder, measurement):
        """sigma (m, rad), correlation of successive readings, and how many static readings told them (0 = stated or guessed)."""
        self.known, self.static = "static" in measurement or "noise" in measurement, 0
        if "static" in measurement:
            frame = pd.read_csv(folder / measurement["static"])
            still = frame[["x_m", "y_m", "z_m"]].to_numpy()
            still, self.static = still - still.mean(axis=0), still.size
            self.rho = float((still[1:] * still[:-1]).sum() / (still**2).sum())
            self.sigma = np.full(4, still.std())
            if "qw" in frame:
                angles = np.cumsum(turned(frame), axis=0)
                self.sigma[3] = (angles - angles.mean(axis=0)).std()
            return
        left, numbers = [], 7  # what a smooth curve (degree 6) leaves of every recording; it takes up correlation, given back
        for one in self.recordings:
            basis = np.linalg.qr(np.vander(one.times / one.times[-1], numbers))[0]
            left.append(one.seen[:, :3] - basis @ (basis.T @ one.seen[:, :3]))
        count, whole = sum(len(one) for one in left), sum((one**2).sum() for one in left)
        self.rho = sum((one[1:] * one[:-1]).sum() for one in left) / whole + numbers * len(left) / count
        guess = np.sqrt(whole / (3 * (count - numbers * len(left))))
        stated = measurement.get("noise", {})
        self.sigma = np.r_[np.full(3, stated.get("position", guess)), stated.get("orientation", 0.01)]

    def residual(self, one, n, start, rho):
        """Misses of one recording in sigmas, whitened."""
        miss = one.misses(n, start) / self.sigma[: one.seen.shape[1]]
        return np.concatenate([miss[:1], (miss[1:] - rho * miss[:-1]) / np.sqrt(1 - rho**2)]).ravel()

    def fit(self, names, numbers, starts, rho):
        """(chi2, values, their standard deviations, starts): starts are fitted afresh for all numbers that are tried."""
        which = [i for i, (law, _) in enumerate(NUMBERS) if law in names]
        starts, hold = [start.copy() for start in starts], {}

        def numbers_of(values):
            n = self.null.copy()
            n[which] = values
            if not (0.5 < n[TIME] < 2 and 0.5 < n[LENGTH] < 2):
                raise ValueError("a clock or a ruler wrong by a factor of two")
            return n

        def linearise(values):
            n = numbers_of(values)
            for k, one in enumerate(self.recordings):
                rest = self.residual(one, n, starts[k], rho)
                moved = [self.residual(one, n, starts[k] + 1e-5 * way, rho) for way in np.eye(8)[one.free]]
                slope = (np.array(moved) - rest).T / 1e-5
                hold[k] = slope, np.linalg.solve(slope.T @ slope, slope.T)

        def left(values):
            n, rest = numbers_of(values), []
            for k, one in enumerate(self.recordings):
                slope, inverse = hold[k]
                for _ in range(10):
                    miss = self.residual(one, n, starts[k], rho)
                    shift = inverse @ miss
                    if miss @ (slope @ shift) < 1e-4:  # of chi2
                        break
                    starts[k][one.free] -= shift
                rest.append(miss)
            return np.concatenate(rest)

        def jacobian(values):
            linearise(values)
            columns = []
            for k, one in enumerate(self.recordings):
                rest = self.residual(one, numbers_of(values), starts[k], rho)
                moved = [self.residual(one, numbers_of(values + way), starts[k], rho) for way in 1e-5 * np.eye(len(which))]
                slope = (np.array(moved) - rest).T / 1e-5
                columns.append(slope - hold[k][0] @ (hold[k][1] @ slope))
            return np.concatenate(columns)

        values = np.array(numbers, float)
        for _ in range(6 if not which else 1):
            linearise(values)
            rest = left(values)
        if not which:
            return rest @ rest, values, values, starts
        found = least_squares(left, values, jacobian, method="lm", x_scale="jac", ftol=1e-6, xtol=1e-6, max_nfev=12)
        deviation = np.sqrt(np.diag(np.linalg.pinv(found.jac.T @ found.jac)))
        return 2 * found.cost, found.x, deviation, starts

    def fits(self, rho, begun=None):
        """{set of laws: fit}: none, every law alone, every pair; a pair begins at its better law, or all where others ended."""
        begun = begun or {}
        base = self.fit((), (), begun[()][3] if begun else [one.start for one in self.recordings], rho)
        pool = {(): base}
        for names in [(law,) for law in self.laws] + list(combinations(self.laws, 2)):
            if "uniform_flow" in names and not {*names, *self.given} & {*DRAGS}:
                continue
            near = min([()] + [(law,) for law in names if (law,) in pool and len(names) > 1], key=lambda one: pool[one][0])
            already = dict(zip([key for key in NUMBERS if key[0] in near], pool[near][1], strict=True))
            begin = [already.get(key, self.null[i]) for i, key in enumerate(NUMBERS) if key[0] in names]
            _, begin, _, starts = begun.get(names, (0, begin, 0, pool[near][3]))
            try:
                fit = self.fit(names, begin, starts, rho)
            except (ValueError, np.linalg.LinAlgError):  # ran away: this set describes nothing
                continue
            laws = [law for law, _ in NUMBERS if law in names]
            if all(value >= -2 * spread for law, value, spread in zip(laws, *fit[1:3], strict=True) if law in POSITIVE):
                pool[names] = fit
        return pool

    def verdict(self, pool, price, ties):
        """What the script says, in the words of `hlcs diagnose --json`."""
        rows = sum(len(self.residual(one, self.null, one.start, 0.0)) for one in self.recordings)
        unknown = sum(one.free.sum() for one in self.recordings)
        cost = {names: rows * np.log(fit[0] / rows) + len(fit[1]) * price(rows) for names, fit in pool.items()}
        cost = {names: value if np.isfinite(value) else np.inf for names, value in cost.items()}  # of a fit that ran away
        within = [names for names in cost if cost[names] <= min(cost.values()) + (TIES if ties else 0.0)]
        within = [names for names in within if not any(set(other) < set(names) for other in within)]  # idle additions
        within.sort(key=cost.get)
        best = within[0]

        def adequate(names):
            free = rows - unknown - len(pool[names][1])
            return bool(stats.f.sf(pool[names][0] / free, free, self.static or 1e9) >= REFUSED) if self.known else True

        word = "unexplained" if not adequate(best) else "complete" if not best else "effect" if len(within) == 1 else "ambiguous"
        numbers = {law: {} for law in best}
        for (law, number), value, spread in zip([key for key in NUMBERS if key[0] in best], *pool[best][1:3], strict=True):
            numbers[law][number] = {"value": value, "low": value - 1.645 * spread, "high": value + 1.645 * spread}
        return {
            "verdict": word,
            "effects": list(best),
            "ambiguous": [sorted({law for names in within for law in names})] if len(within) > 1 and best else [],
            "parameters": numbers,
            "adequate": {"before": adequate(()), "after": adequate(best)},
        }


def plain_script(case):
    """{variant: (verdict, CPU seconds)}."""
    said, pool = {}, {}
    for white in (True, False):
        began = time.process_time()
        pool = case.fits(case.rho if white else 0.0, pool)
        seconds = time.process_time() - began
        for name, (wants, price, ties) in VARIANTS.items():
            if wants == white:
                said[name] = case.verdict(pool, price, ties), seconds
    return said


def sindy(case):
    """(verdict, CPU seconds) of pysindy: library {1, v, v |v|, h, v^3}, its smoothed differences twice, its thresholded least
    squares; the threshold that predicts held-out groups best. The weak form is left out: it wants one grid of times for all
    recordings. What is selected is translated: a constant is effective gravity or a tilt, v across is Magnus where it spins."""
    began, data = time.process_time(), []
    warnings.filterwarnings("ignore", message="Sparsity parameter is too big")  # such thresholds are tried on purpose
    for one in case.recordings:
        window = min(max(11, int(0.15 * len(one.times) / one.times[-1]) // 2 * 2 + 1), (len(one.times) - 1) // 2 * 2 + 1)
        difference = pysindy.SmoothedFiniteDifference(smoother_kws={"window_length": window, "polyorder": 3})
        place, model = one.seen[:, :3], np.empty((len(one.times), 3))
        v = np.asarray(difference._differentiate(place, one.times))
        for row, into in zip(v, model, strict=True):
            accelerate(row, one.start[7] * one.axis, case.null, one.body, into)
        left = np.asarray(difference._differentiate(v, one.times)) - model
        speed = np.linalg.norm(v, axis=1, keepdims=True)
        data.append((v, one.times, left, np.column_stack([speed * v, place[:, 2], v**3]), one.group))
    groups = sorted({one[4] for one in data})
    size = np.sqrt(sum((one[2] ** 2).sum() for one in data))

    def learn(threshold, some):
        model = pysindy.SINDy(pysindy.STLSQ(threshold * size, normalize_columns=True), pysindy.PolynomialLibrary(degree=1))
        v, times, left, inputs, _ = (list(part) for part in zip(*some, strict=True))
        return model.fit(v, t=times, x_dot=left, u=inputs)

    def missed(threshold):
        total = 0.0
        for group in groups if len(groups) > 1 else []:
            model = learn(threshold, [one for one in data if one[4] != group])
            total += sum(((one[2] - model.predict(one[0], u=one[3])) ** 2).sum() for one in data if one[4] == group)
        return total

    chosen = np.abs(learn(min(np.geomspace(1.0, 0.003, 9), key=missed), data).coefficients()) > 0
    across, along = ~np.eye(3, dtype=bool), np.eye(3, dtype=bool)
    spins = "magnus" in case.laws
    parts = {
        "effective_gravity": chosen[2, 0],
        "tilt": chosen[:2, 0].any(),
        "linear_drag": chosen[:, 1:4][along].any(),
        "magnus" if spins else "cross_coupling": chosen[:, 1:4][across].any() or chosen[:, 4:7][across].any(),
        "quadratic_drag": chosen[:, 4:7][along].any(),
        "height_force": chosen[:, 7].any(),
        "cubic_drag": chosen[:, 8:].any(),
    }
    names = [name for name, there in parts.items() if there]
    vague = [name for name in names if name in ("effective_gravity", "tilt")]
    word = "complete" if not names else "ambiguous" if vague else "effect"
    return {"verdict": word, "effects": names, "ambiguous": [[name] for name in vague]}, time.process_time() - began


def judge(cases, verdicts=None, first=None, quiet=False):
    """{peer: {case: verdict with "seconds"}} and the answers of the cases that were judged."""
    answers = json.loads((Path(cases) / "answers.json").read_text(encoding="utf-8"))["cases"]
    chosen = {n: a for n, a in answers.items() if a["family"] in FAMILIES and a["kind_of_data"] == "trajectory"}
    chosen = dict(list(chosen.items())[:first])
    said = {}
    for name, answer in chosen.items():
        case = Case(Path(cases) / "cases" / name)
        if not said:
            case.fits(0.0)  # compiles
        told = plain_script(case)
        if pysindy is not None:
            told["pysindy"] = sindy(case)
        for peer, (verdict, seconds) in told.items():
            said.setdefault(peer, {})[name] = {**verdict, "seconds": round(seconds, 2)}
        if not quiet:
            hidden = " + ".join(answer["effects"]) or "-"
            print(f"{name} {hidden}: " + "; ".join(f"{peer}: {v['verdict']} {v['effects']}" for peer, (v, _) in told.items()))
    if verdicts:
        files = {name: Path(verdicts) / f"{name}.json" for name in next(iter(said.values()))}
        ours = {name: json.loads(file.read_text(encoding="utf-8")) for name, file in files.items() if file.exists()}
        said = {"hlcs": ours, **said}
    return said, chosen


def table(said, answers):
    """{row: {peer: cell}} in the rows of score.py that apply, with CPU seconds and the size of what is reported."""
    rows = {}
    for peer, verdicts in said.items():
        missing = {"verdict": "missing", "effects": [], "ambiguous": []}
        pairs = [(answer, {**missing, **verdicts.get(name, {})}) for name, answer in answers.items()]
        for figure in score.figures(pairs):
            if figure.count:
                share = f"{figure.value:.2f}" if figure.hits is None else f"{figure.hits}/{figure.count}"
                rows.setdefault(figure.name, {})[peer] = share
        sizes = [len(score.reported(verdict)) for _, verdict in pairs if score.found(verdict)]
        seconds = [verdict["seconds"] for _, verdict in pairs if "seconds" in verdict] or [np.nan]
        rows.setdefault("names in a report with an effect, median", {})[peer] = f"{np.median(sizes or [0]):g}"
        rows.setdefault("seconds a case (CPU; ours by the clock): median, worst", {})[peer] = (
            f"{np.median(seconds):.1f}, {max(seconds):.1f}"
        )
    return rows


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", required=True)
    parser.add_argument("--verdicts", help="folder of our verdicts, for a first column of ours")
    parser.add_argument("--first", type=int, help="the first so many of the cases that apply only")
    parser.add_argument("--out", help="JSON with every verdict and the table")
    parser.add_argument("--markdown", action="store_true", help="print the table as Markdown")
    given = parser.parse_args(arguments)
    said, answers = judge(given.cases, given.verdicts, given.first, given.markdown)
    told = {"format": 1, "cases": len(answers), "rows": table(said, answers), "verdicts": said}
    if given.out:
        Path(given.out).write_text(json.dumps(told, indent=1), encoding="utf-8")
    print(score.peers_table(told) if given.markdown else pd.DataFrame(told["rows"]).T.to_string())
    if pysindy is None:
        print("pysindy is not installed (pip install pysindy): its column is left out")


if __name__ == "__main__":
    main()
