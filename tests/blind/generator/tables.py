"""Outcome tables: fall time against height, rebound against height, stopping distance against launching speed.

`height_m` is the free way below the ball, `rebound_height_m` the free way it regains. Every table needs one motion along a
line from rest (falling, or rising and sliding played backwards), solved by an eighth-order Runge-Kutta method and read off at
all settings.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import solve_ivp

from .again import GROUP, turns
from .build import Redraw, draw_laws, judge, written
from .case import Setup, csv_text, toml_text
from .dials import Dial, one
from .fluid import around, displaced
from .fluid import rivals as missing
from .noise import Noise
from .strength import Lens

G = 9.81
OUTCOME = {"flight": "fall_time_s", "bounce": "rebound_height_m", "slide": "stop_distance_m"}
SIGMAS = {"flight": (1.5e-3, 1e-2), "bounce": (3e-3, 1.5e-2), "slide": (4e-3, 3e-2)}  # stop watch with light gates, ruler, tape
RIVALS = {
    "flight": ("linear_drag", "quadratic_drag", "buoyancy", "added_mass", "clock_offset", "time_scale", "length_scale"),
    "bounce": ("restitution", "velocity_dependent_restitution", "linear_drag", "quadratic_drag", "length_scale"),
    "slide": ("friction", "viscous_friction", "stribeck_friction", "quadratic_drag", "length_scale"),
}


def _either(name, key, centre, **extra):
    def draw(rng):
        side = rng.choice([-1.0, 1.0])
        return lambda amplitude: {name: {key: centre + side * amplitude, **extra}}

    return draw


def _stribeck(rng):
    speed = float(rng.uniform(0.2, 0.45))
    return lambda amplitude: {"stribeck_friction": {"ratio": 1 + amplitude, "speed": speed, "form": 0.5}}


def _ripple(name):
    def draw(rng):
        count, phase = float(rng.uniform(2.0, 3.0)), float(rng.uniform(0, 2 * np.pi))
        return lambda amplitude: {name: {"amplitude": amplitude, "count": count, "phase": phase}}

    return draw


TABLE = ("table",)
HIDDEN = {
    "flight": {
        "quadratic_drag": one("quadratic_drag", "drag_coefficient", 0.02, 1.4, TABLE, form="form"),
        "linear_drag": one("linear_drag", "rate", 0.002, 1.0, TABLE, form="form"),
        "clock_offset": one("clock_offset", "offset", 5e-4, 0.2, TABLE, sign=0),
        "time_scale": one("time_scale", "factor", 3e-4, 0.045, TABLE, null=1.0, sign=0),
        "length_scale": one("length_scale", "factor", 5e-4, 0.09, TABLE, null=1.0, sign=0),
    },
    "bounce": {
        "restitution": Dial(_either("restitution", "coefficient", 0.75), 1e-3, 0.2, TABLE),
        "velocity_dependent_restitution": one("velocity_dependent_restitution", "exponent", 1e-3, 0.2, TABLE, form="form"),
        "quadratic_drag": one("quadratic_drag", "drag_coefficient", 0.02, 1.4, TABLE, form="form"),
        "linear_drag": one("linear_drag", "rate", 0.003, 1.0, TABLE, form="form"),
        "length_scale": one("length_scale", "factor", 5e-4, 0.09, TABLE, null=1.0, sign=0),
    },
    "slide": {
        "friction": Dial(_either("friction", "coefficient", 0.30), 5e-4, 0.15, TABLE),
        "viscous_friction": one("viscous_friction", "slope", 5e-4, 0.3, TABLE, form="form"),
        "stribeck_friction": Dial(_stribeck, 5e-3, 0.9, TABLE),
    },
}
OUTSIDE = {
    "flight": {"reaction_ripple": Dial(_ripple("reaction_ripple"), 1e-3, 0.1, TABLE)},
    "bounce": {"ringing_floor": Dial(_ripple("ringing_floor"), 1e-3, 0.3, TABLE)},
    "slide": {"striped_floor": Dial(_ripple("striped_floor"), 1e-3, 0.5, TABLE)},
}
DEGENERATE = {
    "flight": (("time_scale", "table"), ("length_scale", "table"), ("quadratic_drag", "narrow"), ("clock_offset", "narrow")),
    "bounce": (("restitution", "table"), ("length_scale", "table"), ("velocity_dependent_restitution", "narrow")),
    "slide": (("viscous_friction", "table"), ("friction", "table")),
}
JOINT = {
    "flight": (("quadratic_drag", "clock_offset", "table"), ("linear_drag", "time_scale", "table")),
    "bounce": (("restitution", "quadratic_drag", "table"), ("restitution", "linear_drag", "table")),
    "slide": (("friction", "viscous_friction", "table"),),
}
DOUBLES = {
    "flight": (("quadratic_drag", "clock_offset", "table"),),
    "bounce": (("restitution", "velocity_dependent_restitution", "table"),),
    "slide": (("friction", "viscous_friction", "table"),),
}


def line(law, reach):
    """Motion from rest along a line, dv/dt = law(v): times, ways and speeds (m,) up to the way `reach` [m]."""

    def enough(t, y):
        return y[0] - reach

    enough.terminal = True
    duration = 60.0
    found = solve_ivp(
        lambda t, y: [y[1], law(max(y[1], 0.0))],
        (0, duration),
        [0.0, 0.0],
        method="DOP853",
        rtol=1e-10,
        atol=1e-12,
        events=enough,
        dense_output=True,
        max_step=0.05,
    )
    if not len(found.t_events[0]):
        raise Redraw("never arrives")
    times = np.linspace(0, found.t_events[0][0], 20001)
    way, speed = found.sol(times)
    return times, way, speed


def respond(setup, effects, errors, settings):
    """Noiseless outcomes (n,) at the settings (n,)."""
    inputs = setup.inputs
    mass = inputs["mass"] * (1 + errors.get("mass", 0.0)) * (1 + effects.get("mass_offset", {}).get("relative", 0.0))
    radius = inputs["radius"] * (1 + errors.get("size", 0.0))
    area = np.pi * radius**2
    law = effects.get("quadratic_drag", {})
    k = 0.5 * inputs["fluid_density"] * law.get("drag_coefficient", 0.0) * area / mass
    k_form = -0.3 * law.get("form", 0.0)
    rate, rate_form = effects.get("linear_drag", {}).get("rate", 0.0), 0.15 * effects.get("linear_drag", {}).get("form", 0.0)
    volume = inputs.get("volume", 4 / 3 * np.pi * inputs["radius"] ** 3) * (radius / inputs["radius"]) ** 3
    lifted, moved_along = displaced({**inputs, "volume": volume}, effects, mass)
    share = 1 / (1 + moved_along)  # of every force that accelerates the body; the rest goes to the fluid that moves along
    g, scale = G * (1 - lifted) * share, effects.get("length_scale", {}).get("factor", 1.0)

    def drag(v):
        return share * (k * v * v * (v / 4.0 + 1e-9) ** k_form + rate * v * (v / 4.0 + 1e-9) ** rate_form)

    ripple = next((effects[name] for name in ("reaction_ripple", "ringing_floor", "striped_floor") if name in effects), None)
    span = (settings - settings.min()) / (settings.max() - settings.min())
    wave = 0.0 if ripple is None else ripple["amplitude"] * np.sin(2 * np.pi * ripple["count"] * span + ripple["phase"])
    if setup.family == "flight":
        times, way, _ = line(lambda v: g - drag(v), settings.max() / scale * 1.01)
        seconds = np.interp(settings / scale, way, times)
        offset = effects.get("clock_offset", {}).get("offset", 0.0)
        return (seconds + offset) / effects.get("time_scale", {}).get("factor", 1.0) + wave
    if setup.family == "bounce":
        _, way, speed = line(lambda v: g - drag(v), settings.max() * 1.01)
        hit = np.interp(settings, way, speed)
        e = effects.get("restitution", {}).get("coefficient", inputs["restitution"])
        law = effects.get("velocity_dependent_restitution", {})
        form, exponent = law.get("form", 0.0), law.get("exponent", 0.0)
        e = e * ((1 - form) * hit**-exponent + form * (1 + 5 * exponent * (1 - hit**0.2))) * (1 + wave)
        _, way, speed = line(lambda v: g + drag(v), settings.max() * 1.5)
        return scale * np.interp(np.clip(e, 0, 1) * hit, speed, way)
    mu = effects.get("friction", {}).get("coefficient", inputs["friction"])
    stribeck = effects.get("stribeck_friction", {"ratio": 1.0, "speed": 1.0})
    power = 2.0 - stribeck.get("form", 0.0)
    viscous = effects.get("viscous_friction", {"slope": 0.0})

    angle = np.deg2rad(inputs.get("angle", 0.0))

    def brake(v):
        grip = mu * (1 + (stribeck["ratio"] - 1) * np.exp(-((v / max(stribeck["speed"], 1e-3)) ** power)))
        rubbing = max(g * (grip + viscous["slope"] * v ** (1 - 0.25 * viscous.get("form", 0.0))), 0.0)
        return np.cos(angle) * rubbing - g * np.sin(angle) + drag(v)

    _, way, speed = line(brake, 1.2 * settings.max() ** 2 / (2 * 0.05 * G))
    if speed[-1] < settings.max():
        raise Redraw("never stops")
    return scale * np.interp(settings, speed, way) * (1 + wave)


NOMINAL = {"mass_kg": "mass", "radius_m": "radius", "angle_deg": "angle"}  # what a design may change -> input


def further(setup, effects, errors, column, tests):
    """Noiseless outcomes (n,) of the rows {column: value} that a design asks for; KeyError where the table cannot have them."""
    known = {}
    for test in tests:
        row = tuple(test.items())
        if row in known:
            continue
        inputs = dict(setup.inputs)
        for key, value in test.items():
            if key != column:
                inputs[NOMINAL[key]] = value
        try:  # the other settings stay: an outside effect is laid over their range
            settings = np.append(np.unique(setup.trials), test[column])
            known[row] = respond(replace(setup, inputs=inputs), effects, errors, settings)[-1]
        except Redraw as problem:
            raise KeyError(f"{test} ({problem})") from None
    return np.array([known[tuple(test.items())] for test in tests])


@dataclass
class TableLens(Lens):
    """The same questions asked of a table: nothing has to be fitted, rows are independent. setup.trials = the settings (n,)."""

    def __post_init__(self):
        self.base_effects = self.setup.base()
        self.plain = self.white = [np.zeros((1, 0))]
        self.single, self.back = np.unique(self.setup.trials, return_inverse=True)
        self.base = respond(self.setup, self.base_effects, {}, self.single)
        self._sensitivities = {}

    def beside(self, laws):
        """Itself: no start of a row is unknown."""
        return self

    def signal(self, effects, errors=None, step=None):
        """[(n, 1)] change of the outcomes, in sigmas."""
        seen = respond(self.setup, {**self.base_effects, **effects}, errors or {}, self.single)
        return [((seen - self.base) / self.sigma_position)[self.back][:, None]]


def setup(rng, family, hidden=(), narrow=False):
    """An outcome experiment: 8 to 12 settings (narrow: close together), 6 to 9 replicates each, spread over two to four days."""
    count, repeats, days = int(rng.integers(8, 13)), int(rng.integers(6, 10)), int(rng.integers(2, 5))
    top, bottom = {"flight": (10.0, 0.5), "bounce": (3.0, 0.1), "slide": (3.5, 0.6)}[family]
    settings = np.round(np.geomspace(0.6 * top if narrow else bottom, top, count), 3)
    table = np.tile(settings, repeats)
    day = np.repeat(np.arange(repeats) % days, count)
    radius, mass = ((0.0335, 0.0577), (0.11, 0.43), (0.02, 0.0027))[rng.integers(3)]
    shape = {"shape": "sphere", "radius": radius}
    air = around(rng, hidden, "box" if family == "slide" else "sphere")
    inputs = {"mass": mass, "radius": radius, "gravity": G, "fluid_density": air.density}
    surroundings = {"gravity": G, **air.stated, "floor": {"height": 0.0, "normal": [0.0, 0.0, 1.0]}}
    title = "fall time against height"
    if family == "bounce":
        inputs["restitution"], surroundings["restitution"], title = 0.75, 0.75, "rebound height against drop height"
    if family == "slide":
        size, mass = [0.12, 0.08, 0.04], 0.35
        shape = {"shape": "box", "size": size}
        # a sphere of the same mean projected area stands in for the block where air drags on it
        area = (size[0] * size[1] + size[1] * size[2] + size[0] * size[2]) / 2
        inputs.update(mass=mass, radius=float(np.sqrt(area / np.pi)), volume=float(np.prod(size)), friction=0.30)
        surroundings["friction"], title = 0.30, "stopping distance of a launched block"
    made = Setup(
        family,
        title,
        shape,
        inputs,
        surroundings,
        air.model,
        table,
        (OUTCOME[family],),
        None,
        missing(RIVALS[family], air),
        ("mass", "size"),
    )
    return made, day


def case(deal, rng, then=None):
    """One outcome table: ({file name: text}, answer); then = (design, number of rows): these join it. Raises Redraw."""
    made, day = setup(rng, deal.family, deal.names, deal.style == "narrow")
    low, high = SIGMAS[deal.family]
    sigma = float(np.exp(rng.uniform(np.log(low), np.log(high))))
    noise = Noise(sigma, 0.01, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    lens = TableLens(made, sigma, 0.01, 0.0)
    dials = (OUTSIDE if deal.kind == "outside" else HIDDEN)[deal.family]
    hidden, amplitudes, lens, noise = draw_laws(deal, rng, lens, noise, dials, (low, high))
    errors = {"mass": float(rng.uniform(-0.02, 0.02)), "size": float(rng.uniform(-0.01, 0.01))}
    answer, _, fitted = judge(deal, lens, hidden, errors)
    answer["amplitudes"] = amplitudes
    true = respond(made, {**made.base(), **answer["hidden_laws"]}, errors, lens.single)[lens.back]
    seen = true + rng.normal(size=len(true)) * noise.position
    if (seen <= 0).any():
        raise Redraw("an outcome below zero")
    best = lens.base[lens.back] + (0 if fitted is None else fitted[0][:, 0] * noise.position)
    rms = [float(np.sqrt(np.mean((seen - model) ** 2))) for model in (lens.base[lens.back], best)]
    answer.update(
        noise={"regime": "replicates", **noise.__dict__},
        nominal_errors=errors,
        oracle={"before": rms[0], "after": rms[1], "noise": noise.position},
    )
    column = "speed_m_s" if deal.family == "slide" else "height_m"
    rows = [
        (f"{setting:g}", f"{value:.5f}", f"day {1 + which}") for setting, value, which in zip(made.trials, seen, day, strict=True)
    ]
    order = np.lexsort((rng.random(len(rows)), day))
    rows = [rows[i] for i in order]
    inputs = [column]
    if then:
        tests = turns(*then)
        inputs += [key for key in then[0] if key != column]
        seen = (
            further(made, {**made.base(), **answer["hidden_laws"]}, errors, column, tests)
            + rng.normal(size=len(tests)) * noise.position
        )
        nominal = [f"{made.inputs.get(NOMINAL[key], 0.0):g}" for key in inputs[1:]]
        rows = [(row[0], *nominal, *row[1:]) for row in rows]
        rows += [(*(f"{test[key]:g}" for key in inputs), f"{value:.5f}", GROUP) for test, value in zip(tests, seen, strict=True)]
    files = {
        "outcomes.csv": csv_text([*inputs, OUTCOME[deal.family], "group"], rows),
        "experiment.toml": toml_text(
            {
                "": {"kind": "outcomes", "title": made.title},
                "body": {**made.shape, "mass": made.inputs["mass"]},
                "surroundings": made.surroundings,
                "model": {"effects": list(written(lens))},
                "measurement": {"file": "outcomes.csv"},
                "diagnose": {"hold_out": "group"},
            }
        ),
    }
    return files, answer
