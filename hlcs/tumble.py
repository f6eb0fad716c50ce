"""Steps of the search that derivatives alone do not take: across the range of a number, and to one of several views."""

from functools import partial

import numpy as np

from . import inference
from .budget import cut
from .model import Term

ACROSS = (0.1, 0.3, 0.6)  # parts of the range of a number from which a refit on a tumble is begun too
EXPLAINED = 1.25  # chi2 per degree of freedom below which it does


def explained(problem, fit):
    """Does a fit leave nothing but noise? Pieces of a tumble absorb much, so little may be left over there."""
    spare = 1 + 3 * np.sqrt(2 / fit.freedom)
    return fit.chi2 < (min(spare, EXPLAINED) if cut(problem) else EXPLAINED) * fit.freedom


def across(problem, fit, entry, near):
    """The better of `near`, a refit of a candidate from its null value, and refits on a tumble from across its range.

    What sticks at one value of a single number and slips at another is not reached by derivatives alone.
    """
    if not cut(problem) or len(entry.free) > 1 or explained(problem, near):
        return near
    (free,) = entry.free
    low, high = free.low, free.low + min(free.high - free.low, 1e3)
    far = [Term(entry, ((free.name, low + share * (high - low)),)) for share in ACROSS]
    fits = problem.at_once([partial(problem.fit, fit.model.with_term(term), fit.starts, 3) for term in far])
    best = min(fits, key=lambda one: one.chi2)
    return near if best.chi2 >= near.chi2 else problem.fit(best.model, best.starts)


def chosen(looks, q, aim):
    """(values while absent, signature, linear step) of the look that explains most of aim (n,), q projected out of it."""
    found = []
    for view, signature in looks:
        step = inference.least_squares(inference.project_out(q, np.concatenate(signature)), inference.project_out(q, aim))
        found.append((step.gain, view, signature, step.estimate))
    best = max(range(len(found)), key=lambda place: found[place][0])
    return found[best][1:]
