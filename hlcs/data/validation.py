"""Can these numbers be what they say they are? Units, axes, static recordings, copies; what is odd but usable.

What no body does is refused by file and column; what is merely odd is described in sentences. Nothing is known here of
effects: only gravity, the floor and the size of the body as the file states them.
"""

import warnings

import numpy as np

from hlcs.data.apparent_acceleration import acceleration, of_a_parabola
from hlcs.data.free_falls import TOO_FAST, TWICE, question, remedy
from hlcs.data.rigid_body import known_body, rigid_body
from hlcs.data.rounded_readings import reading_step
from hlcs.files.limits import MOST_STEPS
from minibullet.errors import InputError, InputWarning, how_many

UPWARDS = 'z points up, turn its sign; or, where each row is a fall of its own, it is a table: kind = "outcomes", fall_time_s'
SLOW_CAMERA = 0.2  # nobody films a fall with fewer pictures: a longer typical step is not in seconds [s]
SLOW_CLOCK = 1.0  # the same of what moves on a floor, where nothing falls [s]
SAME = 1e-6  # part of the longest step by which the steps of a copy may differ: its digits were rounded again
LEAST = 8  # samples of which one parabola tells how far its curvature is off
LEANS = 0.2  # angle of a camera to its floor beyond which axes are taken for mixed up [rad]
ALOFT = 5.0  # times as long as a throw of that height can last


def check_duration(trials, file):
    """InputError where recordings are longer than can be computed in steps of the experiment file's size."""
    step = file.time_step
    seconds = sum(float(trial.times[-1] - trial.times[0]) for trial in trials)
    if seconds / step > MOST_STEPS:
        raise InputError(
            f"{file.path}: model.time_step = {step:g} s: the recordings last {seconds:.4g} s, which is "
            f"{seconds / step:.3g} steps; at most {MOST_STEPS:.0e} are computed: take time_step >= "
            f"{seconds / MOST_STEPS:.2g} s, or cut them"
        )


def check_units(trial, path):
    """Refuse what no dropped, thrown or rolling body does: wrong units of length or time."""
    duration = trial.times[-1] - trial.times[0]
    floor, gravity = trial.surroundings.floor_height, trial.surroundings.gravity
    vertical = acceleration(trial, 2)
    there = np.isfinite(trial.position[:, 2])
    if vertical and np.isinf(vertical[1]) and there.sum() >= LEAST:  # an impact among few samples makes a fall no faster
        vertical = of_a_parabola(trial.times[there], trial.position[there, 2])
    falls = -vertical[0] / gravity if gravity > 1 and vertical else 0.0  # times as fast as freely
    for axis, name in enumerate("xyz"):
        there = np.isfinite(trial.position[:, axis])
        if there.sum() < 4:
            continue
        t, z = trial.times[there], trial.position[there, axis]
        speed = np.median(np.abs(np.diff(z) / np.diff(t)))
        if speed > 400.0 or np.ptp(z) > 2000.0:
            raise InputError(
                f"{path}, column {name}_m: typical speed {speed:.3g} m/s over {np.ptp(z):.3g} m; "
                f"units that cannot be right: {remedy(falls, 1.0)}"
            )
    if gravity > 1 and vertical:
        a, error = vertical
        if a + (4 * error if floor is not None else 0.0) < -6 * gravity:
            raise InputError(
                f"{path}, column z_m: apparent acceleration {-a:.3g} m/s2 in free flight; units that cannot be right: "
                f"{remedy(falls)}"
            )
        if a + 4 * error < -TOO_FAST * gravity and "angular_velocity" not in trial.start:  # topspin pulls a ball down
            told = f"{path}, column z_m: a fall of {-a:.3g} m/s2 where gravity is {gravity:.3g} m/s2; {question(falls)}"
            warnings.warn(told, InputWarning, stacklevel=2)
        if floor is None and duration > 120 and not trial.surroundings.in_liquid:
            raise InputError(
                f"{path}, column t_s: free flight of {duration:.4g} s; units that cannot be right: times in s{_clock_seen(trial)}"
            )


def check_steps(trial, path):
    """Warn of samples that are far apart in time where no height is recorded, by which a fall would tell its clock."""
    step = float(np.median(np.diff(trial.times)))
    if step < SLOW_CLOCK or trial.surroundings.in_liquid or np.isfinite(trial.position[:, 2]).sum() >= 4:
        return
    told = f"{path}, column t_s: {step:.3g} s from one sample to the next; times are in s{_clock_seen(trial)}"
    warnings.warn(told, InputWarning, stacklevel=2)


