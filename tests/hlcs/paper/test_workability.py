"""Set-back of the layers, and the map of lost and misplaced units: what is counted, over what it is averaged."""

import numpy as np
import pytest

from hlcs.paper import reproduce, workability
from hlcs.paper.reproduce import Plan
from hlcs.paper.reproduce_text import text_of
from hlcs.placement import figures
from hlcs.placement.grids import TPG

SMALL = {"rows": 4, "columns": 4, "layers": 2, "time_step": 1 / 120}


def case(lost, misplaced, drift):
    """A case of three structures: numbers of each."""
    return {"lost_by_test": lost, "misplaced_by_test": misplaced, "drift_by_test": [[0.0, last] for last in drift]}


def test_cases_are_compared_structure_by_structure():
    """Counts that differ by 1, 2, 3 in pairs: mean 2, half the interval 4.303 / sqrt(3) (Student, 2 degrees of freedom), however
    much the structures differ among themselves; a constant difference has no width."""
    first = case([0, 50, 10], [5, 5, 5], [0.1, 0.2, 0.3])
    second = case([1, 52, 13], [7, 7, 7], [0.2, 0.3, 0.4])
    found = reproduce.differences(first, second)
    assert found["lost"]["mean"] == pytest.approx(2.0)
    assert found["lost"]["high"] - 2.0 == pytest.approx(4.3027 / np.sqrt(3), rel=1e-4)
    assert (found["misplaced"]["low"], found["misplaced"]["high"]) == (2.0, 2.0)
    assert found["last_drift"]["mean"] == pytest.approx(0.1)


def test_a_wider_grid_keeps_its_kind():
    grid = workability.widened(TPG, 1.1)
    assert (grid.spacing_x, grid.spacing_y, grid.triangular) == (pytest.approx(1.738), pytest.approx(1.397), True)
    assert workability.widened(TPG, 1.0) is TPG


def test_set_back_layers_have_fewer_units_and_are_paired_with_the_whole_ones(monkeypatch):
    monkeypatch.setattr(workability, "SET_BACKS", (0.0, 1.0))
    monkeypatch.setattr(workability, "Slope", lambda grade: workability.Flat())
    document = workability.set_back(Plan(SMALL, repeats=2, workers=1))
    whole, back = document["cases"][:2]
    assert (whole["units"], whole["set_back"], back["set_back"]) == (16 + 9, 0.0, 1.0)
    assert back["units"] == 16 + 2  # of the second layer, 4 x 4 less a spacing all round
    assert whole["change"]["lost"]["mean"] == 0.0
    assert len(back["lost_by_test"]) == 2 and "set-back" in text_of(document)


def test_the_map_tells_counts_with_their_intervals(monkeypatch):
    monkeypatch.setattr(workability, "WIDER", (1.0, 1.1))
    monkeypatch.setattr(workability, "SCATTERS", (0.2,))
    document = workability.workability(Plan(SMALL | {"rows": 3, "columns": 3}, repeats=2, workers=1))
    assert [row["spacing_x"] for row in document["cases"]] == [1.58, pytest.approx(1.738)]
    for row in document["cases"]:
        assert row["misplaced"]["mean"] == pytest.approx(np.mean(row["misplaced_by_test"]))
    assert "1.580 x 1.270" in text_of(document)
    words = [text.get_text() for ax in figures.workability_axes(document["cases"]) for text in ax.texts]
    assert len(words) == 4 and all("%" in word for word in words)
