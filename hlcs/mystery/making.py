"""`hlcs mystery make`: a new data set in which an effect is hidden, with its answer sealed.

The effect's number is drawn from what is found in nature; the camera, or of layers the number of tests, is chosen so that the
effect is as strong as was asked for. Strength is the discovery page's: what the effect changes in the recordings once the unknown
starts are fitted, or in the means of layers, root mean square, in standard deviations of their noise.
"""

from collections.abc import Callable
from math import exp, log
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from hlcs.files.documents import to_toml
from hlcs.mystery import layers, recording, scenes
from hlcs.mystery.seal import SEALED, sealed
from minibullet.errors import InputError, if_alike, is_number, shown

FINEST, COARSEST = 2e-4, 1e-2  # m: a good tracker close by, a film of a telephone from far
SCENES = 8  # that are drawn until one can show an effect of the strength that is asked for
USUAL = 2e-3  # m, where nothing is hidden
NOTHING = "Nothing. The model is complete at the precision of these data, and saying so is the right answer."


class Offer(NamedTuple):
    """An effect that can be hidden."""

    scene: Callable  # random generator -> Scene
    law: Callable  # random generator -> (function of the amplitude -> {parameter: value})
    low: float  # the amplitude lies between these; they are found in nature or in laboratories
    high: float
    story: str  # what `reveal` says


def plain(parameter):
    """A law whose amplitude is its parameter."""
    return lambda rng: lambda amplitude: {parameter: amplitude}


def beside(parameter, usual):
    """A law whose parameter is off what is usual by the amplitude, to either side."""

    def draw(rng):
        side = rng.choice([-1.0, 1.0])
        return lambda amplitude: {parameter: usual + side * amplitude}

    return draw


def across(first, second):
    """A law with two parts, along x and along y; their size is the amplitude."""

    def draw(rng):
        angle = rng.uniform(0.0, 2 * np.pi)
        return lambda amplitude: {first: amplitude * np.cos(angle), second: amplitude * np.sin(angle)}

    return draw


OFFERS = {
    "quadratic_drag": Offer(scenes.tower, plain("drag_coefficient"), 0.40, 0.50, "The air resists the balls."),
    "uniform_flow": Offer(scenes.tank, across("velocity_x", "velocity_y"), 0.003, 0.06, "The water was not at rest."),
    "magnus": Offer(
        scenes.spinning, plain("coefficient"), 0.15, 1.0, "The spin bends the flight; its side changes with the spin."
    ),
    "spin_decay": Offer(scenes.spinning, plain("rate"), 0.01, 0.4, "The air slows the spin."),
    "clock_offset": Offer(scenes.tower, beside("offset", 0.0), 0.004, 0.06, "The release was stamped too early or too late."),
    "time_scale": Offer(scenes.gallery, beside("factor", 1.0), 0.002, 0.04, "The clock of the camera runs wrong."),
    "length_scale": Offer(scenes.gallery, beside("factor", 1.0), 0.004, 0.08, "The ruler is wrong."),
    "friction": Offer(scenes.hallway, beside("coefficient", 0.3), 0.01, 0.12, "The floor has another friction than stated."),
    "viscous_friction": Offer(scenes.hallway, plain("slope"), 0.01, 0.15, "The friction grows with the speed."),
    "bottom_slope": Offer(scenes.hallway, across("grade_x", "grade_y"), 0.003, 0.05, "The floor is not level."),
    "restitution": Offer(
        scenes.gymnasium, beside("coefficient", 0.75), 0.01, 0.12, "The floor gives back another share of speed."
    ),
    "velocity_dependent_restitution": Offer(
        scenes.gymnasium, plain("exponent"), 0.02, 0.2, "The faster the impact, the smaller the share of speed that comes back."
    ),
    "rolling_friction": Offer(scenes.boards, plain("arm"), 2e-5, 6e-4, "The ball sinks a hair into the board and pays for it."),
}