def check_clock(trial, path):
    """Refuse times that are not seconds (frames, milliseconds): a body that stays in the air far longer than its height allows.

    A throw that rises by h lasts at most 2 sqrt(2 h / g); h from the range of the heights, or from the floor where there is one.
    """
    around = trial.surroundings
    there = np.isfinite(trial.position[:, 2])
    step = float(np.median(np.diff(trial.times)))
    if not around.gravity > 1 or around.in_liquid or there.sum() < 4 or step < SLOW_CAMERA:
        return
    t, z = trial.times[there], trial.position[there, 2]
    radius = inner_radius(trial.body)
    if around.floor_height is None:
        aloft, base = np.ones(len(t), bool), float(z.min())
    elif radius is not None and around.floor_normal[2] > 0.99:
        base = around.floor_height + radius
        aloft = z > base + radius  # clear of the floor whatever its attitude
    else:
        return
    longest, height = 0.0, 0.0
    for part in np.split(np.arange(len(t)), np.flatnonzero(np.diff(aloft.astype(int))) + 1):
        if aloft[part[0]] and t[part[-1]] - t[part[0]] > longest and np.ptp(z[part]) > 0.02 * max(z.max() - base, 1e-9):
            longest, height = float(t[part[-1]] - t[part[0]]), float(z[part].max() - base)
    if longest > ALOFT * 2 * np.sqrt(2 * height / around.gravity):
        raise InputError(
            f"{path}, column t_s: {longest:.4g} s in the air within {height:.3g} m, where {around.gravity:.3g} m/s2 "
            f"allows {2 * np.sqrt(2 * height / around.gravity):.2g} s; units that cannot be right: times in s{_clock_seen(trial)}"
        )


def _clock_seen(trial):
    """What times that are not seconds look like, the end of a sentence: counts of pictures, or what gravity shows as the clock.

    A free fall of g seconds^-2 reads g/n^2 where n units of time are one second.
    """
    vertical = acceleration(trial, 2)
    falls = vertical is not None and np.isfinite(vertical[1]) and vertical[0] < -4 * vertical[1]
    rate = float(np.sqrt(trial.surroundings.gravity / -vertical[0])) if falls else None
    counted = bool(np.all(trial.times == np.round(trial.times))) and np.median(np.diff(trial.times)) == 1
    if counted:
        about = f" (about {rate:.2g} a second, by the fall)" if rate else ""
        return f": these look like frame numbers, divide them by the frame rate{about}"
    if rate and 1 / TWICE < rate / 1000 < TWICE:
        return ": these look like milliseconds, divide them by 1000"
    about = f"; by the fall about {rate:.2g} of them are one second" if rate else ""
    return f"{about}; divide frame numbers by the frame rate, milliseconds by 1000"


def check_plane(trial, path):
    """Refuse a height in a recording of motion in a plane, and one without a position in it; then what else may be wrong."""
    if np.isfinite(trial.position[:, 2]).any():
        raise InputError(f"{path}, column z_m: a height, where measurement.planar = true; leave out the column, or planar")
    if not np.isfinite(trial.position[:, :2]).any():
        raise InputError(f"{path}: measurement.planar = true, but neither x_m nor y_m is recorded")
    for check in (check_units, check_length, check_quaternions):
        check(trial, path)


