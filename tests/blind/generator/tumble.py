"""Tumbling: a cube thrown on a floor in a foreign engine (pybullet, as a multibody), filmed from release to rest.

What is true of friction and restitution is read off the engine's own impacts, never taken as typed: friction as the horizontal
over the vertical momentum that the floor gives in a step, m dv + m g dt, where all contact points slip before and after it;
restitution as the ratio of the contact point's normal speeds before the first and after the last step in which it is pushed. Only
as a multibody is the engine's friction a cone; in maximal coordinates it is a pyramid along and across the slip, up to sqrt(2)
times what was typed. What lies in the floor is pushed out of it at a hundredth of the speed of the impact at most; by default at
a fifth, and a cube that rebounds nowhere would. pybullet is the extra `oracle`: Linux and Python 3.11 only.
"""

import numpy as np

from .build import Redraw, _files
from .case import Setup, Trial
from .dials import groups
from .noise import Noise, frames

GRAVITY = 9.81  # m/s2
STEP = 1 / 9600  # s; within one a cube of 2 m/s goes 0.2 mm into the floor, and a film between two is off by less than 0.05 mm
SLIPS, HITS = 0.05, 0.3  # m/s: faster points slip; faster impacts show the restitution
TRIES, SPREAD = 20, 0.08  # throws until one shows a friction that is one number: its middle four fifths as wide as this, relative
SIGMA = (3e-4, 1.5e-3)  # m


def toss(start, mass, side, friction, restitution, duration):
    """Times, positions, orientations (w, x, y, z), and of the steps in which all contact points slip (vertical momentum, ratio
    of the horizontal to it), and of the impacts (speed, ratio of the normal speeds)."""
    import pybullet as engine

    client = engine.connect(engine.DIRECT)
    try:
        engine.setGravity(0, 0, -GRAVITY)
        engine.setPhysicsEngineParameter(
            fixedTimeStep=STEP,
            numSolverIterations=100,
            enableConeFriction=1,
            restitutionVelocityThreshold=1e-2,
            contactERP=0.01,
            deterministicOverlappingPairs=1,
        )
        surface = {"lateralFriction": np.sqrt(friction), "restitution": np.sqrt(restitution)}  # of a pair: the product
        slab = engine.createCollisionShape(engine.GEOM_BOX, halfExtents=[5, 5, 0.5])  # of a plane it takes one corner at a time
        shape = engine.createCollisionShape(engine.GEOM_BOX, halfExtents=[side / 2] * 3)
        floor = engine.createMultiBody(0, slab, basePosition=[0, 0, -0.5], useMaximalCoordinates=0)
        w, x, y, z = start["orientation"]
        body = engine.createMultiBody(
            mass, shape, basePosition=list(start["position"]), baseOrientation=[x, y, z, w], useMaximalCoordinates=0
        )
        engine.changeDynamics(floor, -1, frictionAnchor=0, **surface)
        still = {"linearDamping": 0.0, "angularDamping": 0.0, "rollingFriction": 0.0, "spinningFriction": 0.0}
        still["activationState"] = engine.ACTIVATION_STATE_DISABLE_SLEEPING
        engine.changeDynamics(body, -1, mass=mass, localInertiaDiagonal=[mass * side**2 / 6] * 3, **still, **surface)
        engine.resetBaseVelocity(body, list(start["velocity"]), list(start["angular_velocity"]))
        return _run(engine, body, floor, mass, round(duration / STEP))
    finally:
        engine.disconnect(client)


def _run(engine, body, floor, mass, steps):
    """The recording of `toss`."""
    place, turn, slips, hits = np.empty((steps + 1, 3)), np.empty((steps + 1, 4)), [], []
    touched = None  # normal speed, arm and number of the impact that lasts
    for k in range(steps + 1):
        position, (x, y, z, w) = engine.getBasePositionAndOrientation(body)
        place[k], turn[k] = position, (w, x, y, z)
        if k == steps:
            break
        before = np.concatenate(engine.getBaseVelocity(body))
        engine.stepSimulation()
        contacts = [contact for contact in engine.getContactPoints(body, floor) if contact[9] > 0]  # those that push
        if not contacts:
            touched = None
            continue
        after = np.concatenate(engine.getBaseVelocity(body))
        slipping = []
        for contact in contacts:
            arm = np.array(contact[5]) - place[k]
            old, new = (v[:3] + np.cross(v[3:], arm) for v in (before, after))
            slipping.append(min(np.hypot(*old[:2]), np.hypot(*new[:2])) > SLIPS and old[:2] @ new[:2] > 0)
            if touched is None and old[2] < -HITS:
                touched = old[2], arm, len(hits)
                hits.append((-old[2], 0.0))
        if slipping and all(slipping):
            given = mass * (after[:3] - before[:3] + [0.0, 0.0, GRAVITY * STEP])
            slips.append((given[2], np.hypot(*given[:2]) / given[2]))
        if touched:  # the contact may take several steps: what counts is the speed when it ends
            hits[touched[2]] = -touched[0], max(-(after[:3] + np.cross(after[3:], touched[1]))[2] / touched[0], 0.0)
    return np.arange(steps + 1) * STEP, place, turn, slips, hits


