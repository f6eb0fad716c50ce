"""The rules that a candidate may break, and how each is said."""

from hlcs.records import Sentence


class Rule(Sentence):
    """What speaks against a candidate."""

    BOTH_DIRECTIONS = (
        "held-out error changes by {changes} in the two directions; a fall above 2 % in each is needed, or one that chance does "
        "not give"
    )
    NO_CHANCE = "no better on recordings it was not fitted to (p = {p:.2g} after the number of candidates)"
    HELD_OUT_ERROR = "held-out error falls by {percent:.1f} % only"
