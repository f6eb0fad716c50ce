"""Tables of outcomes: one number for each experiment."""

from hlcs.kinds.outcomes.experiment import Outcomes