def made(effect, strength, seed):
    """{file name: text} of a new data set: experiment.toml, the recordings and rest.csv or the table, answer.sealed.

    effect: a name of `OFFERS` or `layers.OFFERS`; strength: in standard deviations of the noise, 0 = nothing is hidden; seed: a
    whole number. The same three give the same bytes on the same computer. Raises InputError for an effect that is not offered,
    and for a strength that no number found in nature and no camera, or number of tests, can show.
    """
    known = OFFERS | layers.OFFERS
    if effect not in known:
        raise InputError(f"effect '{shown(effect)}': cannot be hidden{if_alike(effect, known)} (all: {', '.join(known)})")
    if not isinstance(seed, int) or isinstance(seed, bool) or seed < 0:
        raise InputError(f"seed = {shown(seed)}: must be a whole number of at least 0")
    if not is_number(strength) or strength < 0:
        raise InputError(f"strength = {shown(strength)}: must be a number of at least 0, in standard deviations of the noise")
    request = {"effect": effect, "strength": float(strength), "seed": seed}
    return _tabled(request) if effect in layers.OFFERS else _recorded(request)


def _recorded(request):
    """The files of recordings of a motion."""
    effect, strength, seed = request.values()
    offer = OFFERS[effect]
    scene, hidden, sigma, rng = _drawn(effect, offer, strength, seed)
    laws = _laws(scene) | hidden
    scene = scene._replace(model=tuple(entry for entry in scene.model if entry["name"] not in hidden))
    camera = recording.Camera(sigma, sigma / scene.shape["radius"] if scene.turns else 0.0, scene.rate)
    files = _files(scene, laws, camera, rng)
    noise = {"position": camera.position, "orientation": camera.orientation, "rate": camera.rate}
    told = f"Noise of the tracker: {1000 * camera.position:.2g} mm."
    files[SEALED] = sealed(_answer(scene.title, hidden, offer.story, noise, told, request))
    return files


def _tabled(request):
    """The files of a table of layers."""
    effect, strength, seed = request.values()
    offer, rng = layers.OFFERS[effect], np.random.default_rng([seed, *effect.encode()])
    tests, amplitude = layers.drawn(offer, strength, rng) if strength else (layers.USUAL, 0.0)
    if tests is None:
        least, most = amplitude
        raise InputError(
            f"strength = {strength:g}: {effect} as it is found changes the means of {layers.FEWEST} to {layers.MOST} tests by "
            f"{least:.2g} to {most:.2g} of their standard errors; give a strength in that range, or 0 to hide nothing"
        )
    return layer_files(layers.TITLE, effect, amplitude, tests, rng, request)


def layer_files(title, effect, amplitude, tests, rng, request):
    """{file name: text} of a table of layers in which an effect is hidden at an amplitude, 0 = nothing; tests: in each week;
    request: what is kept of how the set was made."""
    offer = layers.OFFERS[effect]
    hidden = {effect: {offer.parameter: amplitude}} if amplitude else {}
    noise = {"regime": "tests", "tests": tests, "hands": layers.HANDS, "week": layers.WEEK}
    sealed_answer = _answer(title, hidden, offer.story, noise, spread_of_tests(tests), request)
    return {
        "experiment.toml": to_toml(layers.experiment(title), inline=True),
        "layers.csv": layers.table(offer, amplitude, tests, rng),
        SEALED: sealed(sealed_answer | {"tied": list(offer.tied) if hidden else []}),
    }


def _drawn(effect, offer, strength, seed):
    """(Scene, {effect: law}, standard deviation of the noise [m], random generator) of that strength: scenes are drawn until one
    has it. InputError where none of them does."""
    reach = []
    for attempt in range(SCENES):
        rng = np.random.default_rng([seed, attempt, *effect.encode()])
        scene = offer.scene(rng)
        if not strength:
            return scene, {}, USUAL, rng
        hidden, sigma, least, most = _scaled(effect, offer, scene, strength, rng)
        if hidden:
            return scene, hidden, sigma, rng
        reach += [least, most]
    raise InputError(
        f"strength = {strength:g}: {effect} as it is found in nature changes what cameras see by {min(reach):.2g} to "
        f"{max(reach):.2g} standard deviations of their noise; give a strength in that range, or 0 to hide nothing"
    )


