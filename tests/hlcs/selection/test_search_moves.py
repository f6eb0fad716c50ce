"""Other moves of the search: another first effect, and what stands for one of two that were found together."""

from types import SimpleNamespace

import numpy as np
import pytest

import hlcs
from hlcs.selection.search_moves import cost

G, RADIUS, MASS = 9.81, 0.02, 0.0216


def test_the_cost_of_a_fit_is_chi2_and_the_complexity_of_its_terms():
    terms = [SimpleNamespace(candidate=2.0), SimpleNamespace(candidate=3.0)]
    fit = SimpleNamespace(chi2=10.0, model=SimpleNamespace(terms=terms))
    assert cost(SimpleNamespace(complexity_penalty=lambda candidate: candidate), fit) == 15.0


def test_two_forms_of_a_law_beside_the_same_second_effect_are_told_as_a_set(tmp_path):
    """Falls with drag and a trigger 20 ms late: alone a slow clock explains most; of two pairs found instead none is lost."""
    generator = np.random.default_rng(3)
    per_metre = 0.25 * 1.2 * np.pi * RADIUS**2 / MASS  # drag coefficient 0.5
    heights = np.repeat((0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0), 8)
    times = np.arccosh(np.exp(per_metre * heights)) / np.sqrt(G * per_metre) + 0.02 + 0.003 * generator.standard_normal(56)
    rows = "".join(f"{h:.6g},{t:.6g}\n" for h, t in zip(heights, times, strict=True))
    (tmp_path / "falls.csv").write_text("height_m,fall_time_s\n" + rows)
    path = tmp_path / "falls.toml"
    path.write_text(
        f'kind = "outcomes"\n[body]\nshape = "sphere"\nradius = {RADIUS}\nmass = {MASS}\n[surroundings]\n'
        'fluid_density = 1.2\n[measurement]\nfile = "falls.csv"\n'
    )
    diagnosis = hlcs.diagnose(path, candidates=["quadratic_drag", "clock_offset", "time_scale", "linear_drag"])
    assert set(diagnosis.effects) == {"quadratic_drag", "clock_offset"} and diagnosis.verdict == "ambiguous"
    assert diagnosis.ambiguous == (("quadratic_drag", "linear_drag"),)
    assert diagnosis.parameters["clock_offset"]["offset"]["value"] == pytest.approx(0.02, abs=0.002)  # 4 standard errors
