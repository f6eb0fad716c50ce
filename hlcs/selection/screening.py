"""What a candidate would do to a fit, before it is refitted: its signatures, and how they compare with what is there."""

from functools import partial

import numpy as np

from hlcs.estimation import inference
from hlcs.estimation.linearization import Linear, chosen
from hlcs.selection.eligibility import lacks_drag
from hlcs.simulation.model import Term
from minibullet.errors import InputError

PRICE, PRICE_ALONE = 6.0, 12.0
FAR = 0.3  # part of its range over which a number is looked at that shows nothing nearer: a rebound goes with its square


class Screening:
    """Signatures of candidates on one problem."""

    def __init__(self, problem, folds):
        self.problem, self.folds = problem, folds
        self.counts = {}  # candidate -> how many of its numbers these data can show
        self.kept = {}  # candidate -> [(values while absent, white signatures)], kept where a simulation is dear
        self.view = {}  # candidate -> values while absent from which it explains most

    def screen(self, fit, entry):
        """Linear signatures of a candidate at a fit, white and projected, list of (n_i, p); None where it cannot join.

        Of several ways to be absent (views) the one whose signature explains most of the residual is taken, and remembered.
        """
        looks = self.looks(fit, entry)
        if looks is None:
            return None
        r, s = fit.linear.projected
        self.view[entry.name], signature, _ = chosen(looks, inference.basis(np.concatenate(s)), np.concatenate(r))
        return signature

    def looks(self, fit, entry, keep=True):
        """[(values at which it is absent, its projected signature there)] of a candidate, or None where it cannot join."""
        if lacks_drag(entry.kind, fit.model):
            return None
        if not keep or entry.name not in self.kept:
            views = entry.views or (None,)
            try:
                found = self.problem.at_once([partial(self.columns, fit, entry, view) for view in views])
            except InputError:
                return None
            found = list(zip(views, found, strict=True))
            if keep and self.problem.shots.contact:
                self.kept[entry.name] = found
        else:
            found = self.kept[entry.name]
        return [
            (view, [inference.project_out(q, part) for q, part in zip(fit.linear.bases, columns, strict=True)])
            for view, columns in found
        ]

    def columns(self, fit, entry, view):
        """White signatures of a candidate at a fit, list of (n_i, p); view: its values while absent, None = it never is."""
        if view is None:
            plus = fit.model.with_term(Term(entry, tuple((free.name, free.start) for free in entry.free)))
            return [part[:, None] for part in self.problem.signature(fit.model, fit.starts, plus)]

        def slope(free):
            def moved(value):
                return fit.model.with_term(Term(entry, tuple((view | {free.name: value}).items())))

            return self.problem.derivative(entry.name, free, free.null, moved, fit.linear, fit.starts, reach=FAR)[0]

        parts = self.problem.at_once([partial(slope, free) for free in entry.free if free.null is not None])
        return [np.column_stack(columns) for columns in zip(*parts, strict=True)]

    def local(self, fit, index, entry):
        """How well a candidate stands in for term `index` right at a fit: (cosine, numbers that imitate the term) or None.

        The linear gain from the null value misjudges strong effects through contacts; here both laws are compared where the
        data are.
        """
        looks = None if entry.absent is None else self.looks(fit, entry, keep=False)
        if looks is None:
            return None
        counts = np.cumsum([0] + [len(term.candidate.free) for term in fit.model.terms])
        mine = slice(counts[index], counts[index + 1])
        columns = np.concatenate(fit.linear.projected[1])
        q = inference.basis(np.delete(columns, np.arange(mine.start, mine.stop), axis=1))
        null = [
            free.null if free.null is not None else value  # a number that means nothing while the effect is absent
            for free, value in zip(fit.model.terms[index].candidate.free, fit.estimate[mine], strict=True)
        ]
        does = inference.project_out(q, columns[:, mine]) @ (fit.estimate[mine] - null)
        view, signature, step = chosen(looks, q, does)
        likeness = inference.project_out(q, np.concatenate(signature)) @ step
        size = np.linalg.norm(does) * np.linalg.norm(likeness)
        numbers, varied = dict(view), [free for free in entry.free if free.null is not None]
        for free, change in zip(varied, step, strict=True):
            numbers[free.name] = float(free.inside(free.null + change))
        return (float(does @ likeness / size) if size > 0 else 0.0), numbers

    def price(self, entry):
        """What a candidate must gain in chi2: log n for each number that these data can show, and a fee."""
        return self.fee(entry) + (PRICE if self.folds.possible else PRICE_ALONE)

    def fee(self, entry):
        """p log n of a candidate, p the numbers that these data can show."""
        return self.counts.get(entry.name, len(entry.free)) * np.log(sum(len(rec.channel) for rec in self.problem.recordings))

    def shown(self, entry, signature):
        """How many of its numbers can move the observations by chi2 = 9 within their bounds; at least 1."""
        if len(entry.free) == 1 or signature.shape[1] < len(entry.free):
            return len(entry.free)
        spans = np.array([min(free.high - free.low, 1e3) for free in entry.free])
        size = np.linalg.svd(signature * spans, compute_uv=False)
        return max(int(np.sum((size > 1e-3 * size[0]) & (size > 3.0))), 1)

    def extrapolated(self, fit, entry, signature):
        """The fit with the candidate in, by one linear step and without a simulation: good enough to rank, not to report."""
        if entry.absent is None:
            return None
        varied = np.array([free.null is not None for free in entry.free])  # the others keep their place while it is absent
        s = []
        for mine, new in zip(fit.linear.s, signature, strict=True):
            columns = np.zeros((len(new), len(entry.free)))
            columns[:, varied] = new
            s.append(np.hstack([mine, columns]))
        start = np.concatenate([fit.estimate, list((self.view.get(entry.name) or entry.absent).values())])
        bounds = [free for term in fit.model.terms for free in term.candidate.free] + list(entry.free)
        step = self.problem.bounded_step(Linear(fit.linear.raw, fit.linear.r, fit.linear.n, s), start, bounds)
        moved = Linear(fit.linear.raw, [r - part @ step for r, part in zip(fit.linear.r, s, strict=True)], fit.linear.n, s)
        numbers = zip((free.name for free in entry.free), (start + step)[len(fit.estimate) :].tolist(), strict=True)
        return self.problem.finished(fit.model.with_term(Term(entry, tuple(numbers))), fit.starts, moved)