def _scaled(effect, offer, scene, strength, rng):
    """({effect: law}, standard deviation of the noise [m], least and greatest strength in this scene): the law as drawn and a
    camera that suits it, or where there is no such camera the law that suits the nearest one; no law where none does."""
    law = offer.law(rng)
    amplitude = exp(rng.uniform(log(offer.low), log(offer.high)))
    without = {name: numbers for name, numbers in _laws(scene).items() if name != effect}
    views = recording.views(scene, without)

    def change(amplitude):
        return recording.shift(scene, without | {effect: law(amplitude)}, views)

    sigma = change(amplitude) / strength
    if FINEST <= sigma <= COARSEST:
        return {effect: law(amplitude)}, sigma, strength, strength
    sigma = float(np.clip(sigma, FINEST, COARSEST))
    least, most = change(offer.low) / COARSEST, change(offer.high) / FINEST
    if not least <= strength <= most:
        return {}, sigma, least, most
    amplitude = brentq(lambda tried: change(tried) - strength * sigma, offer.low, offer.high, rtol=1e-6)
    return {effect: law(amplitude)}, sigma, least, most


def _laws(scene):
    """{effect: law} of the model of a scene."""
    return {entry["name"]: {key: value for key, value in entry.items() if key != "name"} for entry in scene.model}


def _files(scene, laws, camera, rng):
    """{file name: text} of what a student gets."""
    files, trials = {}, []
    for number, trial in enumerate(scene.trials, start=1):
        name = f"recording_{number:02d}.csv"
        times = recording.stamps(camera, trial.duration)
        position, orientation = recording.seen(rng, camera, *recording.film(scene, laws, trial, trial.start, times))
        files[name] = recording.csv_of(times, position, orientation if scene.turns else None)
        start = {key: [float(part) for part in getattr(trial.start, key)] for key in trial.known}
        own = {"floor": scenes.resting_on(trial.floor)["floor"]} if trial.floor and trial.floor.normal[2] < 1 else {}
        trials.append({"file": name, "group": trial.group} | ({"start": start} if start else {}) | own)
    files["rest.csv"] = recording.still_life(rng, camera, scene.turns)
    experiment = {
        "kind": "trajectory",
        "title": scene.title,
        "body": scene.shape,
        "surroundings": scene.surroundings,
        "model": {"effects": list(scene.model)},
        "measurement": {"static": "rest.csv"},
        "diagnose": {"hold_out": "group"},
        "trial": trials,
    }
    return {"experiment.toml": to_toml(experiment, inline=True)} | files


def spread_of_tests(tests):
    """What is told of the noise of a table of layers; tests: in each week."""
    return f"Hands and plates change a layer by {100 * layers.HANDS:.2g} % from test to test; {tests} tests in each week."


def _answer(title, hidden, story, noise, told, request):
    """What is sealed: the keys of the packaged sets, and `made`, what makes the set again. hidden: {effect: law}; noise: its
    numbers, and told in words."""
    laws = {name: {key: float(value) for key, value in law.items()} for name, law in hidden.items()}
    lines = [f"{title}.", "", story if hidden else NOTHING, ""]
    for name, law in laws.items():
        numbers = ", ".join(f"{key} = {value:.6g}" for key, value in law.items())
        lines.append(f"  {name}: strength {request['strength']:.1f} sigma; as the library writes it: {numbers}")
    lines.append(f"  {told}")
    return {
        "effects": list(laws),
        "hidden_laws": laws,
        "parameters": laws,
        "strengths": dict.fromkeys(laws, request["strength"]),
        "tied": [],
        "possible": [],
        "outside": False,
        "noise": noise,
        "text": "\n".join(lines) + "\n",
        "made": request,
    }
