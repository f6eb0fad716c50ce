"""The tour's walk along the arrows of a step runs as printed, and the values are the ones it promises."""

import re
from pathlib import Path

import numpy as np
import pytest

TOUR = Path(__file__).resolve().parents[2] / "docs" / "tour.md"


def test_every_arrow_of_the_tour_can_be_printed():
    """The code block of docs/tour.md, run; the numbers in its comments by hand: m g, g dt, mu g dt."""
    block = re.search(r"```python\n(.+?)```", TOUR.read_text(encoding="utf-8"), re.DOTALL).group(1)
    scope = {}
    exec(block, scope)  # a page of this repository, not a user's file
    step, delassus = scope["step"], scope["mb"].contact.block_rows.delassus
    assert len(step.wrenches) == 1 and step.wrenches[0][1, 2] == pytest.approx(-19.62)
    assert len(step.contacts.gap) == 4 and set(step.law.friction) == {0.6}
    assert step.problem.free_twist[1, 2] == pytest.approx(-9.81 / 240)
    np.testing.assert_array_equal(step.problem.target, 0.0)
    assert delassus(step.problem)[0].shape == (12, 12)
    assert step.after.twist[1, 0] == pytest.approx(1.0 - 0.6 * 9.81 / 240, rel=1e-8)
    assert step.residual <= 1e-8 and set(step.work) >= {"gravity", "contact_normal", "contact_friction"}
