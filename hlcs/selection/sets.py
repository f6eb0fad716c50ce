"""From the fitted sets to the verdict's ground: the best set that stands, the sets that do as well, and the weight of each."""

from functools import cache, cached_property, partial

import numpy as np

from hlcs.selection.candidate_sets import with_special_cases
from hlcs.selection.held_out import HeldOut, beaten, held_out
from hlcs.selection.thresholds import EQUAL, HELPS, TIED


class FittedSets:
    """What a finished search is worth on held-out data, and beside one another."""

    def __init__(
        self,
        search,
        cross_validation,
        overdispersion=1.0,
        alone=lambda problem, fit: fit,
        adequate=frozenset(),
        possible=lambda effects: True,
        outdone=frozenset(),
    ):
        """overdispersion: how many residuals count as one where no set is adequate; a wrong model concentrates falsely; alone:
        function (problem, fit) -> the fit of a set as it would be, had nothing but this set been looked at; adequate: sets that
        are so where none is that held-out data prove; possible: function set -> may it stand; outdone: sets that may stand, but
        not as the best one, since a part of them does as well."""
        self.search, self.cross_validation, self.overdispersion, self.alone = search, cross_validation, overdispersion, alone
        self.adequate, self.possible, self.outdone = adequate, possible, outdone
        # (Fit without an effect, Fit with it) -> HeldOut: a set may be fitted better meanwhile
        self.seen_held_out = cache(lambda *fits: held_out(search.problem, cross_validation, *fits))
        self.started = {}  # set -> its Fit from a larger one, begun beside others

    def tempered(self):
        """Itself, its sets fitted anew from `returned` where that leaves them cheaper."""
        search, problem = self.search, self.search.problem
        problem.overdispersion = self.overdispersion
        search.fits_for_verdict = {}  # fitted with each residual as one; the best of them are among the fits
        for effects, numbers in [] if search.budget.stopped else self.returned():
            fit = search.fits[effects]
            again = problem.fit(search.preview.model_with(numbers), fit.initial_states)
            search.fits[effects] = min(again, fit, key=lambda fit: fit.tempered(self.overdispersion))
        self.__dict__.pop("ranked", None)
        return self

    def returned(self):
        """[(set, its numbers with those where they are expected that are off only since so much was made of each residual)].

        Of the sets that may then come near the best: a wrong model drives its numbers as far as its misfit is large.
        """
        found = []
        for effects in self.ranked if self.overdispersion > 1 else ():
            fit = self.search.fits[effects]
            savings = fit.savings(self.overdispersion) if np.isfinite(fit.cost) else np.zeros(0)
            back = savings > EQUAL
            if back.any() and self.cost(effects) - savings[back].sum() <= self.cost(self.ranked[0]) + TIED:
                numbers = {name: dict(fit.model.numbers[name]) for name in effects}
                for (name, free, _), expected in zip(fit.numbers, back, strict=True):
                    numbers[name][free.name] = free.expected if expected else numbers[name][free.name]
                found.append((effects, numbers))
        return found

    def cost(self, effects):
        """-2 log of the posterior probability of a fitted set, up to a constant of the data."""
        return self.cost_of(effects, self.search.fits[effects])

    def cost_of(self, effects, fit):
        """The same of any Fit of a set."""
        return fit.tempered(self.overdispersion) + self.search.price(effects, fit)

    @cached_property
    def ranked(self):
        """The fitted sets, the best first."""
        return sorted(self.search.fits, key=lambda effects: (self.cost(effects), sorted(effects)))

    @cached_property
    def cheapest(self):
        """The set of highest posterior probability that stands, of those too that were fitted to judge others; the model under
        test stands always."""
        search = self.search
        while True:
            cheapest = next(effects for effects in self.ranked if self.leads(effects))
            parts = {effects: fit for effects, fit in search.fits_for_verdict.items() if search.fits.get(effects) is not fit}
            search.fits |= parts
            del self.ranked
            if not any(self.cost(effects) < self.cost(cheapest) for effects in parts):
                return cheapest

    @cached_property
    def best(self):
        """The cheapest set that stands or, of those of as many effects that cost no more than EQUAL beyond it, that of the fewest
        numbers, and of those beyond what is plausible: a scale before a curve of five, a drag before a scale off by 13 %."""
        cheapest = self.cheapest
        near = [
            effects
            for effects in self.ranked
            if len(effects) == len(cheapest) and self.cost(effects) - self.cost(cheapest) <= EQUAL and self.leads(effects)
        ]
        return min(near, key=lambda effects: (len(self.search.fits[effects].numbers), self.search.fits[effects].implausible))

    def leads(self, effects):
        """May a set be the best one?"""
        return effects not in self.outdone and self.stands(effects)

    def stands(self, effects):
        """Does every effect of a set lower the held-out error beside the others, and more than absorb where nothing explains the
        data? What the file implies needs no proof on held-out data, and absorbs or not where it stands alone."""
        if not self.possible(effects):
            return False
        fits, doubtful = self.search.fits, sorted(effects - self.search.implied_beside(effects))
        if not np.isfinite(fits[effects].chi2):
            return False
        known = [name for name in doubtful if self.without(effects, name) in fits]  # what needs no fit comes first
        if any(self.broken(effects, name) for name in known):
            return False
        self.fit_without(effects, () if effects in self.adequate else doubtful)
        broken = any(self.broken(effects, name) for name in doubtful)
        return not broken and not any(self.absorbs(effects, name) for name in doubtful or sorted(effects))

    def absorbs(self, effects, name):
        """Where no set explains the data: does an effect take less than HELPS of the excess misfit that is left without it? Not
        a law of contact whose number impacts show otherwise than the model has it: a second witness tells that it is there. What
        a flight shows of a drag, or of a spin that is lost, is no second one."""
        witnessed = name in self.search.readings and self.search.candidates[name].group.startswith("contact")
        return self.overdispersion > 1 and not witnessed and self.share(effects, name) < HELPS

    def share(self, effects, name):
        """Share of the excess misfit that is left without an effect of a set which it takes away, 0 to 1; of a law of which a
        special case was fitted, of what that one leaves; and of the misfit of the model under test, where less is left without it
        only by numbers that contradict what the file states."""
        special = with_special_cases(effects, name, self.search.candidates)
        rests = [self.without(effects, name), *(rest for rest in special if rest in self.search.fits)]
        left = [fit for fit in map(self.fit, rests) if not fit.contradicts] or [self.search.base]
        return min(explained(fit, self.search.fits[effects]) for fit in left)

    def broken(self, effects, name):
        """Explanation of the rule that an effect of a set breaks on held-out data; None of none, where the set is shown by what
        it leaves, and where the data are explained without it only by numbers that contradict what the file states, such as a
        liquid as heavy as the body."""
        if effects in self.adequate or self.fit(self.without(effects, name)).contradicts:
            return None
        return self.held_out(effects, name).broken(self.cross_validation.few, len(self.search.candidates))

    def held_out(self, effects, name) -> HeldOut:
        """What one effect of a set does beside the others, and with it whatever acts through it alone."""
        return self.seen_held_out(self.fit(self.without(effects, name)), self.search.fits[effects])

    def without(self, effects, name):
        """A set without an effect and without what cannot act without it."""
        rest = effects - {name}
        if not self.search.compatible(rest):
            rest = frozenset(other for other in rest if not self.search.candidates[other].through_drag)
        return rest

    def fit(self, effects):
        """The Fit of a set, made where the search had no need of it or did not bring it to its end.

        From where the larger set that it is a part of stands and, where that one alone explains the data, from what the model
        under test foresees of it: without what it was found beside a law may have other numbers, as a friction that is more
        across the grain in place of one that is less along it.
        """
        search = self.search
        found = search.fits.get(effects)
        if found is not None and found.converged:
            return found
        for_verdict, bare = search.fits_for_verdict, search.models.get(frozenset())
        if effects not in for_verdict:
            started = self.started.pop(effects, None) or self.fitted_as_in_larger(effects)
            tried = [found, self.alone(search.problem, started)]
            explained = search.noise_alone(search.fits[self.larger(effects)]) and not search.noise_alone(tried[-1])
            if explained and bare and bare.foresees(effects):
                numbers = bare.proposal(effects).numbers
                tried.append(self.alone(search.problem, self.fitted_from(numbers, search.fits[frozenset()])))
            for_verdict[effects] = min(filter(None, tried), key=lambda fit: fit.tempered(self.overdispersion))
        return for_verdict[effects]

    def fit_without(self, effects, names):
        """Begin, in one batch, what `fit` needs of a set without each of these effects."""
        converged = {its for its, fit in self.search.fits.items() if fit.converged}
        done = self.started.keys() | self.search.fits_for_verdict.keys() | converged
        rests = [rest for rest in dict.fromkeys(self.without(effects, name) for name in names) if rest not in done]
        fits = self.search.problem.batched([partial(self.fitted_as_in_larger, rest) for rest in rests])
        self.started.update(zip(rests, fits, strict=True))

    def larger(self, effects):
        """The smallest fitted set that holds a set and more; the set itself where none does."""
        holding = (known for known in self.search.fits if effects < known)
        return min(holding, key=lambda known: (len(known), sorted(known)), default=effects)

    def fitted_as_in_larger(self, effects):
        """The Fit of a set from where the larger one stands that it is a part of."""
        fit = self.search.fits[self.larger(effects)]
        return self.fitted_from({name: numbers for name, numbers in fit.model.numbers.items() if name in effects}, fit)

    def fitted_from(self, numbers, parent):
        """The Fit of a set from these numbers, or from nearer to the model under test where that fits better; parent: a Fit with
        the initial states that belong to them."""
        search, base = self.search, self.search.fits[frozenset()]
        near = search.preview.nearer(numbers, base)
        states = parent.initial_states if near == numbers else base.initial_states
        return search.problem.fit(search.preview.model_with(near), states)

    def worth(self, effects, name):
        """By how much the cost of a set would rise without one of its effects."""
        rest = self.without(effects, name)
        return self.search.cost_of(rest, self.fit(rest)) - self.search.cost(effects)

    def ordered(self, effects):
        """The effects of a set as a tuple, what it needs most first; of one told beside the best, as far as is known without fits
        that nothing else asks for."""
        asked = effects == self.best
        if asked:
            self.fit_without(effects, sorted(effects))

        def needed(name):
            return self.worth(effects, name) if asked or self.without(effects, name) in self.search.fits else 0.0

        return tuple(sorted(effects, key=lambda name: (-needed(name), name)))

    @cached_property
    def tied(self):
        """The best set and those that do as well, the best first: not beaten on held-out data, none that holds a simpler one of
        less cost, none that contradicts what the file states where the best does not, and none that does better with more of what
        the file implies.

        That something is missing the best set has proved: one of no more effects that does as much in its place is set beside
        it, not beside nothing.
        """
        best, search = self.best, self.search
        reach = self.cost(best) + TIED

        def proved(effects):
            alike = self.overdispersion <= 1 and 0 < len(effects) <= len(best)
            return self.possible(effects) if alike else self.stands(effects)

        near = [effects for effects in self.ranked if self.cost(effects) <= reach and proved(effects)]
        return [best] + [
            effects
            for effects in near
            if effects != best
            and not any(
                self.is_part(other, effects) or effects < other <= effects | search.implied
                for other in near
                if (other or not best) and self.cost(other) < self.cost(effects)
            )
            and (search.fits[best].contradicts or not search.fits[effects].contradicts)
            and (self.overdispersion > 1 or not beaten(self.cross_validation, search.fits[best], search.fits[effects]))
        ]

    def is_part(self, few, many):
        """Is a set part of another one, its laws special cases of the other's counted as part of them?"""

        def within(name):
            return name in many or any(self.search.candidates[other].holds(self.search.candidates[name]) for other in many)

        return few != many and len(few) <= len(many) and all(map(within, few))

    @cached_property
    def absorbing(self):
        """[the cheapest set that holds on held-out data and only absorbs], where no set stands and it costs less; else []."""
        if self.best or self.overdispersion <= 1:
            return []
        better = (effects for effects in self.ranked if self.cost(effects) < self.cost(self.best))
        return [effects for effects in better if not any(self.broken(effects, name) for name in sorted(effects))][:1]

    @cached_property
    def weights(self):
        """Posterior probability of every fitted set among them, 0 of those that cost less than the best and do not stand."""
        names = self.ranked
        costs = np.array([self.cost(effects) for effects in names])
        costs[(costs < self.cost(self.best)) & [effects not in self.tied for effects in names]] = np.inf
        relative = np.exp(-(costs - self.cost(self.best)) / 2)
        return dict(zip(names, relative / relative.sum(), strict=True))

    @cached_property
    def inclusion(self):
        """Weight of all sets that hold each candidate."""
        return {
            name: float(sum(weight for effects, weight in self.weights.items() if name in effects))
            for name in self.search.candidates
        }

    def alternatives(self):
        """{effect of the best set: names that take its place in the sets that do as well}."""
        others = {
            name: [other for effects in self.tied[1:] if name not in effects for other in sorted(effects - self.best)]
            for name in self.ordered(self.best)
        }
        return {name: list(dict.fromkeys(places)) for name, places in others.items()}


def explained(base, final):
    """Share of the excess of chi2 over its expectation that a fit takes away, 0 to 1; 1 where there was none."""
    excess = [max(fit.chi2 - fit.freedom, 0.0) for fit in (base, final)]
    return float(np.clip(1 - excess[1] / excess[0], 0.0, 1.0)) if excess[0] > 0 else 1.0
