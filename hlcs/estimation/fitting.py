"""One fit: trust-region least squares in the numbers, with the initial state of each recording eliminated.

At any numbers every recording has initial states that fit it best, each found without the others; what is left is a problem in
the few shared numbers alone (variable projection: G. H. Golub, V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413), whose Jacobian is
the signatures with the states projected out. What is believed of the numbers beforehand stands beside the residuals as rows of
their own; a number is held only where its law ends.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy import optimize

from hlcs.estimation.least_squares import belief, least_squares
from hlcs.estimation.linearization import Fit, free_numbers, values_of, white_columns
from minibullet.errors import InputError

CLOSE, CLOSE_IN_CONTACT = 0.02, 0.3  # fall of chi2 below which a further step is not worth its simulations
NARROW, NARROW_IN_CONTACT = 1e-8, 1e-4  # steps in spreads that are no longer taken: through contacts chi2 is rough below
NARROW_IN_SEGMENTS = 0.01  # the same of segments: `segment_profiles` tells their final numbers
MOST_EVALUATIONS = 40  # of the residuals in the numbers
MOST_STATE_STEPS = 12  # of the initial states at given numbers
HELD = 0.5  # part of the promised fall of chi2 below which columns of the states are old, as where they promise as much again
CAUTIOUS = (1.0, 0.3, 0.1)  # parts of a step of an initial state that are tried: a strong drag bends its path far from the best
FIRM = 0.01  # what columns tell of a direction, of what they tell best, below which a long way along it shows nothing of the data
ENDS = 2.0  # standard errors to both sides at which intervals through contacts are measured: 1.645 is the end of a 90 % interval
NO_NEARER = 2  # linearisations in a row that promise no end within the limit and come not half as near to it: a fit is given up
NO_MINIMUM = 1.0  # fall of chi2 from a fit to an end of its intervals that shows it at no minimum: that of one standard error
SETTLED = 0.2  # relative change of the standard errors from one measurement of them to the next below which they are known
MEASURED = 4  # such measurements at most
REACHES = 8  # that are tried along an axis at most: the first of them come nearer by a factor of 4 at most


class OutOfReach(Exception):
    """A fit is given up: what it is promised stays beyond its limit, or its numbers are such as cannot be."""


class Elimination:
    """The residuals of a problem as a function of the numbers of a model alone."""

    def __init__(self, problem, model, initial_states, limit=None):
        self.problem, self.model, self.limit = problem, model, limit or (lambda: np.inf)
        self.beyond, self.no_nearer = np.inf, 0
        self.close, self.narrow = (CLOSE_IN_CONTACT, NARROW_IN_CONTACT) if problem.contact else (CLOSE, NARROW)
        if problem.segmented:
            self.close, self.narrow = left_by_segments(problem), NARROW_IN_SEGMENTS
        self.frees, self.start = free_numbers(model), values_of(model)
        self.spread = np.array([free.spread for free in self.frees])
        self.linear, self.best = None, (np.inf, self.start, initial_states)  # of all points seen: cost, numbers, initial states
        self.settle(self.start, initial_states, renew=not self.frees)  # numbers that move on need no more than a beginning

    def linearise(self, values, initial_states):
        """Linearise at numbers (p,) and initial states, where that has not just been done."""
        if self.linear is None or values is not self.values or initial_states is not self.states:
            self.values, self.states = values, initial_states
            self.linear = self.problem.linearise(with_values(self.model, values), initial_states)

    def settle(self, values, initial_states, renew=True):
        """Linearise at numbers (p,) where no recording has a better initial state nearby; renew: as `follow` looks for it."""
        self.linearise(values, initial_states)
        initial_states, _ = self.follow(with_values(self.model, values), initial_states, self.linear.white, renew)
        self.linearise(values, initial_states)
        self.last = values, self.states
        self.remember(np.concatenate([*self.linear.white, self.believed(values)[0]]))

    def believed(self, values):
        """What is believed of the numbers at values (p,), as `least_squares.belief` has it, beside data that tell so much."""
        weight = np.sqrt(self.problem.overdispersion)
        return tuple(weight * part for part in belief(values, self.frees))

    def remember(self, rows):
        """Keep the last point where its rows (n + p,) are the shortest so far: paths through impacts may lose a recording."""
        cost = float(rows @ rows)
        if cost < self.best[0]:
            self.best = cost, *self.last

    def follow(self, model, initial_states, white, renew=False):
        """(initial states, white residuals) where each recording fits best at the numbers of a model.

        Steps are taken on the columns of the last linearisation as long as they hold what they promise and promise less and less,
        then, to `renew`, on new ones: on the way of a fit new columns come with its next linearisation.
        """
        columns, fresh, moved, before = self.linear.state_columns, False, False, np.inf

        def renewed():
            return self.problem.linearise(model, initial_states, np.arange(len(white))).state_columns

        for _ in range(MOST_STATE_STEPS):
            if not np.isfinite(chi2_of(white)).all():
                break
            moves = [least_squares(n, r) for n, r in zip(columns, white, strict=True)]
            promised = sum(move.gain for move in moves)
            if not promised > self.close:
                if not (renew and moved) or fresh:
                    break
                columns, fresh = renewed(), True  # those of a start far off promise nothing where more is left
                continue
            ways = [[share * move.estimate for move in moves] for share in CAUTIOUS]
            firm = [least_squares(n, r, FIRM).estimate for n, r in zip(columns, white, strict=True)]
            if not all(map(np.array_equal, firm, ways[0])):
                ways.append(firm)
            tried = [initial_states, *(self.problem.stepped(initial_states, moves) for moves in ways)]
            initial_states, white, fall = self.nearest(model, tried, white)
            moved = True
            slow, before = promised > HELD * before, promised
            if fall < HELD * promised or renew and slow:
                if not renew or fresh and fall <= self.close:
                    break
                columns, fresh = renewed(), True
        return initial_states, white

    def nearest(self, model, options, white):
        """(initial states, white residuals, fall of chi2) of the option, (trials, 13) each, that fits each recording best; white:
        residuals of the first."""
        tried = [white, *map(self.problem.whitened, self.problem.residuals_at(model, options[1:]))]
        chi2 = np.array([chi2_of(each) for each in tried])
        best = list(enumerate(chi2.argmin(axis=0)))
        initial_states, white = np.array([options[taken][k] for k, taken in best]), [tried[taken][k] for k, taken in best]
        return initial_states, white, float((chi2[0] - chi2.min(axis=0)).sum())

    def residuals(self, step, renew=False):
        """White residuals of all recordings and what is believed of the numbers, (n + p,); step: from one spread below the start
        of each number, in spreads; renew: as `follow` looks for the initial states."""
        values = self.start + (step - 1.0) * self.spread
        change, linear = values - self.values, self.linear
        followed = linear.state_moves or [np.zeros((n.shape[1], len(change))) for n in linear.state_columns]
        left = [r - s @ change for r, s in zip(linear.white, linear.parameter_columns, strict=True)]
        absorbing = [least_squares(n, part, FIRM).estimate for n, part in zip(linear.state_columns, left, strict=True)]
        foreseen = [part - n @ move for part, n, move in zip(left, linear.state_columns, absorbing, strict=True)]
        moves = [move + along @ change for move, along in zip(absorbing, followed, strict=True)]
        try:
            model, states = with_values(self.model, values), self.problem.stepped(self.states, moves)
            white = self.problem.white_residuals(model, states)
            if (chi2_of(white) > np.maximum(chi2_of(linear.white), chi2_of(foreseen) / HELD)).any():  # a long way bends
                parts = [[share * move for move in moves] for share in (*CAUTIOUS[1:], 0.0)]
                shorter = [self.problem.stepped(self.states, part) for part in parts]
                states, white, _ = self.nearest(model, [states, *shorter, self.problem.initial_guess()], white)
            states, white = self.follow(model, states, white, renew)
        except InputError:  # numbers may lead where nothing can be: scipy then tries a shorter step
            return np.full(sum(map(len, linear.white)) + len(values), np.nan)
        self.last, rows = (values, states), np.concatenate([*white, self.believed(values)[0]])
        self.remember(rows)
        return rows

    def slopes(self, step):
        """Their derivatives with the initial states projected out, (n + p, p), where the residuals were found last: scipy asks
        for them nowhere else."""
        self.linearise(*self.last)
        slopes = np.concatenate([*(-part for part in self.linear.projected[1]), np.diag(self.believed(self.values)[1])])
        slopes = np.nan_to_num(slopes) * self.spread
        self.look_ahead(slopes)
        return slopes

    def look_ahead(self, slopes):
        """Raise OutOfReach where the best end that these slopes (n + p, p) promise stays beyond the limit, NO_NEARER times in a
        row by more than half of what it was beyond it before: far from its end a fit is promised more with each step."""
        rows = np.concatenate([*self.linear.projected[0], self.believed(self.values)[0]])
        possible = all(free.possible(value) for value, free in zip(self.values, self.frees, strict=True))
        promised = float(rows @ rows) - least_squares(slopes, rows).gain if possible and np.isfinite(rows).all() else np.inf
        before, self.beyond = self.beyond, promised - self.limit()
        self.no_nearer = self.no_nearer + 1 if self.beyond > HELD * max(before, 0.0) or promised == np.inf else 0
        if self.no_nearer == NO_NEARER:
            raise OutOfReach


def left_by_segments(problem):
    """chi2 by which a fit of segments may miss its minimum, each smooth to no less; 0 where there are none."""
    return CLOSE_IN_CONTACT * len(problem.trials) * problem.segmented


def fit(problem, model, initial_states, limit=None):
    """The Fit of a model's free numbers and of all initial states, from where they stand.

    limit: function that says what a fit may cost to be of interest; one that is out of its reach ends where it is then, not
    converged.
    """
    path, converged = Elimination(problem, model, initial_states, limit), True
    if path.frees and np.isfinite(chi2_of(path.linear.white)).all():
        count = sum(map(len, path.linear.white))
        ends = np.array([(free.least, free.most) for free in path.frees]).T
        try:
            found = optimize.least_squares(  # its first steps are as long as where it begins: one spread of each number
                path.residuals,
                np.ones(len(path.frees)),
                path.slopes,
                bounds=1 + (ends - path.start) / path.spread,
                ftol=path.close / count,
                xtol=path.narrow,
                gtol=None,
                max_nfev=MOST_EVALUATIONS,
            )
            converged = found.status > 0
        except (ValueError, OutOfReach):  # ValueError: scipy's, where nothing can be simulated right beside the start
            converged = False
        path.settle(*path.best[1:])
    return fit_at(with_values(model, path.values), path.states, path.linear, converged)


def fit_at(model, initial_states, linear, converged=True):
    """The Fit at this point, with the covariance of its free numbers."""
    values, frees = values_of(model), free_numbers(model)
    columns = white_columns(linear, values, frees)
    covariance = np.zeros((len(frees), len(frees)))
    if np.isfinite(columns).all():  # a run may leave the finite numbers
        covariance = least_squares(columns, np.zeros(len(columns))).covariance
    return Fit(model, initial_states, linear, values, covariance, converged)


class Ends(NamedTuple):
    """Both ends of an interval along an axis through the numbers, or the fit and one of them, in spreads."""

    reach: float  # from the fit to an end, or to where a law ends before
    measured: float  # reach of the interval by what the residuals change between the ends; 0 where they are not finite
    move: np.ndarray  # from one end to the other (p,)
    change: np.ndarray  # of the residuals along with it (n + p,)

    def cut(self):
        """The same of an interval that ends right here, where the next one longer shows that it is no longer."""
        return self._replace(measured=self.reach, change=self.change * self.measured / self.reach)


def measured_errors(problem, found):
    """The Fit that was found with the covariance that residuals at the ends of its intervals show; where they fit better there
    it had come to no minimum, and what is found from there is told instead."""
    for _ in range(MEASURED):
        path = Elimination(problem, found.model, found.initial_states)
        stood, measured = path.best[0], seen_at_ends(path, found)
        left, values, states = path.best
        if not left < stood - NO_MINIMUM:
            return measured
        found = replace(fit(problem, with_values(found.model, values), states), step_error=found.step_error)
    return seen_at_ends(Elimination(problem, found.model, found.initial_states), found)


def seen_at_ends(path, fit):
    """The Fit with the covariance that residuals at the ends of its intervals show, the initial states fitted anew there.

    Through contacts the columns of two numbers that hide each other are rough where each alone moves the impacts. They look less
    alike than they are, and the intervals of both too narrow. Along what the two can do together the impacts stay: so the ends
    are those of the principal axes of the covariance, found anew until it agrees with its own ends. Where it never does, what the
    data tell depends on where one looks, and of each number the widest error that was seen is told. path: the Elimination there.
    """
    covariance, seen = fit.covariance, []
    units = np.outer(path.spread, path.spread)
    for _ in range(MEASURED):
        variances, axes = np.linalg.eigh(covariance / units)
        reaches = ENDS * np.sqrt(np.maximum(variances, 0.0))
        ends = [ends_along(path, axis, reach) for axis, reach in zip(axes.T, reaches, strict=True)]
        moves, changes = np.array([each.move for each in ends]), np.array([each.change for each in ends])
        if not all(0 < each.measured < np.inf for each in ends) or np.linalg.matrix_rank(moves) < len(moves):
            return fit  # something cannot be simulated there, or a law ends on both sides
        former, covariance = covariance, moves.T @ np.linalg.pinv(changes @ changes.T) @ moves * units
        seen.append(np.diag(covariance))
        if np.all(np.abs(seen[-1] / np.diag(former) - 1) < 2 * SETTLED):
            break
    else:
        wider = np.sqrt(np.max(seen, axis=0) / seen[-1])
        covariance = covariance * np.outer(wider, wider)
    return replace(fit, covariance=covariance, sides=sides_along(path, covariance))


def sides_along(path, covariance):
    """How many of its standard errors each number may go down and up for one, (2, p), at least one: what the residuals change on
    one side alone shows. A ball that grips its floor does so at any larger friction."""
    found = np.ones((2, len(covariance)))
    for number, along in enumerate(covariance.T / np.sqrt(np.diag(covariance))[:, None] / path.spread):
        size = float(np.linalg.norm(along))
        for side, sign in enumerate((-1, 1)):
            measured = ends_along(path, along / size, ENDS * size, (sign, 0)).measured
            found[side, number] = max(measured / (ENDS * size), 1.0) if measured < np.inf else 1.0
    return found


def ends_along(path, axis, reach, sides=(1, -1)):
    """The Ends along an axis (p,) that show an interval which ends there; reach: where to begin; sides: of it, 0 = the fit.

    From farther off a law that bends, or that something cuts, shows an interval that is too short: the ends come nearer. Rough
    residuals do so from anywhere near: where no short reach shows more than itself, the ends go farther off instead.
    """
    within, beyond = None, []  # the longest reach that shows more than itself, and all that show less
    for count in range(REACHES):
        ends = seen_from(path, axis, reach, sides)
        if abs(ends.measured - reach) < SETTLED * reach or ends.measured == np.inf:
            return ends
        if ends.measured < reach:
            beyond.append(ends)
        elif within is None or reach > within.reach:
            within = ends
        most = min((each.reach for each in beyond), default=np.inf)
        if within is None:
            if count + 1 == MEASURED:
                return clear_of_roughness(path, axis, beyond[0], sides)
            reach = max(ends.measured, most / 4)
        elif most < (1 + SETTLED) * within.reach:
            break
        else:
            reach = ends.measured if within.reach < ends.measured < most else np.sqrt(within.reach * most)
    return within.cut() if beyond else within


def clear_of_roughness(path, axis, ends, sides):
    """Ends along an axis (p,) ever farther off, from these on, until they show no more, or reach as far as what is believed."""
    while 2 * ends.reach < ENDS:
        former, ends = ends, seen_from(path, axis, 2 * ends.reach, sides)
        if ends.measured < (1 + SETTLED) * former.measured:
            return max(former, ends, key=lambda each: each.measured)
    return ends


def seen_from(path, axis, reach, sides):
    """The Ends so far from the fit to both sides along an axis (p,), each kept where the laws hold."""
    least, most = (np.array([getattr(free, end) for free in path.frees]) for end in ("least", "most"))
    ways = np.outer(reach * np.array(sides), axis) * path.spread
    ends = (np.clip(path.start + ways, least, most) - path.start) / path.spread
    move, change = np.subtract(*ends), np.subtract(*(path.residuals(1 + end, renew=True) for end in ends))
    size = float(np.linalg.norm(change))
    measured = 0.0 if not np.isfinite(size) else ENDS * float(np.linalg.norm(move)) / size if size > 0 else np.inf
    return Ends(reach, measured, move, change)


def chi2_of(white):
    """Sums of squares of white residuals of each recording (trials,); infinite where a run left the finite numbers."""
    return np.nan_to_num([float(part @ part) for part in white], nan=np.inf)


def with_values(model, values):
    """The model with other values of its free numbers (p,), each kept where its law holds."""
    values = iter(values)
    numbers = [
        {free.name: free.inside(value) for free, value in zip(term.candidate.free, values, strict=False)} for term in model.terms
    ]
    return replace(model, terms=tuple(term.at(term.numbers | its) for term, its in zip(model.terms, numbers, strict=True)))
