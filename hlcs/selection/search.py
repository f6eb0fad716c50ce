"""The search for what is missing: screen, refit, hold out; forward with re-tries, backward; rivals.

Rules (thresholds from theory or set here, none tuned to a data set): a candidate with p numbers is accepted when the
whitened chi2 falls by more than p log n + 6 (12 where nothing can be held out), when it predicts recordings it was not
fitted to better than without it, when its numbers lie inside their bounds, and when the held-out error falls by 2 % or
by 0.1 sigma. Never more than three.
"""

from functools import partial

import numpy as np
from scipy import stats

from hlcs.estimation import inference
from hlcs.estimation.cross_validation import Folds
from hlcs.estimation.effort import Budget, cut
from hlcs.estimation.least_squares import Problem
from hlcs.estimation.linearization import Try
from hlcs.selection.eligibility import carries
from hlcs.selection.pairs import hidden_pair
from hlcs.selection.reasons import Rule
from hlcs.selection.screening import Screening
from hlcs.simulation.model import Term

MOST_TERMS = 3
NO_FLUID = (25.0, 600.0)  # between dense gases, a few bar included, and light liquids there is no fluid [kg/m3]
RIVAL_MARGIN = 6.0
REFIT_BEST = 6
REFIT_DEAR = 2  # where every simulation has contacts to solve
REFIT_STRONG = 12  # there, as long as nothing explains the data
ABREAST = 0.98  # part of the best linear gain from which a candidate points at the residual as well
WITNESSED = 0.98  # part of the best gain from which what impacts show directly goes first, where neither explains the data
EXPLAINED = 1.25  # chi2 per degree of freedom below which a fit explains the data
SHORT = 0.8  # part of its linear gain below which a refit through contacts is taken up again from the full linear step


