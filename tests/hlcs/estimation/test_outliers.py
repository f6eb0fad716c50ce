"""Isolated outliers are found, what is smooth or a kink is none, and those that stay are counted."""

import numpy as np
import pytest
from throws import correlated

from hlcs.estimation.correlated_noise import CorrelatedNoise
from hlcs.estimation.outliers import NO_TAIL, anywhere, isolated_in, isolated_outliers, spread_of, tail_of

TIMES = np.arange(60) / 60


def test_an_isolated_outlier_is_found_and_smooth_misfit_is_not(generator):
    values = np.sin(np.linspace(0, 3, 60)) * 50 + generator.standard_normal(60)
    assert not isolated_outliers(TIMES, values).any()
    values[20] += 15
    assert np.flatnonzero(isolated_outliers(TIMES, values)).tolist() == [20]


def test_two_outliers_beside_each_other_are_found_and_so_is_one_at_the_end(generator):
    values = generator.standard_normal(60)
    values[[30, 31, 59]] += 20
    assert np.flatnonzero(isolated_outliers(TIMES, values)).tolist() == [30, 31, 59]


def test_outliers_at_the_ends_are_found_and_their_neighbours_kept(generator):
    """What four samples foretell scatters by 1.58 sigma: more than 4.7 is found, of 5 to 15 sigma nine in ten. One marks its
    neighbour by half its size, which must not go in its place; good ends, 4.9 sigma from the next four too, go less than once in
    1,000."""
    found = neighbours = good = 0
    for _ in range(400):
        values = generator.standard_normal(60)
        good += int(isolated_outliers(TIMES, values, np.sqrt(1.5))[[0, -1]].sum())
        values[[0, -1]] += generator.uniform(5, 15, 2) * generator.choice([-1, 1], 2)
        flags = isolated_outliers(TIMES, values, np.sqrt(1.5))
        found, neighbours = found + int(flags[[0, -1]].sum()), neighbours + int(flags[[1, -2]].sum())
    assert found > 0.85 * 800 and neighbours < 0.05 * 800 and good <= 1


@pytest.mark.parametrize("fall", [0.25, 0.4, 0.6, 0.8])
def test_a_series_that_bends_at_its_beginning_loses_few_samples(generator, fall):
    """What a linear drag leaves of a coffee filter near its final speed falls exponentially, from 60 sigma on by up to a half
    from sample to sample: each first sample stands out from those after it, as long as there are any. Three outliers in a row
    are none (one in 40,000 of three per cent)."""
    for size in generator.uniform(20, 200, 100):
        values = generator.standard_normal(60) - size * np.exp(-fall * np.arange(60))
        assert isolated_outliers(TIMES, values, np.sqrt(1.5))[:5].sum() < 3


@pytest.mark.parametrize("spread", [np.sqrt(1.5), 0.0])
def test_a_short_series_is_not_rough_because_samples_stand_alone_in_it(generator, spread):
    """Ten samples of which three stand out by 6 to 9 sigma: by its own scatter few are found. Where the noise is known more than
    four in five are, and one good sample in 100 goes: beside an outlier it stands out itself."""
    found = good = 0
    for _ in range(40):
        series = [[TIMES[:10], generator.standard_normal(10)] for _ in range(30)]
        bad = [2, 5, 7]
        series[0][1][bad] += generator.uniform(6, 9, 3) * generator.choice([-1, 1], 3)
        flags = isolated_in(series, [spread] * 30)[0]
        found, good = found + int(flags[bad].sum()), good + int(flags.sum() - flags[bad].sum())
    assert (found > 0.8 * 120) == (spread > 0) and good <= 0.1 * 280


@pytest.mark.parametrize("rougher", [1.5, 3.0, 10.0])
def test_series_that_are_rougher_than_noise_lose_few_samples(generator, rougher):
    """What a wrong model leaves may scatter more than noise: then no sample stands alone by that scatter. A second difference of
    4 of its sigma comes once in 16,000, as many as there are here; five times that is allowed."""
    lost = sum(
        int(np.sum(isolated_in([(TIMES, rougher * generator.standard_normal(60)) for _ in range(9)], [np.sqrt(1.5)] * 9)))
        for _ in range(30)
    )
    assert lost <= 5


@pytest.mark.parametrize("share", [0.03, 0.06, 0.10])
def test_outliers_do_not_make_the_others_look_like_noise(generator, share):
    """In nine series of 30 samples an outlier marks three second differences, and all seem rougher for it. More than
    nine in ten are found, good samples less than once in 500, beside an outlier."""
    found = good = wild = 0
    for _ in range(60):
        series, bad = [], generator.random((9, 30)) < share
        for its in bad:
            values = generator.standard_normal(30)
            values[its] += generator.uniform(5, 15, its.sum()) * generator.choice([-1, 1], its.sum())
            series.append((TIMES[:30], values))
        flags = np.array(isolated_in(series, [np.sqrt(1.5)] * 9))
        found, wild, good = found + np.sum(flags & bad), wild + np.sum(bad), good + np.sum(flags & ~bad)
    assert found > 0.9 * wild and good < 32


