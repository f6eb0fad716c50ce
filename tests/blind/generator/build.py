"""From a deal (family, what is hidden, how strong) to a case: files as a user writes them, and the answer to be sealed."""

from dataclasses import dataclass, replace

import numpy as np

from . import again
from .case import csv_text, toml_text
from .library import ALIASES, LIBRARY, plausible, possible
from .noise import REGIMES, Noise, frames, spoil, spoil_orientation
from .observe import FINE, axes_seen, film, holds
from .strength import NEAR, Lens, gentle, look_alikes, scaled

SIGMAS = {
    "flight": (1e-3, 8e-3),
    "sinking": (3e-4, 2e-3),
    "bounce": (8e-4, 5e-3),
    "slide": (5e-4, 3e-3),
    "roll": (3e-4, 2e-3),
    "topple": (3e-4, 1.5e-3),
    "stack": (2e-4, 8e-4),
}  # what trackers of such experiments reach [m]
WRONG = {
    "mass": 0.02,
    "size": 0.01,
    "tilt_x": 0.017,
    "tilt_y": 0.017,
}  # nominal inputs may be off by this much, or less (see gentle)
MISFIT = 3.0  # information that the departure from the textbook law and the wrong inputs may leave after the best textbook fit
NOTHING = 0.5  # information that what a fluid does beside the stated model may have
SHARE = 0.35  # an outside effect must keep this share of its information after the best single library law


class Redraw(Exception):
    """This draw cannot be made as dealt; draw again."""


@dataclass(frozen=True)
class Deal:
    """What is to be hidden. kind: null, single, clear (nothing imitates it), degenerate, nested, double, joint (two laws that
    hide each other), outside, mixed (a library law and an outside effect), placebo."""

    family: str
    kind: str
    names: tuple[str, ...]
    style: str
    strengths: tuple[float, ...]
    regime: str
    rate: int | None = None  # frames a second; None = drawn among those of the regime
    far: bool = False  # the first law has a number beyond its plausible range, up to twice its end


def trajectory(deal, room, rng, then=None):
    """One case of a trajectory family: ({file name: text}, answer). A placebo shuffles what is hidden between recordings;
    then = (design, number of tests): these are recorded too, after all others. Raises Redraw."""
    rate = deal.rate or int(rng.choice(REGIMES[deal.regime][2]))
    low, high = SIGMAS[deal.family]
    sigma = float(np.exp(rng.uniform(np.log(low), np.log(high))))
    noise = Noise.draw(rng, deal.regime, rate, sigma, float(rng.choice([0.005, 0.01, 0.02])))
    setup = room.setup(rng, lambda duration: frames(rng, noise, duration), deal.style, deal.names)
    if min(len(trial.times) for trial in setup.trials) < 8 or sum(len(trial.times) for trial in setup.trials) < 100:
        raise Redraw("too few frames")
    lens = Lens(setup, noise.position, noise.orientation, noise.rho)
    table = {**room.HIDDEN, **getattr(room, "EXTRA", {}), **room.OUTSIDE}
    hidden, amplitudes, lens, noise = draw_laws(deal, rng, lens, noise, table, SIGMAS[deal.family])
    limits = [float(np.clip(rng.normal(), -1.5, 1.5) / 1.5 * WRONG[key]) for key in setup.errors]
    errors = gentle(lens, setup.errors, limits)
    answer, _, fitted = judge(deal, lens, hidden, errors)
    answer["amplitudes"] = amplitudes
    acting = {**setup.base(), **answer["hidden_laws"]}
    films = [film(setup, trial, acting, errors, step=FINE) for trial in setup.trials]
    if not all(np.isfinite(position).all() for position, _ in films):
        raise Redraw("not finite")
    if not all(holds(setup, trial, acting, errors) for trial in setup.trials):
        raise Redraw("the motion is no longer the one that the file describes")
    if deal.kind == "placebo":
        plain = [film(setup, trial, setup.base(), step=FINE) for trial in setup.trials]
        films = shuffled(rng, films, plain, [trial.group for trial in setup.trials])
        answer.update(parameters={}, tied=[])
    later = rng.spawn(1)[0]  # the recordings made first stay as they were
    more = again.trials(setup, *then, lambda duration: frames(later, noise, duration)) if then else []
    stated = deal.regime == "outliers" and rng.random() < 0.5
    setup = replace(setup, model=written(lens))
    files, noisy = _files(
        rng, setup, noise, stated, films, more, [film(setup, trial, acting, errors, step=FINE) for trial in more]
    )
    answer.update(
        noise={"regime": deal.regime, "stated": stated, **noise.__dict__},
        nominal_errors=errors,
        oracle=_oracle(lens, noisy, fitted),
    )
    return files, answer