def check_axes(trial, path):
    """Refuse a fall along another axis than z, or upwards: columns mixed up, or z counted downwards."""
    gravity = trial.surroundings.gravity
    if not gravity > 1:
        return
    if trial.surroundings.in_liquid:
        _check_sinking(trial, path)
        return
    seen = {name: known for axis, name in enumerate("xyz") if (known := acceleration(trial, axis))}
    if "z" not in seen:
        _check_unseen_fall(trial, path, seen)
        return
    recorded = [column[np.isfinite(column)] for column in trial.position.T]
    if trial.surroundings.floor_height is None and not any(np.ptp(column) for column in recorded if len(column)):
        warnings.warn(
            f"{path}: no position changes in {len(trial.times)} samples, and no floor holds the body; is it at rest on a "
            "floor (surroundings.floor.height), recorded to tell the noise (measurement.static), or was the tracker frozen?",
            InputWarning,
            stacklevel=2,
        )
    a, error = seen["z"]
    if 0.5 * gravity < a - 4 * error and a < 1.5 * gravity:
        raise InputError(f"{path}, column z_m: falls upwards (apparent acceleration {a:+.3g} m/s2); {UPWARDS}")
    for name in ("x", "y"):
        if name in seen and abs(a) + 4 * error < 0.25 * gravity:
            b, other = seen[name]
            if 4 * other < 0.25 * gravity and abs(abs(b) - gravity) < 0.25 * gravity:
                raise InputError(
                    f"{path}: falls along {name}_m (apparent acceleration {b:+.3g} m/s2, along z_m {a:+.3g}); z points up: "
                    f"are the columns {name}_m and z_m mixed up? Where {name}_m points up in your program, it is z_m, and "
                    f"-z_m is {name}_m (hlcs import --up {name})"
                )


def _check_unseen_fall(trial, path, seen):
    """Warn where nothing holds a body whose height is not recorded: it falls, and what moves on a floor is another motion."""
    if not seen or trial.surroundings.floor_height is not None or np.isfinite(trial.position[:, 2]).any():
        return
    way = trial.surroundings.gravity / 2 * (took := trial.times[-1] - trial.times[0]) ** 2
    warnings.warn(
        f"{path}: no column z_m and no floor: the body is taken to fall freely, {way:.3g} m in {took:.3g} s; where it moves "
        f"on a floor or a slope state surroundings.floor, where {next(iter(seen))}_m is its height name it z_m",
        InputWarning,
        stacklevel=2,
    )


def _check_sinking(trial, path):
    """Warn where a body goes the way that its weight in the liquid does not: z counted downwards, or a wrong mass or size.

    Against its weight less the lift it slows down, at the least as if it carried along as much liquid as it displaces.
    """
    vertical = acceleration(trial, 2)
    if vertical is None or not known_body(trial.body) or trial.surroundings.floor_height is not None:
        return
    body, (a, error) = rigid_body(trial.body), vertical
    displaced = trial.surroundings.fluid_density * body.volume
    pull = -trial.surroundings.gravity * (body.mass - displaced) / (body.mass + displaced)
    there = np.isfinite(trial.position[:, 2])
    z = trial.position[there, 2]
    if (z[-1] - z[0]) * pull < 0 and a * np.sign(pull) + 4 * error < abs(pull) / 2:
        does, denser = ("rises", "denser") if pull < 0 else ("sinks", "less dense")
        warnings.warn(
            f"{path}, column z_m: {does}, and does not slow down, though mass and size make the body {denser} than the fluid of "
            f"{trial.surroundings.fluid_density:.4g} kg/m3; z points up: turn its sign where depths are counted (hlcs import "
            "--up -z), else check mass and size",
            InputWarning,
            stacklevel=2,
        )


def inner_radius(body):
    """Least distance of the surface of a body from its centre [m], None where the size is not stated or a mesh."""
    if body.shape == "sphere":
        return body.radius
    if body.shape == "box":
        return None if body.size is None else min(body.size) / 2
    if body.shape in ("disc", "cylinder", "cone"):
        low = None if body.height is None else body.height / (4 if body.shape == "cone" else 2)  # of the base of a cone
        return None if None in (low, body.radius) else min(low, body.radius / (2 if body.shape == "cone" else 1))
    return body.side / 2 if body.shape == "cubipod" and body.side else None


def check_floor(trial, path):
    """Refuse a body that runs below its floor; a sentence where its centre comes nearer than its size allows."""
    around, radius = trial.surroundings, inner_radius(trial.body)
    normal = around.normal
    used = np.abs(normal) > 1e-9
    there = np.isfinite(trial.position[:, used]).all(axis=1)
    if around.floor_height is None or radius is None or there.sum() < 4:
        return []
    position = np.nan_to_num(trial.position[there])
    lift = position @ normal - around.floor_height
    way = position - position[0]  # along it a camera that leans shows the floor rise or fall
    aside = np.linalg.norm(way - (way @ normal)[:, None] * normal, axis=1)
    if np.median(lift + LEANS * aside) < -radius:
        row = trial.rows[there][np.argmin(lift)]
        raise InputError(
            f"{path}, row {row}: the centre of the body is {-lift.min():.3g} m below its floor, most samples are; "
            "check floor.height and the zero of the positions"
        )
    low = float(np.quantile(lift, 0.05))
    scatter = float(np.std(np.diff(lift, 3))) / np.sqrt(20) if len(lift) > 8 else 0.0
    if low < 0.6 * radius - 4 * scatter:
        return [
            f"{path.name}: comes as near as {low:.3g} m to the floor, but the centre of this body cannot come nearer than "
            f"{radius:.3g} m: positions are of the centre; check floor.height and the zero of the positions"
        ]
    return []


