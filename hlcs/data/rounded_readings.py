"""Readings that are multiples of one step: pixels, last digits."""

import numpy as np

MOST_PARTS = 8  # of the smallest distance between two readings that are tried as their step
ENOUGH = 12  # distinct readings: of as many that are no multiples, one set in a million lies within NEAR of a step by chance
NEAR = 0.1  # of a step, within which a reading is one of its multiples: its last digits are rounded too
FEW = 20  # readings of which fewer than ENOUGH are distinct: so many repeat that they are rounded


def reading_step(values):
    """Step of the readings [unit of values] if all are multiples of one step coarser than 1e-6 of their range, else 0.

    The smallest distance between two of them is the step or a few steps; it is refined over longer and longer distances.
    """
    distinct = np.unique(values)
    few = len(distinct) < ENOUGH
    if len(distinct) < 2 or few and len(values) < FEW:
        return 0.0
    away = distinct - distinct[0]
    smallest = float(np.min(np.diff(distinct)))
    for part in range(1, 2 if few else MOST_PARTS + 1):
        step = smallest / part
        if step < 1e-6 * away[-1]:
            break
        for reach in np.geomspace(4, max(away[-1] / step, 4), 12):  # steps over which the last estimate is sure of their count
            near = away <= reach * step
            count = np.round(away[near] / step)
            step = float(count @ away[near] / (count @ count)) if count.any() else step
        if np.max(np.abs(away / step - np.round(away / step))) < NEAR:
            return step
    return 0.0
