"""The restitution and the friction that a model has at the impacts of a measurement: what these show stands beside it."""

import numpy as np

from hlcs.effects.contract import Setup
from hlcs.simulation.outcome_motion import law_at, state_of

NUMBERS = ("restitution", "friction")


def numbers_at(impacts, model, trials):
    """{"restitution", "friction"}: what the laws of contact of a Model make of those stated, the mean over the impacts, each with
    its own speeds; {} without impacts.

    As of a body that is upright and does not turn, under its own weight, and slips along some line of its floor."""
    found = {name: [] for name in NUMBERS}
    for trial in trials:
        speeds = np.array([(impact.speed, impact.slip or 0.0) for impact in impacts if impact.trial == trial.name])
        if len(speeds):
            effects, changes, _ = model.changes(trial.surroundings)
            setup = Setup(trial.body, trial.surroundings)
            for change in changes:
                setup = change.setup(setup)
            normal = setup.surroundings.normal
            along = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
            velocity = speeds[:, 1:] * along / np.linalg.norm(along) - speeds[:, :1] * normal
            setups = [setup] * len(speeds)
            law = law_at(setups, effects, state_of(setups, velocity), velocity, np.tile(normal, (len(speeds), 1)))
            for name in NUMBERS:
                found[name].extend(getattr(law, name))
    return {name: float(np.mean(values)) for name, values in found.items() if values}
