"""Compare says where a model misses and by how many sigma, and says nothing where there is only noise."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from throws import drag_per_metre, write_drops, write_throws

import hlcs
import minibullet as mb


def test_a_right_model_leaves_noise(tmp_path):
    comparison = hlcs.compare(write_throws(tmp_path, rho=0.6))
    assert comparison.adequate
    assert 0.8 < max(row["sigma"] for row in comparison.where) < 2.0
    assert abs(comparison.noise["position"] / 0.004 - 1) < 0.15  # sigma of 1800 correlated samples is known to 5 %


def test_a_missing_drag_shows_where_it_is_fastest(tmp_path):
    comparison = hlcs.compare(write_throws(tmp_path, drag_per_metre=drag_per_metre(0.5)))
    assert not comparison.adequate
    worst = comparison.where[0]
    assert worst["trial"] == "throw_7.csv" and worst["sigma"] > 3 and worst["phase"] == "flight"
    frame = comparison.to_dataframe()
    assert {"trial", "channel", "time", "height", "speed", "sigmas"} <= set(frame.columns)
    assert "throw_7.csv" in str(comparison)


def test_two_models_are_compared_on_the_same_readings():
    """Beside a wrong model good readings stand alone, and bad ones do not: what the better one sets aside counts for both."""
    experiment = hlcs.mystery.experiment("tower-drop")
    alone, both = hlcs.compare(experiment), hlcs.compare(experiment, effects=[mb.QuadraticDrag(0.46)])

    def readings(comparison):
        return set(zip(*(comparison.table[name] for name in ("trial", "channel", "time")), strict=True))

    assert readings(both.before) == readings(both) != readings(alone)
    assert both.before.notes == both.notes


def test_without_known_noise_nothing_is_judged(tmp_path):
    comparison = hlcs.compare(write_throws(tmp_path, static=False))
    assert comparison.adequate is None and "unknown" in str(comparison)


def test_files_of_a_comparison(tmp_path):
    comparison = hlcs.compare(write_throws(tmp_path, count=4))
    folder = comparison.save(tmp_path / "out")
    names = {path.name for path in folder.iterdir()}
    assert names == {"comparison.json", "residuals.csv", "comparison.txt", "comparison.png", ".hlcs"}  # the last lists the others
    assert len(comparison.plot()) == 4


def test_outcome_table_against_the_law_of_fall(tmp_path):
    """Fall times sqrt(2 h / g) with 2 ms noise are what the bare model says."""
    generator = np.random.default_rng(3)
    heights = np.repeat(np.linspace(1, 9, 8), 4)
    times = np.sqrt(2 * heights / 9.81) + 0.002 * generator.standard_normal(32)
    rows = "".join(f"{h},{t:.6f}\n" for h, t in zip(heights, times, strict=True))
    (tmp_path / "o.csv").write_text("height_m,fall_time_s\n" + rows)
    path = tmp_path / "e.toml"
    path.write_text('kind = "outcomes"\n[body]\nshape = "sphere"\nradius = 0.05\nmass = 0.5\n[measurement]\nfile = "o.csv"\n')
    comparison = hlcs.compare(path)
    assert comparison.adequate and abs(comparison.noise["position"] / 0.002 - 1) < 0.4  # 24 degrees of freedom: 15 % each sigma
    frame = comparison.to_dataframe()  # its own columns, under their own names
    assert list(frame["height_m"]) == sorted(heights) and set(frame["channel"]) == {"fall_time_s"} and "speed" not in frame
    labels = [axes.get_xlabel() for axes in comparison.plot() if axes.axison]
    assert labels == ["model [s]", "height [m]"]  # no panel for inputs that the table has not


def reorder(path, *, marker="", step=7):
    """Put the lines of a file but the first, or its parts that begin with `marker`, in another order."""
    text = path.read_text()
    head, *parts = text.split(marker) if marker else text.splitlines(keepends=True)
    shuffled = [parts[(step * k + 3) % len(parts)].rstrip("\n") + "\n" for k in range(len(parts))]
    assert len(set(shuffled)) == len(parts)
    path.write_text(marker.join([head, *shuffled]))


@pytest.mark.parametrize("write", [lambda folder: write_throws(folder, rho=0.6), lambda folder: write_drops(folder, 0.001)])
def test_the_order_of_trials_changes_no_digit(tmp_path, write):
    path = write(tmp_path)
    first = hlcs.compare(path).to_json()
    reorder(path, marker="[[trial]]\n", step=5)
    assert hlcs.compare(path).to_json() == first


@pytest.mark.parametrize("grouped", [False, True])
def test_the_order_of_rows_changes_no_digit(tmp_path, grouped):
    """Fall times with drag of 0.05 /m: neither their comparison nor their diagnosis knows in which order they were written."""
    generator = np.random.default_rng(3)
    heights = np.repeat(np.linspace(1, 9, 10), 3)
    times = np.arccosh(np.exp(0.05 * heights)) / np.sqrt(9.81 * 0.05) + 0.004 * generator.standard_normal(30)
    days = [f",day {k % 2}" if grouped else "" for k in range(30)]
    rows = "".join(f"{h},{t:.6f}{day}\n" for h, t, day in zip(heights, times, days, strict=True))
    (tmp_path / "o.csv").write_text(f"height_m,fall_time_s{',group' if grouped else ''}\n" + rows)
    path = tmp_path / "e.toml"
    path.write_text(
        'kind = "outcomes"\n[body]\nshape = "sphere"\nradius = 0.05\nmass = 0.5\n[surroundings]\nfluid_density = 1.2\n'
        'fluid_viscosity = 1.8e-5\n[measurement]\nfile = "o.csv"\n'
    )
    first = hlcs.compare(path).to_json(), hlcs.diagnose(path).to_json()
    reorder(tmp_path / "o.csv")
    assert (hlcs.compare(path).to_json(), hlcs.diagnose(path).to_json()) == first


def test_the_noise_beside_before_and_after_is_that_of_the_model_before(tmp_path, monkeypatch):
    """Of layers the noise holds the scatter of a model's runs, 0.70 % of the mended model and 0.69 % before: one is told."""
    module, noises = sys.modules["hlcs.compare"], iter([0.0070, 0.0069])
    real = module.comparison_of

    def with_noise(*given):
        comparison, aside = real(*given)
        return replace(comparison, error=comparison.error | {"noise": next(noises)}), aside

    monkeypatch.setattr(module, "comparison_of", with_noise)
    seen = hlcs.compare(write_throws(tmp_path), effects=[{"name": "quadratic_drag", "drag_coefficient": 0.1}])
    assert seen.error["noise"] == seen.before.error["noise"] == 0.0069


