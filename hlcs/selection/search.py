"""The search for what is missing: screen, refit, hold out; forward with re-tries, backward; competing models.

Rules (thresholds from theory or set here, none tuned to a data set): a candidate with p numbers is accepted when the
whitened chi2 falls by more than p log n + 6 (12 where nothing can be held out), when it predicts recordings it was not
fitted to better than without it, when its numbers lie inside their bounds, and when the held-out error falls by 2 % or
by 0.1 sigma. Never more than three.
"""

from functools import partial

import numpy as np
from scipy import stats

from hlcs.estimation.budget import Budget
from hlcs.estimation.cross_validation import CrossValidation
from hlcs.estimation.least_squares import least_squares, project_out
from hlcs.estimation.linearization import CandidateTrial
from hlcs.estimation.problem import Problem
from hlcs.estimation.whitening import colour
from hlcs.selection.eligibility import carries
from hlcs.selection.pairs import hidden_pair
from hlcs.selection.reasons import Rule
from hlcs.selection.screening import Screening
from hlcs.simulation.model import Term

MOST_TERMS = 3
NO_FLUID = (25.0, 600.0)  # between dense gases, a few bar included, and light liquids there is no fluid [kg/m3]
COMPETITOR_MARGIN = 6.0  # of chi2, within which a competing model is not ruled out
MOST_REFITS = 6  # of candidates that point at the residual weakly
FIRST_REFITS_IN_CONTACT = 2  # where every simulation has contacts to solve
MOST_REFITS_IN_CONTACT = 12  # there, as long as nothing explains the data
AS_GOOD = 0.98  # part of the best linear gain from which a candidate points at the residual as well
WITNESSED = 0.98  # part of the best gain from which what impacts show directly goes first, where neither explains the data
EXPLAINED = 1.25  # chi2 per degree of freedom below which a fit explains the data
SHORT = 0.8  # part of its linear gain below which a refit through contacts is taken up again from the full linear step


