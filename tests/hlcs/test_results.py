"""Every result shows itself in a line with units, draws itself onto Axes, and is saved; a class with a renderer has all of it."""

from importlib import import_module

import numpy as np
import pytest
from throws import write_throws

import hlcs
from hlcs.learning.learned import Learned
from hlcs.placement.comparison import compare_layers
from hlcs.records import Plan
from hlcs.rendering import RENDERERS


def names_in(folder):
    """Names of the files that a reader sees in a folder."""
    return {file.name for file in folder.iterdir() if not file.name.startswith(".")}


HELD_OUT = {"before": 0.02, "after": 0.002}


@pytest.mark.parametrize("name", sorted(RENDERERS))
def test_a_renderer_shows_a_result_in_every_way(name):
    renderer = import_module(RENDERERS[name])
    assert all(callable(getattr(renderer, way)) for way in ("line", "text", "html", "plot", "save"))


def plan(needed):
    """A pilot of 4 recordings; as it is `needed` would do, with a camera twice as good 3."""
    row = {"length_s": 1.2, "unit": "m", "noncentrality": 2.0, "power": 0.4}
    options = (
        {"change": "as it is", "sigma": 0.002, "recordings": needed, **row},
        {"change": "half the noise", "sigma": 0.001, "recordings": 3, **row},
    )
    told = {"recordings": needed, "length_s": 1.2, "sigma": 0.002, "unit": "m"}
    pilot = {"recordings": 4, "power": 0.4}
    return Plan("magnus", {"lift": 0.5}, 0.9, "recordings", 8.0, pilot, told, options, ())


def test_a_plan_draws_what_each_change_needs(tmp_path):
    """Bars end at the numbers of the plan; more than a thousand is said, not drawn as a number."""
    ax = plan(12).plot()
    assert [bar.get_width() for bar in ax.patches] == [12, 3] and ax.get_xlabel() == "recordings needed"
    assert ax.get_lines()[0].get_xdata()[0] == 4
    assert "> 1000" in [text.get_text().strip() for text in plan(None).plot().texts]
    assert plan(12).plot(ax) is ax
    assert "magnus, lift = 0.5" in repr(plan(12)) and "Needed: 12 recordings of 1.2 s, with a noise of 0.002 m" in repr(plan(12))
    assert "<table" in plan(12)._repr_html_() and "Pilot: 4 recordings" in str(plan(12))
    assert names_in(plan(12).save(tmp_path / "plan")) == {"plan.json", "plan.txt", "plan.png", "options.csv"}


def entry(value, unit):
    return {"value": value, "low": 0.9 * value, "high": 1.1 * value, "unit": unit}


def test_a_learned_law_draws_its_force_over_its_variable(tmp_path):
    grid = np.linspace(0.0, 2.0, 5)
    band = {"grid": grid, "value": 3.0 * grid, "low": 2.5 * grid, "high": 3.5 * grid}
    law = Learned("height", "power", {"exponent": entry(1.0, "1")}, "A force that grows as height^1", "", HELD_OUT, band, ())
    ax = law.plot()
    assert ax.get_lines()[0].get_ydata() == pytest.approx(3.0 * grid)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("height [m]", "force / mass [m/s2]")
    assert repr(law) == "<Learned: A force that grows as height^1>" and "exponent" in str(law) and "exponent" in law._repr_html_()
    assert names_in(law.save(tmp_path / "law")) == {"learned.json", "learned.txt", "learned.png"}


def test_a_learned_oscillation_draws_its_swing():
    """Amplitude 0.004 m at 5 Hz: two periods are 0.4 s, and the swing reaches 4 mm, to the spacing of its points."""
    numbers = {"frequency_hz": entry(5.0, "Hz"), "amplitude_x": entry(0.004, "m")}
    (curve,) = Learned("time", "oscillation", numbers, "The camera shakes", "", HELD_OUT, {}, ()).plot().get_lines()
    assert curve.get_xdata()[-1] == pytest.approx(0.4) and curve.get_ydata().max() == pytest.approx(4.0, rel=1e-3)


def test_layer_tables_and_their_comparison_show_and_draw_their_layers(tmp_path):
    table = hlcs.laboratory("table2", grid="TPG")
    assert repr(table).startswith("<LayerTable: laboratory, TPG (Table 2") and "5 layers" in repr(table)
    drawn = table.plot().containers[0].lines[0].get_ydata()
    assert drawn == pytest.approx(table.mean) and str(table) == table.summary()
    assert names_in(table.save(tmp_path / "table")) == {"layers.csv", "table.txt", "layers.png"}
    assert "mean relative error +0.00 %" in repr(compare_layers(table, table))


def test_comparison_and_diagnosis_tell_verdict_error_and_noise_in_a_line(tmp_path):
    path = write_throws(tmp_path, count=4)
    comparison, diagnosis = hlcs.compare(path), hlcs.diagnose(path, candidates=["quadratic_drag"])
    for result in (comparison, diagnosis):
        assert "\n" not in repr(result) and len(repr(result)) < 250 and "throws (trajectory)" in repr(result)
        assert "noise" in repr(result) and ("mm" in repr(result) or " m" in repr(result))
    assert f": {diagnosis.verdict}" in repr(diagnosis)
    assert len(comparison.plot()) == len(diagnosis.plot()) == 4
