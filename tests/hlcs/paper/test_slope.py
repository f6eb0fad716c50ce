"""The slope's variants: each beside the first, with intervals; the hypothesis of units on a tip on layer 1."""

import numpy as np
import pytest

from hlcs.paper import slope
from hlcs.paper.reproduce import Plan
from hlcs.paper.reproduce_text import text_of


def test_a_shift_has_welch_s_interval():
    """(1, 2, 3) and (4, 6, 8): difference 4, standard error sqrt(1/3 + 4/3), 2.94 degrees of freedom (Welch-Satterthwaite), of
    which Student's 97.5 % quantile is 3.2193."""
    found = slope._shift(np.array([1.0, 2.0, 3.0, np.nan]), np.array([4.0, 6.0, 8.0]))
    assert found["mean"] == pytest.approx(4.0)
    assert found["high"] - 4.0 == pytest.approx(3.2193 * np.sqrt(5 / 3), rel=2e-3)
    assert 4.0 - found["low"] == pytest.approx(found["high"] - 4.0)


def test_every_variant_stands_beside_the_first_and_none_is_chosen(monkeypatch):
    """On a tip a unit of the first layer stands 0.106 Dn higher than on its edge: all on tips, layer 1 is that much thicker, to
    what plates on few tips lean (0.03 Dn)."""
    monkeypatch.setattr(slope, "VARIANTS", {"plain": {}, "on tips": {"tip_share": 1.0}})
    monkeypatch.setattr(slope, "SHARES", (0.0, 1.0))
    monkeypatch.setattr(slope, "LAYER_1_TESTS", 1)
    document = slope.slope(Plan({"rows": 3, "columns": 3, "layers": 1, "time_step": 1 / 120}, repeats=2, workers=1))
    plain, tips = document["variants"]
    assert plain["layers"][0]["shift"] == {"mean": 0.0, "low": 0.0, "high": 0.0}
    assert tips["layers"][0]["shift"]["mean"] == pytest.approx(1.40428 - 1.29826, abs=0.03)
    assert [(row["share"], row["bottom_slope"]) for row in document["layer_1"]] == [
        (0.0, 0.0),
        (0.0, 0.04),
        (1.0, 0.0),
        (1.0, 0.04),
    ]
    assert document["layer_1"][1]["measured"]["mean"] == 1.316  # Table 3
    text = text_of(document)
    assert "No setting is chosen by this table" in text and "on tips" in text and "refused" in text
