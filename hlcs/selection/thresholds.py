"""Every threshold of search and verdict, with its reason; prices are in units of -2 log of a probability, as chi2 is.

An effect is accepted where the evidence for it outweighs the odds against it; nothing else decides what is in the model. What the
effects know of their own numbers stands in their classes.
"""

ODDS = 6.0  # against any one effect: 1 to 20, so that of some forty candidates two are expected to be missing
ODDS_ALONE = 12.0  # the same where nothing can be held out
TIED = 6.0  # sets within it of the best do as well: it has less than twenty times their probability
EQUAL = 1.0  # costs that differ by no more are as good (odds of 1 to 1.6): two fits of a set, or two sets, fewer numbers first
REACH = 12.0  # sets foreseen within it of the best are fitted: twice TIED, since what is foreseen is not what is found
MOST_EFFECTS = 3  # in a set, beside what the file implies: with more, recordings of one body tell nothing apart
FORESEEN = 0.2  # part of what a set takes away that is foreseen at least before any fit: a rebound, seen from a model of none
LOOKED = 4.0  # times what one simulation differs from what was foreseen: fits of drags far from the data differ by up to 3.4
REFITS = 30  # of sets in one go of a search (`Search.run`), so that it ends
EXPANDED = 4  # sets whose neighbours are foreseen, while the best one leaves more than noise
TOGETHER = 6  # sets fitted in one batch where simulations with contacts are shared
NOISE = 3.0  # standard deviations of chi2 within which a fit leaves nothing but noise
ALIKE = 0.98  # part of the square of what an effect does that another does too (cosine 0.99): fitted, whatever is foreseen
FALL = 0.02  # of the held-out error, relative: in each direction where recordings are few
FALL_IN_SIGMA = 0.1  # or this, where they are many
BY_CHANCE = 0.05  # p of a gain on held-out recordings, after the number of candidates
BEATEN = 0.01  # p at which held-out recordings tell two sets apart
HELPS = 0.5  # share of the excess misfit left without it that an effect takes, to be named where all sets fail: else it absorbs
INTERVAL = 0.90  # of numbers
