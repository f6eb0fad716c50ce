"""Our layers beside other engines and the laboratory: what z and the intervals are, and what is refused."""

import numpy as np
import pytest

from hlcs.files import folders
from hlcs.paper import blender
from hlcs.paper.reproduce import Plan
from minibullet.errors import InputError

K = np.array([1.322, 1.089, 0.998, 0.991, 0.986])  # Blender's seven pieces on the TPG, printed/reference.csv


class Simulator:
    """In place of simulations: layer coefficients by grid and seed; what it was asked for."""

    def __init__(self, coefficients):
        self.coefficients, self.asked = coefficients, []

    def __call__(self, tests):
        self.asked += tests
        return [self.coefficients(test) for test in tests]


def scattered(test):
    """K raised by 0.03 in layer 2, with a deviation of 0.02 there over the seeds 1 to 4 (+-0.01732 has that with n - 1)."""
    return K + np.array([0.0, 0.03 + 0.02 * np.sqrt(0.75) * (-1.0) ** test.seed, 0.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def document():
    return blender.blender(Plan({}, repeats=4), simulator=Simulator(scattered))


def test_z_is_the_difference_over_the_root_of_both_variances_of_the_means(document):
    """0.03 over sqrt(0.02^2 / 4 + 0.01^2) = 0.03 / 0.014142 = 2.121; layers that agree have 0."""
    row = document["beside_engines"][0]
    assert (row["grid"], row["tests"]) == ("TPG", 4)
    np.testing.assert_allclose(row["z"], [0.0, 2.1213, 0.0, 0.0, 0.0], atol=1e-4)
    assert row["bias"]["mean"] == pytest.approx(0.03 / 5)
    folders.to_json(document)  # strict JSON


def test_the_first_row_has_blender_s_settings_and_each_other_one_changes_a_step():
    """Section 4 of the notes on the reference runs: margin 0.008 on units and plates, 0.36, 60 steps a second, 10 iterations."""
    simulator = Simulator(scattered)
    blender.blender(Plan({}, repeats=2), simulator=simulator)
    first = simulator.asked[0]
    assert (first.margin, first.plate_margin, first.friction, first.iterations) == (0.008, 0.008, 0.36, 10)
    assert first.time_step == pytest.approx(1 / 60) and (first.rows, first.columns, first.plates) == (8, 8, 3)
    defaults = simulator.asked[-6:]
    assert all((test.margin, test.time_step) == (0.0, 1 / 240) for test in defaults)
    assert [test.seed for test in defaults] == [1, 2] * 3


def test_the_error_to_the_laboratory_has_an_interval_and_a_perfect_model_beside_it():
    """A model that is the laboratory's mean in every run has no error and no interval; what a perfect model shows does not hang
    on it: with means of five tests about 0.6 % on the TPG."""
    measured = np.array([1.294, 1.076, 0.980, 0.970, 0.984])
    row = blender._beside_laboratory("table2", "TPG", "flat", np.tile(measured, (20, 1)))
    assert all(value == pytest.approx(0.0, abs=1e-12) for key in ("error", "bias") for value in row[key].values())  # rounding
    assert 0.002 < row["perfect"]["mean"] < row["perfect"]["below_in_95_of_100"] < 0.02


def test_the_text_marks_a_layer_beyond_the_bound(document):
    assert "larger" not in blender.blender_text(document).partition("pieces\n")[2].partition("\n")[0]
    far = blender.blender(Plan({}, repeats=4), simulator=Simulator(lambda test: K + 0.1 + 0.001 * test.seed))
    assert blender.blender_text(far).count("  larger\n") == len(blender.CASES)


@pytest.mark.parametrize(
    ("plan", "words"),
    [
        (Plan({"friction": 0.5}), "leave out --friction"),
        (Plan({}, preset="paper"), "leave out --preset"),
        (Plan({"layers": 6}), "at most --layers 5"),
        (Plan({}, repeats=1), "take --repeats 2 or more"),
    ],
)
def test_what_would_not_be_that_comparison_is_refused(plan, words):
    with pytest.raises(InputError, match=words):
        blender.blender(plan, simulator=Simulator(scattered))
