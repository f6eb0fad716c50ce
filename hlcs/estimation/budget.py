"""What a diagnosis of recordings may cost: how many recordings are screened, how many refitted, and what must be said.

Costs are counted in steps of one body, so that a plan depends on the data alone and not on how busy the computer is.
"""

from dataclasses import replace
from time import perf_counter

import numpy as np

from hlcs.data.notes import OutOfTime, Stopped
from hlcs.processes import interrupts

STOPPED = "stopped by Ctrl-C before its end: what was not fitted by then, sets of effects or a law, is missing from this answer"
IN_TIME = "to keep within the limit of time"
SEGMENTED_LIMIT = 3.0e6  # body-steps from which as many recordings of a tumbling body are screened as these allow for
TUMBLING_LIMIT = 6.0e6  # of a search on them, what a step costs by itself counted: twenty tosses of a cube take 4.4e6, some 90 s
SMOOTH_LIMIT = 10.0e6  # the same where recordings are not in segments: some 100 s at 8 to 12 us each
FLIGHT_LIMIT = 120.0e6  # the same where nothing touches: some 100 s at 0.4 to 0.8 us each
SEARCH_LINEARISATIONS = 250  # that a search over the whole library needs: twenty tosses of a cube are told from four, in 150 s
FIT_LINEARISATIONS = 7  # that a fit takes, as a rule
CONFIRM_LINEARISATIONS = 60  # to fit the model under test and to refit what was accepted, on more recordings
TELLING = 0.02  # part of the limit after which the time left can be told
LINEARISATION_RUNS = 13  # one, and one for each number of the initial state


class Budget:
    """What a search has spent, and what it left out for that."""

    def __init__(self, problem):
        self.problem, self.simulator = problem, problem.simulator
        self.limit = FLIGHT_LIMIT
        if self.problem.contact:
            self.limit = TUMBLING_LIMIT if problem.segmented else SMOOTH_LIMIT
        self.start, self.begun = self.simulator.body_steps, perf_counter()
        self.full = False  # are as many sets fitted as a search may fit?
        self.left_out, self.stopped = 0, False  # sets of effects that wait, or waited in the end; did Ctrl-C end it
        self.numbers, self.on_fits = 0, 0  # how many numbers were fitted, counted once a fit, and what that took

    @property
    def steps(self):
        """Body-steps that are spent."""
        return self.simulator.body_steps - self.start

    @property
    def share(self):
        """Part of the limit that is spent [-]."""
        return self.steps / self.limit

    @property
    def spent(self):
        """Is the limit reached, or are as many sets fitted as a search may fit?"""
        return self.full or self.share > 1

    def stop(self, progress):
        """End here: Ctrl-C is answered by a verdict on what was fitted so far."""
        interrupts.answered()
        self.stopped = True
        progress("stopped: judging what was fitted so far (Ctrl-C again gives up)")

    def fitted(self, numbers, before):
        """Fits of so many numbers were made since so many `steps`: what the next ones take is told from them."""
        self.numbers, self.on_fits = self.numbers + numbers, self.on_fits + self.steps - before

    def time_left(self):
        """Words on how long the search may still take at most, by what it took so far; none before that can be told."""
        if not TELLING < self.share < 1:
            return ""
        seconds = (perf_counter() - self.begun) * (1 / self.share - 1)
        return f", at most {seconds:.0f} s left" if seconds < 100 else f", at most {seconds / 60:.0f} min left"

    def affordable(self, numbers, most):
        """Places of the fits, of so many numbers each, that what is left allows for in one batch, at most so many. Of segments,
        where a fit is a good part of the limit, as told by what each number took so far, those that are too dear passed over;
        through other contacts the first two at least; where nothing touches one after the other."""
        if not self.problem.contact:
            return [0]
        left = (1 - self.share) * self.limit
        if self.problem.segmented and self.numbers:
            places, each = [], self.on_fits / self.numbers
            for place, count in enumerate(numbers):
                if len(places) < most and count * each <= left:
                    places.append(place)
                    left -= count * each
            return places
        cost = 2 * FIT_LINEARISATIONS * linearisation_cost(self.problem.trials, self.simulator.time_step)
        return list(range(len(numbers)))[: int(np.clip(left / max(cost, 1.0), 2, most))]

    def notes(self):
        """Sentences on what was left out."""
        if self.stopped:
            return (Stopped(STOPPED),)
        if not self.left_out:
            return ()
        why = "since so many were fitted" if self.full else IN_TIME
        return (OutOfTime(f"left out {why}: sets of effects that might do as well ({self.left_out})"),)


def linearisation_cost(trials, step):
    """Body-steps of one linearisation of recordings."""
    return LINEARISATION_RUNS * sum((trial.times[-1] - trial.times[0]) / step for trial in trials)


def screening_subset(measurement, contact, limit=SEGMENTED_LIMIT, step=None):
    """(Recordings to screen, Recordings to confirm on, sentences); recordings of every group.

    Without contacts, or where all recordings are cheap enough, both are all Recordings.
    """
    trials, step = measurement.trials, step or measurement.file.time_step
    if not contact:
        return measurement, measurement, ()
    each = linearisation_cost(trials, step) / len(trials)
    few, many = (int(max(limit / (count * each), 1)) for count in (SEARCH_LINEARISATIONS, CONFIRM_LINEARISATIONS))
    if few >= len(trials):
        return measurement, measurement, ()
    groups = [trial.group for trial in trials]  # one recording of each after the other, in their order
    order = sorted(range(len(trials)), key=lambda index: (groups[:index].count(groups[index]), groups[index]))
    first, second = ([trials[k] for k in sorted(order[:count])] for count in (few, many))
    rest = "all" if many >= len(trials) else f"{many}; the rest are left out"
    note = f"every candidate is tried on {told(first, trials)}, those accepted are refitted on {rest}"
    return replace(measurement, trials=tuple(first)), replace(measurement, trials=tuple(second)), (f"{IN_TIME} {note}",)


def only(few, measurement):
    """(Recordings to screen, the same to confirm on, sentences) where already a fit of these few takes what all may take."""
    return few, few, (f"{IN_TIME} {told(few.trials, measurement.trials)} are used; the rest are left out",)


def told(few, trials):
    """Words on how many of the recordings these few are, and their names."""
    names = ", ".join(trial.name for trial in few[:6]) + " .." * (len(few) > 6)
    return f"{len(few)} of {len(trials)} recordings ({names})"
