"""The World: bodies, effects and settings, and the step that moves them. The composition and nothing else."""

from collections import deque
from numbers import Integral
from time import perf_counter

import numpy as np

from minibullet import effects as effect_room
from minibullet import rotations
from minibullet.bodies import ContactLaw
from minibullet.collision.warm_start import NO_CONTACTS, WarmStart
from minibullet.contact import exact, gauss_seidel, sequential_impulse
from minibullet.contact import problem as problems
from minibullet.contact.islands import find_islands
from minibullet.dynamics import constraints, depenetration, impacts, integrate, motion_bounds, seen_by_laws
from minibullet.dynamics.free_motion import free_motion
from minibullet.dynamics.inverse_mass import inverse_mass
from minibullet.errors import InputError, is_number, shown_value
from minibullet.report.display import Display
from minibullet.report.step_report import ContactTable, Step, StepValues
from minibullet.scene import overlaps, running
from minibullet.scene.notices import Notices, step_of
from minibullet.scene.registry import Registry
from minibullet.settings import Settings


class World(Display):
    """Rigid bodies with hard contact under effects that are added from outside.

    effects: values of minibullet.Effect (gravity is one); settings: a Settings value; rescue: a file that takes the last good
    state when a step fails, and beside it, ``.past.npz``, the last hundred (nothing is written if left out). SI units, z up,
    world frame.
    """

    def __init__(self, effects=(), settings=None, *, rescue=None):
        self.effects = (effects,) if isinstance(effects, effect_room.Effect) else tuple(effects)
        self.settings = settings or Settings()
        if not isinstance(self.settings, Settings):
            raise InputError(f"world: settings = {settings!r}; it must be a Settings value")
        self.rescue = rescue
        self._acting = effect_room.compose(self.effects)
        self.registry = Registry()
        self.time, self.steps, self.unsolved_steps, self.worst_residual = 0.0, 0, 0, 0.0
        self.last_step = None
        self._notices = Notices()
        self._past = deque(maxlen=100)  # (time, bodies) after the last steps, kept where there is a rescue file
        self._warm_start = NO_CONTACTS  # the contacts of the last step

    # ---- what stands in the world

    def add(
        self,
        shape,
        *,
        density=None,
        mass=None,
        inertia=None,
        position=(0.0, 0.0, 0.0),
        orientation=(1.0, 0.0, 0.0, 0.0),
        velocity=(0.0, 0.0, 0.0),
        angular_velocity=(0.0, 0.0, 0.0),
        friction=None,
        restitution=None,
        margin=None,
        fixed=False,
        name=None,
        group=None,
    ):
        """Add a body and return its handle. shape: such as Box; density [kg/m3]; mass, in place of density [kg]; inertia:
        principal moments or a 3x3 matrix about the centre of mass, body axes, from the shape where left out [kg m2]; position:
        of the centre of mass [m]; orientation: (w, x, y, z) [-]; velocity [m/s]; angular_velocity, world frame [rad/s];
        friction, restitution: of its contacts [-]; margin: layer around it that contacts keep open, settings.margin where left
        out [m]; fixed: it never moves; name: for messages; group: a number, bodies of different groups never touch.

        Raises InputError that names the body, the field, the value and the remedy.
        """
        return self.registry.add(
            shape,
            name,
            density=density,
            mass=mass,
            inertia=inertia,
            position=position,
            orientation=orientation,
            velocity=velocity,
            angular_velocity=angular_velocity,
            friction=friction,
            restitution=restitution,
            margin=self.settings.margin if margin is None else margin,
            fixed=fixed,
            group=group,
        )

    def add_plane(self, normal=(0.0, 0.0, 1.0), height=0.0, *, friction=None, restitution=None, name=None, group=None):
        """Add the fixed half-space below the plane normal . x = height |normal| and return its handle; it has no margin.
        normal: out of it [-]; height: of the plane along its normal [m]; friction, restitution: of its contacts [-]; name: for
        messages; group: a number, it touches bodies of its own group and of none."""
        return self.registry.add_plane(normal, height, friction, restitution, name, group)

    def freeze(self, bodies=None):
        """Fix bodies where they are; they keep touching others but never move again. bodies: handles, all by default."""
        self.registry.freeze(self.registry.handles if bodies is None else bodies)
        scene = self.registry.scene
        fixed = ~np.isfinite(scene.bodies.mass)
        for first, end in scene.collision.cache.contacts[fixed[scene.collision.cache.bodies].all(axis=1)]:
            self._warm_start.impulse[first:end] = 0.0  # between two fixed bodies nothing would ever change last step's impulse

    def set_aside(self, bodies):
        """Take fixed bodies out of every step: they touch nothing, and cost nothing, until they are brought back. bodies: their
        handles, which keep position and orientation; `World.bodies` does not list them."""
        self.registry.set_aside(list(bodies))

    def bring_back(self, bodies):
        """Bodies that were set aside stand where they stood again, fixed, from the next step on. bodies: their handles."""
        self.registry.bring_back(list(bodies))

    def overlaps(self, tolerance=overlaps.TOUCH):
        """Bodies that overlap where they stand, before any step: rows (handle a, handle b, depth in m), deepest first.

        tolerance: depths below this times the smaller body's radius are touch, not overlap [-].
        """
        scene = self.registry.commit()
        handle = {h._row: h for h in self.registry.handles}
        return [(handle[a], handle[b], depth) for a, b, depth in overlaps.list_overlaps(scene, tolerance)]

    def separate(self, bodies=None, most=200):
        """Push overlapping bodies apart without giving them velocity or turning them.

        bodies: handles of those to be moved, all moving ones by default; most: rounds. Returns the largest distance any of them
        was moved [m].
        """
        scene = self.registry.commit()
        return overlaps.separate(scene, [h._row for h in (self.registry.handles if bodies is None else bodies)], most)

    @property
    def bodies(self):
        """Handles of all bodies, planes left out, in the order they were added."""
        return [handle for handle in self.registry.handles if not handle.is_plane]

    # ---- the step

    def step(self, n=1):
        """Advance by steps of settings.time_step. n: how many."""
        if not isinstance(n, Integral) or n < 0:
            raise InputError(f"step: n = {shown_value(n)}; it must be a whole number >= 0")
        for _ in range(running.whole_steps(f"step: n = {n}", n, self.settings.time_step)):
            self._advance()

    def _advance(self):
        """One step; where it fails or is interrupted the world stays as it was, and is saved where ``rescue`` says."""
        start, last_good = perf_counter(), running.checkpoint(self)
        try:
            self._step()
            self.last_step.wall = perf_counter() - start
        except InputError as error:
            running.roll_back(self, last_good)
            raise running.stopped(self, str(error)) from None
        except BaseException:
            running.roll_back(self, last_good)
            raise

    def _step(self):
        """One step, in physical order. n bodies, m contacts; a twist is a velocity and an angular velocity, a wrench a force and
        a moment. ``free_twist`` is the twist at the end of the step if nothing touched, ``mean_twist`` the mean on the way."""
        scene, settings, dt = self.registry.scene, self.settings, self.settings.time_step
        before = scene.bodies
        rotation = rotations.rotation_matrices(before.orientation)

        # what acts on the bodies: one wrench per effect, and the mass that fluids add
        wrenches = effect_room.wrenches(self._acting, before, self.time)
        inverse = inverse_mass(before, rotation, effect_room.added_mass(self._acting, before))
        free_twist, mean_twist, torque_free_rate = free_motion(before, inverse, wrenches, settings)

        # who touches whom, where, how hard last time: ``narrow_phase.Collision.update``, then ``manifolds.build``
        motion_bound = motion_bounds.motion_bound(before.twist, free_twist, scene.bounding_radius, dt)
        points = scene.contact_points(scene.poses(rotation, motion_bound), self._warm_start)
        gap, size = points.gap, scene.contact_size(points.bodies)
        factors = constraints.contact_factors(points.bodies, points.arms, inverse)
        self._notices.look(self, points.bodies, gap, size, motion_bound, zip(self._acting, wrenches, strict=True), inverse)
        law = self._law(scene, before, free_twist, points, factors)

        # impacts with restitution first, each at its own moment, and what acts otherwise after them; then the resting contacts
        linked, untouched = find_islands(points.bodies, scene.moving), free_twist
        contacts = impacts.ImpactContacts(factors, gap, size, law.restitution, law.friction, *linked)
        impact_impulse, jump, correction, room = impacts.impact_impulses(contacts, scene.moving, before.twist, free_twist, dt)
        if np.count_nonzero(jump):
            later = effect_room.wrenches(self._acting, before._replace(twist=before.twist + jump), self.time)
            wrenches = effect_room.mean_wrenches(wrenches, later, jump, correction, dt)
            free_twist, mean_twist, _ = free_motion(before, inverse, wrenches, settings)
        free_twist, mean_twist = free_twist + jump, mean_twist + jump - correction / dt
        rounding = 1e-14 * motion_bound.max(initial=0.0) / dt  # of the largest speed: what double precision leaves
        problem = constraints.assemble(contacts, law, free_twist, room, rounding, scene.reference_mass, dt)
        solution = self._solve(problem, problems.into_axes(factors.jacobian, points.impulse))  # from last step's impulses

        # move: with the mean twist where gaps allow it, else with the final one; overlap is undone without giving velocity.
        # contact forces act during the whole step, so half of the change that they make counts in the mean
        change = solution.twist - free_twist
        motion = integrate.admissible_motion(
            factors, gap, 1e-7 * size, mean_twist + 0.5 * change, solution.twist - correction / dt, dt
        )
        motion += depenetration.undo_overlap(problem, gap, size, dt)
        after = integrate.integrate(before, motion, solution.twist, torque_free_rate, dt)
        values = StepValues(before, after, wrenches, untouched, points, law, problem, solution, impact_impulse)
        self._finish(scene, motion, values)

    def _law(self, scene, before, free_twist, points, factors):
        """The law at each contact: what the bodies say, changed by the effects that speak of contacts."""
        pair, none = points.bodies, np.zeros(len(points.gap))
        friction = scene.pair_value(scene.friction, pair, self.settings.friction)
        law = ContactLaw(friction, scene.pair_value(scene.restitution, pair, self.settings.restitution), none, none, none)
        if not effect_room.changes_contact_law(self._acting):
            return law
        contacts = seen_by_laws.describe(before, free_twist, points, factors, self.settings.time_step)
        return effect_room.contact_law(self._acting, contacts, before, law)

    def _solve(self, problem, impulse):
        """The Solution of the contact problem by the solver that the settings name, starting from these impulses (m, 3)."""
        settings = self.settings
        moment = np.zeros(impulse.shape)
        if settings.solver == "sequential_impulse":
            return sequential_impulse.solve(
                problem, impulse, moment, iterations=settings.iterations, tolerance=settings.tolerance
            )
        falls_back = settings.solver == "exact"
        # islands that each just pass may fail together, by up to sqrt(3), because each was measured against its own largest
        # of |q|, |r| and |u|: where a second solver can help, Gauss-Seidel has to do better than the tolerance
        goal = 0.5 * settings.tolerance if falls_back else settings.tolerance
        solution = gauss_seidel.solve(problem, impulse, moment, iterations=settings.iterations, tolerance=goal)
        if falls_back and len(solution.unconverged):
            solution = exact.solve_unconverged(problem, solution, settings.tolerance)
        return solution

    def _finish(self, scene, motion, values):
        """Take over the state after the step and publish what happened."""
        after, points, problem, solution = values.after, values.points, values.problem, values.solution
        if not integrate.is_finite(after.position, after.twist):
            fine = np.array([integrate.is_finite(*at) for at in zip(after.position[:, None], after.twist[:, None], strict=True)])
            # what is fixed cannot be the cause: it is named only where nothing that moves is
            bad = int(np.argmin(fine | (~scene.moving & ~fine[scene.moving].all())))
            raise InputError(f"{step_of(self)}: the motion of body {scene.names[bad]!r} is not finite")
        scene.bodies = after
        scene.past_motion = motion_bounds.path_bound(motion, scene.bounding_radius, self.settings.time_step)
        normal, impulse = points.arms[:, 6:].copy(), problems.into_world(problem.factors.jacobian, solution.impulse)
        self._warm_start = WarmStart(points.on_a, points.on_b, normal, impulse)
        self.time += self.settings.time_step
        self.steps += 1
        if self.rescue is not None:
            self._past.append((self.time, after))
        self.unsolved_steps += solution.residual > self.settings.tolerance
        self.worst_residual = max(self.worst_residual, solution.residual)
        self.last_step = Step(self, values)

    # ---- running

    def run(self, duration, *, watch=None):
        """Advance by some time. duration: rounded to whole steps [s]; watch: ``watch(world)`` is called after every step."""
        if not is_number(duration) or not duration >= 0.0:
            raise InputError(f"run: duration = {shown_value(duration)} s; it must be finite and >= 0")
        dt = self.settings.time_step
        for _ in range(running.whole_steps(f"run: duration = {duration!r} s", duration / dt, dt)):
            self._advance()
            if watch is not None:
                watch(self)

    def settle(self, max_time=10.0, *, watch=None, select=None):
        """Advance until nothing moves, or the time is over; returns "at_rest" or "time_limit". max_time: at most so long [s];
        watch: ``watch(world)`` is called after every step; select: ``select(bodies)`` (the Bodies record) says which bodies
        must be at rest, boolean (n,), all moving ones if not given. At rest is: for as long as a free fall over its radius
        takes, every moving body was slower than 2e-3 sqrt(a R), with R its bounding radius and a what effects accelerate it by.
        """
        if not is_number(max_time) or not max_time > 0.0:
            raise InputError(f"settle: max_time = {shown_value(max_time)} s; it must be finite and > 0")
        calm, dt = 0, self.settings.time_step
        for _ in range(max(1, running.whole_steps(f"settle: max_time = {max_time!r} s", max_time / dt, dt))):
            self._advance()
            if watch is not None:
                watch(self)
            slow, wait = running.rest_scale(self.registry.scene, self.last_step.wrenches, select)
            calm = calm + 1 if slow else 0
            if calm and calm * dt >= wait:
                return "at_rest"
        return "time_limit"

    def save(self, path):
        """Write everything to one file (no pickle), whole or not at all; a world loaded from it goes on bit for bit.
        path: of the file."""
        from minibullet.scene import saving  # what only saves is no part of a simulation, and is loaded when it is asked for

        saving.save(self, path)

    @classmethod
    def load(cls, path, effects=None):
        """The world that `save` wrote, bodies in the order they were added. path: of the file; effects: where some are your own.

        Nothing in the file is believed: InputError where it is missing, is not such a file or was changed, where any of it cannot
        be or its parts disagree, or where it holds effects that are not minibullet's.
        """
        from minibullet.scene import saving

        return saving.load(cls, path, effects)

    @property
    def notices(self):
        """What the run has told so far, each thing once, one line each: overlaps, steps too long for a body."""
        return tuple(self._notices.texts)

    @property
    def contacts(self):
        """The contacts of the last step: ``to_dataframe()`` says who touches whom, where, how hard."""
        return ContactTable(self.last_step)
