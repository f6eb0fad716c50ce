"""The books of one step: certificate, energy and momentum. Computed when asked for, from what the step left behind.

Energy: with v- and v+ the twists before and after and v = (v- + v+)/2, the change of kinetic energy is an identity, dT = sum
over effects of dt F.v + contact impulses times the mean relative velocity + terms of rotation and damping. What the lines do
not explain is the ledger defect.
"""

from functools import cached_property
from typing import NamedTuple

import numpy as np

from minibullet import rotations
from minibullet.bodies import Bodies, ContactLaw
from minibullet.collision.manifolds import ContactPoints
from minibullet.contact import problem
from minibullet.contact.gauss_seidel import Solution
from minibullet.contact.problem import ContactProblem
from minibullet.contact.residual import natural_map_error
from minibullet.dynamics import seen_by_laws
from minibullet.effects.contract import name_of
from minibullet.values import table

MOST_ROWS = 12  # contacts that the table in a notebook lists


class StepValues(NamedTuple):
    """The values that one step passes on from part to part."""

    before: Bodies  # when the step began
    after: Bodies  # when it ended
    wrenches: tuple  # one (n, 6) array per effect, world frame [N, N m]
    untouched: np.ndarray  # twist at the end if nothing touched [m/s, rad/s], (n, 6)
    points: ContactPoints  # who touched whom, and where, when the step began
    law: ContactLaw  # what holds at each of these contacts
    problem: ContactProblem
    solution: Solution
    impact_impulse: np.ndarray  # impulses of impacts, contact axes [N s], (m, 3); 0.0 without impacts


