"""What these data cannot tell apart, and the experiment that would."""

from dataclasses import dataclass, field

import numpy as np

SEPARATION = 16.4  # N lambda at which the right one of two wins by more than 6 units with probability 0.9


@dataclass(frozen=True)
class NextExperiment:
    """An experiment to do next."""

    text: str
    separates: tuple[str, ...]
    tests_needed: int | None
    design: dict = field(default_factory=dict)

    def __str__(self):
        return self.text


def next_experiment(prepared, search, final, rivals, verdict):
    """The experiment that best separates the surviving rivals."""
    pairs = [(term.name, name) for term, others in zip(final.model.terms, rivals, strict=True) for name, _, _ in others]
    if not pairs:
        return NextExperiment("repeat the worst trial with raw frames, and film a ruler and a clock in the same view", (), None)
    return NextExperiment("not yet designed", pairs[0], None)


def tests_needed(separation):
    """N = ceil(16.4 / lambda), None where one test separates nothing."""
    return int(np.ceil(SEPARATION / separation)) if separation > 1e-9 else None
