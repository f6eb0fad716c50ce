"""A noise stated too small is told from a missing effect: data made by closed forms, the truth of the noise known."""

import numpy as np
import pytest
import throws
from throws import G, drag_per_metre, write_throws

import hlcs

STATED = "noise = { position = 0.001 }\n"  # m


def shown(folder, **made):
    """What a comparison with a model of gravity alone says of the noise, one millimetre being stated."""
    return hlcs.compare(write_throws(folder, static=False, noise=STATED, **made)).noise_shown


@pytest.mark.parametrize("rho", [0.0, 0.6])
def test_a_noise_of_three_times_what_is_stated_is_found_and_told(tmp_path, rho):
    """1,440 samples know a standard deviation to 2 %, those correlated by 0.6 to 3 %; three times that."""
    found = shown(tmp_path, sigma=0.003, rho=rho)
    assert found["known"] == 0.001 and found["sigma"] == pytest.approx(0.003, rel=0.09)
    told = f"line 11: measurement.noise, position = {found['sigma']:.2g}"
    assert found["remedy"].endswith(told)


def test_an_effect_that_is_missing_is_no_noise(tmp_path):
    assert shown(tmp_path, sigma=0.001, drag_per_metre=drag_per_metre(0.47)) is None


@pytest.mark.parametrize("frequency", [9.0, 20.0])
def test_a_camera_that_shakes_is_no_noise(tmp_path, monkeypatch, frequency):
    """Samples at 60 Hz of 4.2 mm to either side: no slow curve follows it, and it is not without order."""
    quiet = throws.correlated

    def shaken(generator, shape, sigma, rho):
        phase = 2 * np.pi * frequency * np.arange(shape[0]) / 60 + generator.uniform(0, 2 * np.pi)
        return quiet(generator, shape, sigma, rho) + 0.0042 * np.sin(phase)[:, None]

    monkeypatch.setattr(throws, "correlated", shaken)
    assert shown(tmp_path, sigma=0.001) is None


def falls(folder, settings, repeats, sigma, stated, late=0.0):
    """Falls from 0.5 to 3 m timed with an error, `late` times the height too late beside; the Comparison."""
    heights = np.repeat(np.linspace(0.5, 3.0, settings), repeats)
    times = np.sqrt(2 * heights / G) + late * heights + sigma * np.random.default_rng(5).standard_normal(len(heights))
    rows = "".join(f"{height:.4f},{time:.5f}\n" for height, time in zip(heights, times, strict=True))
    (folder / "falls.csv").write_text("height_m,fall_time_s\n" + rows)
    text = 'kind = "outcomes"\n[body]\nshape = "sphere"\nradius = 0.02\nmass = 0.26\n[measurement]\nfile = "falls.csv"\n'
    (folder / "e.toml").write_text(text + f"noise = {stated}\n")
    return hlcs.compare(folder / "e.toml")


@pytest.mark.parametrize(("settings", "repeats", "seen"), [(6, 5, "rows that repeat each other"), (24, 1, "smooth curve")])
def test_so_it_is_in_tables_by_repeats_or_about_a_curve(tmp_path, settings, repeats, seen):
    """24 and 20 degrees of freedom know a standard deviation to 15 and 16 %; three times that."""
    found = falls(tmp_path, settings, repeats, sigma=0.006, stated=0.002).noise_shown
    assert found["sigma"] == pytest.approx(0.006, rel=0.5) and found["known"] == 0.002 and seen in found["seen"]
    assert "measurement.noise, outcome = 0.00" in found["remedy"]


@pytest.mark.parametrize(("settings", "repeats"), [(6, 5), (24, 1)])
def test_a_table_that_misses_an_effect_is_not_told_that_its_noise_is_small(tmp_path, settings, repeats):
    """The noise is as stated, and falls last 5 ms longer for every metre."""
    missed = falls(tmp_path, settings, repeats, sigma=0.001, stated=0.001, late=0.005)
    assert not missed.adequate and missed.noise_shown is None
