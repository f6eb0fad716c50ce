"""The next experiment on layers: which grid, repeated how often, or which direct reading, tells the surviving suspects apart."""

import numpy as np

from hlcs.effects.witnesses import OF_LAYERS
from hlcs.kinds.layers import least_squares
from hlcs.records import NextExperiment
from hlcs.selection.experiment_design import SEPARATION, hardest, tests_needed


def next_experiment(search, fit, rivals, where, verdict):
    """The NextExperiment for rivals that survive, or for what stays unexplained.

    rivals: [(LayerTrial, cosine)] of each accepted effect; where: what the model misses, the worst first.
    """
    pairs = [(accepted, rival) for accepted, others in zip(fit.accepted, rivals, strict=True) for rival, _ in others]
    text, names, needed, design = "", (), None, {}
    if pairs:
        score, names, index = hardest([_best_set(search, *pair) for pair in pairs])
        needed, measured_set = tests_needed(score), search.sets[index]
        design = {"grid": measured_set.grid.name, "bottom_slope": measured_set.bottom_slope}
        tests = f"{needed} more tests on {measured_set.name}"
        readings = "; or ".join(dict.fromkeys(OF_LAYERS.get(name, "measure " + name) for name in names))
        text = (
            f"{readings}; by layers alone {tests if needed else 'more than a thousand tests on any grid measured here'} to tell "
            f"{names[0]} from {names[1]} (lambda = {score:.3g} a test)"
        )
    if verdict == "unexplained":
        worst, campaigns = where[0], {measured_set.name: measured_set.campaign for measured_set in search.sets}
        others = [campaign for campaign in campaigns.values() if campaign != campaigns[worst["trial"]]]
        elsewhere = f"by the hands and in the flume of '{others[0]}'" if others else "by other hands, in another campaign"
        needed = needed or _tests_for(worst)
        text = (
            f"repeat {worst['trial']} (layer {worst['layer']} misses most) {elsewhere}, {needed} tests or more: "
            f"that separates the campaign from the physics" + (f"; then: {text}" if text else "")
        )
        names = names or ("campaign_offset",)
    return NextExperiment(text, names, needed, design)


def _best_set(search, accepted, rival):
    """(lambda of one test, names, index of the set) of the measured grid on which two explanations differ most."""
    data, scores = search.data, []
    for index in range(len(search.sets)):
        rows = (data.set == index) & search.layers
        variance = (data.variance * data.tests)[rows]  # of a single test
        matrix = np.diag(variance) + least_squares.CAMPAIGN**2 * np.outer(data.mean[rows], data.mean[rows])
        scores.append(least_squares.chi_squared(matrix, (accepted.shift - rival.shift)[rows]))
    return max(scores), (accepted.name, rival.name), int(np.argmax(scores))


def _tests_for(worst):
    """Tests of a layer that would show its present misfit again with the usual odds."""
    return int(np.clip(np.ceil(SEPARATION / max(worst["z"] ** 2 / 5.0, 1e-3)), 3, 50))