class Search(Screening):
    """One search over candidates on one problem."""

    def __init__(self, problem: Problem, candidates, folds: Folds, progress=None, read=None):
        super().__init__(problem, folds)
        self.read = read or {}  # candidate -> its numbers as samples around the impacts show them, where the model has others
        self.candidates = sorted(candidates, key=lambda entry: entry.name)
        self.progress = progress or (lambda text: None)
        self.budget = Budget(problem)
        self.places = {}  # (terms of a model, index of one) -> what stands in its place (rivals.Place)
        self.refitted = {}  # (terms of a model, candidate) -> its fit on top of that model

    def refit(self, fit, entry):
        """The fit with the candidate in, from its null value and from what impacts show; made once."""
        key = fit.model.terms, entry.name
        if key in self.refitted:
            return self.refitted[key]
        begin = list(entry.starts)
        if entry.absent is not None:
            begin = [tuple((self.view.get(entry.name) or entry.absent).items())]
        if entry.name in self.read:
            begin.append(tuple(self.read[entry.name].items()))
        fits = self.problem.at_once(
            [partial(self.problem.fit, fit.model.with_term(Term(entry, values)), fit.starts) for values in begin]
        )
        self.refitted[key] = min(fits, key=lambda found: found.chi2)
        return self.refitted[key]

    def judge(self, before, entry, fit, trial):
        """Fill in the held-out figures of a refitted candidate against the fit without it."""
        if not np.isfinite(fit.chi2):
            trial.fails.append(Rule.FINITE())
            return
        trial.fit, trial.gain = fit, before.chi2 - fit.chi2
        if not self.folds.possible:
            return
        r0, r1 = self.folds.residuals(before), self.folds.residuals(fit)
        dots = spread = clustered = 0.0
        for a, b in zip(r0, r1, strict=True):
            difference = a - b
            dots += float(difference @ a)
            spread += float(difference @ difference)
            clustered += float(difference @ b) ** 2
        trial.p = float(stats.norm.sf(dots / np.sqrt(max(spread, clustered)))) if spread > 0 else 1.0
        raw0, raw1 = self.coloured(r0), self.coloured(r1)
        falls = []
        for side in (0, 1):
            inside = np.flatnonzero(self.folds.side == side)
            e0, e1 = (_rms([raw[k] for k in inside]) for raw in (raw0, raw1))
            falls.append(1 - e1 / e0)
        trial.directions = tuple(falls)
        e0, e1 = _rms(raw0), _rms(raw1)
        trial.held_out, trial.falls, trial.falls_sigma = e1, 1 - e1 / e0, e0 - e1

    def coloured(self, residuals):
        """White residuals turned back into residuals in units of sigma, list of (n_i,)."""
        return [
            inference.colour(recording.links, part) / recording.links.sigma
            for recording, part in zip(self.problem.recordings, residuals, strict=True)
        ]

    def decide(self, trials):
        """Fill in `fails`: the rules each refitted candidate breaks."""
        tried = [trial for trial in trials if trial.visible > 0]
        ordered = sorted(tried, key=lambda trial: (trial.p, trial.candidate.name))
        largest = 0.0
        for place, trial in enumerate(ordered):  # Holm's step-down
            largest = max(largest, min(1.0, (len(ordered) - place) * trial.p))
            trial.holm = largest
        for trial in tried:
            if trial.fit is not None:
                trial.fails += self.broken(trial)

    def broken(self, trial):
        """Explanations of the rules that a judged candidate breaks; its `holm` counts those it was chosen among."""
        rest = max(trial.fit.chi2 / trial.fit.freedom, 1.0)  # what stays unexplained counts as noise
        if trial.gain <= trial.price * rest:
            return [Rule.PRICE(gain=trial.gain, price=trial.price * rest)]
        found = []
        if self.folds.possible:
            if self.folds.few and min(trial.directions) <= 0.02:
                changes = " and ".join(f"{-100 * fall:+.0f} %" for fall in trial.directions)
                found.append(Rule.BOTH_DIRECTIONS(changes=changes))
            elif not self.folds.few and trial.holm >= 0.05:
                found.append(Rule.NO_CHANCE(p=trial.holm))
            elif trial.falls <= 0.02 and trial.falls_sigma <= 0.1:
                found.append(Rule.HELD_OUT_ERROR(percent=100 * trial.falls))
        found += self.out_of_bounds(trial.fit)
        if self.contradicts(trial.fit):
            found.append(Rule.STATED_FLUID(density=trial.fit.model.terms[-1].numbers["fluid_density"]))
        return found

    def out_of_bounds(self, fit, index=-1):
        """Explanations about numbers of a term, the newest or another, that lie at a bound or are not plausible."""
        term, found = fit.model.terms[index], []
        for free, at_bound in zip(term.candidate.free, fit.bounds_of(index), strict=True):
            if at_bound:
                found.append(Rule.INSIDE_BOUNDS(name=free.name, value=term.numbers[free.name]))
        relative = getattr(term.candidate.kind, "relative_bound", None)
        if relative:
            low, high = self.problem.shots.range
            size = sum(abs(value) for value in term.numbers.values())
            if size > 2 * relative * (high - low):
                found.append(Rule.PLAUSIBLE_SIZE(size=size))
        return found

    # --- rounds ---------------------------------------------------------------------------------------------------------------

    def round(self, fit):
        """Every candidate tried on top of a fit: {name: Try}."""
        trials = {}
        r = np.concatenate(fit.linear.projected[0])
        s_now = np.concatenate(fit.linear.projected[1])
        q_now = inference.basis(s_now)
        r = inference.project_out(q_now, r)
        entries = [entry for entry in self.candidates if entry.name not in fit.model.names]
        self.progress(f"screening {len(entries)} candidates")
        signatures = self.problem.at_once([partial(self.screen, fit, entry) for entry in entries])
        for entry, signature in zip(entries, signatures, strict=True):
            trial = Try(entry, price=self.price(entry))
            trials[entry.name] = trial
            if signature is None:
                continue
            trial.signature = signature
            s = inference.project_out(q_now, np.concatenate(signature))
            full = np.linalg.norm(np.concatenate(signature))
            self.counts[entry.name] = self.shown(entry, np.concatenate(signature))
            trial.price = self.price(entry)
            trial.visible = float(np.linalg.norm(s)) if np.linalg.norm(s) > 1e-6 * max(full, 1e-300) and full > 1e-9 else 0.0
            if trial.visible:
                trial.linear_gain = inference.least_squares(s, r).gain
        ranked = sorted(
            (trial for trial in trials.values() if trial.visible),
            key=lambda trial: (trial.candidate.name not in self.read, trial.price - trial.linear_gain, trial.candidate.name),
        )
        worth = [
            trial
            for place, trial in enumerate(ranked)
            if trial.linear_gain > 0.6 * trial.price
            or trial.candidate.name in self.read
            or place < REFIT_BEST
            and trial.linear_gain > 0.3 * trial.price
        ]
        for trial, found in zip(worth, self.refits(fit, worth), strict=True):
            self.judge(fit, trial.candidate, found, trial)
        self.decide(list(trials.values()))
        return trials

    def refits(self, fit, worth):
        """Fits with each of the candidates in, list; where a simulation is dear, the first in rank, the rest by one linear step.

        As long as none of the first explains the data the linear ranking is not to be trusted, and more are refitted; then only
        what points at the residual as well as the best.
        """
        found = [None] * len(worth)
        if self.problem.shots.contact:
            most = self.budget.refits(self.problem, REFIT_STRONG)
            if most < min(REFIT_STRONG, len(worth)):
                self.budget.note("refits of candidates that point least at the residual; one linear step judges them")
            waves = [range(0, REFIT_DEAR), range(REFIT_DEAR, most)]
        else:
            waves = [range(len(worth))]
        most_gain, explains = max((trial.linear_gain for trial in worth), default=0.0), False
        for wave in waves:
            places = [
                place for place in wave if place < len(worth) and (not explains or worth[place].linear_gain > ABREAST * most_gain)
            ]
            if not places:
                break
            self.progress("refitting " + ", ".join(worth[place].candidate.name for place in places[:3]))
            fits = self.problem.at_once([partial(self.refit, fit, worth[place].candidate) for place in places])
            for place, refitted in zip(places, fits, strict=True):
                found[place] = refitted
            if not self.problem.shots.contact:
                break
            short = [
                place
                for place in places
                if fit.chi2 - found[place].chi2 < SHORT * worth[place].linear_gain
                and worth[place].candidate.absent is not None
                and not cut(self.problem)
            ]
            far = [
                self.extrapolated(fit, worth[place].candidate, worth[place].signature).model for place in short
            ]  # a law that bends is reached from its other side
            again = self.problem.at_once([partial(self.problem.fit, model, fit.starts) for model in far])
            for place, refitted in zip(short, again, strict=True):
                found[place] = min(found[place], refitted, key=lambda one: one.chi2)
            explains = any(explained(self.problem, found[place]) for place in places)  # nothing but noise is left
        for place, trial in enumerate(worth):
            if found[place] is None:
                found[place] = self.extrapolated(fit, trial.candidate, trial.signature)
                trial.linear = found[place] is not None
        rest = [place for place in range(len(worth)) if found[place] is None]  # a law that is never absent has no linear step
        fits = self.problem.at_once([partial(self.refit, fit, worth[place].candidate) for place in rest])
        for place, refitted in zip(rest, fits, strict=True):
            found[place] = refitted
        self.refitted |= {
            (fit.model.terms, trial.candidate.name): one for trial, one in zip(worth, found, strict=True) if not trial.linear
        }
        return found

    def run(self, fit):
        """(fits after each accepted step, rounds): forward with re-tries, then backward."""
        fits, rounds, kept = [fit], [], None
        while True:
            trials, kept = kept or self.round(fits[-1]), None
            rounds.append(trials)
            terms = fits[-1].model.terms
            allowed = [
                trial
                for trial in trials.values()
                if trial.fit is not None and not trial.fails and not self.same_form(trial.candidate, terms)
            ]
            if len(terms) >= MOST_TERMS:
                break
            if fits[1:] and self.budget.search_over("a search beyond " + ", ".join(term.name for term in terms)):
                break
            if not allowed:
                pair = []
                if len(terms) < MOST_TERMS - 1 and not self.budget.search_over("pairs of candidates"):
                    pair = hidden_pair(self, fits[-1], trials)
                if not pair:
                    break
                fits += pair
                while (pruned := self.prune(fits[-1], newest=len(pair))) is not None:  # what stood for both of them
                    fits.append(pruned)
                continue
            best = self.best(allowed)
            if best.linear:  # now it is worth a simulation; then choose again
                best.linear, best.fails = False, []
                self.judge(fits[-1], best.candidate, self.refit(fits[-1], best.candidate), best)
                for trial in trials.values():
                    trial.fails = []
                self.decide(list(trials.values()))
                rounds.pop()
                kept = trials
                continue
            fits.append(self.simplest_form(best, allowed).fit)
            pruned = self.prune(fits[-1])
            if pruned is not None:
                fits.append(pruned)
                if len(fits) > 2 * MOST_TERMS + 2:
                    break
        return fits, rounds

    def best(self, allowed):
        """The trial of highest evidence; among those within one unit of it, not a fluid where the file says there is none, and
        rather another value of a number that the model has than a law that it has not.

        Where it does not explain the data, what the samples around the impacts show directly goes first if it does about as well.
        """
        most = max(trial.gain - trial.price for trial in allowed)
        dry = self.problem.trials[0].surroundings.fluid_density == 0.0
        near = [trial for trial in allowed if trial.gain - trial.price > most - 1.0]
        best = max(
            near,
            key=lambda trial: (
                not (dry and trial.candidate.group == "fluid"),
                trial.candidate.kind.replaces,
                round(trial.gain - trial.price, 6),
                trial.candidate.name,
            ),
        )
        if best.candidate.name in self.read or explained(self.problem, best.fit):
            return best
        witnessed = [trial for trial in allowed if trial.candidate.name in self.read and trial.gain > WITNESSED * best.gain]
        return max(witnessed, key=lambda trial: (round(trial.gain - trial.price, 6), trial.candidate.name), default=best)

    def contradicts(self, fit):
        """Does the newest term deny what the file states (lift of a fluid far denser), and without mending the model?

        On a floor, lift that only lightens the load says what friction says; there the fluid must at least be one that exists.
        """
        stated, term = self.problem.trials[0].surroundings.fluid_density, fit.model.terms[-1]
        if term.name == "buoyancy" and self.problem.shots.contact and NO_FLUID[0] < term.numbers["fluid_density"] < NO_FLUID[1]:
            return True
        return term.name == "buoyancy" and 0 < 2 * stated < term.numbers["fluid_density"] and fit.chi2 > 1.5 * fit.freedom

    def simplest_form(self, best, allowed):
        """Among forms of one law that all leave the model inadequate, the one with the fewest numbers."""
        if best.fit.chi2 < 1.5 * best.fit.freedom:
            return best
        forms = [
            trial
            for trial in allowed
            if self.same_form(trial.candidate, best.fit.model.terms[-1:]) and trial.gain > 0.5 * best.gain
        ]
        return min(forms, key=lambda trial: (len(trial.candidate.free), -trial.gain), default=best)

    @staticmethod
    def same_form(entry, terms):
        """Is a candidate another form of a law that one of the terms is a form of?"""
        return bool(entry.kind.form_of) and any(term.candidate.kind.form_of == entry.kind.form_of for term in terms)

    def prune(self, fit, newest=1):
        """The fit without the first term whose removal costs less than its price, or that what came later drove beyond what is
        plausible; None where there is none. The `newest` ones stay."""
        if len(fit.model.terms) < 2:
            return None
        for index, term in enumerate(fit.model.terms[: len(fit.model.terms) - newest]):
            if carries(fit.model, index):
                continue
            without = self.problem.fit(fit.model.without(index), fit.starts)
            if without.chi2 - fit.chi2 < self.price(term.candidate) or self.out_of_bounds(fit, index):
                return without
        return None


def _rms(parts):
    total = np.concatenate(parts)
    return float(np.sqrt(np.mean(total**2)))


def explained(problem, fit):
    """Does a fit leave nothing but noise? Pieces of a tumble absorb much, so little may be left over there."""
    spare = 1 + 3 * np.sqrt(2 / fit.freedom)
    return fit.chi2 < (min(spare, EXPLAINED) if cut(problem) else EXPLAINED) * fit.freedom
