"""The hidden-effect suite: sealed cases made by another code path, and the score of the verdicts on them."""
