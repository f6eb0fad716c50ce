"""Tables of layers that `hlcs mystery make` writes: pybullet's heap, and exactly what was hidden in it."""

import csv
import io

import numpy as np
import pytest

import hlcs
from hlcs import mystery
from hlcs.mystery import layers
from hlcs.mystery.making import made
from hlcs.mystery.seal import SEALED, opened

SEEDS = range(40)


def means_and_errors(text):
    """Means of a table and their standard errors from its own columns, both (WEEKS, LAYERS)."""
    rows = [[float(row[name]) for name in ("mean", "cv", "tests")] for row in csv.DictReader(io.StringIO(text))]
    mean, cv, tests = np.reshape(rows, (layers.WEEKS, layers.LAYERS, 3)).transpose(2, 0, 1)
    return mean, mean * cv / np.sqrt(tests)


def test_a_plate_raises_the_first_layer_by_its_thickness_and_no_other():
    """The same hands and weeks with the plate and without: the difference is the plate times the factor of the week, 1 +- 3 %;
    rounding to 1e-4 of both adds 1e-4."""
    offer = layers.OFFERS["plate_bias"]
    without, with_plate = (
        means_and_errors(layers.table(offer, amplitude, 8, np.random.default_rng(5)))[0] for amplitude in (0.0, 0.04)
    )
    np.testing.assert_allclose(with_plate[:, 0] - without[:, 0], 0.04, atol=0.03 * 0.04 + 1e-4)
    np.testing.assert_allclose(with_plate[:, 1:], without[:, 1:], atol=1e-12)


@pytest.mark.parametrize("effect", layers.OFFERS)
def test_strength_is_the_change_of_the_means_over_their_standard_errors(effect):
    """Read from forty tables with it and forty without: no more than their own columns. The mean of the change is known to
    sqrt(2 (0.01^2 + 0.01^2 / 2)) / sqrt(160) = 0.14 %, 0.4 of the standard errors of 5 to 12 tests; so 0.4 is allowed."""
    wanted = 0.8 * layers.strength(layers.OFFERS[effect], layers.OFFERS[effect].high, layers.MOST)
    found = [[means_and_errors(made(effect, strength, seed)["layers.csv"]) for seed in SEEDS] for strength in (wanted, 0)]
    (with_it, errors), (without, _) = (np.mean(part, axis=(0, 2)) for part in found)
    assert np.sqrt(np.mean(((with_it - without) / errors) ** 2)) == pytest.approx(wanted, abs=0.8)


def test_what_is_written_is_an_experiment_that_tells_nothing_but_in_its_seal(tmp_path):
    file = mystery.make("plate_bias", 5, 1, tmp_path / "case")
    assert 'kind = "layers"' in file.read_text("utf-8") and hlcs.Experiment.read(file)
    files = made("plate_bias", 5, 1)
    assert files == made("plate_bias", 5, 1) and files["layers.csv"] != made("plate_bias", 5, 2)["layers.csv"]
    answer = opened(files[SEALED].encode())
    assert answer["effects"] == ["plate_bias"] and answer["tied"] == ["orientation_bias"]
    assert not any(name in text for name in layers.OFFERS for file, text in files.items() if file != SEALED)
    nothing = opened(made("plate_bias", 0, 1)[SEALED].encode())
    assert nothing["effects"] == nothing["tied"] == [] and "Nothing." in nothing["text"]


def test_a_strength_that_no_number_of_tests_shows_is_refused_with_those_that_can_be_had():
    with pytest.raises(hlcs.InputError, match=r"strength = 100: plate_bias .* means of 4 to 12 tests by 1.1 to 9.6 of their"):
        made("plate_bias", 100, 1)


@pytest.mark.slow
@pytest.mark.parametrize("effect", layers.OFFERS)
def test_what_is_hidden_is_found(effect, tmp_path):
    """It stands in the verdict, with its number within twice the 90 % interval, 3.3 sigma, and what looks the same beside it."""
    diagnosis = hlcs.diagnose(mystery.make(effect, 8, 1, tmp_path / "case"), workers=1)
    answer = mystery.answer(tmp_path / "case")
    assert effect in {*diagnosis.effects, *(name for names in diagnosis.ambiguous for name in names)}
    assert diagnosis.verdict == "ambiguous" and answer["tied"]
    for name, true in answer["parameters"][effect].items():
        number = diagnosis.parameters[effect][name]
        assert abs(number["value"] - true) < 2 * (number["high"] - number["low"]) / 2