class Step:
    """What one step did. Attributes are plain numbers; ``to_dict()`` has them all under the names of the documentation."""

    def __init__(self, world, values):
        self.step, self.time, self.time_step = world.steps, world.time, world.settings.time_step
        self.effects, self.names, self.tolerance = world.effects, tuple(world.registry.scene.names), world.settings.tolerance
        self.before, self.after, self.wrenches, self._untouched, self.points = values[:5]
        self.law, self.problem, self.solution, self.impact_impulse = values[5:]
        self.residual, self.iterations = self.solution.residual, self.solution.iterations
        self.converged = self.solution.residual <= world.settings.tolerance
        self.fcl_calls = world.registry.scene.collision.calls
        self.reference_mass, self.wall = (
            self.problem.reference_mass,
            0.0,
        )  # the world, which has the clock, says how long it took [s]

    @cached_property
    def contacts(self):
        """The Contacts record of the step, as effects saw it."""
        return seen_by_laws.describe(self.before, self._untouched, self.points, self.problem.factors, self.time_step)

    @property
    def impulse(self):
        """Impulse on body b of each contact, world axes [N s], (m, 3); those of impacts included."""
        return problem.into_world(self.problem.factors.jacobian, self.solution.impulse + self.impact_impulse)

    @cached_property
    def final_velocity(self):
        """Relative velocity of each contact at the end of the contact solve, contact axes, the target taken off [m/s], (m, 3)."""
        return problem.velocity_beyond_target(self.problem, self.solution.twist)

    @cached_property
    def components(self):
        """cone, dual, signorini, slip: which part of the law fails, relative
        to the largest impulse and velocity (0 for an exact solution)."""
        r, u, mu = self.solution.impulse, self.final_velocity, self.problem.friction
        q = problem.velocity_beyond_target(self.problem, self.problem.free_twist)
        r_ref = np.abs(r).max(initial=0.0)
        u_ref = max(np.abs(u).max(initial=0.0), np.abs(q).max(initial=0.0))
        if r_ref == 0.0 or u_ref == 0.0:
            return {"cone": 0.0, "dual": 0.0, "signorini": 0.0, "slip": 0.0}
        r_t, u_t = np.sqrt((r[:, 1:] ** 2).sum(axis=1)), np.sqrt((u[:, 1:] ** 2).sum(axis=1))
        slip = mu[:, None] * r[:, :1] * u[:, 1:] + u_t[:, None] * r[:, 1:]
        return {
            "cone": float(max((r_t - mu * r[:, 0]).max(), (-r[:, 0]).max(), 0.0) / r_ref),
            "dual": float(max((-u[:, 0]).max(), 0.0) / u_ref),
            "signorini": float(np.abs(r[:, 0] * u[:, 0]).max() / (r_ref * u_ref)),
            "slip": float(np.sqrt((slip**2).sum(axis=1)).max() / (r_ref * u_ref)),
        }

    def _errors(self, reference_mass):
        """Squared error of the natural map of each contact, impulses over ``reference_mass``, (m,)."""
        rows = zip(self.solution.impulse / reference_mass, self.final_velocity, self.problem.friction, strict=True)
        return np.array([natural_map_error(r, u, mu) for r, u, mu in rows])

    @cached_property
    def residual_rho1(self):
        """The relative residual as other codes publish it, impulses in N s (a reference mass of 1 kg); rolling left out."""
        q = problem.velocity_beyond_target(self.problem, self.problem.free_twist)
        size = max(np.linalg.norm(q), np.linalg.norm(self.solution.impulse), np.linalg.norm(self.final_velocity))
        return float(np.sqrt(self._errors(1.0).sum()) / size) if size > 0.0 else 0.0

    @property
    def penetration(self):
        """Deepest overlap when the step began [m]."""
        return float(max(-self.points.gap.min(initial=0.0), 0.0))

    def _kinetic(self, bodies):
        moving = np.isfinite(bodies.mass)
        rotation = rotations.matrix(bodies.orientation[moving])
        rate = np.einsum("nji,nj->ni", rotation, bodies.twist[moving, 3:])
        return float(
            0.5 * (bodies.mass[moving] * (bodies.twist[moving, :3] ** 2).sum(axis=1)).sum()
            + 0.5 * (bodies.inertia[moving] * rate**2).sum()
        )

    @cached_property
    def kinetic_energy(self):
        """Kinetic energy after the step [J]."""
        return self._kinetic(self.after)

    @cached_property
    def potential_energy(self):
        """Potential energy after the step of the effects that have one, zero where z and all else is zero [J]."""
        moving = np.isfinite(self.after.mass)
        chosen = type(self.after)(*(array[moving] for array in self.after))
        return float(sum(effect.potential(chosen) for effect in self.effects)) if moving.any() else 0.0

    @cached_property
    def work(self):
        """Work of this step by line [J]: every effect by name, contact_normal, contact_friction, rotation (turning of unequal
        moments of inertia and damping) so that the sum is the change of kinetic energy; and ``defect``, what no line
        explains."""
        mean = 0.5 * (self.before.twist + self.after.twist)
        lines = {}
        for effect, wrench in zip(self.effects, self.wrenches, strict=True):
            name = name_of(effect)
            lines[name] = lines.get(name, 0.0) + float(self.time_step * (wrench * mean).sum())
        impulse = self.solution.impulse + self.impact_impulse
        speed = problem.relative_velocity(self.problem.factors, mean)
        lines["contact_normal"] = float((impulse[:, 0] * speed[:, 0]).sum())
        lines["contact_friction"] = float((impulse[:, 1:] * speed[:, 1:]).sum() + self._rolling_work(mean))
        change = self.kinetic_energy - self._kinetic(self.before)
        # rotation and damping: what M dv - dt F - H r leaves, times the mean twist, plus the turn of the inertia
        moving = np.isfinite(self.before.mass)
        step = self.after.twist[moving] - self.before.twist[moving]
        given = self.time_step * sum((w[moving] for w in self.wrenches), np.zeros_like(step))
        total = np.zeros_like(self.before.twist)
        for side, sign in ((0, -1.0), (1, 1.0)):
            np.add.at(
                total,
                self.problem.factors.bodies[:, side],
                sign * np.einsum("mi,mik->mk", impulse, self.problem.factors.jacobian[:, side]),
            )
        momentum = np.concatenate(
            [
                self.before.mass[moving, None] * step[:, :3],
                self._angular(self.after)[moving] - self._angular(self.before)[moving],
            ],
            axis=1,
        )
        left = momentum - given - total[moving]
        turn = change - float((momentum * mean[moving]).sum())
        lines["rotation"] = turn + float((left * mean[moving]).sum()) - self._rolling_work(mean)
        lines["defect"] = change - sum(lines.values())
        return lines

    def _rolling_work(self, mean):
        rate = mean[self.problem.factors.bodies[:, 1], 3:] - mean[self.problem.factors.bodies[:, 0], 3:]
        return float((problem.into_world(self.problem.factors.jacobian, self.solution.moment) * rate).sum())

    def _angular(self, bodies):
        """Angular momentum of each body about its own centre [kg m2/s], (n, 3); zero if fixed."""
        rotation = rotations.matrix(bodies.orientation)
        rate = np.einsum("nji,nj->ni", rotation, bodies.twist[:, 3:])
        return np.einsum(
            "nij,nj->ni",
            rotation,
            np.where(np.isfinite(bodies.mass)[:, None], np.where(np.isfinite(bodies.inertia), bodies.inertia, 0.0) * rate, 0.0),
        )

    @cached_property
    def momentum_defect(self):
        """Largest component of sum m dv - dt sum F - impulses of fixed bodies, over the largest of these terms [-]."""
        moving = np.isfinite(self.before.mass)
        gained = (self.before.mass[moving, None] * (self.after.twist - self.before.twist)[moving, :3]).sum(axis=0)
        pulled = self.time_step * sum((w[moving, :3].sum(axis=0) for w in self.wrenches), np.zeros(3))
        a, b = self.problem.factors.bodies[:, 0], self.problem.factors.bodies[:, 1]
        world = self.impulse
        given = world[~moving[a]].sum(axis=0) - world[~moving[b]].sum(axis=0)
        size = max(np.abs(gained).max(), np.abs(pulled).max(), np.abs(given).max())
        return float(np.abs(gained - pulled - given).max() / size) if size > 0.0 else 0.0

    def _place(self, contact):
        """The names of the two bodies of a contact, and where it is [m]."""
        contacts = self.contacts
        names = self.names[contacts.body_a[contact]], self.names[contacts.body_b[contact]]
        return {"bodies": names, "point": tuple(contacts.point[contact].tolist())}

    def to_dict(self):
        """Everything a step publishes, by name; floats in SI units."""
        speed = np.sqrt((self.after.twist[:, :3] ** 2).sum(axis=1)).max(initial=0.0)
        rate = np.sqrt((self.after.twist[:, 3:] ** 2).sum(axis=1)).max(initial=0.0)
        worst = int(np.argmin(self.contacts.gap)) if len(self.contacts.gap) else None
        work = dict(self.work)
        normal, friction, rotation, defect = (work.pop(k) for k in ("contact_normal", "contact_friction", "rotation", "defect"))
        return {
            "step": self.step,
            "t": self.time,
            "dt": self.time_step,
            "n_contacts": len(self.contacts.gap),
            "n_active": int((self.solution.impulse[:, 0] > 0).sum()),
            "residual": self.residual,
            "residual_rho1": self.residual_rho1,
            "worst_contact": self._place(int(np.argmax(self._errors(self.reference_mass)))) if len(self.contacts.gap) else None,
            "reference_mass": self.reference_mass,
            "converged": bool(self.converged),
            "iterations_outer": self.solution.outer,
            "iterations_inner": self.iterations,
            **self.components,
            "penetration_max": self.penetration,
            "sum_pen2": float((np.minimum(self.contacts.gap, 0.0) ** 2).sum()),
            "deepest_contact": None if worst is None else self._place(worst),
            "E_kin": self.kinetic_energy,
            "E_pot": self.potential_energy,
            "work_by_effect": work,
            "work_normal": normal,
            "work_friction": friction,
            "work_rotation": rotation,
            "ledger_defect": defect,
            "momentum_defect": self.momentum_defect,
            "speed_max": float(speed),
            "omega_max": float(rate),
            "wall_s": self.wall,
        }

    def __repr__(self):
        words = f"{self._contact_words()}, residual {self.residual:.1e} after {self.iterations} iterations"
        return f"<Step {self.step} to t = {self.time:.6g} s: {words}, penetration {self.penetration:.1e} m>"

    def _contact_words(self):
        count = len(self.points.gap)
        return f"{count} contact{'' if count == 1 else 's'}"

    def _repr_html_(self):
        rows = [
            ("kinetic energy", f"{self.kinetic_energy:.6g}", "J"),
            ("potential energy", f"{self.potential_energy:.6g}", "J"),
            *((f"work: {name.replace('_', ' ')}", f"{value:.3g}", "J") for name, value in self.work.items()),
        ]
        return table(repr(self), ("quantity", "value", "unit"), rows)

    def plot(self, ax=None):
        """Draw what changed the kinetic energy: the work of every effect and of the contacts [J]. ax: Axes to draw on, new ones
        where left out; returns the Axes."""
        from minibullet.report import curves  # what only draws is loaded when something is drawn: no run needs it

        return curves.work_axes(self, ax)


