"""The next experiment on layers: which grid, repeated how often, or which direct reading, tells the surviving suspects apart."""

import numpy as np

from hlcs.effects.witnesses import OF_LAYERS
from hlcs.kinds.layers import least_squares
from hlcs.records import NextExperiment
from hlcs.selection.experiment_design import SEPARATION, tests_needed


def next_experiment(search, stage, rivals, where, verdict):
    """The NextExperiment for rivals that survive, or for what stays unexplained."""
    pairs = [(one, other) for one, others in zip(stage.accepted, rivals, strict=True) for other, _ in others]
    text, names, needed, design = "", (), None, {}
    if pairs:
        scored = [(*_best_set(search, stage, one, other), one, other) for one, other in pairs]
        score, index, one, other = min(scored, key=lambda row: (row[0], row[2].name, row[3].name))  # the hardest pair decides
        names, needed = (one.name, other.name), tests_needed(score)
        design = {"grid": search.sets[index].grid.name, "bottom_slope": search.sets[index].bottom_slope}
        many = (
            f"{needed} more tests on {search.sets[index].name}"
            if needed
            else "more than a hundred tests on any grid measured here"
        )
        readings = dict.fromkeys(OF_LAYERS.get(name, "measure " + name) for name in names)
        text = (
            f"{'; or '.join(readings)}; by layers alone {many} to tell {one.name} from {other.name} (lambda = {score:.3g} a test)"
        )
    if verdict == "unexplained":
        worst = where[0]
        campaign = next(one.campaign for one in search.sets if one.name == worst["trial"])
        others = [one.campaign for one in search.sets if one.campaign != campaign]
        elsewhere = f"by the hands and in the flume of '{others[0]}'" if others else "by other hands, in another campaign"
        needed = needed or _tests_for(worst)
        text = (
            f"repeat {worst['trial']} (layer {worst['layer']} misses most) {elsewhere}, {needed} tests or more: "
            f"that separates the campaign from the physics" + (f"; then: {text}" if text else "")
        )
        names = names or ("campaign_offset",)
    return NextExperiment(text, names, needed, design)


def _best_set(search, stage, one, other):
    """(lambda of one test, index of the set) of the measured grid on which two explanations differ most."""
    data, scores = search.data, []
    for index in range(len(search.sets)):
        rows = (data.set == index) & (data.layer > 0)
        variance = (data.variance * data.tests)[rows]  # of a single test
        matrix = np.diag(variance) + least_squares.CAMPAIGN**2 * np.outer(data.mean[rows], data.mean[rows])
        scores.append(least_squares.chi_squared(matrix, (one.shift - other.shift)[rows]))
    return max(scores), int(np.argmax(scores))


def _tests_for(worst):
    """Tests of a layer that would show its present misfit again with the usual odds."""
    return int(np.clip(np.ceil(SEPARATION / max(worst["z"] ** 2 / 5.0, 1e-3)), 3, 50))