class Search(Screening):
    """One search over candidates on one problem."""

    def __init__(self, problem: Problem, candidates, cross_validation: CrossValidation, progress=None, readings=None):
        super().__init__(problem, cross_validation)
        self.readings = (
            readings or {}
        )  # candidate -> its numbers as samples around the impacts show them, where the model has others
        self.candidates = sorted(candidates, key=lambda entry: entry.name)
        self.progress = progress or (lambda text: None)
        self.budget = Budget(problem)
        self.replacements = {}  # (terms of a model, index of one) -> competing_models.Replacement
        self.refitted = {}  # (terms of a model, candidate) -> its fit on top of that model

    def refit(self, fit, entry):
        """The fit with the candidate in, from its null value and from what impacts show; made once."""
        key = fit.model.terms, entry.name
        if key not in self.refitted:
            begin = list(entry.starts)
            if entry.absent is not None:
                begin = [tuple((self.view.get(entry.name) or entry.absent).items())]
            if entry.name in self.readings:
                begin.append(tuple(self.readings[entry.name].items()))
            self.refitted[key] = self.best_fit(fit.model, entry, begin, fit.initial_states)
        return self.refitted[key]

    def best_fit(self, model, entry, begin, initial_states):
        """The best fit of a model with a candidate in, from each of the values to begin with."""
        models = [model.with_term(Term(entry, values)) for values in begin]
        fits = self.problem.batched([partial(self.problem.fit, one, initial_states) for one in models])
        return min(fits, key=lambda fit: fit.chi2)

    def judged(self, before, entry, fit):
        """The CandidateTrial of a refitted candidate against the fit without it."""
        trial = CandidateTrial(entry, required_gain=self.required_gain(entry))
        self.judge(before, fit, trial)
        return trial

    def judge(self, before, fit, trial):
        """Fill in the held-out figures of a refitted candidate against the fit without it."""
        if not np.isfinite(fit.chi2):
            trial.fails.append(Rule.FINITE())
            return
        trial.fit, trial.gain = fit, before.chi2 - fit.chi2
        if not self.cross_validation.possible:
            return
        r0, r1 = self.cross_validation.residuals(before), self.cross_validation.residuals(fit)
        dots = spread = clustered = 0.0
        for a, b in zip(r0, r1, strict=True):
            difference = a - b
            dots += float(difference @ a)
            spread += float(difference @ difference)
            clustered += float(difference @ b) ** 2
        trial.p = float(stats.norm.sf(dots / np.sqrt(max(spread, clustered)))) if spread > 0 else 1.0
        raw0, raw1 = self.coloured(r0), self.coloured(r1)
        trial.directions = tuple(
            1 - _rms([raw1[k] for k in inside]) / _rms([raw0[k] for k in inside])
            for inside in (np.flatnonzero(self.cross_validation.half == half) for half in (0, 1))
        )
        e0, e1 = _rms(raw0), _rms(raw1)
        trial.falls, trial.falls_sigma = 1 - e1 / e0, e0 - e1

    def coloured(self, residuals):
        """White residuals turned back into residuals in units of sigma, list of (n_i,)."""
        return [
            colour(recording.whitening, part) / recording.whitening.sigma
            for recording, part in zip(self.problem.recordings, residuals, strict=True)
        ]

    def apply_rules(self, trials):
        """Fill in `fails`: the rules each refitted candidate breaks."""
        tried = [trial for trial in trials if trial.visible > 0]
        ordered = sorted(tried, key=lambda trial: (trial.p, trial.candidate.name))
        largest = 0.0
        for place, trial in enumerate(ordered):  # Holm's step-down
            largest = max(largest, min(1.0, (len(ordered) - place) * trial.p))
            trial.holm = largest
        for trial in tried:
            if trial.fit is not None:
                trial.fails += self.broken_rules(trial)

    def broken_rules(self, trial):
        """Explanations of the rules that a judged candidate breaks; its `holm` counts those it was chosen among."""
        rest = max(trial.fit.chi2 / trial.fit.freedom, 1.0)  # what stays unexplained counts as noise
        if trial.gain <= trial.required_gain * rest:
            return [Rule.PRICE(gain=trial.gain, price=trial.required_gain * rest)]
        broken = []
        if self.cross_validation.possible:
            if self.cross_validation.few and min(trial.directions) <= 0.02:
                changes = " and ".join(f"{-100 * fall:+.0f} %" for fall in trial.directions)
                broken.append(Rule.BOTH_DIRECTIONS(changes=changes))
            elif not self.cross_validation.few and trial.holm >= 0.05:
                broken.append(Rule.NO_CHANCE(p=trial.holm))
            elif trial.falls <= 0.02 and trial.falls_sigma <= 0.1:
                broken.append(Rule.HELD_OUT_ERROR(percent=100 * trial.falls))
        broken += self.out_of_bounds(trial.fit)
        if self.contradicts(trial.fit):
            broken.append(Rule.STATED_FLUID(density=trial.fit.model.terms[-1].numbers["fluid_density"]))
        return broken

    def out_of_bounds(self, fit, index=-1):
        """Explanations about numbers of a term, the newest or another, that lie at a bound or are not plausible."""
        term = fit.model.terms[index]
        outside = [
            Rule.INSIDE_BOUNDS(name=free.name, value=term.numbers[free.name])
            for free, at_bound in zip(term.candidate.free, fit.at_bound[fit.numbers_of(index)], strict=True)
            if at_bound
        ]
        relative = getattr(term.candidate.kind, "relative_bound", None)
        if relative:
            low, high = self.problem.simulator.height_range
            size = sum(abs(value) for value in term.numbers.values())
            if size > 2 * relative * (high - low):
                outside.append(Rule.PLAUSIBLE_SIZE(size=size))
        return outside

    # --- rounds ---------------------------------------------------------------------------------------------------------------

    def round(self, fit):
        """Every candidate tried on top of a fit: {name: CandidateTrial}."""
        entries = [entry for entry in self.candidates if entry.name not in fit.model.names]
        self.progress(f"screening {len(entries)} candidates")
        signatures = self.problem.batched([partial(self.screen, fit, entry) for entry in entries])
        trials = [self.screened(fit, entry, signature) for entry, signature in zip(entries, signatures, strict=True)]
        ranked = sorted(
            (trial for trial in trials if trial.visible),
            key=lambda trial: (
                trial.candidate.name not in self.readings,
                trial.required_gain - trial.linear_gain,
                trial.candidate.name,
            ),
        )
        worth = [
            trial
            for place, trial in enumerate(ranked)
            if trial.linear_gain > 0.6 * trial.required_gain
            or trial.candidate.name in self.readings
            or place < MOST_REFITS
            and trial.linear_gain > 0.3 * trial.required_gain
        ]
        for trial, refitted in zip(worth, self.refits(fit, worth), strict=True):
            self.judge(fit, refitted, trial)
        self.apply_rules(trials)
        return {trial.candidate.name: trial for trial in trials}

    def screened(self, fit, entry, signature):
        """The CandidateTrial of a candidate before any refit; signature: its own at the fit, None where it cannot join."""
        trial = CandidateTrial(entry, required_gain=self.required_gain(entry), signature=signature)
        if signature is not None:
            r, q = fit.linearization.residual
            columns = np.concatenate(signature)
            s, full = project_out(q, columns), np.linalg.norm(columns)
            self.visible_numbers[entry.name] = self.count_visible(entry, columns)
            trial.required_gain = self.required_gain(entry)
            size = float(np.linalg.norm(s))
            if size > 1e-6 * max(full, 1e-300) and full > 1e-9:
                trial.visible, trial.linear_gain = size, least_squares(s, r).gain
        return trial

    def refits(self, fit, worth):
        """Fits with each of the candidates in, list; with contacts the first are refitted, the rest come by one linear step."""
        refitted = self._refits_in_contact(fit, worth) if self.problem.simulator.contact else {}
        for place, trial in enumerate(worth if self.problem.simulator.contact else ()):
            if place not in refitted and (linear := self.linear_fit(fit, trial.candidate, trial.signature)) is not None:
                refitted[place], trial.by_linear_step = linear, True
        rest = [place for place in range(len(worth)) if place not in refitted]  # a law that is never absent has no linear step
        if rest and not self.problem.simulator.contact:
            self.progress("refitting " + ", ".join(trial.candidate.name for trial in worth[:3]))
        refitted |= self._refit_all(fit, worth, rest)
        self.refitted |= {
            (fit.model.terms, trial.candidate.name): refitted[place]
            for place, trial in enumerate(worth)
            if not trial.by_linear_step
        }
        return [refitted[place] for place in range(len(worth))]

    def _refit_all(self, fit, worth, places):
        """{place: fit with that candidate in}, refitted in one batch."""
        fits = self.problem.batched([partial(self.refit, fit, worth[place].candidate) for place in places])
        return dict(zip(places, fits, strict=True))

    def _refits_in_contact(self, fit, worth):
        """{place: fit} of the candidates that are worth simulations with contacts.

        As long as none of the first explains the data the linear ranking is not to be trusted, and more are refitted; then only
        what points at the residual as well as the best.
        """
        refitted, explains = {}, False
        most = self.budget.affordable(MOST_REFITS_IN_CONTACT)
        if most < min(MOST_REFITS_IN_CONTACT, len(worth)):
            self.budget.leave_out("refits of candidates that point least at the residual; one linear step judges them")
        most_gain = max((trial.linear_gain for trial in worth), default=0.0)
        for wave in (range(0, FIRST_REFITS_IN_CONTACT), range(FIRST_REFITS_IN_CONTACT, most)):
            places = [
                place for place in wave if place < len(worth) and (not explains or worth[place].linear_gain > AS_GOOD * most_gain)
            ]
            if not places:
                break
            self.progress("refitting " + ", ".join(worth[place].candidate.name for place in places[:3]))
            refitted |= self._refit_all(fit, worth, places)
            short = [
                place
                for place in places
                if fit.chi2 - refitted[place].chi2 < SHORT * worth[place].linear_gain
                and worth[place].candidate.absent is not None
                and not self.problem.segmented
            ]  # a law that bends is reached from its other side
            far = [self.linear_fit(fit, worth[place].candidate, worth[place].signature).model for place in short]
            again = self.problem.batched([partial(self.problem.fit, model, fit.initial_states) for model in far])
            for place, other in zip(short, again, strict=True):
                refitted[place] = min(refitted[place], other, key=lambda either: either.chi2)
            explains = any(explained(self.problem, refitted[place]) for place in places)  # nothing but noise is left
        return refitted

    def run(self, fit):
        """(fits after each accepted step, rounds): forward with re-tries, then backward."""
        fits, rounds, again = [fit], [], None
        while True:
            trials, again = again or self.round(fits[-1]), None
            rounds.append(trials)
            terms = fits[-1].model.terms
            allowed = [
                trial
                for trial in trials.values()
                if trial.fit is not None and not trial.fails and not self.same_form(trial.candidate, terms)
            ]
            if len(terms) >= MOST_TERMS:
                break
            if fits[1:] and self.budget.ends_search("a search beyond " + ", ".join(term.name for term in terms)):
                break
            if not allowed:
                pair = []
                if len(terms) < MOST_TERMS - 1 and not self.budget.ends_search("pairs of candidates"):
                    pair = hidden_pair(self, fits[-1], trials)
                if not pair:
                    break
                fits += pair
                while (pruned := self.prune(fits[-1], newest=len(pair))) is not None:  # what stood for both of them
                    fits.append(pruned)
                continue
            best = self.best(allowed)
            if best.by_linear_step:  # now it is worth a simulation; then choose again
                best.by_linear_step, best.fails = False, []
                self.judge(fits[-1], self.refit(fits[-1], best.candidate), best)
                for trial in trials.values():
                    trial.fails = []
                self.apply_rules(list(trials.values()))
                rounds.pop()
                again = trials
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
        most = max(trial.gain - trial.required_gain for trial in allowed)
        dry = self.problem.trials[0].surroundings.fluid_density == 0.0
        near = [trial for trial in allowed if trial.gain - trial.required_gain > most - 1.0]
        best = max(
            near,
            key=lambda trial: (
                not (dry and trial.candidate.group == "fluid"),
                trial.candidate.kind.replaces,
                round(trial.gain - trial.required_gain, 6),
                trial.candidate.name,
            ),
        )
        if best.candidate.name in self.readings or explained(self.problem, best.fit):
            return best
        witnessed = [trial for trial in allowed if trial.candidate.name in self.readings and trial.gain > WITNESSED * best.gain]
        return max(witnessed, key=lambda trial: (round(trial.gain - trial.required_gain, 6), trial.candidate.name), default=best)

    def contradicts(self, fit):
        """Does the newest term deny what the file states (lift of a fluid far denser), and without mending the model?

        On a floor, lift that only lightens the load says what friction says; there the fluid must at least be one that exists.
        """
        stated, term = self.problem.trials[0].surroundings.fluid_density, fit.model.terms[-1]
        if (
            term.name == "buoyancy"
            and self.problem.simulator.contact
            and NO_FLUID[0] < term.numbers["fluid_density"] < NO_FLUID[1]
        ):
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
            without = self.problem.fit(fit.model.without(index), fit.initial_states)
            if without.chi2 - fit.chi2 < self.required_gain(term.candidate) or self.out_of_bounds(fit, index):
                return without
        return None


def _rms(parts):
    total = np.concatenate(parts)
    return float(np.sqrt(np.mean(total**2)))


def explained(problem, fit):
    """Does a fit leave nothing but noise? Segments of a tumble absorb much, so little may be left over there."""
    spare = 1 + 3 * np.sqrt(2 / fit.freedom)
    return fit.chi2 < (min(spare, EXPLAINED) if problem.segmented else EXPLAINED) * fit.freedom
