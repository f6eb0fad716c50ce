"""Runs of a model, many initial states at a time: flights in one batch, runs with contacts beside each other in one World."""

from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from hlcs.data.rigid_body import rigid_body
from hlcs.effects.contract import Scene, Setup
from hlcs.simulation import contact_motion
from hlcs.simulation.batching import current_task
from hlcs.simulation.free_flight import Split, alike, fly_each, step_lengths
from hlcs.simulation.initial_state import fastest_slide, height_on_floor
from minibullet import rotations
from minibullet.bodies import Bodies
from minibullet.effects import Gravity, TiltedGravity
from minibullet.errors import InputError

STEP_COST = {False: 300, True: 30}  # with contacts? -> bodies that cost as much as one step costs however few there are
MOST_IN_A_WORLD = 600  # runs in one World: more are no cheaper together, and need more memory
MOST_FLOWN = 2_000_000  # steps of bodies in one flight: what is recorded of them takes 200 MB
STEADY = 0.7  # way of a flat body in one step, in heights of its centre above the floor: at 1 it begins to chatter [-]
SHORT = 1e-3  # no step is shorter for that [s]: a phone 8 mm high slides at 3 m/s without chatter
IN_FLIGHT = 1 / 15  # shortest first step of flights [s]: halved as far as the data need it (`kinds.trajectories.time_step`)
FARTHEST = 2.0  # times what was recorded: so long a run goes on at most, to show what a clock that is late shows
MOST_OBSERVED = 250_000  # samples observed in one go: what that takes on the way is some 300 MB


def step_of_reading(trials, seated, step):
    """The time step [s] of runs that shows what accelerometers read: the usual one, or a shorter one where trials have them.

    No longer than a reading, which is a difference of velocities between two nodes. A flat body that slides on its floor farther
    in one step than its centre lies above it chatters: its face is lifted, and falls.
    """
    steps = [step]
    for trial, on_floor in zip(trials, seated, strict=True):
        if trial.accelerations:
            steps.append(trial.accelerations.window)
            if on_floor:
                steps.append(max(STEADY * height_on_floor(trial) / max(fastest_slide(trial), 1e-9), SHORT))
    return min(steps)


def step_of_flights(trials):
    """The first time step [s] of flights: as long as it takes from one reading to the next, and no shorter than IN_FLIGHT."""
    spacings = [float(np.median(np.diff(trial.times))) for trial in trials if len(trial.times) > 1]
    return max(IN_FLIGHT, min(spacings, default=IN_FLIGHT))


class Motion(NamedTuple):
    """What a run shows at the n times of its trial."""

    position: np.ndarray  # (n, 3) [m]
    orientation: np.ndarray  # (n, 4)
    specific_force: np.ndarray | None = None  # read by an accelerometer at the centre of mass (n, 3) [m/s2]


class Request(NamedTuple):
    """Runs of one model that are asked for, and what acts in them."""

    model: object  # a Model
    initial_states: np.ndarray  # (B, 13)
    owner: np.ndarray  # trial of each (B,)
    time_step: float | None  # [s], None = the usual one
    setups: list  # Setup of each
    effects: list  # of each, a tuple
    changes: list  # of what the camera sees

    def of_runs(self, runs, time_step):
        """Of some of the runs (indices), in these steps."""
        setups, effects = ([its[run] for run in runs] for its in (self.setups, self.effects))
        states, owner = self.initial_states[runs], self.owner[runs]
        return self._replace(initial_states=states, owner=owner, time_step=time_step, setups=setups, effects=effects)


