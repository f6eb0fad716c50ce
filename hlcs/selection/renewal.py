"""A search that begins anew where samples or numerics of its data have changed: what it foresaw of them stays."""

import numpy as np

from hlcs.selection.preview import misfit
from hlcs.selection.thresholds import HELPS, TIED
from minibullet.errors import InputError


def due(search, looked, best, promised, by_step):
    """Is it time to look anew at single samples and numerics, beside the best set? What the misfit of a worse model did to them
    is nothing to explain, so where the best leaves less than half of the excess of those that were looked at. But first comes
    what may explain half of what it leaves, if the error of the time step does not do so too.

    promised: what that may cost; by_step: function fit -> chi2 that this error is worth.
    """
    left = min(search.excess(search.fits[effects]) for effects in looked if effects in search.fits)
    now = search.excess(search.fits[best])
    if not (left > 0 and now < HELPS * left):
        return False
    return not search.cost(best) - promised > HELPS * now > 0 or by_step(search.fits[best]) > HELPS * now


def renewed(search, begun):
    """The Search that begun(first=sets to be fitted first) begins on the changed data of a former one: with what did best there,
    and with what is simpler than that.

    Through contacts, where a look at a fit costs a good part of the limit, what was foreseen is taken over: single samples and
    the step of time change little of that. Where the fit that foresaw a set leaves less now, so does the set; where it leaves
    more, these are samples that stood alone beside it, and no others need miss them. Other fits than that of the model under test
    are taken as they were, and what was fitted then is left out: what did well is kept.
    """
    after = begun(first=[(search.fits[effects].model.numbers, search.fits[effects].initial_states) for effects in kept(search)])
    bare = frozenset()
    if not (search.contact and bare in search.models):
        return after
    after.models[bare] = search.models[bare]
    after.implied, after.implied_alone = search.implied, search.implied_alone
    anew = {search.base: after.base}  # Fit that sets were foreseen from -> the same on the data as they are now
    for effects, proposal in search.foreseen.items():
        parent = proposal.parent
        if parent is not search.base and effects in search.fits:
            continue
        if parent not in anew:
            anew[parent] = as_it_was(parent, search.problem)
        if there := anew[parent]:
            moved = min(misfit(there) - misfit(parent), 0.0)
            after.foreseen[effects] = proposal._replace(cost=proposal.cost + moved, parent=there)
    after.found = {there: search.found[parent] for parent, there in anew.items() if there and parent in search.found}
    return after


def as_it_was(fit, problem):
    """A Fit at the numbers and the initial states of one that was made before the data of a problem changed; None where nothing
    can be simulated there."""
    try:
        with np.errstate(all="ignore"):  # a run may leave the finite numbers there
            there = problem.fit_at(fit.model, fit.initial_states)
    except InputError:
        return None
    return there if np.isfinite(there.chi2) else None


def affordable(search):
    """Does what is left of the limit of a search of segments allow for a new one of what is kept, and of the model under test?"""
    numbers = [1, *map(search.count, kept(search))]
    return not search.budget.left_out and len(search.budget.affordable(numbers, len(numbers))) == len(numbers)


def kept(search):
    """The sets that do as well as the best one, and those that were fitted of what is simpler: where held-out data do not prove
    a law, its special case may stand. Not the model under test, which is always fitted."""
    best, *_ = ranked = search.ranked()
    sets = [effects for effects in ranked if effects]
    near = [effects for effects in sets if search.cost(effects) < search.cost(best) + TIED]
    near += [effects for effects in unsettled(search, sets, best) if effects not in near]
    simpler = {few for effects in near for few in search.parts(effects)}
    return near + [effects for effects in sets if effects in simpler and effects not in near]


def unsettled(search, sets, best):
    """Those of the sets of which the best one, which leaves more than noise, explains less than half of what they leave: how many
    residuals count as one is not known yet. In flight, where nothing foresees them from far away; of sets that hold another
    one that other, from which they are foreseen."""
    excess = {} if search.contact else {effects: search.excess(search.fits[effects]) for effects in sets}
    least = excess.get(best, 0.0)
    alike = [effects for effects in excess if least > 0 and HELPS * excess[effects] <= least]
    return [effects for effects in alike if not any(few < effects for few in alike)]
