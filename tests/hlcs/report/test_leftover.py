"""What residuals look like: patterns that are there are named, and noise has none."""

import numpy as np
import pytest
from planted import NOISE, table

from hlcs.report.leftover import common_pattern, few_recordings, likeness, neighbours, own_offset, spectra, spectrum

TIMES = np.arange(200) / 100


def noisy(generator, shape=0.0, trials=4):
    """A table of four recordings of white noise and of a shape that they share (n,)."""
    one = table(np.zeros(len(TIMES)), TIMES, trials)
    residual = np.tile(shape * np.ones(len(TIMES)), trials) + NOISE * generator.standard_normal(len(one["residual"]))
    return one | {"residual": residual, "sigmas": residual / NOISE, "white": residual / NOISE}


def test_white_noise_hides_no_period_and_shows_no_pattern(generator):
    """The level is one in a thousand: of 50 tables none, as 19 of 20 times."""
    found = [noisy(generator) for _ in range(50)]
    assert not any(spectrum(each).hides_a_period for each in found)
    assert max(common_pattern(each)[1] for each in found) < 0.1 and max(own_offset(each) for each in found) < 0.05
    assert max(abs(neighbours(each)) for each in found) < 0.15  # 5 standard errors of 800 pairs, 1/sqrt(796)


def test_the_power_of_white_noise_is_one_and_its_p_is_uniform_enough(generator):
    """Normalised by its own mean square: the mean over all frequencies is 1, to 1/sqrt(200 frequencies x 4 recordings x 20)."""
    power = np.concatenate([spectrum(noisy(generator)).power for _ in range(20)])
    assert np.mean(power) == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("frequency", [3.0, 12.0, 40.0])
def test_a_swing_is_found_at_its_frequency_with_its_amplitude(generator, frequency):
    """The amplitude of a sine in noise: A^2 = 4 P / n, to the noise sqrt(2/n) sigma of each recording."""
    found = spectrum(noisy(generator, 2 * NOISE * np.sin(2 * np.pi * frequency * TIMES)))
    assert found.hides_a_period and found.peak == pytest.approx(frequency, abs=0.3)  # a recording of 2 s resolves 0.5 Hz
    assert found.amplitude == pytest.approx(2 * NOISE, rel=0.15)


def test_a_drift_is_no_period(generator):
    """A slow curve has its largest power below three periods a recording."""
    found = noisy(generator, 5 * NOISE * (TIMES - 1.0) ** 2)
    assert not spectrum(found).hides_a_period
    assert common_pattern(found)[1] > 0.5 and "in the same way in all recordings" in likeness(found)


def test_what_is_of_each_recording_alone_is_told_apart(generator):
    found = noisy(generator)
    offsets = np.repeat([3.0, -3.0, 2.0, -2.0], len(TIMES))
    by = {"residual": NOISE * offsets, "sigmas": offsets, "white": offsets}
    moved = found | {name: found[name] + part for name, part in by.items()}
    assert own_offset(moved) > 0.7 and "an offset that each recording has of its own" in likeness(moved)


def test_rows_of_equal_inputs_that_miss_alike_do_not_scatter(generator):
    """Nine settings of two inputs, ten rows each, a misfit of three times the noise that is another one in each setting."""
    speed, angle = (np.repeat(part.ravel(), 10) for part in np.meshgrid([3.0, 5.0, 7.0], [20.0, 40.0, 60.0]))
    shape = np.where(((speed + angle / 10) % 4) < 2, 3.0, -3.0)
    for shift, told in ((shape, "rows of equal inputs miss alike"), (0.0, "rows scatter more than the noise says")):
        sigmas = shift + generator.standard_normal(90)
        rows = {"trial": np.zeros(90, int), "channel": np.zeros(90, int), "input": speed, "sigmas": sigmas, "residual": sigmas}
        assert told in likeness(rows | {"speed_m_s": speed, "angle_deg": angle})


def test_an_offset_of_each_group_of_rows_is_told(generator):
    """Nine groups of ten rows whose inputs are the same, such as drops that were timed by nine students, each three sigma off."""
    group, speed = np.repeat(np.arange(9), 10), np.tile(np.linspace(1.0, 5.0, 10), 9)
    for offset, told in ((3.0, "an offset that each group of rows has of its own"), (0.0, "rows scatter more")):
        sigmas = np.where(group % 2, offset, -offset) + generator.standard_normal(90)
        rows = {"trial": group, "channel": np.zeros(90, int), "input": speed, "sigmas": sigmas, "residual": sigmas}
        assert told in likeness(rows | {"speed_m_s": speed})


