"""Competing models: which are beaten on held-out data, and what is a term's own."""

from types import SimpleNamespace

import numpy as np
import pytest
from linear_models import Line, model

from hlcs.selection.competing_models import beaten, own_columns


@pytest.mark.parametrize(("distance", "refused"), [(4.6, False), (4.7, True)])
def test_a_model_is_beaten_from_the_quantile_of_its_difference_on(distance, refused):
    """Residuals b of one model and b + d of the other, d across b: (|b + d|^2 - |b|^2) / (2 |d|) = |d| / 2; p = 0.01 is 2.326."""
    b, d = np.array([3.0, 0.0, 0.0]), np.array([0.0, distance, 0.0])
    residuals = {"best": [b], "other": [b + d]}
    halves = SimpleNamespace(possible=True, residuals=lambda fit: residuals[fit.name])
    best, other = SimpleNamespace(name="best", chi2=9.0), SimpleNamespace(name="other", chi2=9.0 + distance**2)
    assert beaten(SimpleNamespace(cross_validation=halves), best, other, 1.0) is refused
    assert not beaten(SimpleNamespace(cross_validation=halves), best, other, 1.5)  # what is unexplained decides nothing
    halves.possible = False
    assert not beaten(SimpleNamespace(cross_validation=halves), best, other, 1.0)


def test_the_own_columns_of_a_term_are_its_signature_without_states_and_other_terms():
    """Of the one term of a line: the centred times over sigma."""
    times = [np.linspace(0.0, 2.0, 9)]
    fit = Line(times, [2.0 * times[0]], 0.5).fit(model(1.0))
    np.testing.assert_allclose(own_columns(fit, 0)[:, 0], (times[0] - 1.0) / 0.5, atol=1e-9)