def test_errors_of_inputs_are_carried_by_the_model_after_for_both(tmp_path):
    """Heights off by 1 cm are a tenth of that in rebounds of a restitution of 0.3, and 0.64 cm of one of 0.8, which is right."""
    heights = np.repeat(np.linspace(0.3, 2.0, 8), 5)
    rebounds = 0.8**2 * heights + 0.001 * np.random.default_rng(5).standard_normal(len(heights))
    rows = [f"{height},{rebound}" for height, rebound in zip(heights, rebounds, strict=True)]
    (tmp_path / "t.csv").write_text("\n".join(["height_m,rebound_height_m", *rows]))
    path = tmp_path / "e.toml"
    path.write_text(
        'kind = "outcomes"\n[body]\nshape = "sphere"\nradius = 0.03\nmass = 0.05\n[surroundings]\nfluid_density = 0.0\n'
        'restitution = 0.3\n[measurement]\nfile = "t.csv"\ninput_sd = { height_m = 0.01 }\n'
    )
    seen = hlcs.compare(path, effects=[{"name": "restitution", "coefficient": 0.8}])
    assert seen.error["noise"] == seen.before.error["noise"] == pytest.approx(0.64 * 0.01, rel=0.05)


def test_where_readings_are_rounded_the_label_says_what_of_the_noise_that_is(tmp_path):
    """Heights in steps of 4 mm beside 1 mm that is stated: 4/sqrt(12) = 1.15 mm, 1.53 mm together."""
    times = np.arange(40) / 60
    heights = 4e-3 * np.round((2 - 9.81 * times**2 / 2 + 1e-3 * np.random.default_rng(1).standard_normal(40)) / 4e-3)
    body, rest = {"shape": "sphere", "radius": 0.03, "mass": 0.1}, {"fluid_density": 0.0}
    frame = {"t_s": times, "z_m": heights}
    seen = hlcs.compare(hlcs.Experiment.from_frames([frame], body, rest, noise={"position": 0.001}))
    assert "Noise: stated, and readings in steps of 4 mm (1.15 mm of it)" in " ".join(str(seen).split())
    assert seen.error["noise"] == pytest.approx(1.53e-3, rel=0.01) and seen.noise["rounding"] == pytest.approx(4e-3)