def test_what_is_left_in_few_of_the_recordings_names_these(generator):
    """A step of ten times the noise in one of four; as large in three of them it is no matter of a few."""
    names = ("a.csv", "b.csv", "c.csv", "d.csv")
    for moved, told in (
        ((1,), "is in b.csv alone: look for what was different there; in it"),
        ((0, 1, 3), "in the same way in all"),
    ):
        found = noisy(generator)
        step = 10 * np.isin(found["trial"], moved) * (found["time"] > 1.0)
        moved_by = {"residual": NOISE * step, "sigmas": step, "white": step}
        assert told in likeness(found | {name: found[name] + by for name, by in moved_by.items()}, trials=names)
    assert "alone" not in likeness(noisy(generator), trials=names)


@pytest.mark.parametrize("trials, more", [(2, 2.0), (10, 1.2), (40, 1.0), (40, 1.05), (80, 1.1)])
def test_recordings_that_all_miss_alike_are_not_told_apart(generator, trials, more):
    """The level is one in a thousand: of 100 tables of white residuals whose variance is `more` in all recordings two at most."""
    told = 0
    for _ in range(100):
        white = np.sqrt(more) * generator.standard_normal(60 * trials)
        told += few_recordings({"trial": np.repeat(np.arange(trials), 60), "white": white, "sigmas": white}) is not None
    assert told <= 2


def test_a_long_recording_that_misses_as_a_short_one_does_is_not_named(generator):
    """Twice the variance of the noise in both, 1,000 and 50 samples: the long one holds 95 % of it, and is not different."""
    white = np.sqrt(2) * generator.standard_normal(1050)
    assert few_recordings({"trial": np.repeat([0, 1], [1000, 50]), "white": white, "sigmas": white}) is None


def test_noise_that_is_correlated_is_no_offset_of_its_own(generator):
    """Of 50 tables of 10 recordings of AR(1) noise, rho = 0.9, whitened as it is, one at most; told by sigmas alone most were."""
    told = 0
    for _ in range(50):
        white = generator.standard_normal((10, 40))
        sigmas = white.copy()
        for k in range(1, 40):
            sigmas[:, k] = 0.9 * sigmas[:, k - 1] + np.sqrt(1 - 0.9**2) * white[:, k]
        trial, channel = np.repeat(np.arange(10), 40), np.zeros(400, int)
        told += own_offset({"trial": trial, "channel": channel, "white": white.ravel(), "sigmas": sigmas.ravel()}) > 0
    assert told <= 1


def test_an_input_that_is_not_the_main_one_is_named(generator):
    """Three heights, two masses, a misfit of the heavy ones alone."""
    height, mass = np.repeat([1.0, 2.0, 3.0], 12), np.tile([0.1, 0.2], 18)
    sigmas = np.where(mass > 0.15, 3.0, -3.0) + generator.standard_normal(36)
    rows = {"trial": np.zeros(36, int), "channel": np.zeros(36, int), "input": height, "sigmas": sigmas, "residual": sigmas}
    assert "goes with mass_kg" in likeness(rows | {"height_m": height, "mass_kg": mass})


def test_what_one_value_of_an_input_misses_alone_is_told_by_that_value(generator):
    """Four surfaces of ten rows, one of them missed by 8 sigma; and all of them, by more the faster: then none is named."""
    friction, speed = np.repeat([0.2, 0.3, 0.45, 0.6], 10), np.tile(np.linspace(0.5, 2.5, 10), 4)
    missed = np.where(friction == 0.45, 8.0, 0.0) + generator.standard_normal(40)
    rows = {"trial": np.zeros(40, int), "channel": np.zeros(40, int), "friction": friction, "speed_m_s": speed, "sigmas": missed}
    assert "is in rows of friction = 0.45 alone" in likeness(rows)
    assert "alone" not in likeness(rows | {"sigmas": 2 * speed**2 + generator.standard_normal(40)})


def test_too_few_samples_have_no_spectrum(generator):
    assert spectra(table(np.ones(10))) == [] and spectrum(table(np.ones(10))) is None


def test_neighbours_are_alike_by_a_correlation_which_is_never_more_than_all():
    """Residuals that grow from sample to sample: their slope on one another is 1.2, their correlation 1."""
    assert neighbours(table(NOISE * 1.2 ** np.arange(20))) == pytest.approx(1.0)


def test_a_swing_that_holds_little_of_what_is_left_is_told_beside_it_with_its_share(generator):
    """A drift of 30 mm with a swing of 1 mm: the swing is seen beyond doubt, and is no cause of what is left."""
    times = np.arange(400) / 100
    swing, noise = 1e-3 * np.sin(2 * np.pi * 9.9 * times), 1e-4 * generator.standard_normal(400)
    alone, beside = table(swing + noise, times), table(swing + noise + 0.05 * np.sign(times - 2.0), times)
    beside["white"] = alone["white"]  # as whitening leaves it: the drift is gone
    assert likeness(alone).startswith("it swings 9.9 times a second")
    told = likeness(beside)
    assert not told.startswith("it swings") and "beside it a swing of 9.9 times a second holds 0 % of it" in told
