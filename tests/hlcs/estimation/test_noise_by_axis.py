"""The noise may differ from axis to axis, as that of a depth seen by two cameras does: data by closed forms, its truth known."""

import numpy as np
import pytest
from throws import drag_per_metre, write_throws

import hlcs
from hlcs.estimation.correlated_noise import CorrelatedNoise
from hlcs.estimation.noise_model import Noise

SIGMAS = np.array([0.002, 0.008, 0.002])  # of x, y, z [m]
STATED = "noise = { position = [0.002, 0.008, 0.002] }\n"


@pytest.mark.parametrize("rho, spread", [(0.0, 0.029), (0.6, 0.042)])
def test_a_body_at_rest_tells_the_noise_of_each_axis(tmp_path, rho, spread):
    """600 samples know a standard deviation to 2.9 %, those correlated by 0.6 to 4.2 %; three times that."""
    found = hlcs.compare(write_throws(tmp_path, sigma=SIGMAS, rho=rho))
    assert found.noise["along_axes"] == pytest.approx(SIGMAS, rel=3 * spread)
    assert found.noise["position"] == pytest.approx(np.sqrt(np.mean(SIGMAS**2)), rel=3 * spread)
    assert found.adequate


def test_axes_that_differ_by_chance_share_one_noise(tmp_path):
    assert "along_axes" not in hlcs.compare(write_throws(tmp_path, sigma=0.004)).noise


def test_curves_tell_the_axis_along_which_the_stated_noise_is_too_small(tmp_path):
    """480 samples along each axis, less 6 numbers for each 24 or so, know it to 3.7 %. So written nothing is missing."""
    path = write_throws(tmp_path, sigma=SIGMAS, static=False, noise="noise = { position = 0.002 }\n")
    found = hlcs.compare(path)
    told = found.noise_shown
    assert not found.adequate and list(told["along"]) == ["x", "y", "z"]
    assert list(told["along"].values()) == pytest.approx(SIGMAS, rel=3 * 0.037)
    line = f"position = [{', '.join(f'{size:.2g}' for size in told['along'].values())}]"
    assert told["remedy"].endswith(line) and "along x, y and z" in str(found)
    path.write_text(path.read_text().replace("position = 0.002", line))
    assert hlcs.compare(path).adequate


def test_a_noise_that_is_stated_of_each_axis_weighs_each_as_it_is_known(tmp_path):
    """Half of the throws go along y: were its readings worth nothing, half of the information would be left, and an interval of
    1.41 times the width; it tells as much as that of 8 mm everywhere would, a quarter as well, if nothing weighed the axes."""
    widths = []
    for sigma, stated in ((SIGMAS, STATED), (0.002, "noise = { position = 0.002 }\n")):
        path = write_throws(tmp_path, sigma=sigma, noise=stated, static=False, drag_per_metre=drag_per_metre(0.47))
        found = hlcs.diagnose(path, candidates=["quadratic_drag", "time_scale"])
        drag = found.parameters["quadratic_drag"]["drag_coefficient"]
        assert found.verdict == "effect" and drag["low"] < 0.47 < drag["high"]
        widths.append(drag["high"] - drag["low"])
    assert 1.0 < widths[0] / widths[1] < 1.6


@pytest.mark.parametrize("columns, sigma", [(("x_m", "y_m", "z_m"), np.sqrt(24e-6)), (("x_m", "z_m"), 0.002)])
def test_errors_and_noise_are_those_of_the_axes_that_are_measured(tmp_path, columns, sigma):
    """In metres, whatever weighs an axis: 24 mm2 = (2^2 + 8^2 + 2^2)/3 of x, y, z, 2 mm of x and z; both verbs tell the error
    of a model alike, to what the starts move it."""
    path = write_throws(tmp_path, sigma=SIGMAS, noise=STATED, static=False, drag_per_metre=drag_per_metre(0.47))
    for file in tmp_path.glob("throw_*.csv"):
        lines = [line.split(",") for line in file.read_text().split()]
        keep = [0, *(lines[0].index(name) for name in columns)]
        file.write_text("\n".join(",".join(line[k] for k in keep) for line in lines) + "\n")
    found = hlcs.diagnose(path, candidates=["quadratic_drag", "time_scale"])
    before, after, told = hlcs.compare(path).error, hlcs.compare(path, found.model).error, found.error["fitted"]
    assert [told["before"], told["after"]] == pytest.approx([before["rms"], after["rms"]], rel=1e-2)
    assert told["noise"] == after["noise"] == pytest.approx(sigma, rel=2e-3)  # a sample may stand out


def test_axes_that_are_as_unlike_as_stated_are_told_too_small_and_not_unlike(tmp_path):
    path = write_throws(tmp_path, sigma=2 * SIGMAS, noise=STATED, static=False)
    found = hlcs.compare(path)
    assert list(found.noise_shown["known_along"].values()) == pytest.approx(SIGMAS)
    assert "too small: it is 2 mm, 8 mm and 2 mm along x, y and z" in str(found).replace("\n", " ")


@pytest.mark.parametrize("value", ["[0.002, 0.008]", '[0.002, "y", 0.002]', "[0.002, 0.0, 0.002]", "[0.002, -0.008, 0.002]"])
def test_a_noise_by_axis_is_three_positive_numbers(tmp_path, value):
    path = write_throws(tmp_path, static=False, noise=f"noise = {{ position = {value} }}\n")
    with pytest.raises(hlcs.InputError, match=r"line 11: measurement.noise.position: (must be 3 finite|every component)"):
        hlcs.compare(path)


def test_readings_in_steps_are_as_coarse_along_an_axis_that_is_well_known(tmp_path):
    """Rounding to 5 mm adds 5/sqrt(12) mm to each axis by itself, whatever the noise of the others: 1.76 mm to one of 1 mm."""
    path = write_throws(tmp_path, sigma=np.array([0.001, 0.001, 0.01]), noise="noise = { position = [0.001, 0.001, 0.01] }\n")
    for file in tmp_path.glob("throw_*.csv"):
        names, *rows = file.read_text().split()
        cells = [[float(cell) for cell in row.split(",")] for row in rows]
        steps = [f"{t:.6f}," + ",".join(f"{0.005 * round(value / 0.005):.3f}" for value in place) for t, *place in cells]
        file.write_text("\n".join([names, *steps]) + "\n")
    path.write_text(path.read_text().replace('static = "rest.csv"\n', ""))
    found = hlcs.compare(path).noise["along_axes"]
    assert found == pytest.approx(np.hypot([0.001, 0.001, 0.01], 0.005 / np.sqrt(12)), rel=1e-3)


def test_the_height_above_a_floor_is_known_as_well_as_readings_along_its_normal():
    """A depth known to 17 mm lies along x, heights are known to 1 mm: what touches a level floor is told by these."""
    noise = Noise(CorrelatedNoise(0.01, 0.0, 0.0, np.zeros((3, 3))), None, 0.01, "stated", along=(1.7, 0.1, 0.1))
    assert noise.towards(np.array([0.0, 0.0, 1.0])) == pytest.approx(0.001)
    assert noise.towards(np.array([0.6, 0.0, 0.8])) == pytest.approx(np.hypot(0.6 * 0.017, 0.8 * 0.001))
    assert noise.position == 0.01 and noise.reading(0).sigma == pytest.approx(0.017)
