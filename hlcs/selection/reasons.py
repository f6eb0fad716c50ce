"""The rules that a candidate may break, and how each is said."""

from hlcs.records import Sentence


class Rule(Sentence):
    """What speaks against a candidate."""

    # recordings and tables of outcomes
    BOTH_DIRECTIONS = "held-out error changes by {changes} in the two directions; a fall above 2 % in each is needed"
    NO_CHANCE = "no better on recordings it was not fitted to (p = {p:.2g} after the number of candidates)"
    HELD_OUT_ERROR = "held-out error falls by {percent:.1f} % only"
    # layers
    MOVES_A_LAYER = "it moves no layer"
    NUMBER_INSIDE_BOUNDS = "its number leaves the bounds"
    NOT_ZERO = "the interval of its number holds zero effect"
    PRICE_OF_LAYERS = "its gain in chi2 of {gain:.1f} does not pay its price of {price:.1f}"
    RESOLUTION = "below resolution: it moves no layer by more than {size:.1f} times what these data show"
    EVERY_GROUP = "held-out misfit does not fall by 2 % on {groups}"
    HELD_OUT_LAYERS = "the held-out error does not fall by 2 %"
    STANDS = "no placement stands with it"
    IN_FULL = "simulated in full, chi2 falls by {gain:.1f} only"


def sentences(broken):
    """The sentences on rules that are broken (Explanations) as one."""
    return "; ".join(explanation.why for explanation in broken)