def scaled_or_resighted(lens, noise, make, strength, dial, trackers):
    """Amplitude of the wanted strength; where no user would believe it, the nearest believable one seen by another tracker."""
    start = np.sqrt(dial.low * dial.high)
    amplitude = scaled(lens, make, strength, start)
    if amplitude is not None and dial.low <= amplitude <= dial.high:
        return amplitude, lens, noise
    amplitude = dial.high if amplitude is None or amplitude > dial.high else dial.low
    factor = lens.strength(lens.signal(make(amplitude))) / strength
    low, high = trackers
    if not 0.3 * low <= noise.position * factor <= 3 * high:
        raise Redraw(f"no believable amplitude (factor {factor:.3g})")
    noise = replace(noise, position=noise.position * factor, orientation=float(np.clip(noise.orientation * factor, 1e-3, 0.05)))
    lens = replace(lens, sigma_position=noise.position, sigma_orientation=noise.orientation)
    amplitude = scaled(lens, make, strength, amplitude)
    if amplitude is None or not 0.5 * dial.low <= amplitude <= 1.1 * dial.high:
        raise Redraw("no believable amplitude")
    return amplitude, lens, noise


def draw_laws(deal, rng, lens, noise, dials, trackers):
    """({effect: parameters} of all that is hidden, {effect: amplitude}, lens and noise of a tracker that suits them)."""
    laws, amplitudes = [], []
    for name, strength in zip(deal.names, deal.strengths, strict=True):
        make = dials[name].draw(rng)
        if deal.far and not laws:
            amplitude = float(edge(make, name, lens.setup.inputs) * rng.uniform(1.02, 2.0))
            if not lens.strength(lens.signal(make(amplitude))) >= 1.2:
                raise Redraw("too weak a law for a far number")
        else:
            amplitude, lens, noise = scaled_or_resighted(lens, noise, make, strength, dials[name], trackers)
        laws.append(make)
        amplitudes.append(amplitude)
    return hidden_laws(laws, amplitudes), dict(zip(deal.names, amplitudes, strict=True)), lens, noise


def edge(make, name, inputs):
    """The amplitude at which a law leaves its plausible range."""
    if name not in LIBRARY or not plausible(name, make(1e-9)[name], inputs):
        raise Redraw(f"{name} has no plausible range to leave")
    low, high = 1e-9, 10.0
    if plausible(name, make(high)[name], inputs):
        raise Redraw(f"{name} never leaves its plausible range")
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if plausible(name, make(middle)[name], inputs) else (low, middle)
    return high


def written(lens):
    """The model under test as the file states it: without entries of the fluid that together move nothing (information below
    `NOTHING`); what moves the body by more must stand there, or the file would contradict itself."""
    kept = list(lens.setup.model)
    for name in ("added_mass", "buoyancy", "quadratic_drag"):
        fewer = [entry for entry in kept if entry["name"] != name]
        gone = {entry["name"] for entry in lens.setup.model} - {entry["name"] for entry in fewer}
        absent = {one: {"coefficient": 0.0, "fluid_density": 0.0, "drag_coefficient": 0.0} for one in gone}
        if len(fewer) < len(kept) and lens.information(lens.signal(absent)) < NOTHING:
            kept = fewer
    return tuple(kept)


def hidden_laws(laws, amplitudes, blend=1.0):
    """{effect: parameters} of all hidden laws; blend < 1 brings their form nearer to the textbook."""
    merged = {}
    for make, amplitude in zip(laws, amplitudes, strict=True):
        for name, law in make(amplitude).items():
            merged[name] = {key: value * blend if key == "form" else value for key, value in law.items()}
    return merged


def _soften(hidden, blend):
    return {name: {key: value * blend if key == "form" else value for key, value in law.items()} for name, law in hidden.items()}


