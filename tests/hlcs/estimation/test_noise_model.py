"""The noise of a measurement: rounding, outliers, coordinates that tell nothing."""

import numpy as np
import pytest
from experiments import TOML, measured
from throws import correlated, flight
from throws import csv as recording

import hlcs
from hlcs.data.recordings import read_recordings
from hlcs.estimation.flexible_curves import resting_from
from hlcs.estimation.noise_model import estimate_noise

BALL = {"shape": "sphere", "radius": 0.03, "mass": 0.05}


def test_a_coordinate_set_to_zero_tells_nothing_of_the_noise(tmp_path):
    """Eight throws in a plane, sigma stated, y written as zero: rho of x and z, 0.6 within three standard errors of 0.04."""
    text = TOML.replace("0.01", "0.003")
    generator, times = np.random.default_rng(4), np.arange(60) / 60
    for k in range(8):
        seen = flight(np.zeros(3), np.array([3.0, 0.0, 4.0]), times) + correlated(generator, (60, 3), 0.003, 0.6) * [1, 0, 1]
        (tmp_path / f"throw_{k}.csv").write_text(recording(times, seen))
        text += f'[[trial]]\nfile = "throw_{k}.csv"\n'
    (tmp_path / "throws.toml").write_text(text)
    noise = estimate_noise(measured(tmp_path / "throws.toml"))
    assert noise.position == 0.003 and noise.rho == pytest.approx(0.6, abs=0.12)


def write_rounded(folder, sigma, step, rest, stated=False, rho=0.0, swing=0.0):
    """Eight throws read in steps, and 600 readings of a body at rest at `rest`: path of the experiment file.

    rho: of the noise; swing: amplitude of what the throws have beside their parabola at 4 Hz [m].
    """
    generator, times = np.random.default_rng(7), np.arange(60) / 60
    noise = f"noise = {{ position = {sigma} }}" if stated else 'static = "rest.csv"'
    text = TOML.replace("noise = { position = 0.01 }", noise)
    for k in range(8):
        seen = flight(np.zeros(3), generator.uniform(-4, 4, 3), times) + correlated(generator, (60, 3), sigma, rho)
        seen += swing * np.sin(2 * np.pi * 4.0 * times)[:, None]
        (folder / f"throw_{k}.csv").write_text(recording(times, step * np.round(seen / step)))
        text += f'[[trial]]\nfile = "throw_{k}.csv"\n'
    seen = rest + correlated(generator, (600, 3), sigma, rho)
    (folder / "rest.csv").write_text(recording(np.arange(600) / 60, step * np.round(seen / step)))
    (folder / "throws.toml").write_text(text)
    return folder / "throws.toml"


@pytest.mark.parametrize("place", [0.0, 0.25, 0.5])
def test_the_pixel_step_is_added_wherever_between_two_pixels_the_body_at_rest_lies(tmp_path, place):
    """Noise of 0.3 mm read in steps of 1 mm: 0.42 mm in flight, known to a tenth from 600 readings at rest."""
    noise = estimate_noise(measured(write_rounded(tmp_path, 3e-4, 1e-3, 0.5 + place * 1e-3)))
    assert noise.source == "static recording"
    assert noise.position == pytest.approx(np.hypot(3e-4, 1e-3 / np.sqrt(12)), rel=0.1)
    assert noise.positions.sigma == pytest.approx(3e-4, rel=5 * np.sqrt(noise.positions.covariance[0, 0]) + 0.02)


def test_a_body_at_rest_that_shows_one_reading_still_tells_the_noise_of_readings_in_motion(tmp_path):
    """Noise of a tenth of a step, the body in the middle of one: q / sqrt(12) in flight to 6 %, and the rest is uncertain."""
    noise = estimate_noise(measured(write_rounded(tmp_path, 1e-4, 1e-3, 0.5)))
    assert noise.position == pytest.approx(1e-3 / np.sqrt(12), rel=0.06)
    assert noise.positions.covariance[0, 0] > 0.3**2