class ContactTable:
    """Contacts of one step, for reading."""

    def __init__(self, step):
        self._step = step

    def __len__(self):
        return 0 if self._step is None else len(self._step.contacts.gap)

    def __repr__(self):
        if not len(self):
            return "<no contacts: no step was made>" if self._step is None else "<no contacts in the last step>"
        frame = self.to_dataframe()
        force, depth = frame["normal_force"].max(), max(-frame["gap"].min(), 0.0)
        return f"<{self._step._contact_words()}: normal force up to {force:.4g} N, penetration up to {depth:.1e} m>"

    def _repr_html_(self):
        frame = self.to_dataframe()
        rows = [
            (
                row.body_a,
                row.body_b,
                f"{row.x:.4g}, {row.y:.4g}, {row.z:.4g}",
                f"{row.gap:.2e}",
                f"{row.normal_force:.4g}",
                f"{row.friction_force:.4g}",
                f"{row.friction:.4g}",
            )
            for row in frame.head(MOST_ROWS).itertuples()
        ]
        head = ("body a", "body b", "point [m]", "gap [m]", "normal force [N]", "friction force [N]", "friction coefficient [-]")
        more = len(frame) - MOST_ROWS
        return table(repr(self), head, rows) + (f"<p>and {more} more</p>" if more > 0 else "")

    def plot(self, ax=None):
        """Draw the friction force of every contact over its normal force, beside Coulomb's limit [N]: what is on it slides.
        ax: Axes to draw on, new ones where left out; returns the Axes."""
        from minibullet.report import curves

        return curves.friction_axes(self.to_dataframe(), ax)

    def to_dataframe(self):
        """One row a contact: body_a, body_b, point x y z [m], normal x y z (a to b), gap [m], normal_force [N],
        friction_force [N], friction."""
        import pandas as pd

        names = (
            "body_a",
            "body_b",
            "x",
            "y",
            "z",
            "normal_x",
            "normal_y",
            "normal_z",
            "gap",
            "normal_force",
            "friction_force",
            "friction",
        )
        if self._step is None:
            return pd.DataFrame({name: [] for name in names})
        contacts, force = self._step.contacts, (self._step.solution.impulse + self._step.impact_impulse) / self._step.time_step
        columns = (
            [self._step.names[a] for a in contacts.body_a],
            [self._step.names[b] for b in contacts.body_b],
            *contacts.point.T,
            *contacts.normal.T,
            contacts.gap,
            force[:, 0],
            np.sqrt((force[:, 1:] ** 2).sum(axis=1)),
            self._step.law.friction,
        )
        return pd.DataFrame(dict(zip(names, columns, strict=True)))