def filmed(times, recording):
    """Positions and orientations (n, .) at the times [s]."""
    at, place, turn, *_ = recording
    turned_over = np.where(np.sum(turn[1:] * turn[:-1], axis=1) < 0, -1.0, 1.0)  # q and -q are one orientation
    turn = turn * np.concatenate([[1.0], np.cumprod(turned_over)])[:, None]
    position = np.column_stack([np.interp(times, at, axis) for axis in place.T])
    orientation = np.column_stack([np.interp(times, at, axis) for axis in turn.T])
    return position, orientation / np.linalg.norm(orientation, axis=1, keepdims=True)


def thrown(rng, side):
    """A start above the floor, in any attitude."""
    turn, heading = rng.normal(size=4), rng.uniform(0, 2 * np.pi)
    return {
        "position": np.array([*rng.uniform(-0.1, 0.1, 2), side + rng.uniform(0.08, 0.25)]),
        "orientation": turn / np.linalg.norm(turn),
        "velocity": np.array([np.cos(heading), np.sin(heading), 0.0]) * rng.uniform(0.6, 1.8),
        "angular_velocity": rng.uniform(-4, 4, 3),
    }


def median(weighted):
    """Weighted median and the middle four fifths of [(weight, value)]."""
    weight, value = np.array(sorted(weighted, key=lambda pair: pair[1])).T
    share = np.cumsum(weight) / weight.sum()
    return [float(value[np.searchsorted(share, level)]) for level in (0.5, 0.1, 0.9)]


def case(deal, rng):
    """One tumbling case: ({file name: text}, answer). Raises Redraw."""
    side = float(rng.choice([0.06, 0.08, 0.10]))
    mass = float(f"{rng.uniform(700, 2400) * side**3:.3g}")
    friction, restitution = float(rng.uniform(0.2, 0.5)), float(rng.choice([0.0, 0.0, 0.3]))
    rate, sigma = int(rng.choice([120, 240])), float(np.exp(rng.uniform(*np.log(SIGMA))))
    noise = Noise.draw(rng, deal.regime, rate, sigma, float(rng.choice([0.005, 0.01])))
    count = int(rng.integers(6, 9))
    trials, films, slips, hits = [], [], [], []
    for group in groups(rng, count):
        for _ in range(TRIES):
            start, duration = thrown(rng, side), float(rng.uniform(0.7, 1.0))
            recording = toss(start, mass, side, friction, restitution, duration)
            if len(recording[3]) > 20 and recording[4]:
                true, low, high = median(recording[3])
                if high - low < SPREAD * true:
                    break
        else:
            raise Redraw("the engine's own friction is not one number")
        trials.append(Trial(group, start, (), frames(rng, noise, duration - STEP)))
        films.append(filmed(trials[-1].times, recording))
        slips += recording[3]
        hits += recording[4]
    true, low, high = median(slips)
    if high - low > 2 * SPREAD * true:
        raise Redraw("the engine's own friction differs from throw to throw")
    rebound = median(hits)
    nominal = round(true * float(rng.choice([0.55, 0.65, 1.5, 1.8])), 2)
    surroundings = {"gravity": GRAVITY, "fluid_density": 0.0, "floor": {"height": 0.0, "normal": [0.0, 0.0, 1.0]}}
    surroundings |= {"friction": nominal, "restitution": round(rebound[0], 3)}
    shape, columns = {"shape": "box", "size": [side] * 3}, ("x_m", "y_m", "z_m", "q")
    setup = Setup("tumble", "cube thrown on a floor", shape, {"mass": mass}, surroundings, (), tuple(trials), columns, None, ())
    stated = deal.regime == "outliers" and rng.random() < 0.5
    files, noisy = _files(rng, setup, noise, stated, films)
    typed = filmed(trials[0].times, toss(trials[0].start, mass, side, nominal, restitution, trials[0].times[-1] + 2 * STEP))[0]
    strength = float(np.sqrt(np.mean((typed - films[0][0]) ** 2)) / noise.position)
    answer = {
        "kind": "single",
        "family": "tumble",
        "style": "tumble",
        "effects": ["friction"],
        "hidden_laws": {"friction": {"coefficient": true}},
        "parameters": {"friction": {"coefficient": true}},
        "read_off": {"friction": [true, low, high], "restitution": rebound, "points": len(slips), "impacts": len(hits)},
        "typed": {"friction": friction, "restitution": restitution},
        "strengths": {"friction": strength},
        "outside": False,
        "tied": [],
        "possible": [],
        "beyond": [],
        "largest_cosine": 0.0,
        "nearest": None,
        "total_strength": strength,
        "numbers": sum(len(position) * 3 for position, _ in noisy),
        "noise": {"regime": deal.regime, "stated": stated, **noise.__dict__},
        "nominal_errors": {},
        "oracle": None,
    }
    return files, answer
