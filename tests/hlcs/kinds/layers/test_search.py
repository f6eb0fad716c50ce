"""The search over candidates of layers: signatures, rounds, rivals."""

import numpy as np
from layer_tables import experiment, measured

from hlcs.kinds.layers.candidates import named
from hlcs.kinds.layers.data import read_layers
from hlcs.kinds.layers.model import LayerModel
from hlcs.kinds.layers.search import LayerSearch


def search_of(tmp_path, simulator, tables, placement=""):
    measurement = read_layers(experiment(tmp_path, tables, placement))
    return LayerSearch(measurement, measurement.sets, simulator), LayerModel(measurement.test)


def chosen(search, *names):
    return [named(name, search.measurement.test, search.sets)[0] for name in names]


def test_as_many_effects_as_grids_and_campaigns_can_tell(tmp_path, simulator):
    assert search_of(tmp_path, simulator, [measured("TPG", 1, "a")])[0].most_effects == 1
    assert search_of(tmp_path, simulator, [measured("TPG", 1, "a"), measured("TPG", 2, "b")])[0].most_effects == 2


def test_a_signature_comes_from_pairs_of_tests_or_from_arithmetic(tmp_path, simulator):
    search, model = search_of(tmp_path, simulator, [measured("TPG", 1, "a"), measured("RPG", 2, "b")])
    fit = search.fit(model)
    assert simulator.ran == 2 * len(search.seeds)
    search.sign(fit, chosen(search, "margin_offset", "plate_bias"), pairs=3)
    assert simulator.ran == 2 * len(search.seeds) + 2 * 3  # only the margin needs simulations
    slope, variance = search.signatures["plate_bias", ""]
    np.testing.assert_allclose(slope[search.layers], search.data.layer[search.layers] == 1)
    assert not variance.any()
    slope, _ = search.signatures["margin_offset", ""]
    np.testing.assert_allclose(slope[search.data.layer == 1], 2.0, rtol=1e-9)  # the stand-in has two margins a layer


def test_equal_signatures_are_rivals_and_a_number_out_of_bounds_is_none(tmp_path, simulator):
    tables = [measured(grid, 7, campaign, shift=-0.07) for grid, campaign in (("TPG", "a"), ("RPG", "b"))]
    search, model = search_of(tmp_path, simulator, tables)
    fits, (trials, *_) = search.run(search.fit(model), chosen(search, "plate_bias", "settlement", "ground_softness"))
    (winner,) = fits[-1].accepted[:1]
    rivals = {rival.name: cosine for rival, cosine in search.rivals(fits[0], winner, trials)}
    assert {winner.name, *rivals} == {"plate_bias", "settlement"}
    assert all(abs(cosine - 1.0) < 1e-9 for cosine in rivals.values())
