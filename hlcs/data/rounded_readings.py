"""Readings that are multiples of one step: pixels, last digits."""

import numpy as np

MOST_PARTS = 8  # of the smallest distance between two readings that are tried as their step
ENOUGH = 12  # distinct readings: of as many that are no multiples, one set in a million lies within NEAR of a step by chance
NEAR = 0.1  # of a step, within which a reading is one of its multiples: its last digits are rounded too
FEW = 20  # readings of which fewer than ENOUGH are distinct: so many repeat that they are rounded
EVEN = 10  # samples that show an even motion: of rounded counts half of the second differences agree, eight once in a hundred
MOST_DECIMALS = 9  # of a metre: no tracker has more
APART = 3.0  # last digits by which equal distances between pixels may differ, and a reading lie off its pixel: all are rounded


def reading_step(values):
    """Step of the readings [unit of values] if all are multiples of one step coarser than 1e-6 of their range, else 0.

    The smallest difference of two readings, or of two distances between neighbours, is the step or a few steps; it is refined
    over longer and longer distances. Where no such step is found it is the last decimal, if there is one.
    """
    distinct = np.unique(values)
    few = len(distinct) < ENOUGH
    if len(distinct) < 2 or few and len(values) < FEW:
        return 0.0
    away, digit = distinct - distinct[0], last_decimal(distinct)
    close = max(APART * digit, 1e-9 * away[-1])
    gaps = np.sort(np.diff(distinct))
    candidates = [gaps] if few else [gaps, np.diff(gaps[gaps > close])]
    smallest = min((float(part.min()) for known in candidates if len(part := known[known > close])), default=0.0)
    for part in range(1, 2 if few else MOST_PARTS + 1):
        step = smallest / part
        if step < 1e-6 * away[-1]:
            break
        for reach in np.geomspace(4, max(away[-1] / step, 4), 12):  # steps over which the last estimate is sure of their count
            near = away <= reach * step
            count = np.round(away[near] / step)
            step = float(count @ away[near] / (count @ count)) if count.any() else step
        if are_multiples(distinct, step):
            return step
    return digit if digit >= 1e-6 * away[-1] else 0.0


def as_it_moved(values, step):
    """Do readings in the order of time (n,), multiples of a step, count as an even motion does: are all second differences of
    their counts the same?

    A cart at a constant speed, and what falls, pass by multiples of one distance from sample to sample, however it is read. Few
    counts of a body that is read in coarse steps may be so by chance.
    """
    counts = np.round((values - values[0]) / step)
    return len(values) >= EVEN and bool(np.ptp(np.diff(counts, 2)) == 0)


def are_multiples(values, step):
    """Are all readings whole steps away from the first, to their last digits?

    Two heights far apart are no multiples of their distance because each is read to a hundredth of it.
    """
    count, digit = (values - values[0]) / step, last_decimal(np.unique(values))
    near = min(NEAR, APART * digit / step) if digit else NEAR
    return bool(np.max(np.abs(count - np.round(count))) < near)


def last_decimal(values):
    """The power of ten of which all values (distinct ones) are multiples, no two the same; 0 where there is none."""
    for decimals in range(MOST_DECIMALS + 1):
        scaled = values * 10.0**decimals
        whole = np.round(scaled)
        near = np.max(np.abs(scaled - whole)) < 1e-3  # doubles of some metres are exact to 1e-6 of the ninth decimal
        if near and len(np.unique(whole)) == len(values):  # small ones are all near zero, and multiples of nothing
            return 10.0**-decimals
    return 0.0