@pytest.mark.parametrize("rho", [0.0, 0.6])
def test_how_the_noise_hangs_together_shows_at_rest_and_not_in_what_no_curve_follows(tmp_path, rho):
    """0.3 mm read in steps of 1 mm, beside a swing that polynomials leave half of: within the scatter of 600 readings, 0.2."""
    noise = estimate_noise(measured(write_rounded(tmp_path, 3e-4, 1e-3, 0.75, rho=rho, swing=0.02)))
    assert noise.positions.rho == pytest.approx(rho, abs=0.2)


def test_a_stated_noise_is_that_before_rounding(tmp_path):
    noise = estimate_noise(measured(write_rounded(tmp_path, 3e-4, 1e-3, 0.5, stated=True)))
    assert noise.position == pytest.approx(np.hypot(3e-4, 1e-3 / np.sqrt(12)), rel=1e-3)


def test_an_axis_with_too_few_readings_at_rest_tells_nothing_of_the_noise(tmp_path):
    """Eight readings in each axis of a body at rest, blank beyond: a curve of degree 5 would leave too few to judge by."""
    path = write_rounded(tmp_path, 3e-4, 1e-3, 0.5)
    header, *rows = (tmp_path / "rest.csv").read_text().splitlines()
    blank = [row.split(",")[0] + ",,," for row in rows[8:40]]
    (tmp_path / "rest.csv").write_text("\n".join([header, *rows[:8], *blank]) + "\n")
    assert not estimate_noise(measured(path)).known


def test_where_a_slide_ends_no_smooth_curve_goes_on():
    """The last sample that is 4 standard deviations short of a stop lies sqrt(8 sigma/a) before it, 3 samples here."""
    times, sigma = np.arange(60) / 30, 0.001
    noise = sigma * np.random.default_rng(2).standard_normal(60)
    moving = np.minimum(times, 1.0)  # a stop at sample 30
    assert 26 <= resting_from(1.8 * (moving - moving**2 / 2) + noise, 0.0) <= 31
    assert resting_from(0.3 * times + noise, 0.0) == 60  # it moves on
    assert resting_from(noise, 0.0) == 0
    assert resting_from(np.where(times < 1.0, times, 1.0).round(1), 0.1) >= 9  # read in steps of a tenth


def doubted(folder, seed, rho, stated=None):
    """Does a note say that curves leave another noise than that of a body at rest, or than is stated? True noise 1 mm; 60 frames
    a second, four throws of 36 frames."""
    generator, times, text = np.random.default_rng(seed), np.arange(36) / 60, TOML
    for k in range(4):
        seen = flight(np.zeros(3), np.array([1.0 + 0.5 * k, 0.0, 3.0]), times)
        (folder / f"{k}.csv").write_text(recording(times, seen + correlated(generator, (36, 3), 1e-3, rho)))
        text += f'[[trial]]\nfile = "{k}.csv"\n'
    rest = correlated(generator, (200, 3), 1e-3, rho)
    (folder / "rest.csv").write_text(recording(np.arange(200) / 60, rest))
    noise = f"noise = {{ position = {stated} }}" if stated else 'static = "rest.csv"'
    (folder / "throws.toml").write_text(text.replace("noise = { position = 0.01 }", noise))
    return any("flexible curve" in note for note in estimate_noise(measured(folder / "throws.toml")).notes)


@pytest.mark.parametrize("rho", [0.0, 0.8])
def test_curves_doubt_a_noise_only_by_more_than_chance(tmp_path, rho):
    """1 in 1,000 by chance alone: 1 in 10 would be 100 times that. Short curves tell little of noise that hangs together."""
    assert sum(doubted(tmp_path, seed, rho) for seed in range(10)) <= 1


@pytest.mark.parametrize("stated", [4e-4, 2.5e-3])
def test_curves_doubt_a_noise_that_is_stated_too_small_or_too_large(tmp_path, stated):
    """2.5 times too little or too much of 1 mm: ten standard errors of some 200 degrees of freedom."""
    assert all(doubted(tmp_path, seed, 0.0, stated) for seed in range(3))


def turning(rate=3.0, count=60):
    """Columns of an orientation that turns about z at a rate [rad/s], 60 samples a second."""
    times = np.arange(count) / 60
    half, none = rate * times / 2, 0.0 * times
    return {"t_s": times, "qw": np.cos(half), "qx": none, "qy": none, "qz": np.sin(half)}


