"""Is it a start that was stated wrongly, and not the model that lacks something?

A start that a file states is taken to be exact. A body that was let go by hand up to a frame before the first stamp moves there
already, and what was never at rest is then asked of effects. Where the model under test agrees with the data once all starts are
fitted, no effect is named (`selection.verdict.starts_first`).
"""

import numpy as np

from hlcs.simulation.initial_state import PLACES, SLOTS
from minibullet import rotations

MEND = "leave start out of the trials that state it, or count t_s from the release; then run it again"
UNITS = ("m", "m/s", "rad", "rad/s")  # of the SLOTS of a start


def starts_shown(problem, fit, judge):
    """What a report says where the model of a fit is adequate once all starts are fitted to the data, a dictionary; else None.

    judge: (problem, fit) -> (Adequacy, table of observations).
    """
    freed = problem.with_starts_fitted()
    if freed is None:
        return None
    found = freed.fit(fit.model, fit.initial_states)
    if not np.isfinite(found.chi2) or not judge(freed, found)[0].adequate:
        return None
    differ = _differences(problem.trials, freed.recordings, fit.initial_states, found.initial_states)
    return {"effects": sorted(fit.model.numbers), "differ": differ, "next": MEND}


def _differences(trials, recordings, stated, shown):
    """{what is stated: {least, most, unit}} of how far the starts that the data show lie aside of those stated, (n, 13) each, as
    far as `recordings` fit what is stated."""
    found = {}
    for slot, (name, place, unit) in enumerate(zip(SLOTS, PLACES, UNITS, strict=True)):
        known = zip(trials, recordings, strict=True)
        where = [k for k, (trial, seen) in enumerate(known) if name in trial.start and any(at == slot for at, _ in seen.unknown)]
        if where:
            before, after = stated[where, place], shown[where, place]
            turned = name == "orientation"
            moved = rotations.logarithm(rotations.product(after, rotations.conjugate(before))) if turned else after - before
            aside = np.linalg.norm(moved, axis=1)
            found[name] = {"least": float(aside.min()), "most": float(aside.max()), "unit": unit}
    return found