class Simulator:
    """Runs a model for trials, many perturbed initial states at a time.

    An initial state is (13,): position of the centre of mass, velocity, orientation (w, x, y, z), angular velocity, world frame,
    at `start_time` of its trial on the trial's own clock.
    """

    def __init__(self, model, trials, start_time, contact=False, step=None, seated=None):
        self.trials = tuple(trials)
        self.contact = contact
        self.seated = np.zeros(len(self.trials), bool) if seated is None else np.asarray(seated)
        self.start_time = np.asarray(start_time, dtype=float)
        heights = np.concatenate([trial.position[np.isfinite(trial.position[:, 2]), 2] for trial in self.trials])
        self.height_range = (float(heights.min()), float(heights.max())) if len(heights) else (0.0, 1.0)  # of all trials [m]
        usual = model.time_step if contact else step_of_flights(self.trials)
        self.time_step = step or step_of_reading(self.trials, self.seated, usual)  # [s]
        self.durations = durations = np.array([trial.times[-1] for trial in self.trials]) - self.start_time
        self.duration_class = np.zeros(len(durations), int)  # of one class share a World, where all go on as long as the longest
        if any(trial.recording for trial in self.trials):
            self.duration_class = np.ceil(np.log2(durations / durations.min()) - 1e-9).astype(int)
        self.halvings = np.zeros(len(durations), int)  # of the step, of trials with contacts that need shorter ones
        self.body_steps = 0  # bodies times steps simulated, what a step costs by itself counted as bodies

    @property
    def of_trials(self):
        """What belongs to each trial: its start time [s], whether it is seated, and the halvings of its step."""
        return self.start_time, self.seated, self.halvings

    def for_trials(self, model, trials, start_time, seated, halvings):
        """A Simulator of other trials of the same scene, in the same steps: heights lie in the range that they have here."""
        other = Simulator(model, trials, start_time, self.contact, self.time_step, seated)
        other.halvings[:] = halvings
        other.height_range = self.height_range
        return other

    def simulate(self, model, initial_states, owner, time_step=None):
        """The Motion at the times of trials[owner[b]], a list, for initial states (B, 13), owner (B,)."""
        (answer,) = self.simulate_all([(model, initial_states, owner, time_step)])
        if isinstance(answer, Exception):
            raise answer
        return answer

    def simulate_all(self, requests):
        """What `simulate` gives for each request (model, initial_states, owner, time_step), or the InputError that it raises.

        Everything that can be simulated together is; a request made inside of `run_tasks` waits for the others.
        """
        task = current_task()
        if task is not None:
            return task.ask(requests)
        answers, compatible = [], {}  # the latter: (time step, what else must be equal) -> [(index of the request, its runs)]
        for index, asked in enumerate(requests):
            try:
                request = self._set_up(*asked)
            except InputError as error:
                answers.append(error)
                continue
            answers.append([None] * len(request.owner))
            for step, key, runs in self._in_a_world(request) if self.contact else self._in_a_flight(index, request):
                compatible.setdefault((step, key), []).append((index, request.of_runs(runs, step), runs))
        for (time_step, _), members in compatible.items():
            size = np.cumsum([0] + [len(runs) for *_, runs in members])[:-1]
            if self.contact:
                batch = size // MOST_IN_A_WORLD
            else:
                batch = size * int(np.max(self.durations) / (time_step or self.time_step) + 2) // MOST_FLOWN
            for number in np.unique(batch):
                inside = [member for member, its in zip(members, batch, strict=True) if its == number]
                found = self._batch_or_errors([request for _, request, _ in inside])
                for (index, _, runs), answer in zip(inside, found, strict=True):
                    if isinstance(answer, Exception):
                        answers[index] = answer
                    elif not isinstance(answers[index], Exception):
                        for run, motion in zip(runs, answer, strict=True):
                            answers[index][run] = motion
        return answers

    def _batch_or_errors(self, requests):
        """Answers to requests that share a World or a flight; where one of them is at fault they are halved till it is alone."""
        try:
            return self._batch(requests)
        except InputError as error:
            half = len(requests) // 2
            if not half:
                return [error]
            return self._batch_or_errors(requests[:half]) + self._batch_or_errors(requests[half:])

    def _in_a_world(self, request):
        """[(time step, duration class, runs)] of a Request with contacts."""
        owner, step = request.owner, request.time_step or self.time_step
        its = np.column_stack([self.halvings[owner], self.duration_class[owner]])
        return [(step / 2.0 ** key[0], key[1], np.flatnonzero((its == key).all(axis=1))) for key in np.unique(its, axis=0)]

    def _in_a_flight(self, index, request):
        """[(time step, what runs that fly together have in common, runs)]: the same surroundings, but for floors: nothing touches
        them, and effects that know of one are each run's own. A model whose first steps are short flies alone: its steps are not
        to depend on others."""
        owner, shared = request.owner, {}
        for b, who in enumerate(owner):
            key = replace(self.trials[who].surroundings, floor_height=None, floor_normal=())
            shared.setdefault(key, []).append(b)
        steps, found = np.ceil(self.durations / self.time_step).astype(int) + 1, []
        for key, members in shared.items():
            alone = _decays_at_once(request.of_runs(members, request.time_step or self.time_step))
            shared_with = key, index if alone else None
            found += [(request.time_step, shared_with, np.array(part)) for part in partition(members, steps[owner], MOST_FLOWN)]
        return found

    def _batch(self, requests):
        """Answers to Requests that share a time step, all runs in one simulation."""
        ends = np.cumsum([0] + [len(request.owner) for request in requests])
        spans, changes = [slice(*its) for its in pairwise(ends.tolist())], [request.changes for request in requests]
        initial_states, owner = (np.concatenate([request[part] for request in requests]) for part in (1, 2))
        setups, effects = ([one for request in requests for one in request[part]] for part in (4, 5))
        samples = [self.trials[who].times - self.start_time[who] for who in owner]
        step = requests[0].time_step or self.time_step
        duration = last = max(max(float(times.max()) for times in samples), step)
        for span, its_changes in zip(spans, changes, strict=True):
            if its_changes:  # a clock that is late shows what came after
                latest = self._latest(span, its_changes, samples, initial_states, owner)
                duration = max(duration, 1.06 * last + 0.05, min(latest, FARTHEST * last))
        track = self._track(setups, initial_states, owner, effects, duration, step)
        models = 1 if self.contact else len(requests)  # what acts in flight is asked of each by itself
        self.body_steps += (len(owner) + STEP_COST[self.contact] * models) * (len(track.times) - 1)
        return [
            self._observe(track, span, its_changes, samples, initial_states, owner, effects)
            for span, its_changes in zip(spans, changes, strict=True)
        ]

    def _set_up(self, model, initial_states, owner, time_step):
        """The Request."""
        built, setups = {}, {}  # by surroundings, by trial
        for who in owner:
            trial = self.trials[who]
            if trial.surroundings not in built:
                built[trial.surroundings] = model.changes(trial.surroundings)
            if who not in setups:
                setup = Setup(trial.body, trial.surroundings)
                for change in built[trial.surroundings][1]:
                    setup = change.setup(setup)
                setups[who] = setup
        effects = [built[self.trials[who].surroundings][0] for who in owner]
        changes = built[self.trials[owner[0]].surroundings][2]
        return Request(model, initial_states, owner, time_step, [setups[who] for who in owner], effects, changes)

    def _observe(self, track, span, changes, samples, initial_states, owner, effects):
        """What camera and accelerometer saw of the runs `span` of a Track, [Motion]; samples: their times."""
        observed = [None] * (span.stop - span.start)
        lengths = np.array([len(times) for times in samples])
        for some in partition(range(span.start, span.stop), lengths, MOST_OBSERVED):
            part = track if len(some) == len(samples) else track.subset(some)
            observe = self._through(part.observe, changes, initial_states[some], owner[some])
            rows = np.arange(max(lengths[some]))  # of the longest; the others have their last time again
            times = np.stack([samples[b][np.minimum(rows, lengths[b] - 1)] for b in some])
            position, orientation = observe(times)
            force = self._specific_force(part, times, owner[some], [effects[b] for b in some], changes)
            for place, b in enumerate(some):
                seen = (None if values is None else values[place, : lengths[b]] for values in (position, orientation, force))
                observed[b - span.start] = Motion(*seen)
        return observed

    def _through(self, observe, changes, initial_states, owner):
        """What the camera sees of some runs, where `observe` is what they do: a function of times, as `Change.look` has it."""
        if changes:
            stated = np.array(["velocity" in self.trials[who].start for who in owner])
            still, sessions = np.all(initial_states[:, 3:6] == 0, axis=1) & stated, [self.trials[who].session for who in owner]
            scene = Scene(still, *self.height_range, np.array(sessions))
            for change in changes:
                observe = change.look(observe, scene)
        return observe

    def _latest(self, span, changes, samples, initial_states, owner):
        """The latest time that changes of what the camera sees ask for of the runs `span` [s]."""
        asked = []

        def observe(times):
            asked.append(float(np.max(times, initial=0.0)))
            return np.zeros((*times.shape, 3)), np.broadcast_to([1.0, 0.0, 0.0, 0.0], (*times.shape, 4))

        ends = np.array([times[[0, -1]] for times in samples[span]])
        self._through(observe, changes, initial_states[span], owner[span])(ends)
        return max(asked, default=0.0)

    def _specific_force(self, track, times, owner, effects, changes):
        """What accelerometers read on all runs of a Track at times (B, n), (B, n, 3) [m/s2]; None where no trial has one.

        The acceleration less the field of gravity, which pulls at the body and at all parts of the instrument alike.
        """
        read = [self.trials[who].accelerations for who in owner]
        if not any(read):
            return None
        window = np.array([each.window if each else 1.0 for each in read])[:, None]
        gravity = [sum(effect.field for effect in acting if isinstance(effect, Gravity | TiltedGravity)) for acting in effects]
        force = track.mean_acceleration(times, window) - np.array(gravity)[:, None]
        in_body = [bool(each and each.in_body) for each in read]
        if any(in_body):
            turns = rotations.conjugate(track.observe(times)[1][in_body])
            force[in_body] = rotations.rotate(turns, force[in_body])
        for change in changes:
            force = change.read(force)
        return force

    def _track(self, setups, initial_states, owner, effects, duration, step):
        """Track of the tracked points, by flight alone or with contacts; effects: of every run."""
        bodies, centres = [rigid_body(setup.body) for setup in setups], np.array([setup.centre for setup in setups])
        if self.contact:
            initial_states = np.array(
                [
                    contact_motion.seat(body.shape, state, self.trials[who].surroundings, setup.surroundings, setup.margin)
                    if self.seated[who]
                    else state
                    for body, state, who, setup in zip(bodies, initial_states, owner, setups, strict=True)
                ]
            )
        off_centre = bool(centres.any())
        if off_centre:
            initial_states = initial_states.copy()
            arms = rotations.rotate(initial_states[:, 6:10], centres)
            initial_states[:, :3] += arms
            initial_states[:, 3:6] += np.cross(initial_states[:, 10:13], arms)
        if self.contact:
            runs = [
                contact_motion.run_of(body, setup, state, acting, off_centre)
                for body, setup, state, acting in zip(bodies, setups, initial_states, effects, strict=True)
            ]
            track = contact_motion.simulate(runs, duration, step)
        else:
            track = _flight(bodies, initial_states, effects, duration, step)
        if off_centre:
            arms = rotations.rotate(track.orientation, centres[None])
            track = track._replace(position=track.position - arms, velocity=track.velocity - np.cross(track.spin, arms))
        return track