def judge(deal, lens, hidden, errors):
    """What an ideal analyst could find: the answer, the noiseless rows, and the rows of the best textbook law (None: nothing)."""
    names = [name for name in deal.names if name in LIBRARY]
    blend = 1.0
    for _ in range(7):
        laws = _soften(hidden, blend)
        rows = lens.signal(laws, errors, step=FINE)
        fitted, left = lens.beside(laws).fit(names, rows, near=laws) if names else ({}, lens.information(rows))
        if left <= MISFIT or deal.kind in ("outside", "mixed", "placebo"):
            break
        blend *= 0.4
    else:
        raise Redraw(f"the textbook law leaves {left:.3g}")
    answer = {
        "kind": deal.kind,
        "family": deal.family,
        "style": deal.style,
        "effects": list(deal.names),
        "hidden_laws": laws,
        "parameters": {},
        "strengths": strengths_of(deal, lens, laws),
        "outside": deal.kind in ("outside", "mixed"),
        "tied": [],
        "possible": [],
        "largest_cosine": 0.0,
        "nearest": None,
        "beyond": [],
        "information": lens.information(rows),
        "left_by_truth": left,
        "form_blend": blend,
        "numbers": lens.count(),
        "total_strength": lens.strength(rows),
    }
    if deal.kind == "outside":
        return _outside(answer, lens, rows), rows, None
    if not names:
        return answer, rows, None
    for name in names:
        if not possible(name, fitted[name]):
            raise Redraw(f"physics forbids {name} as it would be found")
        if not plausible(name, fitted[name], lens.setup.inputs):
            answer["beyond"].append(name)
        answer["parameters"][name] = {knob.name: fitted[name][knob.name] for knob in LIBRARY[name] if knob.scored}
    if len(names) > 1:
        answer["pair_cosine"] = _pair(deal, lens, laws, rows, left)
    for name in names:  # every hidden law beside its own rivals
        own = lens.signal({name: laws[name]}, step=FINE) if len(deal.names) > 1 else rows
        own_left = lens.fit([name], own, near=laws)[1] if len(deal.names) > 1 else left
        if deal.kind == "placebo":
            continue
        tied, beside, cosine, nearest, simpler = look_alikes(lens, name, own, own_left)
        if simpler:
            raise Redraw(f"{simpler} imitates {name} with fewer parameters")
        answer["tied"] += [rival for rival in tied if rival not in names]
        answer["possible"] += [rival for rival in beside if rival not in names]
        answer["largest_cosine"] = max(answer["largest_cosine"], cosine)
        answer["nearest"] = min(nearest, 1e12 if answer["nearest"] is None else answer["nearest"])
        if len(names) > 1:
            answer.setdefault("each", {})[name] = {"tied": tied, "possible": beside, "cosine": cosine}
    if deal.kind == "degenerate" and not answer["tied"]:
        raise Redraw("not degenerate")
    if deal.kind == "clear" and (answer["tied"] or answer["largest_cosine"] >= 0.9 or answer["nearest"] < NEAR):
        raise Redraw("something imitates it")
    if deal.kind == "nested" and answer["nearest"] < NEAR:
        raise Redraw("a simpler form would do")
    return answer, rows, lens.signal(fitted)


def strengths_of(deal, lens, laws):
    """{effect: strength}: as dealt, but for a law with a far number, which has the strength that it has."""
    dealt = dict(zip(deal.names, deal.strengths, strict=True))
    return dealt | {name: lens.strength(lens.signal({name: laws[name]})) for name in deal.names[: int(deal.far)]}


def _pair(deal, lens, laws, rows, left):
    """Cosine of what two laws add. Of a double they must not hide each other; of a joint pair they must, and be worth finding;
    in neither may one law of the library explain both."""
    pair = [lens.project(lens.signal({name: laws[name]}), white=True) for name in deal.names]
    cosine = float(pair[0] @ pair[1] / np.sqrt((pair[0] @ pair[0]) * (pair[1] @ pair[1])))
    if deal.kind == "joint":
        if cosine > -0.5:
            raise Redraw(f"cosine {cosine:.2f}: neither hides the other")
        if lens.strength(rows) < 0.6:
            raise Redraw("together too weak")
    elif abs(cosine) > 0.9:
        raise Redraw("the two hide each other")
    for name in {*lens.setup.rivals, *deal.names}:
        if (name in deal.names or lens.cosine(name, rows) > 0.9) and lens.fit([name], rows)[1] - left < NEAR:
            raise Redraw(f"{name} alone explains both")
    return cosine


def _outside(answer, lens, rows):
    """How much of an outside effect the best single library law imitates."""
    best, who = answer["information"], None
    for name in lens.setup.rivals:
        if lens.cosine(name, rows) < 0.3:
            continue
        law, left = lens.fit([name], rows, turns=2)
        if possible(name, law[name]) and left < best:
            best, who = left, name
    share = best / max(answer["information"], 1e-12)
    if share < SHARE:
        raise Redraw(f"{who} imitates it")
    answer.update(
        left_by_truth=None,
        imitator=who,
        unexplained_share=share,
        unexplained_strength=answer["total_strength"] * float(np.sqrt(share)),
    )
    answer["possible"] = sorted(set(lens.setup.rivals) | {alias for name in lens.setup.rivals for alias in ALIASES.get(name, ())})
    return answer


