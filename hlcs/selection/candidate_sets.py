"""Which sets of effects can stand, and the odds against each."""

from hlcs.selection.eligibility import lacks_drag


class CandidateSets:
    """The sets of effects that candidates make beside a model under test."""

    def __init__(self, candidates, base_kinds, odds):
        """candidates: list of Candidate; base_kinds: classes of effects in the model under test; odds: against one effect."""
        self.candidates = {entry.name: entry for entry in sorted(candidates, key=lambda entry: entry.name)}
        self.base_kinds, self.odds = base_kinds, odds
        self.implied_alone = self.implied = frozenset()  # what the file implies beside the best fit: see `LinearModel.certain`

    def price(self, effects, fit=None):
        """The odds against a set: against each effect, once more against a law that holds another as a special case; where the
        file implies effects that these data would show (the lift of a stated fluid) once against the absence of any, or against
        what contradicts the file in its `fit`; none against what the file states to be uncertain (the length of a pixel). Air
        that the file does not state is not missed, and counts as one effect with all that it does."""
        implied = self.implied_beside(effects)
        entries = [self.candidates[name] for name in effects if name not in implied and not self.candidates[name].doubted]
        against = sum(1 + any(map(entry.holds, self.candidates.values())) for entry in entries)
        air = {name for name in implied if self.candidates[name].presumed}
        missed = bool(implied - air - effects) or fit is not None and fit.contradicts
        return self.odds * (against + missed + bool(air & effects))

    def implied_beside(self, effects):
        """What the file implies beside a set: what the data would show and, beside others, what their numbers would; a law that
        holds another one stands in its place. Air that no file states is implied beside others alone."""
        held = {name for name in self.implied for law in effects if self.candidates[law].holds(self.candidates[name])}
        stated = {name for name in self.implied_alone if not self.candidates[name].presumed}
        implied = (self.implied if effects - self.implied else frozenset(stated)) - held
        if self.compatible(effects | implied):
            return implied
        return frozenset(name for name in implied if not self.candidates[name].through_drag)

    def compatible(self, effects):
        """May these candidates stand in one model? Not two forms of a law in the same power, nor what acts by an absent drag."""
        entries = [self.candidates[name] for name in effects]
        forms = [(entry.form_of, power) for entry in entries if entry.form_of for power in entry.kind.powers]
        kinds = [*self.base_kinds, *(entry.kind for entry in entries)]
        return len(forms) == len(set(forms)) and not any(lacks_drag(entry, kinds) for entry in entries)

    def count(self, effects):
        """How many numbers a set has that a fit must find, one at least."""
        return max(sum(len(self.candidates[name].free) for name in effects - self.implied), 1)

    def parts(self, effects):
        """Sets without one of the doubtful effects of a set, or with a special case in the place of its law."""
        names = sorted(effects - self.implied)
        return [few for name in names for few in (effects - {name}, *with_special_cases(effects, name, self.candidates))]


def with_special_cases(effects, name, candidates):
    """Sets with a special case of a law in its place."""
    return [effects - {name} | {other} for other, law in candidates.items() if candidates[name].holds(law)]