def _flight(bodies, initial_states, effects, duration, step):
    """Track of rigid bodies that fly from initial states (B, 13), orientations those of their own axes; effects: of each."""
    with np.errstate(all="ignore"):  # a run may leave what can be; its chi2 is then not finite and it is refused
        track = fly_each(_flying(bodies, initial_states), effects, duration, step)
    back = rotations.conjugate(np.array([body.turn for body in bodies]))
    return track._replace(orientation=rotations.product(track.orientation, back))


def _decays_at_once(request):
    """Does a drag slow a body so fast that its flight begins with steps shorter than those of the Request?"""
    bodies, step = _flying([rigid_body(setup.body) for setup in request.setups], request.initial_states), request.time_step
    with np.errstate(all="ignore"):
        return step_lengths(step, step, Split.of(bodies, alike(request.effects), step).fastest)[0] < step


def _flying(bodies, initial_states):
    """Bodies of rigid bodies at initial states (B, 13), as `_flight` has them."""
    return Bodies(
        initial_states[:, :3],
        rotations.product(initial_states[:, 6:10], np.array([body.turn for body in bodies])),
        np.concatenate([initial_states[:, 3:6], initial_states[:, 10:13]], axis=1),
        *(np.array([getattr(body, name) for body in bodies]) for name in ("mass", "inertia", "volume", "area", "radius")),
    )


def partition(members, sizes, most):
    """Members in lists, each as long as its largest size times its length stays within `most`; sorted by size where they do not.

    members: indices into sizes. All are treated as the largest of their list is, so that like goes with like.
    """
    members = list(members)
    if len(members) * max(sizes[b] for b in members) <= most:
        return [members]
    parts = [[]]
    for b in sorted(members, key=lambda b: sizes[b]):
        if parts[-1] and (len(parts[-1]) + 1) * sizes[b] > most:
            parts.append([])
        parts[-1].append(b)
    return parts