def test_a_kink_is_no_outlier(generator):
    """A wrong rebound bends the residuals by 30 sigma a sample: no sample that is left out mends that."""
    values = 30 * np.maximum(np.arange(60) - 30, 0) + generator.standard_normal(60)
    assert not isolated_outliers(TIMES, values).any()


def test_samples_alone_at_one_end_of_most_series_are_part_of_the_motion(generator):
    """Five first samples of eight series 10 sigma off, one other in each: by a share of 3 % that comes once in 300,000."""
    series = [(TIMES, generator.standard_normal(60)) for _ in range(8)]
    for k, (_, values) in enumerate(series):
        values[20 + k] += 20
        values[0] += 10 * (k < 5)
    found = [np.flatnonzero(its).tolist() for its in isolated_in(series, [np.sqrt(1.5)] * 8)]
    assert found == [[20 + k] for k in range(8)]


def test_samples_in_a_row_in_several_series_are_part_of_the_motion(generator):
    """Three samples of a fall, 20 to 60 sigma off by a wrong clock, in three of six series that rest elsewhere: lost samples lie
    in a row so often once in a million. In one series a tracker may have lost them; a single one of another is set aside."""
    for falls, flagged in ((3, []), (1, [3, 4, 5, 6, 7])):
        series = [(TIMES, generator.standard_normal(60)) for _ in range(6)]
        for _, values in series[:falls]:
            values[4:7] += [20, 60, 40]
        series[5][1][30] += 20
        found = [np.flatnonzero(its).tolist() for its in isolated_in(series, [np.sqrt(1.5)] * 6)]
        assert (found[0], found[5]) == (flagged, [30])


@pytest.mark.parametrize("share", [0.03, 0.05, 0.10])
def test_outliers_that_lie_anywhere_are_left_out_at_the_ends_and_in_a_row_too(generator, share):
    """6 series: of 4,000 ends and 2,000 rows with flags that are random some 0.6 are expected to lose them."""
    changed = 0
    for _ in range(2000):
        flags = [generator.random(40) < share for _ in range(6)]
        changed += any(map(np.any, map(np.logical_xor, anywhere([its.copy() for its in flags]), flags)))
    assert changed <= 4


def test_a_steady_motion_with_a_dropped_sample_has_no_outlier(generator):
    times = np.delete(TIMES, 30)
    assert not isolated_outliers(times, 1e4 * times + generator.standard_normal(59)).any()


def test_of_three_per_cent_of_outliers_few_stay_and_few_good_samples_go(generator):
    """Outliers of 5 to 15 sigma: in normal noise a second difference has 1.22 sigma, so 4.9 +- 1.2 sigma and more is found, nine
    in ten; good samples stand out once in 16,000 and beside outliers."""
    found = good = wild = 0
    for _ in range(100):
        values, bad = generator.standard_normal(200), generator.random(200) < 0.03
        values[bad] += generator.uniform(5, 15, bad.sum()) * generator.choice([-1, 1], bad.sum())
        flags = isolated_outliers(TIMES[0] + np.arange(200) / 60, values, np.sqrt(1.5))
        found, wild, good = found + np.sum(flags & bad), wild + np.sum(bad), good + np.sum(flags & ~bad)
    assert found > 0.85 * wild and good < 0.002 * 20000


def test_the_scatter_of_second_differences_follows_from_the_noise(generator):
    """AR(1) of 0.8: within 3 % (20,000 samples, of which some 2,000 are independent)."""
    values = correlated(generator, (20000,), 2.0, 0.8)
    second = values[1:-1] - (values[:-2] + values[2:]) / 2
    noise = CorrelatedNoise(2.0, 0.8, 0.0, np.zeros((3, 3)))
    assert abs(np.std(second) / spread_of(noise, np.arange(20000) / 60, 1 / 60) - 1) < 0.03


def test_outliers_that_stay_are_counted_and_normal_noise_has_none_to_speak_of(generator):
    """20,000 samples, one in a hundred at 5 sigma: their share within five standard errors, the scale within 2 %."""
    white = generator.standard_normal(20000)
    assert tail_of(white).share < 5 * np.sqrt(0.001 / 20000) and tail_of(np.zeros(300) + white[:300].clip(-2, 2)) == NO_TAIL
    white[::100] = 5.0
    tail = tail_of(3.0 * white)
    assert abs(tail.share - 0.01) < 5 * np.sqrt(0.011 / 20000)
    assert abs(np.max(tail.sizes) / 5.0 - 1) < 0.02 and abs(tail.variance - 0.24) < 0.06
