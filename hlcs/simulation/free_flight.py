"""Free flight of many bodies at once: Runge-Kutta for the effects' forces, no contacts.

The forces are those the engine would ask for (`effect.forces`, `effect.added_mass`); only the integration is another,
of fourth order, so that its error lies far below any measurement and many perturbed starts fly in one batch. A drag in proportion
to speed is integrated exactly, however strong it is: v' = a - k v has a closed form while a is a polynomial of time, and that is
what Runge-Kutta takes it for (S. M. Cox, P. C. Matthews, J. Comput. Phys. 176 (2002) 430, ETDRK4; k = 0 is the classical method).
Of another drag that is too strong for a step, k v near its final speed is taken out and integrated so.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hlcs.simulation.batch_effects import holders, rows_of
from hlcs.simulation.decay import Decay
from hlcs.simulation.track import Track
from minibullet import rotations
from minibullet.bodies import Bodies
from minibullet.dynamics.integrate import moved
from minibullet.effects import AddedMass, contract
from minibullet.effects.body import ConstantForce, force_only
from minibullet.effects.fluid import Viscous, length_of
from minibullet.kernels import leaf
from minibullet.rotations import rotation_matrices
from minibullet.vectors import turn, turn_back

STIFF = 1.0  # decay of a change of velocity within a step that Runge-Kutta still follows [-]
FIRST, GROWTH = 0.2, 1.3  # first step of a flight, in times of its fastest decay, and how much longer each next one may be [-]


@leaf
def euler(rotation, spin, torque, inertia, faster):
    """Fill in the angular accelerations (n, 3) of free bodies: Euler's equations in the principal axes of each.

    rotation: body axes to world axes (n, 3, 3); spin, torque, faster: along the world's axes (n, 3); inertia: principal (n, 3).
    """
    for n in range(len(spin)):
        a, b, c = turn_back(rotation[n], spin[n])
        x, y, z = turn_back(rotation[n], torque[n])
        i, j, k = inertia[n, 0], inertia[n, 1], inertia[n, 2]
        faster[n, 0], faster[n, 1], faster[n, 2] = turn(
            rotation[n], ((x + (j - k) * b * c) / i, (y + (k - i) * c * a) / j, (z + (i - j) * a * b) / k)
        )


class Forces(NamedTuple):
    """Forces of some of the bodies."""

    rows: slice | np.ndarray  # which
    effects: list  # with a method forces(bodies, time) each


def alike(entries):
    """[(entry, rows)]: which of n entries are equal."""
    places = {}
    for place, entry in enumerate(entries):
        if not place or entry is not entries[place - 1]:  # most often one value stands in all
            its = places.setdefault(entry, [])
        its.append(place)
    return [(entry, rows_of(its)) for entry, its in places.items()]


def some_of(bodies: Bodies, rows) -> Bodies:
    """The bodies of these rows."""
    return Bodies(*(values[rows] for values in bodies))


def viscous_rates(bodies: Bodies, models):
    """(rates k at which drags in proportion to speed slow n bodies (n, 1) [1/s], the forces beside them, a list of Forces).

    Zero, and all forces, where there is no such drag or the added mass is not the same in every direction. A force that several
    models have is asked once for all their bodies.

    models: as `alike` has them of the effects of each body.
    """
    rates, acting, places = np.zeros((len(bodies.mass), 1)), [], np.arange(len(bodies.mass))
    for effects, rows in models:
        viscous, part = viscous_drags(effects), some_of(bodies, rows)
        if viscous:
            added = contract.added_mass(effects, part)
            mass = part.mass + (0.0 if added is None else added[:, 0, 0])
            rates[rows, 0] = sum(effect.resistance(part) for effect in viscous) / mass
        forces = [effect for effect in effects if effect not in viscous and contract.overrides(effect, "forces")]
        forces += [Inertial(effect) for effect in viscous if type(effect).inertial is not Viscous.inertial]
        acting.append(forces)
    together = {}  # bodies -> what acts on them
    for (effect, _), numbers in holders(acting).items():
        its = np.concatenate([places[models[number][1]] for number in numbers])
        together.setdefault(tuple(sorted(its)), []).append(effect)
    return rates, [Forces(rows_of(its), effects) for its, effects in together.items()]


def viscous_drags(effects):
    """The drags in proportion to speed among effects that are integrated exactly."""
    return [effect for effect in effects if isinstance(effect, Viscous)] if isotropic_mass(effects) else []


@dataclass(frozen=True)
class Inertial:
    """What a drag adds to its part in proportion to speed."""

    drag: Viscous

    def forces(self, bodies, time):
        return force_only(self.drag.inertial(bodies))


def isotropic_mass(effects):
    """Is all added mass the same in every direction and attitude?"""
    return all(type(effect) is AddedMass for effect in effects if contract.overrides(effect, "added_mass"))


def accelerations(bodies: Bodies, models, forces):
    """Function (time, position, orientation, twist) -> accelerations of n free bodies, linear and angular as the twist (n, 6).

    models, forces: those that count, as `viscous_rates` has them.
    """
    mass, heavier = bodies.mass[:, None].copy(), []  # the latter: what adds another mass in each direction, and to which rows
    for effects, rows in models:
        added = contract.added_mass(effects, some_of(bodies, rows))
        if added is not None and isotropic_mass(effects):
            mass[rows] += added[:, 0, :1]  # the same in every direction and attitude: so much more to accelerate
        elif added is not None:
            heavier.append((effects, rows))
    isotropic, n = np.allclose(bodies.inertia, bodies.inertia[:, :1]), len(bodies.mass)
    steady, parts = np.zeros((n, 6)), []
    for rows, effects in forces:
        part = some_of(bodies, rows)
        for effect in effects:
            if isinstance(effect, ConstantForce):
                steady[rows] += effect.forces(part, 0.0)
        acting = [effect.forces for effect in effects if not isinstance(effect, ConstantForce)]
        parts += [(rows, part, acting)] if acting else []

    def rates(time, x, q, twist):
        total = steady.copy()
        for rows, part, answers in parts:
            state, its = part._replace(position=x[rows], orientation=q[rows], twist=twist[rows]), total[rows]
            for answer in answers:
                its += answer(state, time)
            if its.base is not total:  # rows that do not follow one another are a copy
                total[rows] = its
        if not heavier and isotropic:
            return total / np.concatenate([mass, mass, mass, bodies.inertia], axis=1)
        axes, w = rotation_matrices(q), twist[:, 3:]
        if not heavier:
            total[:, :3] /= mass
            euler(axes, w, total[:, 3:].copy(), bodies.inertia, total[:, 3:])
            return total
        inertia = np.einsum("nij,nj,nkj->nik", axes, bodies.inertia, axes)
        total[:, 3:] -= rotations.cross(w, np.einsum("nij,nj->ni", inertia, w))
        effective = np.zeros((n, 6, 6))
        effective[:, [0, 1, 2], [0, 1, 2]] = mass
        effective[:, 3:, 3:] = inertia
        state = bodies._replace(position=x, orientation=q, twist=twist)
        for effects, rows in heavier:
            effective[rows] += contract.added_mass(effects, some_of(state, rows))
        return np.linalg.solve(effective, total[:, :, None])[:, :, 0]

    return rates


def drag_rates(answer, bodies: Bodies, viscous, step):
    """How fast drags in no proportion to speed let a change of velocity decay: (near the final speed, at first), (n, 1) each
    [1/s]; zero where no such drag answers within a step [s]. The second is a power of two times 1 / step.

    A drag like u^p decays at p D/u along the velocity and at D/u across it: 1.5 D/u is near enough to both for p from 1 to 2.

    answer: as `accelerations` gives it; viscous: rates of drags in proportion to speed (n, 1) [1/s].
    """
    start, spin = (bodies.position, bodies.orientation), np.zeros((len(viscous), 3))
    still, velocity = answer(0.0, *start, np.zeros_like(bodies.twist))[:, :3], bodies.twist[:, :3]

    def rate_at(velocity):
        slower = answer(0.0, *start, np.concatenate([velocity, spin], axis=1))[:, :3] - still
        return 1.5 * length_of(slower) / np.maximum(length_of(velocity), 1e-300)

    pull = length_of(still)
    heading, speed = still / np.maximum(pull, 1e-300), 1.5 * pull * step / STIFF  # a final speed below this is reached in a step
    first, final = rate_at(velocity), np.zeros_like(viscous)
    answers = rate_at(speed * heading) * step > STIFF
    if answers.any():
        for _ in range(8):  # each leaves a third of the error of log speed at most
            slowed = (rate_at(speed * heading) / 1.5 + viscous) * speed
            speed = speed * (pull / np.maximum(slowed, 1e-300)) ** (1 / 1.5)
        final = rate_at(speed * heading)
        final = np.where(answers & (final * step > STIFF) & np.isfinite(final), final, 0.0)
    first = np.maximum(final, np.where(np.isfinite(first), first, 0.0)) * step
    return final, np.where(first > STIFF, 2.0 ** np.ceil(np.log2(np.maximum(first, 1.0))), 0.0) / step


class Split(NamedTuple):
    """Accelerations of n bodies in two parts: decays of their velocities, integrated exactly, and what is left."""

    answer: Callable  # all but the drags in proportion to speed, as `accelerations` has it
    decay: np.ndarray  # (n, 1) [1/s]
    beside: np.ndarray  # the part of it that `answer` holds as well (n, 1) [1/s]
    fastest: float  # of all bodies, at first or later [1/s]

    @classmethod
    def of(cls, bodies, models, step):
        """The Split of bodies that fly in steps of so long [s]; models: as `alike` has them of the effects of each."""
        viscous, others = viscous_rates(bodies, models)
        answer = accelerations(bodies, models, others)
        beside, first = drag_rates(answer, bodies, viscous, step)
        return cls(answer, viscous + beside, beside, float((viscous + first).max(initial=0.0)))


def step_lengths(duration, step, fastest):
    """Steps (count,) of `step` [s] that reach to a duration or beyond; short ones first where velocities decay at once.

    fastest: rate of decay [1/s]. Between nodes a motion is taken for a cubic, and a decay from the start is none. The nodes do
    not depend on the duration: a longer flight is the shorter one gone on with, and predictions differ by their models alone.
    """
    first = FIRST / max(fastest, 1e-300)
    growing = first * GROWTH ** np.arange(max(int(np.log(step / first) / np.log(GROWTH)), 0)) if first < step else np.zeros(0)
    growing = growing[np.cumsum(growing) - growing < duration]
    rest = duration - growing.sum()
    count = max(int(np.ceil(rest / step - 1e-9)), 0 if len(growing) else 1)
    return np.concatenate([growing, np.full(count, step)])


def fly(bodies: Bodies, effects, duration, step) -> Track:
    """Fly n bodies for `duration` [s] or a little longer under the effects (gravity among them), in steps of at most `step`."""
    return fly_each(bodies, [tuple(effects)] * len(bodies.mass), duration, step)


def fly_each(bodies: Bodies, effects, duration, step) -> Track:
    """The same with effects of each body: a tuple for each, gravity among them.

    Where a drag in no proportion to speed answers within a step (that of a light body in a liquid) a decay like its own near the
    final speed is integrated exactly, and what is left by Runge-Kutta: stable where the decay is more than half of the true one.
    """
    answer, decay, beside, fastest = Split.of(bodies, alike(effects), step)
    lengths = step_lengths(duration, step, fastest)
    decay, beside = (np.repeat(np.concatenate([part, 0 * part], axis=1), 3, axis=1) for part in (decay, beside))
    count, h, split = len(lengths), 0.0, bool(beside.any())  # no spin decays so

    def rates(time, x, q, v):
        return answer(time, x, q, v) + beside * v if split else answer(time, x, q, v)

    x, q, v = (np.array(part, dtype=float) for part in (bodies.position, bodies.orientation, bodies.twist))
    record = [np.empty((count + 1, *part.shape)) for part in (x, q, v)]
    times = np.concatenate([[0.0], np.cumsum(lengths)])
    for k in range(count + 1):
        for store, value in zip(record, (x, q, v), strict=True):
            store[k] = value
        if k == count:
            break
        if lengths[k] != h:
            h = lengths[k]
            half, whole = Decay.over(-decay * h / 2), Decay.over(-decay * h)
        t = times[k]
        a1 = rates(t, x, q, v)
        v2 = half.left * v + h / 2 * half.one * a1
        a2 = rates(t + h / 2, *moved(x, q, half.one * v, h / 2), v2)  # a steady spin is turned exactly, however fast it is
        v3 = half.left * v + h / 2 * half.one * a2
        mean = np.concatenate([v2[:, :3], (v + v2)[:, 3:] / 2], axis=1)
        a3 = rates(t + h / 2, *moved(x, q, mean, h / 2), v3)
        v4 = half.left * v2 + h / 2 * half.one * (2 * a3 - a1)
        a4 = rates(t + h, *moved(x, q, v3, h), v4)
        # the accelerations as a polynomial of time: a1 + slope s + bend s^2, s from 0 to 1 over the step
        slope, bend = 2 * (a2 + a3) - 3 * a1 - a4, 2 * (a1 + a4 - a2 - a3)
        ahead = moved(x, q, whole.one * v + h * (whole.two * a1 + whole.three * slope + 2 * whole.four * bend), h)
        x, q, v = *ahead, whole.left * v + h * (whole.one * a1 + whole.two * slope + 2 * whole.three * bend)
    position, orientation, twist = record
    velocity, spin = (np.ascontiguousarray(part) for part in (twist[..., :3], twist[..., 3:]))
    return Track(times, position, velocity, orientation, spin, np.zeros((count, len(x)), bool))
