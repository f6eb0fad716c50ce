"""Numbers of recordings that were split into segments: each segment is a witness of its own, and their disagreement is the error.

Segments share nothing but the numbers of the model, so along a line through these chi2 is a sum of curves, one of each segment.
What a free initial state absorbs, a path that tips the other way and an impact that no law describes move the minimum of one
curve, not those of all alike; the curvature of the sum, which gives the usual standard error, knows nothing of it. The scores of
the segments at the common minimum do: their sum is zero, the sum of their squares tells how far the minimum would have moved
with other segments (P. J. Huber, Proc. 5th Berkeley Symp. 1 (1967) 221; clusters: K.-Y. Liang, S. L. Zeger, Biometrika 73 (1986)
13). Where too few segments say anything, or there is no minimum, the number is withheld.
"""

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy import special

from hlcs.estimation import fitting
from hlcs.estimation.fitting import with_values
from hlcs.estimation.linearization import free_numbers, width_of
from hlcs.estimation.multiple_shooting import chi2_over, grown_states, improve_for, regrown, searched

VALUES = 9  # of a number, at which all segments are fitted anew: a parabola through them averages what single fits leave
WIDE_LINE = 0.1  # half of the first line of values, part of the plausible range: fits through impacts end so far from the minimum
SHORTER = 3  # times are the last steps of a walk, which begins with those of such a line
LINE_REACH = (
    10.0  # half of the lines after it [standard errors]: chi2 rises by 100, far above what fits of the segments leave (5 to 30)
)
LINES = 4  # through a number at most, until a short one has the minimum inside
GROWN = 3  # at one value of so many initial states are also sought anew, and around: its neighbours take them over
EXCHANGES = 4  # rounds in which segments try the initial states of the other values
BUMP = 1.0  # chi2 above the mean of the values on both sides beyond which a minimum was missed, not more than noise may do
LINE_ROUNDS = 4  # steps of the initial states in each of them
STUDENT = 0.95  # of Student's law, at which an error from few segments is told as one from many
ALONE = 0.95  # part of what is known of a number that one segment may tell: beyond, the others do not see that it is wrong


class Line(NamedTuple):
    """All segments along a line through the numbers of a model, their initial states fitted anew at each point."""

    offsets: np.ndarray  # of the number that leads from the start of the line (J,)
    direction: np.ndarray  # change of all numbers for each unit of it (p,)
    chi2: np.ndarray  # (J, segments)
    states: np.ndarray  # (J, segments, 13)


class Reading(NamedTuple):
    """What a Line says of its number."""

    offset: float  # of the minimum from the start of the line
    bare: float  # standard error by the curvature alone
    error: float  # by the disagreement of the segments too; a normal law of this error has the 90 % interval of the number
    alone: float  # part of what is known of it that the strongest segment tells


def profiled(problem, fit):
    """A Fit of segments with the numbers and errors of their profiles; `withheld` says which cannot be given, and why."""
    readings, withheld = [None] * len(fit.estimate), {}
    for index in places_from_data(fit):
        effect, free, _ = fit.numbers[index]
        fit, reading = centred(problem, fit, index)
        readings[index] = reading
        if reading is None:
            withheld[effect, free.name] = "the segments into which its recordings are split have no common minimum in it"
        elif reading.alone > ALONE:
            withheld[effect, free.name] = (
                "only one of the segments into which its recordings are split tells it: nothing shows its error"
            )
    known = zip(readings, fit.errors, strict=True)
    scale = np.array([1.0 if reading is None else reading.error / error for reading, error in known])
    return replace(fit, covariance=fit.covariance * np.outer(scale, scale), withheld=withheld)


def fit(problem, model, initial_states, limit=None):
    """A Fit of segments, quick: on short lines through each number, initial states as far as they follow from those given.

    A step-by-step fit loses a segment here and there on its way, and with it the way; where lines show no minimum it is tried,
    to the `limit` of `fitting.fit`.
    """
    there = problem.fit_at(model, initial_states)
    states = regrown(problem, there)  # those of another model may lie beyond an impact from here
    states = searched(problem, model, states, np.arange(len(states)))
    if not np.array_equal(states, initial_states):
        there = problem.fit_at(model, states)
    first = there
    for index in places_from_data(there):
        there, reading = centred(problem, there, index, thorough=False)
        if reading is None:
            return fitting.fit(problem, there.model, there.initial_states, limit)
    return min(first, there, key=lambda fit: fit.cost)  # a parabola through rough values may lead away from a good beginning


def places_from_data(fit):
    """Places of the numbers of a Fit of which the data tell as much as was believed beforehand, or more: the others, such as the
    lift of the air that the file states, stay as they are believed."""
    return [place for place, known in enumerate(np.diag(fit.information)) if not known < 1]


