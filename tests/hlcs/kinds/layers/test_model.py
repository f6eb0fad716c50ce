"""The model under test for layers, and its simulations."""

from dataclasses import replace

import numpy as np
import pytest
from layer_tables import experiment, measured

import hlcs
from hlcs.data.experiment_file import read_experiment_file
from hlcs.kinds.layers import Layers
from hlcs.kinds.layers.data import read_layers
from hlcs.kinds.layers.model import LayerModel, coefficients, model_of
from hlcs.kinds.protocol import Options


def test_a_model_of_layers_runs_its_own_placement():
    model = LayerModel(hlcs.PlacementTest(layers=1, rows=2, columns=2))
    assert model.run(seed=4).test == replace(model.placement, seed=4)


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ('{ name = "plate_bias", offse = 1.0 }', "plate_bias needs one number, offset"),
        ('{ name = "time_step", factor = 0.25 }', "time_step needs no number"),
        ('{ name = "plate_bias", offset = true }', "offset = .*it must be a finite number"),
        ('{ name = "plate_bia" }', "'plate_bias'"),
    ],
)
def test_stated_effects_that_cannot_be_are_refused_by_file_and_line(tmp_path, entry, words):
    file = experiment(tmp_path, [measured("TPG", 1, "a")])
    file.path.write_text(file.path.read_text() + f"[model]\neffects = [{entry}]\n")
    with pytest.raises(hlcs.InputError, match=f"layers.toml, line .*{words}"):
        model_of(read_layers(read_experiment_file(file.path)))


def test_a_switch_is_there_by_its_name_or_with_its_constant(tmp_path):
    for entry in ('{ name = "loose_lower_layers" }', '{ name = "loose_lower_layers", switch = 1 }'):
        file = experiment(tmp_path, [measured("TPG", 1, "a")])
        file.path.write_text(file.path.read_text() + f"[model]\neffects = [{entry}]\n")
        assert model_of(read_layers(read_experiment_file(file.path))).placement.loose_lower_layers


def test_a_stated_number_beyond_what_is_plausible_is_told_by_file_and_line(tmp_path, simulator):
    file = experiment(tmp_path, [measured("TPG", 1, "a")])
    file.path.write_text(file.path.read_text() + '[model]\neffects = [{ name = "plate_bias", offset = 0.3 }]\n')
    (note,) = (note for note in Layers(read_experiment_file(file.path), Options(), simulator).notes if "plausible" in note)
    assert "layers.toml, line" in note and "plate_bias: offset = 0.3 lies above what is plausible (-0.05 to 0.05 Dn)" in note


def test_runs_come_back_by_model_set_and_seed_and_refused_ones_as_nan(tmp_path, simulator):
    sets = read_layers(experiment(tmp_path, [measured("TPG", 1, "a"), measured("RPG", 2, "b")])).sets
    models = [LayerModel(hlcs.PlacementTest(margin=margin)) for margin in (0.0, 0.01)]
    tables = coefficients(simulator, models, sets, [1, 2, 3])
    assert [[runs.shape for runs in of_model] for of_model in tables] == [[(3, 5), (3, 5)], [(3, 5), (3, 5)]]
    np.testing.assert_allclose(tables[1][0][:, 0] - tables[0][0][:, 0], 0.02, rtol=1e-9)
    assert simulator.ran == 12
    coefficients(simulator, models, sets, [1, 2, 3])
    assert simulator.ran == 12  # read back from the store
    none = coefficients(lambda tests, label: [None] * len(tests), models[:1], sets[:1], [1, 2])
    assert np.isnan(none[0][0]).all() and none[0][0].shape == (2, 5)
