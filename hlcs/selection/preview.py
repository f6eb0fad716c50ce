"""Sets of effects simulated before any fit: where a fit of them begins, and what a linear model cannot foresee."""

from functools import partial

import numpy as np

from hlcs.estimation.fitting import chi2_of
from hlcs.estimation.segment_profiles import best
from hlcs.selection.thresholds import LOOKED
from hlcs.simulation.model import Term
from minibullet.errors import InputError

NEARER = (1, 1 / 2, 1 / 4, 1 / 8, 0)  # parts of the way to the numbers that were foreseen
HERE = (1,)  # the same where they are looked at through contacts: impacts bend the way there, and one simulation shows it
FARTHER = (1, 2, 4, 8, 16)  # times that way: seen from no drag, drops that a drag hardly lets bounce foretell a sixteenth of it


class Preview:
    """What the model under test does with effects in it, at numbers {effect: {number: value}}."""

    def __init__(self, problem, model, candidates):
        """candidates: name -> Candidate."""
        self.problem, self.model, self.candidates = problem, model, candidates

    def model_with(self, numbers):
        """The model under test with these effects in it; what acts through a drag stands behind it."""
        model = self.model
        for name in sorted(numbers, key=lambda name: (self.candidates[name].through_drag, name)):
            entry = self.candidates[name]
            model = model.with_term(Term(entry, tuple((free.name, float(numbers[name][free.name])) for free in entry.free)))
        return model

    def on_the_way(self, numbers, parent, share):
        """The numbers {effect: {number: value}} that stand at a part of the way from those of a fit, or at a multiple of it."""
        known = parent.model.numbers
        return {
            name: {free.name: free.towards(known.get(name, {}), numbers[name][free.name], share) for free in entry.free}
            for name, entry in ((name, self.candidates[name]) for name in numbers)
        }

    def nearer(self, numbers, parent):
        """Numbers {effect: {number: value}} that were foreseen from a fit, or nearer to where they stand in it, while the misfit
        is larger there than at that fit: far away a linear model promises what cannot be, and a fit would get lost."""
        for share in NEARER:
            tried = self.on_the_way(numbers, parent, share)
            if self.left_at(tried, parent) <= parent.chi2:
                break
        return tried

    def left_at(self, numbers, parent):
        """chi2 at numbers {effect: {number: value}}, the initial states moved linearly from a fit; inf where nothing can be
        simulated."""
        return self.left_from(numbers, parent.initial_states, parent.linearization.without_states)

    def left_from(self, numbers, initial_states, projected=lambda white: white):
        """chi2 at numbers {effect: {number: value}} and initial states, of the white residuals as a function projects them."""
        try:
            with np.errstate(all="ignore"):  # a run may leave the finite numbers there
                white = self.problem.white_residuals(self.model_with(numbers), initial_states)
                total = float(np.sum(np.concatenate(projected(white)) ** 2))
        except InputError:
            return np.inf
        return total if np.isfinite(total) else np.inf

    def nearest(self, numbers, *options):
        """Initial states (trials, 13), of each recording those of the options that leave the least of it at numbers {effect:
        {number: value}}: fitted to a wrong model they may lead astray, and so may those read off the data."""
        model = self.model_with(numbers)
        try:
            with np.errstate(all="ignore"):  # a run may leave the finite numbers there
                return best([(chi2_of(self.problem.white_residuals(model, states)), states) for states in options])[1]
        except InputError:
            return options[0]

    def believed(self, numbers):
        """The surprise of numbers {effect: {number: value}}."""
        return sum(self.candidates[name].surprise(numbers[name]) for name in sorted(numbers))

    def look(self, proposals):
        """By how much less than foreseen each proposal may cost, {set: amount}: LOOKED times what one simulation at
        its numbers differs from it. Far from the data a law that is not linear in its numbers is foreseen at too much."""
        seen = self.problem.batched([partial(self.left_at, each.numbers, each.parent) for each in proposals])
        foreseen = [misfit(each.parent) - each.fall - self.believed(each.numbers) for each in proposals]
        return {each.effects: LOOKED * abs(a - b) for each, a, b in zip(proposals, seen, foreseen, strict=True)}

    def looked(self, proposals, shares):
        """Proposals with numbers at these multiples of the way to theirs, where a simulation there leaves less than was foreseen.

        Through contacts what a law does far away is no continuation of what it does here: impacts come at other moments, a body
        comes to rest, or misses what it hit before.
        """
        ways = [(each, self.on_the_way(each.numbers, each.parent, share)) for each in proposals for share in shares]
        seen = self.problem.batched([partial(self.left_at, numbers, each.parent) for each, numbers in ways])
        found = []
        for (proposal, numbers), left in zip(ways, seen, strict=True):
            more = misfit(proposal.parent) - left - self.believed(numbers) - proposal.fall
            if more > 0:
                found.append(proposal._replace(cost=proposal.cost - more, numbers=numbers, fall=proposal.fall + more))
        return found


def misfit(fit):
    """What `Proposal.fall` is of: the misfit of a fit and the surprise of its numbers."""
    return fit.chi2 + fit.surprise