def shuffled(rng, films, plain, groups):
    """Films in which what was added to the plain motion comes from another recording, each axis with a sign of its own.

    Signs are drawn so that pluses and minuses balance over all recordings and, to one, in every group: an uneven draw leaves
    a part of what is hidden in the data, and finding that part would be right.
    """
    count = len(films)
    order = (np.arange(count) + rng.integers(1, count)) % count
    signs = np.column_stack([balanced(rng, groups) for _ in range(3)])
    mixed = []
    for (position, turn), source, sign in zip(plain, order, signs, strict=True):
        added = films[source][0] - plain[source][0]
        rows = np.minimum(np.arange(len(position)), len(added) - 1)
        mixed.append((position + added[rows] * sign, turn))
    return mixed


def balanced(rng, groups):
    """Signs (n,): plus and minus in turn through the recordings of one group after the other, dealt anew within each group."""
    signs, first = np.empty(len(groups)), rng.choice([-1.0, 1.0])
    dealt = 0
    for group in sorted(set(groups)):
        mine = np.flatnonzero([other == group for other in groups])
        signs[mine] = rng.permutation(first * (-1.0) ** np.arange(dealt, dealt + len(mine)))
        dealt += len(mine)
    return signs


def _oracle(lens, noisy, fitted):
    """RMS [m] of the recorded positions against the model under test, and against the true law with textbook coefficients,
    starts fitted."""
    rows = [lens._rows(seen, base) for seen, base in zip(noisy, lens.base, strict=True)]
    positions = len(axes_seen(lens.setup))

    def rms(parts):
        flat, at, total, count = lens.project(parts), 0, 0.0, 0
        for part in parts:
            kept = flat[at : at + part.size].reshape(part.shape)[:, :positions]
            at, total, count = at + part.size, total + float(np.sum(kept**2)), count + kept.size
        return lens.sigma_position * float(np.sqrt(total / count))

    before = rms(rows)
    after = before if fitted is None else rms([a - b for a, b in zip(rows, fitted, strict=True)])
    return {"before": before, "after": after, "noise": lens.sigma_position}


def _files(rng, setup, noise, stated, films, more=(), more_films=()):
    """The folder a user would hand in (sigma stated, or a static recording), and the films as recorded; `more` come last."""
    header = (
        ["t_s"] + [name for name in setup.columns if name != "q"] + (["qw", "qx", "qy", "qz"] if "q" in setup.columns else [])
    )
    seen_axes = axes_seen(setup)
    files, noisy, entries = {}, [], []

    def recorded(position, orientation):
        position = position.copy()
        position[:, seen_axes] = spoil(rng, noise, position[:, seen_axes], noise.position)
        return position, None if "q" not in setup.columns else spoil_orientation(rng, noise, orientation)

    def table(times, position, orientation):
        parts = [times[:, None], position[:, seen_axes]] + ([] if orientation is None else [orientation])
        return csv_text(header, np.concatenate(parts, axis=1))

    def keep(trial, position, orientation):
        noisy.append(recorded(position, orientation))
        name = again.recording_name(len(noisy) - 1)
        files[name] = table(trial.times, *noisy[-1])
        known = {key: [float(x) for x in np.round(trial.start[key], 9)] for key in trial.known}
        entries.append({"file": name, "group": trial.group, **({"start": known} if known else {}), **trial.overrides})

    for trial, seen in zip(setup.trials, films, strict=True):
        keep(trial, *seen)
    still = np.arange(600) / noise.rate
    place = np.array([0.1, 0.2, 1.0]) + rng.uniform(0, 1, 3) * max(noise.quantum, 0.1) * noise.position  # somewhere in its pixel
    place = np.repeat(place[None], 600, axis=0)
    resting = table(np.round(still, 6), *recorded(place, np.repeat([[1.0, 0.0, 0.0, 0.0]], 600, axis=0)))
    measurement = {"static": "rest.csv"}
    if stated:
        measurement = {"noise": {"position": noise.position}}
        measurement["noise"] |= {"orientation": noise.orientation} if "q" in setup.columns else {}
    else:
        files["rest.csv"] = resting
    for trial, seen in zip(more, more_films, strict=True):
        keep(trial, *seen)
    files["experiment.toml"] = toml_text(
        {
            "": {"kind": "trajectory", "title": setup.title},
            "body": {**setup.shape, "mass": setup.inputs["mass"]},
            "surroundings": setup.surroundings,
            "model": {"effects": list(setup.model)},
            "measurement": measurement,
            "diagnose": {"hold_out": "group"},
            "trial": entries,
        }
    )
    return files, noisy[: len(films)]