def descended(problem, fit, index):
    """The Fit where a number, the others following, has walked down to the least chi2 in long steps, then in short ones, at most
    as far as its plausible range is wide.

    Each value begins with the initial states of the one before it: through impacts they are found from nearby or not at all.
    """
    free, direction, everyone = free_numbers(fit.model)[index], followed(fit, index), np.arange(len(fit.initial_states))
    width, known = width_of(free), {}  # (chi2, states) at each place, in the short steps
    short = WIDE_LINE * width / (VALUES // 2) / SHORTER

    def look(places, states):
        ends = {place: fit.estimate[index] + place * short for place in places if place not in known}
        there = [place for place, end in ends.items() if free.period is not None or free.inside(end) == end]
        new = [place for place in there if abs(place * short) <= width]
        ways = [partial(_improved, problem, at(fit, place * short, direction), states, everyone) for place in new]
        known.update(zip(new, problem.batched(ways), strict=True))
        return min(known, key=lambda place: known[place][0].sum())

    here = look([0], fit.initial_states)
    for step in (SHORTER, 1):
        before = None
        while here != before:
            before, here = here, look([here - step, here + step], known[here][1])
    if {here - 1, here + 1} <= known.keys():
        before, there, after = (known[place][0].sum() for place in (here - 1, here, here + 1))
        if 0 < (bend := before - 2 * there + after) < np.inf:
            here = look([here + 0.5 * (before - after) / bend], known[here][1])
    model, states = at(fit, here * short, direction), known[here][1]
    return problem.fit_at(model, states, fit.converged)


def followed(fit, index):
    """By how much all numbers of a Fit change with one of them where chi2 leads them, (p,)."""
    covariance = fit.covariance
    return covariance[:, index] / covariance[index, index] if covariance[index, index] > 0 else np.eye(len(covariance))[index]


def at(fit, offset, direction):
    """The Model of a Fit at an offset along a direction."""
    return with_values(fit.model, fit.estimate + offset * direction)


def centred(problem, fit, index, thorough=True):
    """(Fit where one number is at the common minimum of all segments, the Reading there or None where none is found).

    thorough: of a fit that stands at the minimum of quick lines already, so that its first line is a short one.
    """
    free = free_numbers(fit.model)[index]
    wide, error = WIDE_LINE * width_of(free), float(np.sqrt(max(fit.covariance[index, index], 0.0)))
    short = thorough and 0.0 < LINE_REACH * error < wide
    reach = LINE_REACH * error if short else wide
    freedom = np.array([recording.freedom for recording in problem.recordings])
    for _ in range(LINES):
        line = along(problem, fit, index, reach, thorough)
        reading = read(line, freedom)
        inside = reading is not None and line.offsets[0] < reading.offset < line.offsets[-1]
        if inside and short:
            return moved(problem, fit, line, reading.offset, thorough), reading
        lowest = int(np.argmin(line.chi2.sum(axis=1)))
        fit = moved(problem, fit, line, line.offsets[lowest], thorough)
        if inside:
            short, reach = True, LINE_REACH * reading.bare
        elif not thorough:  # the states of the middle of a line do not lead as far as that
            fit, short, reach = descended(problem, fit, index), False, wide
        elif not 0 < lowest < VALUES - 1:  # else it is on both sides of the lowest value, however rough: once more around that
            short, reach = False, wide
    return fit, None


def along(problem, fit, index, reach, thorough):
    """The Line through a fit on which one number leads, as far as `reach`, and the others follow as chi2 asks them to.

    thorough: are initial states also sought from the samples anew and around those that are missed, at one value of GROWN, and
    passed on from value to value until none is better?
    """
    free, direction = free_numbers(fit.model)[index], followed(fit, index)
    ends = [fit.estimate[index] + side * reach for side in (-1, 1)]
    ends = ends if free.period is not None else [free.inside(end) for end in ends]
    offsets = np.linspace(*ends, VALUES) - fit.estimate[index]
    models = [at(fit, offset, direction) for offset in offsets]
    sought = [thorough and place % GROWN == GROWN // 2 for place in range(VALUES)]
    ways = [partial(_first, problem, model, fit.initial_states, there) for model, there in zip(models, sought, strict=True)]
    results, tried = problem.batched(ways), [{} for _ in models]
    for _ in range(EXCHANGES if thorough else 0):
        before = results
        results = problem.batched([partial(_exchanged, problem, model, before, k, tried[k]) for k, model in enumerate(models)])
        if all(np.array_equal(old[1], new[1]) for old, new in zip(before, results, strict=True)):
            break
    results = problem.batched([partial(_shared, problem, model, results, k, tried[k]) for k, model in enumerate(models)])
    chi2, states = (np.array(part) for part in zip(*results, strict=True))
    return Line(offsets, direction, chi2, states)


def _first(problem, model, states, sought):
    """(chi2, states) of all segments at a point of a line, from these states; sought: and from their first samples, with those
    that are still missed sought around them."""
    everyone = np.arange(len(states))
    begun = [states, *([grown_states(problem, model, everyone)] if sought else [])]
    return best([_improved(problem, model, states, everyone, sought) for states in begun])


def _shared(problem, model, results, place, tried):
    """(chi2, states) at a place of a line, the best of what stands at all of them, results: [(chi2, states)]; tried: chi2 of what
    was tried there, by segment and state, which grows."""
    chi2, states = (part.copy() for part in results[place])
    options = {(segment, state.tobytes()): state for _, found in results for segment, state in enumerate(found)}
    tried |= {(segment, state.tobytes()): left for segment, (left, state) in enumerate(zip(chi2, states, strict=True))}
    new = {which: state for which, state in options.items() if which not in tried}
    if new:
        owner = np.array([segment for segment, _ in new])
        left = chi2_over(problem, model, np.array(list(new.values())), owner)
        tried |= dict(zip(new, left, strict=True))
    for which, state in options.items():
        if (left := tried[which]) < chi2[which[0]]:
            chi2[which[0]], states[which[0]] = left, state
    return chi2, states


def _exchanged(problem, model, results, place, tried):
    """(chi2, states) at a place of a line, the best of what stands at all of them, results: [(chi2, states)], improved there.

    Along a line chi2 of a segment bends up or has a kink where it passes to another way; where it lies above the mean of the
    points on both sides, a way was missed, and those from there are improved as well.
    """
    own, options = results[place][0], [_shared(problem, model, results, place, tried)]
    if len(better := np.flatnonzero(options[0][0] < own)):
        options.append(_improved(problem, model, options[0][1], better))
    beside = results[place - 1 : place + 2 : 2] if 0 < place < len(results) - 1 else []
    if beside and len(above := np.flatnonzero(own > BUMP + np.mean([chi2 for chi2, _ in beside], axis=0))):
        options += [_improved(problem, model, states, above) for _, states in beside]
    return best(options)


def _improved(problem, model, states, which, sought=False):
    """(chi2, states) after some steps of the segments `which`, chi2 infinite of others; sought: and around those missed."""
    states = states.copy()
    improve_for(LINE_ROUNDS, problem, model, states, which)
    if sought:
        states = searched(problem, model, states, which)
    chi2 = np.full(len(states), np.inf)
    chi2[which] = chi2_over(problem, model, states[which], which)
    return chi2, states


def best(options):
    """(chi2, states) that takes for each segment the best of [(chi2 (segments,), states (segments, 13))]."""
    chi2 = np.array([option[0] for option in options])
    which, everyone = np.argmin(chi2, axis=0), np.arange(chi2.shape[1])
    return chi2[which, everyone], np.array([option[1] for option in options])[which, everyone]


def read(line, freedom):
    """The Reading of a Line, None where the sum of its curves has no minimum; freedom: observations of each segment less the
    unknowns of its initial state (segments,).

    A segment that misses by more than its noise counts for as much less.
    """
    chi2 = line.chi2 / np.maximum(np.min(line.chi2, axis=0) / freedom, 1.0)
    if not np.isfinite(chi2).all():
        return None
    curvature, slope, _ = np.polyfit(line.offsets, chi2, 2)
    bend = curvature.sum()
    if not bend > 0:
        return None
    offset = -slope.sum() / (2 * bend)
    scores = slope + 2 * curvature * offset
    telling = np.maximum(curvature, 0.0) / np.sum(np.maximum(curvature, 0.0))
    few = max(1 / np.sum(telling**2) - 1, 1.0)  # degrees of freedom of as many segments as would tell it alike
    scatter = np.sqrt(np.sum(scores**2) * (few + 1) / few) / (2 * bend) * special.stdtrit(few, STUDENT) / special.ndtri(STUDENT)
    return Reading(float(offset), float(bend**-0.5), float(max(scatter, bend**-0.5)), float(telling.max()))


def moved(problem, fit, line, offset, thorough):
    """The Fit at an offset on a Line, from the initial states of its nearest point; thorough: as of `along`."""
    nearest = int(np.argmin(np.abs(line.offsets - offset)))
    model, states = at(fit, offset, line.direction), line.states[nearest]
    _, states = _improved(problem, model, states, np.arange(len(states)), thorough)
    return problem.fit_at(model, states, fit.converged)