def check_quaternions(trial, path):
    """Refuse orientations whose scalar stands last: against the stated start, or against the floor under a box.

    In free flight alone nothing tells: with the scalar in another place a steady turn is still a steady turn. A box that keeps
    the same depth in its floor while it turns, or starts as stated, has its orientations right, its floor or centre elsewhere.
    """
    there = np.flatnonzero(np.isfinite(trial.orientation[:, 0]))
    if len(there) == 0:
        return
    given = trial.orientation[there]
    last = given[:, [3, 0, 1, 2]]
    around, body, wrong, agree = trial.surroundings, trial.body, False, False
    if "orientation" in trial.start:
        stated = np.asarray(trial.start["orientation"]) / np.linalg.norm(trial.start["orientation"])
        near, far = (2 * np.arccos(min(1.0, abs(float(q[0] @ stated)))) for q in (last, given))
        wrong, agree = far > 1.0 and near < 0.2, far < near
    if around.floor_height is not None and body.shape == "box" and body.size and np.isfinite(trial.position[there]).all():
        lift = around.above_floor(trial.position[there])
        depths = [extent_of_box(q, body.size, around.floor_normal) - lift for q in (given, last)]
        (low, sinks), (low_last, sinks_last) = (np.quantile(depth, (0.25, 0.75)) for depth in depths)
        even = sinks - low < 0.5 * (sinks_last - low_last)
        wrong |= sinks > 0.2 * min(body.size) and sinks_last < 0.05 * min(body.size) and not (even or agree)
    if wrong:
        raise InputError(
            f"{path}, columns qw..qz: only with the scalar last do these orientations agree with the start or the "
            "floor; quaternions are scalar first: qw, qx, qy, qz"
        )


def extent_of_box(orientations, size, normal):
    """How far a box of that size reaches from its centre against a normal, for orientations (n, 4): (n,) [m]."""
    w, v = orientations[:, :1], -orientations[:, 1:]  # the normal in body axes
    normal = np.broadcast_to(np.asarray(normal, dtype=float), v.shape)
    turned = normal + 2 * np.cross(v, np.cross(v, normal) + w * normal)
    return np.abs(turned) @ (np.asarray(size) / 2)


def check_length(trial, path):
    """Refuse a recording with fewer samples in a channel than its unknown start has numbers."""
    for axis, name in enumerate("xyz"):
        count = int(np.isfinite(trial.position[:, axis]).sum())
        free = 2 - ("position" in trial.start) - ("velocity" in trial.start)
        if 0 < count < free + 2:
            raise InputError(
                f"{path}, column {name}_m: {how_many(count, 'sample')}; {free + 2} are needed: {free} for the start, 2 to judge"
            )
    for axis, name in enumerate("xyz" if trial.unplaced else ""):
        count, needed = int(np.isfinite(trial.accelerations.values[:, axis]).sum()), 3 - ("velocity" in trial.start)
        if 0 < count < needed:
            raise InputError(
                f"{path}, column a{name}_m_s2: {how_many(count, 'sample')}; {needed} are needed "
                f"({needed - 2} for the start and 2 to judge by)"
            )
    if not trial.columns:
        raise InputError(f"{path}: no sample at all in any column but t_s")


