"""Runs of a model, many starts at a time: in flight all in one batch, with contacts side by side in one World."""

from dataclasses import replace

import numpy as np

from hlcs.data.rigid_body import solid
from hlcs.effects.contract import Scene, Setup
from hlcs.simulation.batching import asker
from hlcs.simulation.free_flight import fly
from minibullet import rotations
from minibullet.bodies import Bodies
from minibullet.errors import InputError

A_STEP = 300  # bodies that cost as much as one step in flight costs however few fly
MOST_TOGETHER = 600  # runs in one World: more are no cheaper together, and need more memory
MOST_FLOWN = 2_000_000  # steps of bodies in one flight: what is recorded of them takes 200 MB
MOST_LOOKED_AT = 250_000  # samples looked at in one go: what that takes on the way is some 300 MB


class Shots:
    """Runs the model for trials, many perturbed starts at a time.

    A start is (13,): position of the centre of mass, velocity, orientation (w, x, y, z), angular velocity, world frame, at
    `start_time` of its trial on the trial's own clock.
    """

    def __init__(self, model, trials, start_time, contact=False, step=None, seated=None):
        self.trials = tuple(trials)
        self.contact = contact
        self.seated = np.zeros(len(self.trials), bool) if seated is None else np.asarray(seated)
        self.start_time = np.asarray(start_time, dtype=float)
        heights = [trial.position[np.isfinite(trial.position[:, 2]), 2] for trial in self.trials]
        heights = np.concatenate(heights) if heights else np.zeros(0)
        self.range = (float(heights.min()), float(heights.max())) if len(heights) else (0.0, 1.0)
        self.step = step or (model.time_step if contact else 1 / 30)
        self.spans = spans = np.array([trial.times[-1] for trial in self.trials]) - self.start_time
        self.class_of = np.zeros(len(spans), int)  # runs of one class share a World: there all go on as long as the longest
        if any(trial.recording for trial in self.trials):
            self.class_of = np.ceil(np.log2(spans / spans.min()) - 1e-9).astype(int)
        self.spent = 0  # bodies times steps simulated
        self.pair = ()  # two steps [s], the second half the first: what both give is carried on to a step of zero

    def simulate(self, model, starts, owner, time_step=None):
        """[(position (n, 3), orientation (n, 4)) at the sample times of trials[owner[b]]] for starts (B, 13), owner (B,)."""
        (answer,) = self.simulate_all([(model, starts, owner, time_step)])
        if isinstance(answer, Exception):
            raise answer
        return answer

    def simulate_all(self, requests):
        """What `simulate` gives for each request (model, starts, owner, time_step), or the InputError that it raises.

        With contacts everything runs side by side in one World; a request made inside of `together` waits for the others.
        """
        piece = asker()
        if piece is not None and self.contact:
            return piece.ask(requests)
        if not self.contact:
            return [self._alone(request) for request in requests]
        if not self.pair:
            return self._side_by_side(requests)
        coarse, fine = ([(*request[:3], request[3] or step) for request in requests] for step in self.pair)
        answers = self._side_by_side(coarse + fine)
        return [carried_on(*both) for both in zip(answers[: len(requests)], answers[len(requests) :], strict=True)]

    def _side_by_side(self, requests):
        """Answers to requests with contacts, those of one time step and one class of durations in one World."""
        answers = [[None] * len(request[1]) for request in requests]
        alike = {}  # (time step, class) -> [(index of the request, its runs)]
        for index, (_, _, owner, time_step) in enumerate(requests):
            for kind in np.unique(self.class_of[owner]):
                alike.setdefault((time_step, kind), []).append((index, np.flatnonzero(self.class_of[owner] == kind)))
        for (time_step, _), members in alike.items():
            before = np.cumsum([0] + [len(runs) for _, runs in members])[:-1]
            for number in np.unique(before // MOST_TOGETHER):
                some = [member for member, place in zip(members, before // MOST_TOGETHER, strict=True) if place == number]
                asked = [
                    (requests[index][0], requests[index][1][runs], requests[index][2][runs], time_step) for index, runs in some
                ]
                try:
                    found = self._batch(asked)
                except InputError:  # one of them is at fault: which one?
                    found = [self._alone(request) for request in asked]
                for (index, runs), answer in zip(some, found, strict=True):
                    if isinstance(answer, Exception):
                        answers[index] = answer
                    elif not isinstance(answers[index], Exception):
                        for run, one in zip(runs, answer, strict=True):
                            answers[index][run] = one
        return answers

    def _alone(self, request):
        """The answer to one request, or the InputError."""
        model, starts, owner, time_step = request
        try:
            answers = [None] * len(owner)
            for members in self._together(model, owner):
                inside = np.array(members)
                (found,) = self._batch([(model, starts[inside], owner[inside], time_step)])
                for b, answer in zip(members, found, strict=True):
                    answers[b] = answer
            return answers
        except InputError as error:
            return error

    def _together(self, model, owner):
        """Runs that can share one flight: same surroundings, save that floors may differ where no effect reads them."""
        if self.contact:
            return [range(len(owner))]
        floors_matter = bool({"wall_drag", "ground_cushion"} & set(model.names))
        kinds = {}
        for b, who in enumerate(owner):
            surroundings = self.trials[who].surroundings
            key = surroundings if floors_matter else replace(surroundings, floor_height=None, floor_normal=())
            kinds.setdefault(key, []).append(b)
        steps = np.ceil(self.spans / self.step).astype(int) + 1
        return [part for members in kinds.values() for part in parted(members, steps[owner], MOST_FLOWN)]

    def _batch(self, requests):
        """Answers to requests that share a time step, all runs in one simulation."""
        runs, acting, looks, spans = [], [], [], []
        for model, starts, owner, _ in requests:
            built, setups = {}, {}
            first = len(runs)
            for start, who in zip(starts, owner, strict=True):
                trial = self.trials[who]
                if trial.surroundings not in built:
                    built[trial.surroundings] = model.changes(trial.surroundings)
                effects, changes, _ = built[trial.surroundings]
                if who not in setups:
                    setup = Setup(trial.body, trial.surroundings)
                    for change in changes:
                        setup = change.setup(setup)
                    setups[who] = setup
                runs.append((setups[who], start, who))
                acting.append(effects)
            spans.append(slice(first, len(runs)))
            looks.append(built[self.trials[owner[0]].surroundings][2])
        owner, starts = np.array([who for _, _, who in runs]), np.array([start for _, start, _ in runs])
        samples = [self.trials[who].times - self.start_time[who] for who in owner]
        step = requests[0][3] or self.step
        duration = max(max(float(times.max()) for times in samples), step)
        duration += 0.06 * duration + 0.05 if any(looks) else 0.0
        track = self._move([setup for setup, _, _ in runs], starts, owner, acting, duration, step)
        self.spent += (len(runs) + (0 if self.contact else A_STEP)) * (len(track.times) - 1)
        answers = []
        for span, changes in zip(spans, looks, strict=True):
            mine, answer = self.trials[owner[span.start]].surroundings, [None] * (span.stop - span.start)
            lengths = np.array([len(times) for times in samples])
            for some in parted(range(span.start, span.stop), lengths, MOST_LOOKED_AT):
                look = (track if len(some) == len(runs) else track.of(some)).look
                if changes:
                    still = np.all(starts[some, 3:6] == 0, axis=1) & np.array(
                        ["velocity" in self.trials[who].start for who in owner[some]]
                    )
                    scene = Scene(starts[some, :3], still, mine.floor_height, *self.range)
                    for change in changes:
                        look = change.look(look, scene)
                longest = max(lengths[some])
                position, orientation = look(np.stack([np.pad(samples[b], (0, longest - lengths[b]), mode="edge") for b in some]))
                for place, b in enumerate(some):
                    answer[b - span.start] = position[place, : lengths[b]], orientation[place, : lengths[b]]
            answers.append(answer)
        return answers

    def _move(self, setups, starts, owner, effects, duration, step):
        """Track of the tracked points, by flight alone or with contacts; effects: of every run, in flight the same for all."""
        solids = [solid(setup.body) for setup in setups]
        centres = np.array([setup.centre for setup in setups])
        shapes = [s.shape for s in solids]
        if self.contact:
            from hlcs.simulation import contact_motion

            starts = np.array(
                [
                    contact_motion.seat(shape, start, self.trials[who].surroundings, setup.surroundings, setup.margin)
                    if self.seated[who]
                    else start
                    for shape, start, who, setup in zip(shapes, starts, owner, setups, strict=True)
                ]
            )
            # a gap that contacts keep open lifts the floor: the body touches, rolls and turns with its own surface
            floors = [
                None
                if setup.surroundings.floor_height is None
                else (setup.surroundings.floor_normal, setup.surroundings.floor_height + setup.margin)
                for setup in setups
            ]
        starts = starts.copy()
        off_centre = bool(centres.any())
        if off_centre:
            arms = rotations.rotate(starts[:, 6:10], centres)
            starts[:, :3] += arms
            starts[:, 3:6] += np.cross(starts[:, 10:13], arms)
            shapes = [
                contact_motion.off_centre(shape, setup.centre) if self.contact else shape
                for shape, setup in zip(shapes, setups, strict=True)
            ]
        if self.contact:
            track = contact_motion.run(
                solids,
                shapes,
                starts,
                floors,
                effects,
                np.array([setup.surroundings.friction for setup in setups]),
                np.array([setup.surroundings.restitution for setup in setups]),
                duration,
                step,
            )
        else:
            turn = np.array([s.turn for s in solids])
            twist = np.concatenate([starts[:, 3:6], starts[:, 10:13]], axis=1)
            state = Bodies(
                starts[:, :3],
                rotations.product(starts[:, 6:10], turn),
                twist,
                *(np.array([getattr(s, name) for s in solids]) for name in ("mass", "inertia", "volume", "area", "radius")),
            )
            track = fly(state, effects[0], duration, step)
            track = track._replace(orientation=rotations.product(track.orientation, rotations.conjugate(turn)))
        if off_centre:
            arms = rotations.rotate(track.orientation, centres[None])
            track = track._replace(position=track.position - arms, velocity=track.velocity - np.cross(track.spin, arms))
        return track


def parted(members, sizes, most):
    """Members in lists, each as long as its largest size times its length stays within `most`; sorted by size where they do not.

    members: indices into sizes. All are treated as the largest of their list is, so that like goes with like.
    """
    members = list(members)
    if len(members) * max(sizes[b] for b in members) <= most:
        return [members]
    found = [[]]
    for b in sorted(members, key=lambda b: sizes[b]):
        if found[-1] and (len(found[-1]) + 1) * sizes[b] > most:
            found.append([])
        found[-1].append(b)
    return found


def carried_on(coarse, fine):
    """Answers (positions, orientations) of one request at a step and at half of it -> at a step of zero; an error stays one.

    Richardson's extrapolation of an error of first order, Phil. Trans. R. Soc. A 210 (1911) 307.
    """
    if isinstance(coarse, Exception) or isinstance(fine, Exception):
        return coarse if isinstance(coarse, Exception) else fine
    return [
        (2 * near - far, rotations.product(rotations.product(turn, rotations.conjugate(before)), turn))
        for (far, before), (near, turn) in zip(coarse, fine, strict=True)
    ]