def noise_of(frames, **stated):
    experiment = hlcs.Experiment.from_frames(frames, body=BALL, measurement={"planar": True}, **stated)
    return estimate_noise(read_recordings(experiment.file))


def test_positions_whose_noise_nobody_knows_are_not_judged_and_that_is_told(generator):
    """A body that speeds up by 1 m/s2, which no law of the model does, beside a spin that fits."""
    spin = turning()
    frames = [
        spin | {"x_m": 0.3 * spin["t_s"] + 0.5 * spin["t_s"] ** 2 + 0.002 * generator.standard_normal(60)} for _ in range(2)
    ]
    noise = noise_of(frames, noise={"orientation": 0.006})
    assert any(note.startswith("noise of the position unknown: positions are not judged") for note in noise.notes)


def test_coordinates_that_never_change_tell_no_noise(generator):
    """A disc that spins on the spot: all that a curve leaves of them is zero, and no number comes of that."""
    spin = turning()
    noise = noise_of(
        [spin | {"x_m": 0 * spin["t_s"], "y_m": 0 * spin["t_s"]}] * 2, noise={"orientation": 0.006, "position": 0.001}
    )
    assert not any("nan" in note for note in noise.notes)


def moved(generator, sigma, count=120):
    times = np.arange(count) / 60
    return {"t_s": times} | {name: 0.3 * times + sigma * generator.standard_normal(count) for name in ("x_m", "y_m")}


def test_a_noise_that_is_stated_is_told_as_stated_beside_a_body_at_rest(generator):
    rest = moved(generator, 0.0005)
    rest |= {name: values - 0.3 * rest["t_s"] for name, values in rest.items() if name != "t_s"}
    noise = noise_of([moved(generator, 0.002) for _ in range(3)], static=rest, noise={"position": 0.005})
    assert noise.source == "stated" and any("the stated noise is 0.005 m" in note for note in noise.notes)


def test_a_body_at_rest_that_shows_one_reading_takes_away_no_tail_of_outliers(generator):
    def strays(values):
        there = generator.random(len(values)) < 0.03
        return values + there * 0.007 * generator.standard_normal(len(values))

    frames = [
        {name: values if name == "t_s" else strays(values) for name, values in moved(generator, 0.002, 600).items()}
        for _ in range(3)
    ]
    still = {"t_s": np.arange(60) / 60, "x_m": np.full(60, 0.25), "y_m": np.full(60, 0.1)}
    alone, beside = (noise_of(frames, static=static, noise={"position": 0.002}) for static in (None, still))
    assert alone.tail.share > 0 and beside.tail.share == alone.tail.share and np.array_equal(beside.tail.sizes, alone.tail.sizes)


def test_a_block_that_turns_back_on_its_slope_shows_its_noise_though_friction_turns_round():
    """Shoved up a board of 14 degrees, friction 0.18: g (sin + mu cos) slows it, g (sin - mu cos) takes it down again.
    White noise of 2 mm as stated: the model that is right leaves no more, and rho is zero, within three errors of 0.08."""
    slope, times, frames, draw = np.radians(14.0), np.arange(0, 1.6, 0.04), [], np.random.default_rng(1)
    up, down = (9.81 * (np.sin(slope) + sign * 0.18 * np.cos(slope)) for sign in (1, -1))
    for speed in (1.0, 1.25, 1.5, 1.75, 2.0, 2.25):
        top = speed / up
        before, after = up * times**2 / 2 - speed * times, down * (times - top) ** 2 / 2 - speed * top / 2
        frames.append({"t_s": times, "x_m": 1.5 + np.where(times < top, before, after) + 0.002 * draw.standard_normal(40)})
    block, floor = {"shape": "box", "size": [0.12, 0.08, 0.04], "mass": 0.35}, {"floor": {"height": 0.0}, "friction": 0.18}
    seen = hlcs.Experiment.from_frames(
        frames,
        block,
        floor,
        noise={"position": 0.002},
        measurement={"planar": True},
        model={"effects": [{"name": "tilted_gravity", "angle_x": 0.0, "angle_y": -slope}]},
    )
    compared = hlcs.compare(seen)
    assert compared.adequate and compared.noise["rho"] < 0.25
    assert compared.noise["flexible"] == pytest.approx(0.002, rel=0.2)  # 2 sigma of 6 x 28 degrees of freedom