def check_at_rest(trial, path):
    """Refuse a static recording that moves: its halves must agree within their scatter about a straight line; phrases on columns
    that drift by less, a list."""
    drifts = []
    for name, values, unit in _readings(trial):
        there = np.isfinite(values)
        t, z = trial.times[there], values[there]
        if len(z) >= 20:
            half = len(z) // 2
            scatter = max(
                *(
                    np.std(part - np.polyval(np.polyfit(when, part, 1), when))
                    for when, part in ((t[:half] - t[0], z[:half]), (t[half:] - t[half], z[half:]))
                ),
                1e-12,
            )
            moved = abs(np.median(z[half:]) - np.median(z[:half]))
            if moved > 6 * scatter:
                raise InputError(
                    f"{path}, column {name}: moves by {moved:.3g} {unit}; a static recording must show a body at rest"
                )
            if moved > 2 * scatter:
                drifts.append(f"column {name}: drifts by {moved:.3g} {unit}, {moved / scatter:.2g} times its scatter")
    return drifts


def _readings(trial):
    """(column, values (n,), unit) of every coordinate and of every axis of an accelerometer."""
    found = [(f"{name}_m", trial.position[:, axis], "m") for axis, name in enumerate("xyz")]
    if trial.accelerations:
        found += [(f"a{name}_m_s2", trial.accelerations.values[:, axis], "m/s2") for axis, name in enumerate("xyz")]
    return found


def describe(trial, path):
    """What is odd but usable in a recording: dropped frames, jitter, quantisation, repeated samples; a list of sentences."""
    notes = []
    steps = np.diff(trial.times)
    typical = np.median(steps)
    gaps = np.flatnonzero(steps > 1.6 * typical)
    if len(gaps):
        where = trial.times[np.argmax(steps)]
        many = f"{len(gaps)} gaps, the longest" if len(gaps) > 1 else "1 gap,"
        notes.append(f"{path.name}: {many} {steps.max():.3g} s at t_s = {where:.4g} (typical step {typical:.3g} s)")
    jitter = np.std(steps[steps <= 1.6 * typical]) / typical
    if jitter > 0.005:
        notes.append(f"{path.name}: time steps jitter by {100 * jitter:.1f} % of {typical:.3g} s; true stamps are used")
    for name, z, unit in _readings(trial):
        missing = int(np.isnan(z).sum())
        if 0 < missing < len(z):
            notes.append(f"{path.name}, column {name}: {missing} of {len(z)} samples missing")
        z = z[np.isfinite(z)]
        step = reading_step(z) if len(np.unique(z)) <= 0.7 * len(z) else 0.0
        same = np.flatnonzero(np.diff(z) == 0)
        if step:
            notes.append(f"{path.name}, column {name}: readings are multiples of {step:.3g} {unit}")
        elif len(z) > 10 and np.ptp(z) > 0 and len(same) > 0.2 * len(z):
            notes.append(f"{path.name}, {name}: {len(same)} samples repeat the one before: a frozen tracker?")
    return notes


def _path(trial):
    """What tells a recording from others, (n, 3): its positions, or the readings of its accelerometer where it has none."""
    return trial.accelerations.values if trial.unplaced else trial.position


def refuse_copies(trials, paths):
    """Refuse a recording that stands twice, shifted or rotated copies included: copies leak from training into test.

    Copies move as far from sample to sample, so their whole ways are alike: only neighbours in a list sorted by it are compared.
    """
    seen = {}  # number of samples and which steps are known -> [(whole way, index, steps)]
    for index, trial in enumerate(trials):
        steps = np.linalg.norm(np.diff(_path(trial)[:, np.isfinite(_path(trial)).any(axis=0)], axis=0), axis=1)
        there = np.isfinite(steps)
        if there.sum() > 3 and np.ptp(steps[there]) > 0:
            seen.setdefault((len(steps), there.tobytes()), []).append((float(steps[there].sum()), index, steps[there]))
    for alike in seen.values():
        alike.sort(key=lambda entry: entry[:2])
        for place, (way, index, steps) in enumerate(alike):
            near = SAME * steps.max()
            for other_way, other, others in alike[place + 1 :]:
                if other_way - way > len(steps) * max(near, SAME * others.max()):
                    break
                first, second = sorted((index, other))
                if np.max(np.abs(steps - others)) < SAME * max(steps.max(), others.max()) and np.allclose(
                    np.diff(trials[first].times), np.diff(trials[second].times), rtol=SAME, atol=1e-9
                ):
                    same = np.allclose(_path(trials[first]), _path(trials[second]), rtol=0, atol=1e-9, equal_nan=True)
                    kind = "the same recording" if same else "a shifted or rotated copy"
                    raise InputError(f"{paths[second]}: {kind} as {paths[first].name}; copies may not stand as separate trials")
