"""What a candidate would do to a fit, before it is refitted: its signatures, and how they compare with what is there."""

from dataclasses import replace
from functools import partial

import numpy as np

from hlcs.estimation.least_squares import basis, bounded_least_squares, project_out
from hlcs.estimation.linearization import best_view, free_numbers
from hlcs.selection.eligibility import lacks_drag
from hlcs.simulation.model import Term
from minibullet.errors import InputError

MARGIN, MARGIN_ALONE = 6.0, 12.0  # of chi2 beyond the complexity penalty; where nothing can be held out
FAR = 0.3  # part of its range over which a number is varied that shows nothing nearer: a rebound goes with its square


class Screening:
    """Signatures of candidates on one problem."""

    def __init__(self, problem, cross_validation):
        self.problem, self.cross_validation = problem, cross_validation
        self.visible_numbers = {}  # candidate -> how many of its numbers these data can show
        self.signatures = {}  # candidate -> [(values while absent, white signatures)], kept where a simulation is dear
        self.view = {}  # candidate -> values while absent from which it explains most

    def screen(self, fit, entry):
        """Linear signatures of a candidate at a fit, white and projected, list of (n_i, p); None where it cannot join.

        Of several ways to be absent (views) the one whose signature explains most of the residual is taken, and remembered.
        """
        views = self.views(fit, entry)
        if views is None:
            return None
        r, s = fit.linearization.projected
        self.view[entry.name], signature, _ = best_view(views, basis(np.concatenate(s)), np.concatenate(r))
        return signature

    def views(self, fit, entry, anew=False):
        """[(values at which it is absent, its projected signature there)] of a candidate, or None where it cannot join.

        anew: whether signatures are found at this fit even where those of an earlier one are kept.
        """
        if lacks_drag(entry.kind, fit.model):
            return None
        signatures = None if anew else self.signatures.get(entry.name)
        if signatures is None:
            views = entry.views or (None,)
            try:
                columns = self.problem.batched([partial(self.columns, fit, entry, view) for view in views])
            except InputError:
                return None
            signatures = list(zip(views, columns, strict=True))
            if not anew and self.problem.simulator.contact:
                self.signatures[entry.name] = signatures
        bases = fit.linearization.state_bases
        return [(view, [project_out(*both) for both in zip(bases, columns, strict=True)]) for view, columns in signatures]

    def columns(self, fit, entry, view):
        """White signatures of a candidate at a fit, list of (n_i, p); view: its values while absent, None = it never is."""
        if view is None:
            plus = fit.model.with_term(Term(entry, tuple((free.name, free.start) for free in entry.free)))
            return [part[:, None] for part in self.problem.signature(fit.model, fit.initial_states, plus)]

        def slope(free):
            def moved(value):
                return fit.model.with_term(Term(entry, tuple((view | {free.name: value}).items())))

            linear, states = fit.linearization, fit.initial_states
            return self.problem.derivative(entry.name, free, free.null, moved, linear, states, reach=FAR)[0]

        parts = self.problem.batched([partial(slope, free) for free in entry.free if free.null is not None])
        return [np.column_stack(columns) for columns in zip(*parts, strict=True)]

    def likeness(self, fit, index, entry):
        """How well a candidate stands in for term `index` right at a fit: (cosine, numbers that imitate the term) or None.

        The linear gain from the null value misjudges strong effects
        through contacts; here both laws are compared where the data are.
        """
        views = None if entry.absent is None else self.views(fit, entry, anew=True)
        if views is None:
            return None
        columns, its = np.concatenate(fit.linearization.projected[1]), fit.numbers_of(index)
        q = basis(np.delete(columns, its, axis=1))
        null = [
            free.null if free.null is not None else value  # a number that means nothing while the effect is absent
            for free, value in zip(fit.model.terms[index].candidate.free, fit.estimate[its], strict=True)
        ]
        does = project_out(q, columns[:, its]) @ (fit.estimate[its] - null)
        view, signature, step = best_view(views, q, does)
        imitation = project_out(q, np.concatenate(signature)) @ step
        size = np.linalg.norm(does) * np.linalg.norm(imitation)
        numbers, varied = dict(view), [free for free in entry.free if free.null is not None]
        for free, change in zip(varied, step, strict=True):
            numbers[free.name] = float(free.inside(free.null + change))
        return (float(does @ imitation / size) if size > 0 else 0.0), numbers

    def required_gain(self, entry):
        """What a candidate must gain in chi2: its complexity penalty and a margin."""
        return self.complexity_penalty(entry) + (MARGIN if self.cross_validation.possible else MARGIN_ALONE)

    def complexity_penalty(self, entry):
        """p log n of a candidate, p the numbers that these data can show, n the observations."""
        count = sum(len(recording.channel) for recording in self.problem.recordings)
        return self.visible_numbers.get(entry.name, len(entry.free)) * np.log(count)

    def count_visible(self, entry, signature):
        """How many of its numbers can move the observations by chi2 = 9 within their bounds; at least 1."""
        if len(entry.free) == 1 or signature.shape[1] < len(entry.free):
            return len(entry.free)
        spans = np.array([min(free.high - free.low, 1e3) for free in entry.free])
        size = np.linalg.svd(signature * spans, compute_uv=False)
        return max(int(np.sum((size > 1e-3 * size[0]) & (size > 3.0))), 1)

    def linear_fit(self, fit, entry, signature):
        """The fit with the candidate in, by one linear step and without a simulation: good enough to rank, not to report."""
        if entry.absent is None:
            return None
        varied = np.array([free.null is not None for free in entry.free])  # the others keep their place while it is absent
        columns = []
        for present, new in zip(fit.linearization.parameter_columns, signature, strict=True):
            added = np.zeros((len(new), len(entry.free)))
            added[:, varied] = new
            columns.append(np.hstack([present, added]))
        linear = replace(fit.linearization, parameter_columns=columns, state_moves=None, trajectories=None)
        begin = np.concatenate([fit.estimate, list((self.view.get(entry.name) or entry.absent).values())])
        step = bounded_least_squares(*linear.projected, begin, [*free_numbers(fit.model), *entry.free])
        moved = replace(linear, white=[r - part @ step for r, part in zip(linear.white, columns, strict=True)])
        numbers = zip((free.name for free in entry.free), (begin + step)[len(fit.estimate) :].tolist(), strict=True)
        return self.problem.fit_at(fit.model.with_term(Term(entry, tuple(numbers))), fit.initial_states, moved)
