"""One search over sets of effects, best first.

From every fit that is expanded, one linear model foresees what other sets would cost (`selection.prediction`); the most promising
one that is not fitted yet is fitted through the simulator and, where it is among the best, expanded in turn. It ends when no set
is foreseen within reach of the best. What was fitted on the way is the answer: the best set, and whatever does as well.

The cost of a set is -2 log of its posterior probability: its misfit, what is believed of its numbers, what it pays for them
(`Fit.cost`), and the odds against each effect.
"""

from functools import partial

import numpy as np

from hlcs.estimation.budget import Budget
from hlcs.estimation.fitting import left_by_segments
from hlcs.selection.candidate_sets import CandidateSets
from hlcs.selection.prediction import LinearModel, Proposal, signatures
from hlcs.selection.preview import FARTHER, HERE, Preview, misfit
from hlcs.selection.refitting import refit
from hlcs.selection.thresholds import (
    ALIKE,
    EQUAL,
    EXPANDED,
    FORESEEN,
    HELPS,
    MOST_EFFECTS,
    NOISE,
    ODDS,
    REACH,
    REFITS,
    TIED,
    TOGETHER,
)


class Search(CandidateSets):
    """The fitted sets of effects of one problem."""

    def __init__(self, problem, candidates, base, odds=ODDS, progress=None, readings=None, first=(), budget=None):
        """base: Fit of the model under test; odds: against one effect; readings: candidate -> its numbers as the data show them
        without the model; first: sets that are fitted whatever is foreseen of them, ({candidate: its numbers}, initial states or
        None) each: far from the data nothing foresees them; budget: of a search that this one goes on with."""
        super().__init__(candidates, base.model.kinds, odds)
        self.problem, self.base = problem, base
        self.progress, self.readings, self.first = progress or (lambda text: None), readings or {}, tuple(first)
        self.preview = Preview(problem, base.model, self.candidates)
        self.budget = budget or Budget(problem)
        self.fits = {frozenset(): base}  # names of effects -> their best fit
        self.fits_for_verdict = {}  # the same of sets that the search had no need of, fitted for the verdict
        self.models = {}  # set that was expanded -> the LinearModel at its fit
        self.overdispersion = 1.0  # how many residuals count as one beside the best fit, where its adequacy has been judged
        self.foreseen = {}  # set -> its Proposal
        self.unsure = {}  # set of one effect -> how much less than foreseen it may cost
        self.twins = set()  # sets that do as the best fits do where these stand, whatever is foreseen far from there
        self.found = {}  # Fit -> [(set that was foreseen from it, fall found, fall foreseen)]
        self.closed = {frozenset()}  # sets that are not fitted again: they cannot be simulated, or were fitted twice
        self.parents = {}  # set -> the Fits that its own fits were foreseen from
        self.ended = {}  # set -> its Fit, of those that are fitted together

    @property
    def contact(self):
        """Does anything touch?"""
        return self.problem.contact

    @property
    def rough(self):
        """chi2 by which fits of segments may miss their minimum; 0 where there are none."""
        return left_by_segments(self.problem)

    # --- what a set costs -----------------------------------------------------------------------------------------------------

    def cost(self, effects):
        """-2 log of the posterior probability of a fitted set, up to a constant of the data."""
        return self.cost_of(effects, self.fits[effects])

    def cost_of(self, effects, fit):
        """The same of any Fit of a set."""
        return fit.cost + self.price(effects, fit)

    def ranked(self):
        """The fitted sets, the best first."""
        return sorted(self.fits, key=lambda effects: (self.cost(effects), sorted(effects)))

    def excess(self, fit):
        """chi2 that a fit leaves beyond what noise alone may leave, as far as the sum of squares can tell."""
        return fit.chi2 - fit.freedom - NOISE * np.sqrt(2 * fit.freedom)

    def noise_alone(self, fit):
        """Does a fit leave nothing but noise, as far as the sum of squares can tell, and with numbers that are plausible?"""
        return self.excess(fit) < 0 and not fit.implausible

    # --- best first -----------------------------------------------------------------------------------------------------------

    def run(self, pause=None):
        """Expand and refit until no set is foreseen within reach of the best, or until Ctrl-C: what is fitted by then stays.
        pause: function (best set, what the most promising one may cost) that says to stop before that; to be gone on with."""
        try:
            self._expand_and_refit(pause or (lambda best, promised: False))
        except KeyboardInterrupt:
            if not self.models:  # nothing is known yet
                raise
            self.budget.stop(self.progress)
        return self

    def wider(self, overdispersion):
        """Go on as far as sets are of interest where so many residuals count as one; is one of them better than all before?"""
        best, self.overdispersion = self.cost(self.ranked()[0]), overdispersion
        return not self.budget.stopped and self.cost(self.run().ranked()[0]) < best - EQUAL

    def reach(self, fit=None):
        """What a set may be foreseen to cost more than the best one, or than a Fit, to be fitted: where more than noise is left,
        in units of it, since what misleads the best fit misleads what is foreseen as well."""
        fit = fit or self.fits[self.ranked()[0]]
        return REACH * max(self.overdispersion, 1.0 if self.noise_alone(fit) else fit.chi2_per_freedom)

    def limit(self, effects):
        """What a fit of a set may cost, its price aside, to be within reach of the best one that is known by now."""
        best = self.ranked()[0]
        known = (best, self.fits[best]), *self.ended.items()
        return min(self.cost_of(its, fit) + self.reach(fit) for its, fit in known) - self.price(effects)

    def _expand_and_refit(self, pause):
        self.expand()
        self.fit_first()
        refits = 0
        while True:
            self.expand()
            if (best := self.ranked()[0]) not in self.models:  # it has changed with what the file implies beside it
                continue
            limit, explained = self.cost(best) + self.reach(), self.noise_alone(self.fits[best])
            known = limit, explained, self.costs_of_parts(best)
            promising = [each for each in self.open_proposals() if self.promising(each, *known)]
            promising.sort(key=lambda each: (self.hoped(each, *known), sorted(each.effects)))
            self.budget.left_out, self.budget.full = len(promising), refits >= REFITS
            if not promising or pause(best, self.hoped(promising[0], *known) if self.contact else promising[0].cost):
                break
            twice = max(promising[0].cost, 0.0) / HELPS  # what is foreseen to leave more comes later, if ever
            together = self.first_ones(self.parts_first([each for each in promising if each.cost <= twice], limit), promising)
            affordable = self.budget.affordable([self.count(each.effects) for each in together], TOGETHER)
            if self.budget.spent or not affordable:
                together = [each for each in together if explained and each.effects in self.twins and each.cost <= limit]
                affordable = range(len(together))  # twins of what was found are few, and without them it would be told alone
            if not (together := [together[place] for place in affordable]):
                break
            named = ", ".join(" + ".join(sorted(proposal.effects)) for proposal in together[:3])
            self.progress(f"fitting {named}{self.budget.time_left()}")
            self.fit_sets(together)
            refits += len(together)

    def fit_first(self):
        """Fit the sets that nothing foresees, what the file implies beside them, that which leaves least where it begins first.

        In flight all, through contacts until one explains the data, and what leaves as little there; none twice that does so.
        """
        begun, start = [], self.base.initial_states
        for numbers, states in self.first:
            certain = [name for name in self.implied if self.compatible({*numbers, name})]
            numbers = {name: self.candidates[name].expected for name in certain} | numbers
            left = self.preview.left_from(numbers, start if states is None else states)
            begun.append((left, sorted(numbers), numbers, states))
        begun.sort(key=lambda each: each[:2])
        for left, names, numbers, states in begun:
            explained = self.contact and self.noise_alone(self.fits[self.ranked()[0]])
            known = self.fits.get(effects := frozenset(names))
            if not (known and self.excess(known) < 0) and (left < begun[0][0] + REACH or not explained):
                self.fit_sets([Proposal(np.inf, effects, numbers, self.base)], states)
            elif there := self.foreseen.get(effects):  # if it is fitted after all, from where it stood before
                self.foreseen[effects] = there._replace(numbers=numbers)
        self.first = ()

    def fit_sets(self, proposals, states=None):
        """Fit sets in one batch, [Proposal], and keep what was found; states: to begin from."""
        before, self.ended = self.budget.steps, {}
        fits = self.problem.batched([partial(refit, self, each, states) for each in proposals])
        self.budget.fitted(sum(self.count(each.effects) for each in proposals), before)
        for proposal, fit in zip(proposals, fits, strict=True):
            effects, parent = proposal.effects, proposal.parent
            if effects in self.fits or fit is None and np.isfinite(proposal.cost):
                self.closed.add(effects)  # of what nothing foresaw the way there may yet be found
            if fit is None:
                continue
            self.parents.setdefault(effects, []).append(parent)
            if effects not in self.fits or fit.cost < self.fits[effects].cost:
                self.fits[effects] = fit
            if proposal.fall > 0:
                self.found.setdefault(parent, []).append((effects, max(misfit(parent) - misfit(fit), 0.0), proposal.fall))

    def parts_first(self, proposals, limit):
        """[Proposal] to be fitted now: what is simpler than these sets and not fitted, and of them those that wait for nothing
        simpler. First what the first one waits for, then the cheapest.

        Simpler are parts with one effect less that are not foreseen to cost more than `limit`, and special cases in the place of
        a law. Far from the data what is foreseen of two effects flatters the one that bends least, and of laws what bends most.
        """
        ordered = {}
        for proposal in proposals:
            parts = []
            for part in self.unfitted_parts(proposal.effects):
                numbers = {name: proposal.numbers.get(name, self.candidates[name].expected) for name in part}
                parts.append(self.foreseen.get(part, Proposal(limit, part, numbers, proposal.parent)))
            same = len(proposal.effects)
            parts = [each for each in parts if not self.adorned(each)]
            first = [each for each in parts if each.cost <= limit and self.borne_out(each) or len(each.effects) == same]
            for each in (*sorted(first, key=self.likely), proposal):
                ordered.setdefault(each.effects, each)
        first, *others = ordered.values()
        ready = [each for each in others if ordered.keys().isdisjoint(self.unfitted_parts(each.effects))]
        return [first, *sorted(ready, key=lambda each: (self.likely(each), sorted(each.effects)))]

    def first_ones(self, proposals, promising):
        """Those of the proposals that are to be fitted now: the first one, and what is foreseen within reach of the cheapest, or
        to take away HELPS of what that one takes from the best so far: through impacts much is found that was not foreseen. The
        others are of interest where these fail. promising: all, of which the cheapest may wait for parts."""
        least = min(map(self.likely, promising))
        most = least + max(self.reach(), HELPS * (self.cost(self.ranked()[0]) - least))
        return [each for place, each in enumerate(proposals) if not place or self.likely(each) <= most]

    def borne_out(self, proposal):
        """Is a set without some effect of the fit that it was foreseen from also foreseen where that effect is not, FORESEEN of
        what that fit takes away there?

        A law that only changes what another one does, as an adhesion that presses a spinning ball harder on its floor, is
        foreseen beside it to do all of its work, and alone does nothing.
        """
        present = frozenset(proposal.parent.model.numbers)
        there = self.models.get(proposal.effects & present)
        if there is None or present <= proposal.effects or not proposal.effects | present <= there.places.keys():
            return True
        return there.proposal(proposal.effects).fall >= FORESEEN * there.proposal(present).fall

    def adorned(self, proposal):
        """Is a set foreseen to take away no more than a part of it does that was fitted? It would leave what that one left. What
        the file implies beside that part stands there though the data do not show it."""
        there = self.models.get(frozenset(proposal.parent.model.numbers))
        parts = [part for part in self.fits if part < proposal.effects and not proposal.effects <= part | self.implied]
        known = [part for part in parts if there and there.foresees(part)]
        return any(proposal.fall < there.proposal(part).fall + EQUAL for part in known)

    def unfitted_parts(self, effects):
        """Its `parts` that are not fitted."""
        return [few for few in self.parts(effects) if self.compatible(few) and few not in self.fits and few not in self.closed]

    def costs_of_parts(self, best):
        """{fitted set: what a set that holds it must stay below}. Where the best one has proved that something is missing, what
        does as well in its place is set beside it, not beside nothing."""
        costs = {effects: self.cost(effects) for effects in self.fits}
        return costs | ({frozenset(): max(costs[frozenset()], costs[best] + TIED)} if best else {})

    def promising(self, proposal, limit, explained, costs):
        """May a set do as well as the best, cost no more than `limit`, and do better than each part of it that is fitted, by
        more than fits leave? explained: does the best leave nothing but noise? costs: of what is fitted, as `costs_of_parts`.

        While it leaves more, a set must be foreseen to take away so much of the excess that the verdict would name it; a single
        effect of a flight need not: what it absorbs is told. Through contacts, where a fit costs a hundred times as much, a set
        must also be borne out where what it replaces is not.
        """
        parts = [cost - self.rough for known, cost in costs.items() if known < proposal.effects]
        if not self.hoped(proposal, limit, explained, costs) < min([limit, *parts]) or self.adorned(proposal):
            return False
        if self.contact and not self.borne_out(proposal):
            return False
        if explained or not self.contact and len(proposal.effects - self.implied) == 1:
            return True
        fall = misfit(self.base) - misfit(proposal.parent) + proposal.fall - self.lost(proposal)
        return fall > HELPS * self.excess(self.base) * (1.0 if self.found else FORESEEN)

    def hoped(self, proposal, limit, explained, costs):
        """The least that a set may cost. A linear model may promise too little: in flight by what a look there shows; through
        contacts, of a set that holds none of the best ones, by as much more of all that it takes away as fits found, of a single
        effect by FORESEEN of it at least, but of segments, which fit by chance; a twin of what explains the data by anything."""
        effects = proposal.effects
        more = 0.0 if explained or effects in self.fits else self.unsure.get(effects, 0.0)
        if self.contact and explained and effects in self.twins:
            more = np.inf
        elif self.contact and all(cost - self.rough > limit for known, cost in costs.items() if known < effects):
            single = not self.rough and effects not in self.fits and len(effects - self.implied) == 1
            share = max(self.share_found(self.base) - 1, FORESEEN if single else 0.0)
            more = max(share * (misfit(self.base) - misfit(proposal.parent) + proposal.fall), 0.0)
        return self.likely(proposal) - more

    def lost(self, proposal):
        """What fits will not find of a fall that is foreseen, by those of the sets that brought one of its effects there: where
        chi2 is rough, or nothing explains the data, a linear model promises much and keeps little."""
        share = self.share_found(proposal.parent, proposal.effects - set(proposal.parent.model.numbers))
        return max(1 - share, 0.0) * max(proposal.fall, 0.0)

    def likely(self, proposal):
        """What a set will cost: as foreseen, and what is lost of that."""
        return proposal.cost + self.lost(proposal)

    def share_found(self, parent, new=None):
        """What the fits of sets that were foreseen from a fit found of the fall that was foreseen of them, the median; before any
        all of it, and that counts as one of them: a single law that bends far away says nothing of the others. new: of sets
        that brought one of these effects there; None = of all."""
        known = [falls for effects, *falls in self.found.get(parent, ()) if new is None or effects & new]
        found, foreseen = np.array([(1.0, 1.0), *known]).T
        return float(np.median(found / foreseen))

    def open_proposals(self):
        """[Proposal] of the sets that are not fitted yet; and once more of those whose fit got stuck, where another one foresees
        them at far less."""

        def stuck(effects, proposal):
            return proposal.parent not in self.parents.get(effects, ()) and self.cost(effects) > proposal.cost + REACH

        return [
            proposal
            for effects, proposal in self.foreseen.items()
            if effects not in self.closed and (effects not in self.fits or stuck(effects, proposal))
        ]

    def expand(self):
        """Foresee neighbours of the best fitted sets: where it explains the data of the best and those told beside it, which have
        twins of their own; else of the next ones too, since what the best one lacks may have led its numbers where nothing is
        foreseen of that. Through contacts, where this is dear, only of those that are as good in units of what it leaves."""
        first = self.ranked()[0]
        reach = TIED if self.noise_alone(self.fits[first]) else np.inf
        if self.contact:
            reach = min(reach, self.reach() if self.budget.share < 0.5 else 0.0)
        near = [first, *(each for each in self.ranked()[1:EXPANDED] if self.cost(each) < self.cost(first) + reach)]
        if first in self.models:
            self.implied_alone, self.implied = self.models[first].certain(self.odds, self.candidates)
        for effects in near:
            fit = self.fits[effects]
            if effects in self.models or not np.isfinite(fit.chi2):
                continue
            entries = [entry for name, entry in self.candidates.items() if name not in effects]
            self.progress(f"screening {len(entries)} candidates{self.budget.time_left()}")
            linear = self.models[effects] = self.linear_at(fit, entries)[1]
            if effects == first:  # a slow fall through a liquid shows a lift that a free fall does not, and the reverse
                self.implied_alone, self.implied = linear.certain(self.odds, self.candidates)
            if not effects:
                expected = {name: self.candidates[name].expected for name in sorted(self.implied)}
                self.first += ((expected, None),) if expected and self.compatible(self.implied) else ()
            proposals = linear.proposals(MOST_EFFECTS, self.compatible, self.implied)
            self.twins |= linear.twins(ALIKE)
            begins = effects in (frozenset(), self.implied)
            singles = [proposal for proposal in proposals if effects < proposal.effects and len(proposal.effects - effects) == 1]
            if begins and not self.contact:
                looks = self.preview.look(singles)
                self.unsure |= looks
                bent = [each for each in singles if looks[each.effects] > max(each.fall, self.reach())]
                self.first += () if effects or self.noise_alone(fit) else tuple((each.numbers, None) for each in bent)
            elif begins:
                explained = any(proposal.fall >= self.excess(fit) for proposal in proposals)
                proposals += self.preview.looked(singles, HERE if explained else FARTHER)
            if not effects and self.contact and not self.noise_alone(fit):
                self.first += tuple((proposal.numbers, None) for proposal in singles if self.doubted(proposal))
                stated = {name for numbers, _ in self.first for name in numbers if self.candidates[name].setting}
                self.first += tuple((each.numbers, None) for each in proposals if each.effects == stated and len(stated) > 1)
            for proposal in proposals:
                known = self.foreseen.get(proposal.effects)
                nearer = EQUAL if known and misfit(fit) < misfit(known.parent) else 0.0  # it is foreseen better from there
                if known is None or proposal.cost < known.cost + nearer:
                    self.foreseen[proposal.effects] = proposal

    def doubted(self, proposal):
        """Is a set one number that the model under test states, its friction or restitution, and foreseen to be of interest? It
        is doubted before all else, with others that are: bodies stop elsewhere by leaps, of which little is foreseen."""
        (name,) = proposal.effects
        new = all(set(numbers) != {name} for numbers, _ in self.first)
        # free starts leave little to be foreseen
        least = 0.0 if self.problem.segmented else HELPS * FORESEEN * self.excess(proposal.parent)
        return new and self.candidates[name].setting and proposal.fall > least

    def linear_at(self, fit, entries):
        """({candidate: its signatures at a fit}, the LinearModel that they make)."""
        looks = [partial(signatures, self.problem, fit, entry, self.readings.get(entry.name, {})) for entry in entries]
        views = dict(zip(entries, self.problem.batched(looks), strict=True))
        return views, LinearModel(fit, views, self.price)
