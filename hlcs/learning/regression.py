"""Laws fitted to the residuals: least squares in the linear numbers, a search over the others, and a test on what is held out."""

from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg, optimize

from hlcs.estimation.least_squares import basis, least_squares, project_out, whitening_beside
from hlcs.learning.laws import Law
from minibullet.bodies import Bodies

BEGUN = 3  # best first looks from which a search goes on
LARGEST = 10.0  # times the size to be expected, as the standard deviation of a strength
ENOUGH = 15  # steps of such a search: it begins near
TOGETHER = 64  # first looks at a time: what they need on the way is some megabytes a recording


@dataclass(frozen=True)
class Fitted:
    """A law at its best numbers, and how well it foretells recordings that its numbers were not fitted to."""

    law: Law
    searched: np.ndarray
    left: np.ndarray  # white residuals of all recordings (rows,)
    score: float = np.inf  # -2 log probability of every recording, foretold by the others, up to a constant
    missed: np.ndarray | None = None  # white residuals of every recording, by what the others foretell and how surely (rows,)
    unforetold: np.ndarray | None = None  # the same without the law (rows,)
    foretold: np.ndarray | None = None  # white residuals of every recording with the numbers of the others (rows,)

    @property
    def chi2(self):
        return float(self.left @ self.left)


class Regression:
    """Residuals of recordings, and what any law does to them."""

    def __init__(self, flights, size):
        """size: of the force to be expected [m/s2]."""
        self.flights, self.size = flights, size
        self.residual = np.concatenate([flight.residual for flight in flights])
        self.nuisance = np.concatenate([flight.nuisance for flight in flights])
        self.recording = np.repeat(np.arange(len(flights)), [len(flight.residual) for flight in flights])
        groups = sorted({flight.part.group for flight in flights})
        self.fold = np.array([groups.index(flight.part.group) for flight in flights])[self.recording]  # of each row
        self.folds = range(len(groups))
        position, velocity, spin = (
            np.concatenate([getattr(flight, name) for flight in flights]) for name in ("position", "velocity", "spin")
        )
        one = np.ones(len(position))
        still = np.tile([1.0, 0.0, 0.0, 0.0], (len(position), 1))
        self.bodies = Bodies(position, still, np.hstack([velocity, spin]), one, np.ones((len(one), 3)), one, one, one)
        self.times = np.concatenate([flight.times for flight in flights])

    def force(self, law, kind, searched, linear):
        """The force per mass at every moment (g, 3)."""
        numbers = dict(zip([number.name for number in (*law.linear, *law.searched)], [*linear, *searched], strict=True))
        return kind(**{name: float(value) for name, value in numbers.items()}).forces(self.bodies, self.times)[:, :3]

    def columns(self, law, kind, searched):
        """White change of the observations per unit of each linear number (rows, linear or linear times recordings)."""
        columns = self.by_flight(law, kind, [searched])
        if not law.own_phases:
            return np.concatenate(columns)
        found = np.zeros((len(self.residual), len(law.linear) * len(columns)))
        for k, part in enumerate(columns):
            found[self.recording == k, k * len(law.linear) : (k + 1) * len(law.linear)] = part
        return found

    def by_flight(self, law, kind, values):
        """White change of the observations of each flight per unit of each linear number, at each of some values of the searched
        ones, list of (r, values times linear)."""
        units = np.eye(len(law.linear))
        forces = np.stack([self.force(law, kind, searched, unit) for searched in values for unit in units], axis=2)
        parts = np.split(forces, np.cumsum([len(flight.times) for flight in self.flights])[:-1])
        return [np.tensordot(flight.response, part, 2) for flight, part in zip(self.flights, parts, strict=True)]

    def first_looks(self, law, kind, values):
        """Sum of squares that is left, and missed of what is expected, at each of some values of the searched numbers (values,).

        By normal equations, which look at many at a time: near enough to choose by.
        """
        nuisance, shape = basis(self.nuisance), (len(values), len(law.linear))
        residual = project_out(nuisance, self.residual)
        ends = np.cumsum([len(flight.residual) for flight in self.flights])[:-1]
        parts = zip(self.by_flight(law, kind, values), np.split(nuisance, ends), np.split(residual, ends), strict=True)
        grams, projections, shares = [], [], []  # of each flight: (values, linear, linear), (values, m, linear), (values, linear)
        for columns, along, missed in parts:
            by_value = columns.reshape(-1, *shape).transpose(1, 0, 2)
            grams.append(by_value.transpose(0, 2, 1) @ by_value)
            projections.append((along.T @ columns).reshape(-1, *shape).transpose(1, 0, 2))
            shares.append((missed @ columns).reshape(shape))
        if law.own_phases:
            places = np.arange(len(grams) * shape[1]).reshape(-1, shape[1])
            gram, projection, share = np.zeros((len(values), places.size, places.size)), np.dstack(projections), np.hstack(shares)
            for its, part in zip(places, grams, strict=True):
                gram[:, its[:, None], its] = part
        else:
            gram, projection, share = sum(grams), sum(projections), sum(shares)
        expected = self.expected(law, share.shape[1])
        gram = gram - projection.transpose(0, 2, 1) @ projection + expected.T @ expected
        size = np.sqrt(np.einsum("vii->vi", gram))
        inverse = np.linalg.pinv(gram / size[:, :, None] / size[:, None, :], rcond=1e-12, hermitian=True)
        share = share / size
        return residual @ residual - np.einsum("vi,vij,vj->v", share, inverse, share)

    def solve(self, law, kind, searched, rows=slice(None)):
        """(LinearFit of linear numbers and nuisance on these rows, all columns)."""
        columns = np.hstack([self.columns(law, kind, searched), self.nuisance])
        expected = np.pad(self.expected(law, columns.shape[1] - self.nuisance.shape[1]), ((0, 0), (0, self.nuisance.shape[1])))
        return least_squares(
            np.vstack([columns[rows], expected]), np.append(self.residual[rows], np.zeros(len(expected)))
        ), columns

    def expected(self, law, count):
        """Rows that say what the data may not: a strength is not beyond all others, and a table goes straight on (k, count)."""
        size = np.eye(count) / (LARGEST * self.size)
        return np.vstack([size, np.diff(np.eye(count), 2, axis=0) / self.size]) if law.knots else size

    def left(self, law, kind, searched, rows=slice(None)):
        """Residuals that the law leaves on these rows."""
        found, columns = self.solve(law, kind, searched, rows)
        return self.residual[rows] - columns[rows] @ found.estimate

    def search(self, law, kind, begins, rows=slice(None)):
        """Values of the searched numbers that leave least on these rows."""
        if not law.searched:
            return np.zeros(0)
        low, high = (np.array([getattr(number, end) for number in law.searched]) for end in ("low", "high"))
        inside = np.clip(np.asarray(begins, dtype=float), low + 1e-6 * (high - low), high - 1e-6 * (high - low))
        if len(inside) > BEGUN:
            chunks = [inside[first : first + TOGETHER] for first in range(0, len(inside), TOGETHER)]
            costs = np.concatenate([self.first_looks(law, kind, chunk) for chunk in chunks])
            inside = inside[np.argsort(costs, kind="stable")[:BEGUN]]
        found = [
            optimize.least_squares(
                lambda searched: self.left(law, kind, searched, rows),
                begin,
                bounds=(low, high),
                x_scale=high - low,
                max_nfev=ENOUGH,
            )
            for begin in inside
        ]
        return min(found, key=lambda one: one.cost).x

    def fits(self, laws, possible, alike):
        """Every law Fitted to all recordings, the best that could do tested on each group with the numbers of the others.

        possible: tells of a law and the residuals that it leaves whether they can do; alike: chi2 by which another may be worse.
        Numbers fitted to a recording itself leave less of it than those of others do: a law that cannot do in its own fit, or
        is worse there than another one held out, need not be tested.
        """
        found = []
        for law in laws:
            kind = law.kind()
            searched = self.search(law, kind, law.begins)
            found.append(Fitted(law, searched, self.left(law, kind, searched)))
        tested, least = [], np.inf
        for one in sorted(found, key=lambda one: one.chi2 + len(one.law.fitted) * np.log(len(self.residual))):
            if one.chi2 < least + alike and possible(one.law, one.left, self.residual):
                tested.append(self.tested(one))
                least = min(least, tested[-1].score)
        return sorted(tested, key=lambda one: one.score)

    def tested(self, fitted):
        """The same, each group of recordings foretold with the numbers of the others and with their uncertainty."""
        law, kind = fitted.law, fitted.law.kind()
        missed, unforetold, foretold, score = np.empty(len(self.residual)), self.residual.copy(), self.residual.copy(), 0.0
        for fold in self.folds:
            test = self.fold == fold
            searched = self.search(law, kind, [fitted.searched], ~test)
            found, columns = self.solve(law, kind, searched, ~test)
            slopes = self.slopes(law, kind, searched, columns, found.estimate)
            every = np.hstack([columns, slopes])
            white, logarithm = whitening_beside(every[test] @ self.spread(law, every, ~test))
            left = self.residual[test] - columns[test] @ found.estimate
            missed[test] = white(left)
            foretold[test] = missed[test] if law.own_phases else left  # there only the frequency is that of the others
            if not law.own_phases:
                unforetold[test] = white(self.residual[test])
            score += float(missed[test] @ missed[test]) + logarithm
        return replace(fitted, score=score, missed=missed, unforetold=unforetold, foretold=foretold)

    def slopes(self, law, kind, searched, columns, estimate):
        """White change of the observations per unit of each searched number, the linear ones held (rows, searched)."""
        count, found = columns.shape[1] - self.nuisance.shape[1], []
        for k, number in enumerate(law.searched):
            step = 1e-5 * (number.high - number.low)
            moved = self.columns(law, kind, searched + step * np.eye(len(searched))[k])
            found.append((moved - columns[:, :count]) @ estimate[:count] / step)
        return np.array(found).reshape(len(law.searched), len(columns)).T

    def spread(self, law, every, rows):
        """Square root of the covariance of all numbers, (k, k): of white observations in these rows, and of what is expected."""
        count = every.shape[1] - len(law.searched) - self.nuisance.shape[1]
        expected = self.expected(law, count)
        reach = [1 / (number.high - number.low) for number in law.searched]
        prior = linalg.block_diag(expected, 1e-9 * np.eye(self.nuisance.shape[1]), np.diag(reach))
        _, sizes, vt = np.linalg.svd(np.vstack([every[rows], prior]), full_matrices=False)
        return vt.T / np.maximum(sizes, 1e-12)

    def estimate(self, law, searched):
        """(linear numbers, standard deviations of these and then of the searched ones), from all rows."""
        kind = law.kind()
        found, columns = self.solve(law, kind, searched)
        every = np.hstack([columns, self.slopes(law, kind, searched, columns, found.estimate)])
        deviation, count = np.linalg.norm(self.spread(law, every, slice(None)), axis=1), columns.shape[1] - self.nuisance.shape[1]
        return found.estimate[:count], np.append(deviation[:count], deviation[columns.shape[1] :])
