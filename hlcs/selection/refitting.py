"""One fit of a set of effects: where it begins, and whether to begin it once more elsewhere."""

from functools import partial

import numpy as np

from hlcs.selection.thresholds import EQUAL
from minibullet.errors import InputError


def refit(search, proposal, states=None):
    """The best fit of a set, from where it was foreseen and, while more than noise is left, from elsewhere; None where no fit
    can be made. states: the initial states of a fit with the numbers of the proposal, where one was made before."""
    best, guess, seen, costs, parent = None, search.problem.initial_guess(), [], [], proposal.parent
    contact = search.contact
    # through contacts a fit that nothing foresaw may yet find its way; elsewhere what it promises is seen from afar
    limited = np.isfinite(proposal.cost) or not contact
    limit = partial(search.limit, proposal.effects) if limited else None
    if states is None:
        numbers = search.preview.nearer(proposal.numbers, parent)
        begun = [(numbers, search.preview.nearest(numbers, parent.initial_states, guess))]
        parts = [fit for known, fit in search.fits.items() if known < proposal.effects and fit is not parent]
        part = min(parts, key=lambda fit: fit.chi2, default=parent)
        if part.chi2 < search.preview.left_at(numbers, parent):  # it can end no worse than there, and so it begins there
            begun.insert(0, (search.preview.on_the_way(proposal.numbers, part, 0.0), part.initial_states))
    else:
        begun = [(proposal.numbers, states), (proposal.numbers, parent.initial_states)]
    least_of_parts = min((fit.chi2 for known, fit in search.fits.items() if known < proposal.effects), default=np.inf)
    foreseen, valleys = len(begun) - 1, in_valleys(search, proposal)
    least = foreseen + len(valleys) if valleys else 0  # place of the last one that is tried while more than noise is left
    others = (*valleys, *beginnings(search, proposal))
    for place, (numbers, states) in enumerate((*begun, *((numbers, guess) for numbers in others))):
        if any(numbers == known and np.array_equal(states, there) for known, there in seen):
            continue
        seen.append((numbers, states))
        try:
            fit = search.problem.fit(search.preview.model_with(numbers), states, limit)
        except InputError:  # numbers with which nothing can be simulated
            continue
        # another beginning led to no better end, or once more to where nothing can be; what is out of reach from where a fit
        # through contacts was foreseen seldom is within it from elsewhere, and the time is needed for other sets
        given_up = contact and limited and place >= foreseen and not fit.converged
        again = given_up or bool(costs) and not fit.cost < min(costs) - EQUAL
        costs.append(fit.cost)
        if fit.cost == min(costs) < np.inf:
            best = search.ended[proposal.effects] = fit
        met = best and best.converged and search.cost_of(proposal.effects, best) < proposal.cost + EQUAL
        lost = not contact and best and best.chi2 > least_of_parts + EQUAL  # without one of its effects it leaves less
        # in flight the states of a wrong model may lead to the wrong side of what acts: those that the data show come too
        guessed = contact or any(np.array_equal(there, guess) for _, there in seen)
        if best and search.noise_alone(best) or place >= least and (again or met and guessed) and not lost:
            break
    return best


def in_valleys(search, proposal):
    """The numbers of a proposal, {effect: {number: value}} each, with those of a law that names several starts at each of these:
    chi2 may have a valley at each, and what foresees a set sees one."""
    numbers, laws = proposal.numbers, search.candidates
    return [numbers | {name: numbers[name] | valley} for name in sorted(proposal.effects) for valley in laws[name].valleys]


def beginnings(search, proposal):
    """Numbers to begin a fit from, {effect: {number: value}} each, without those that say the same."""
    names = sorted(proposal.effects)
    laws, most = search.candidates, len(names) - 1
    neighbours = [search.fits[effects].model.numbers for effects in search.ranked() if len(proposal.effects & effects) == most]
    seen = [
        proposal.numbers,
        {name: proposal.numbers[name] | search.readings.get(name, {}) for name in names},
        *({name: known.get(name, laws[name].expected) for name in names} for known in neighbours),
        {name: laws[name].start for name in names},
    ]
    return [numbers for place, numbers in enumerate(seen) if numbers not in seen[:place]]
