"""What a diagnosis of recordings may cost: how many recordings are screened, how many refitted, and what must be said.

Costs are counted in steps of one body, so that a plan depends on the data alone and not on how busy the computer is.
"""

from dataclasses import replace

import numpy as np

LIMIT = 3.0e6  # body-steps of a search on a tumbling body: some 90 s at 30 us each
SMOOTH = 15.0e6  # the same where recordings are not cut: 6 us each
FLIGHT = 40.0e6  # the same where nothing touches: at most 2 us each, what a step costs by itself counted too
UNITS = 200  # linearisations that a search over the whole library needs
FORWARD, AFTERWARDS = 0.6, 0.8  # parts of the limit after which no round, no exchange is begun
A_REFIT = 7  # linearisations
CONFIRM = 60  # linearisations to fit the model under test and to refit what was accepted, on more recordings
LEFT_OUT = "left out to keep within the limit of time:"
NUMBERS = 13  # runs of a linearisation: one, and one for each number of the start


class Budget:
    """What a search has spent, and what it left out for that."""

    def __init__(self, problem):
        self.shots = problem.shots
        self.limit = (LIMIT if cut(problem) else SMOOTH) if self.shots.contact else FLIGHT
        self.start = self.shots.spent
        self.left_out = []

    @property
    def share(self):
        """Part of the limit that is spent [-]."""
        return (self.shots.spent - self.start) / self.limit

    def search_over(self, what):
        """Is so much spent that no other round is begun? Then `what` is noted as left out."""
        return self._over(FORWARD, what)

    def rivals_over(self, what):
        """The same for exchanges and rivals. In flight there is always enough for them: no verdict goes without its rivals."""
        return self.shots.contact and self._over(AFTERWARDS, what)

    def _over(self, part, what):
        if self.share <= part:
            return False
        self.note(what)
        return True

    def note(self, what):
        """Say that something is left out, once."""
        if what not in self.left_out:
            self.left_out.append(what)

    def refits(self, problem, most, least=2, each=1):
        """How many pieces of work of `each` refits, side by side, what is left allows for: at least and at most so many."""
        if not self.shots.contact:
            return most
        allowed = int((1 - self.share) * self.limit / (2 * each * A_REFIT * max(unit(problem.trials, problem.shots.step), 1.0)))
        return int(np.clip(allowed, least, most))

    def notes(self):
        """Sentences on what was left out."""
        return tuple(f"{LEFT_OUT} {what}" for what in self.left_out)


def cut(problem):
    """Are the recordings of a problem pieces of longer ones?"""
    return any(trial.recording for trial in problem.trials)


def unit(trials, step):
    """Body-steps of one linearisation of recordings."""
    return NUMBERS * sum((trial.times[-1] - trial.times[0]) / step for trial in trials)


def screened(measurement, contact, limit=LIMIT):
    """(Measurement of the recordings to screen, Measurement of those to confirm on, sentences); recordings of every group.

    Without contacts, or where all recordings are cheap enough, both are the measurement itself.
    """
    trials, step = measurement.trials, measurement.file.time_step
    if not contact:
        return measurement, measurement, ()
    each = unit(trials, step) / len(trials)
    few, many = (int(max(limit / (count * each), 1)) for count in (UNITS, CONFIRM))
    if few >= len(trials):
        return measurement, measurement, ()
    order = in_turn(trials)
    first, second = ([trials[k] for k in sorted(order[:count])] for count in (few, many))
    names = ", ".join(trial.name for trial in first[:6]) + " .." * (few > 6)
    rest = "all" if many >= len(trials) else f"{many}; the rest are left out"
    note = (
        f"to keep within the limit of time every candidate is tried on {few} of {len(trials)} recordings ({names}), "
        f"those accepted are refitted on {rest}"
    )
    return replace(measurement, trials=tuple(first)), replace(measurement, trials=tuple(second)), (note,)


def in_turn(trials):
    """Indices of recordings, one of each group after the other, in their order."""
    groups = {}
    for index, trial in enumerate(trials):
        groups.setdefault(trial.group, []).append(index)
    queues = [groups[name] for name in sorted(groups)]
    longest = max(len(queue) for queue in queues)
    return [queue[place] for place in range(longest) for queue in queues if place < len(queue)]
