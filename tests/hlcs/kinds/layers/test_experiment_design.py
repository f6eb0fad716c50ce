"""The next experiment on layers."""

from hlcs.kinds.layers import experiment_design


def test_tests_to_show_a_misfit_again_go_with_its_inverse_square():
    """z of five tests grows with the root of their number: 16.4 / (z^2 / 5) tests, at least 3 and at most 50."""
    assert [experiment_design._tests_for({"z": z}) for z in (0.0, 2.0, 4.0, 40.0)] == [50, 21, 6, 3]
