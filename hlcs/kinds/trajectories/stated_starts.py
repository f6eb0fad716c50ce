"""Is it a start that was stated wrongly, and not the model that lacks something?

A start that a file states is taken to be exact. A body that was let go by hand up to a frame before the first stamp moves there
already, and what was never at rest is then asked of effects. Nothing but the words of a report depends on it.
"""

import numpy as np

from hlcs.simulation.initial_state import PLACES, SLOTS

MEND = "leave start out of the trials that state it, or count t_s from the release; then run it again"
UNITS = {"position": "m", "velocity": "m/s", "angular_velocity": "rad/s"}  # of what is told to differ


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
    return {"effects": sorted(fit.model.numbers), "differ": _differences(problem.trials, fit, found), "next": MEND}


def _differences(trials, stated, shown):
    """{what is stated: {least, most, unit}} of how far the starts of a fit that the data show lie aside of those stated."""
    found = {}
    for slot, place in zip(SLOTS, PLACES, strict=True):
        where = [k for k, trial in enumerate(trials) if slot in trial.start]
        if where and slot in UNITS:
            aside = np.linalg.norm(shown.initial_states[where, place] - stated.initial_states[where, place], axis=1)
            found[slot] = {"least": float(aside.min()), "most": float(aside.max()), "unit": UNITS[slot]}
    return found
