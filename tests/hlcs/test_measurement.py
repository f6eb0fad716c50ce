"""Experiment files and recordings: what cannot be used is refused by file, line or row, and what to do."""

import numpy as np
import pytest
from throws import correlated, flight
from throws import csv as recording

import hlcs
from hlcs.data.experiment_file import read_experiment_file
from hlcs.data.measurement import read_measurement, read_outcomes, read_recording
from hlcs.estimation.inference import (
    Correlated,
    chain,
    colour,
    coloured,
    correlation,
    fit_noise,
    isolated_outliers,
    lower_factor,
    polynomials,
    whiten,
    whitened,
)
from hlcs.estimation.linearization import Recording
from hlcs.estimation.noise_model import Noise, estimate_noise
from hlcs.kinds.trajectories.observations import judge
from hlcs.kinds.trajectories.preparation import prepare
from hlcs.kinds.trajectories.thinning import on_all_rows, thinned
from minibullet.errors import InputError, InputWarning

TOML = 'kind = "trajectory"\n[body]\nshape = "sphere"\nradius = 0.03\nmass = 0.05\n[measurement]\nnoise = { position = 0.01 }\n'


def experiment(folder, csv="", toml=TOML, trial='file = "a.csv"\n', name="a.csv"):
    """An experiment folder with one recording; the path of its TOML."""
    lines = "".join(f"{0.1 * k:.1f},{1 - 0.05 * k * k:.4f}\n" for k in range(8))
    (folder / name).write_text(csv or "t_s,z_m\n" + lines)
    path = folder / "e.toml"
    path.write_text(toml + f"[[trial]]\n{trial}")
    return path


def refused(path, *words):
    """The message with which reading is refused; it holds all the words."""
    with pytest.raises(InputError) as problem:
        read_measurement(path)
    message = str(problem.value)
    assert "\n" not in message
    for word in words:
        assert word in message, message


def test_a_good_file_is_read(tmp_path):
    measurement = read_measurement(experiment(tmp_path))
    assert measurement.trials[0].columns == ["z"] and measurement.file.body.mass == 0.05


@pytest.mark.parametrize(
    ("toml", "words"),
    [
        (TOML.replace("radius", "raduis"), ("line 4", "raduis", "radius")),
        (TOML.replace("[measurement]", "[measurment]"), ("measurment", "measurement", "line 6")),
        (TOML.replace("position = 0.01", "positon = 0.01"), ("positon", "position", "line 7")),
        (TOML.replace("0.05", "-1.0"), ("line 5", "mass", "greater than 0")),
        (TOML.replace("0.03", "30.0"), ("density", "kg and m")),
        (TOML.replace('"sphere"', '"spere"'), ("spere", "sphere")),
        (TOML.replace('"trajectory"', '"trajectories"'), ("trajectory",)),
        (TOML + "[model]\neffects = 3\n", ("effects", "list")),
        (TOML.replace("{ position = 0.01 }", "0.01"), ("line 7", "noise", "{ position = 0.01 }")),
        (TOML.replace("{ position", "{ outcome"), ("line 7", "outcome", "position [m]")),
        (TOML + "[surroundings]\nfloor = 0.0\n", ("line 9", "floor", "{ height = 0.0 }")),
        (TOML + "[placement]\nlayers = 5\n", ("line 8", "placement", "layers")),
    ],
)
def test_wrong_keys_and_values_are_named(tmp_path, toml, words):
    refused(experiment(tmp_path, toml=toml), *words)


@pytest.mark.parametrize(
    ("csv", "words"),
    [
        ("t_s,z_m\n0,1\n0.2,1\n0.1,1\n0.3,1\n", ("a.csv", "row 4", "t_s", "unsorted")),
        ("t_s,z_m\n0,1\n0.1,1\n0.1,1\n0.3,1\n", ("row 4", "duplicate")),
        ("t_s,z_m\n0,1\n0.1,nan\n0.2,1\n", ("row 3", "z_m", "not finite", "blank")),
        ("t_s,z_m\n0,1\n0.1,inf\n0.2,1\n", ("row 3", "not finite")),
        ("t_s,z_m\n0,1\n0.1,one\n0.2,1\n", ("row 3", "not a number")),
        ("t_s,z_m\n0,1\n0.1\n", ("row 3", "cells")),
        ("t_s,h_m\n0,1\n0.1,1\n", ("row 1", "h_m", "nearest")),
        ("t_s,z_m\n0,1\n0.1,1\n0.2,0.9\n", ("3 samples", "4 are needed")),
        ("t_s,qw,qx,qy,qz\n0,1,0,0,0\n0.1,0,0,0,0\n", ("row 3", "zero length")),
        ("t_s,qw,qx,qy\n0,1,0,0\n", ("qw, qx, qy, qz",)),
        ("t_s,z_m\n" + "".join(f"{0.1 * k},{1000 - 4905 * (0.1 * k) ** 2}\n" for k in range(9)), ("z_m", "units")),
        ("t_s;z_m\n0;1\n0,1;0,9\n", ("row 1", "semicolons", "commas")),
        ("t_s,z_m\n0,0,1,0\n0,1,0,9\n", ("row 2", "4 cells", "point")),
        ('t_s,z_m\n0,1\n"0,1",1\n', ("row 3", "t_s", "0,1", "point")),
        ("t_s,z_m,\n0,1,\n", ("row 1", "column 3", "comma")),
        ("t_s,z\n0,1\n", ("row 1", "'z'", "'z_m'")),
        ("t_s,z_m\n\0,1\n", ("not text",)),
        ("t_s,y_m,z_m\n" + "".join(f"{0.1 * k},{9 - 0.049 * k * k},{0.2 * k}\n" for k in range(9)), ("y_m", "z_m", "mixed up")),
        ("t_s,z_m\n" + "".join(f"{0.1 * k},{4.9 * (0.1 * k) ** 2}\n" for k in range(9)), ("z_m", "falls upwards")),
        ("t_s,z_m\n" + "".join(f"{0.1 * k},{300 - 490 * (0.1 * k) ** 2}\n" for k in range(7)), ("z_m", "units")),
    ],
)
def test_bad_recordings_are_refused_by_row_and_column(tmp_path, csv, words):
    refused(experiment(tmp_path, csv=csv), *words)


FLOOR = TOML + "[surroundings]\nfloor = { height = 0.0 }\n"


def test_units_are_checked_between_impacts_too(tmp_path):
    """A ball bouncing on its floor, heights in cm: no parabola fits the whole, but one fits every piece between impacts."""
    times = np.arange(120) / 60
    since = np.minimum(times % 0.5, 0.5)
    rows = "".join(f"{t:.5f},{100 * (0.03 + 4.905 * s * (0.5 - s)):.3f}\n" for t, s in zip(times, since, strict=True))
    refused(experiment(tmp_path, csv="t_s,z_m\n" + rows, toml=FLOOR), "z_m", "acceleration", "units")


def test_a_body_inside_its_floor_is_refused_or_described(tmp_path):
    rows = "".join(f"{0.02 * k:.2f},{-0.5 + 0.003 * (k % 2):.4f}\n" for k in range(20))
    refused(experiment(tmp_path, csv="t_s,z_m\n" + rows, toml=FLOOR), "below its floor", "floor.height")
    rows = "".join(f"{0.02 * k:.2f},{max(0.3 - 4.9 * (0.02 * k) ** 2, 0.0):.4f}\n" for k in range(30))
    notes = read_measurement(experiment(tmp_path, csv="t_s,z_m\n" + rows, toml=FLOOR)).notes
    assert any("positions are of the centre" in note for note in notes)


def test_a_scalar_that_stands_last_is_seen_under_a_box(tmp_path):
    """A box 0.2 x 0.1 x 0.04 lies flat, turned by 45 degrees about z: with the scalar last it would stand on an edge."""
    c, d = np.cos(np.pi / 8), np.sin(np.pi / 8)
    toml = FLOOR.replace('"sphere"', '"box"').replace("radius = 0.03", "size = [0.2, 0.1, 0.04]")
    for quaternion in (f"{c:.6f},0,0,{d:.6f}", f"0,0,{d:.6f},{c:.6f}"):
        rows = "".join(f"{0.1 * k:.1f},{0.001 * k},0,0.02,{quaternion}\n" for k in range(9))
        path = experiment(tmp_path, csv="t_s,x_m,y_m,z_m,qw,qx,qy,qz\n" + rows, toml=toml)
        if quaternion.startswith("0,"):
            refused(path, "qw..qz", "scalar")
        else:
            assert read_measurement(path).trials


def test_a_static_recording_that_drifts_is_refused(tmp_path):
    path = experiment(tmp_path, toml=TOML.replace("noise = { position = 0.01 }", 'static = "rest.csv"'))
    rows = "".join(f"{0.1 * k:.1f},{1 - 0.03 * k + 0.001 * (k % 3):.4f}\n" for k in range(40))
    (tmp_path / "rest.csv").write_text("t_s,z_m\n" + rows)
    refused(path, "rest.csv", "z_m", "at rest")


def test_copies_are_refused_even_rotated(tmp_path):
    times = np.arange(12) * 0.1
    seen = np.column_stack([times, np.sin(times), -(times**2)])
    for name, table in (("a.csv", seen), ("b.csv", seen[:, [1, 0, 2]] * [1, -1, 1] + 3)):
        rows = "".join(f"{t:.2f},{x!r},{y!r},{z!r}\n" for t, (x, y, z) in zip(times, table.tolist(), strict=True))
        (tmp_path / name).write_text("t_s,x_m,y_m,z_m\n" + rows)
    path = tmp_path / "e.toml"
    path.write_text(TOML + '[[trial]]\nfile = "a.csv"\n[[trial]]\nfile = "b.csv"\n')
    refused(path, "b.csv", "rotated copy", "a.csv")
    path.write_text(TOML + '[[trial]]\nfile = "a.csv"\n[[trial]]\nfile = "a.csv"\n')
    refused(path, "duplicate trial")


def test_oddities_are_told_not_dropped(tmp_path):
    times = [0, 0.1, 0.2, 0.3, 0.4, 0.9, 1.0, 1.1, 1.2, 1.3]
    lines = "".join(f"{t},{'' if k == 3 else 5 - 0.05 * k}\n" for k, t in enumerate(times))
    measurement = read_measurement(experiment(tmp_path, "t_s,z_m\n" + lines))
    notes = " ".join(measurement.notes)
    assert "gaps" in notes and "1 of 10 samples missing" in notes


def test_overrides_of_a_trial(tmp_path):
    file = read_experiment_file(experiment(tmp_path, trial='file = "a.csv"\nmass = 0.2\nradius = 0.05\ngravity = 9.8\n'))
    assert file.trials[0].body.mass == 0.2 and file.trials[0].surroundings.gravity == 9.8 and file.body.mass == 0.05


@pytest.mark.parametrize(
    ("csv", "words"),
    [
        ('t_s,z_m\n0,1\n0.1,"1\n0.2,1\n', ("row 3", "quote", "not closed")),
        ("t_s,z_m\n0,1\n0.1," + "9" * 400 + "\n", ("row 3", "z_m", "not finite")),
        ("t_s,z_m\n0,1\n0.1," + "9" * 20_000 + "\n", ("row 3", "20,004 characters")),
        ("t_s,z_m" + ",x" * 3000 + "\n0,1\n", ("row 1", "unknown column 'x'")),
        ("t_s,z_m\n0,1\n0.1,\x1b[31m1\n", ("row 3", r"'\x1b[31m1' is not a number")),
        ("\x1b[2Jt_s,z_m\n0,1\n", ("row 1", r"\x1b[2Jt_s")),
        ("t_s,z_m\n" + "0,1\n" * 200_001, ("200,002 lines", "200,000 rows")),
    ],
)
def test_what_is_no_table_is_refused_in_one_printable_line(tmp_path, csv, words):
    with pytest.raises(InputError) as problem:
        read_measurement(experiment(tmp_path, csv=csv))
    message = str(problem.value)
    assert message.isprintable() and len(message) < 500 + len(str(tmp_path))
    for word in words:
        assert word in message, message


def test_lines_may_end_in_any_way_and_rows_are_lines_of_the_file(tmp_path):
    rows = ["# from the tracker", "t_s, z_m", "", '0,"1"', "0.1 , 1.1", "0.2,", ",", "0.3,0.9", "0.4,0.8"]
    found = []
    for end in ("\n", "\r\n", "\r"):
        (tmp_path / "a.csv").write_bytes(end.join(rows).encode())
        found.append(read_recording(tmp_path / "a.csv"))
    for times, position, _, places in found:
        assert times.tolist() == [0, 0.1, 0.2, 0.3, 0.4] and places.tolist() == [4, 5, 6, 8, 9]
        assert np.array_equal(position[:, 2], [1, 1.1, np.nan, 0.9, 0.8], equal_nan=True)


def test_an_experiment_holds_so_many_rows_in_all(tmp_path, monkeypatch):
    monkeypatch.setattr("hlcs.data.measurement.MOST_ROWS", 15)
    (tmp_path / "b.csv").write_text("t_s,z_m\n" + "".join(f"{0.1 * k:.1f},{1.1 - 0.05 * k * k:.4f}\n" for k in range(8)))
    refused(experiment(tmp_path, trial='file = "a.csv"\n[[trial]]\nfile = "b.csv"\n'), "more than 15 rows", "b.csv")


def test_a_search_keeps_every_kth_row_and_what_happens_fast(tmp_path, monkeypatch):
    """A bounce at 0.5 s: of 120 rows every sixth stays, all of the beginning, and all around the blow that the samples show."""
    monkeypatch.setattr("hlcs.kinds.trajectories.thinning.MOST_SEARCHED", 20)
    times = np.arange(120) / 120
    height = 0.03 + np.where(times < 0.5, 4.905 * (0.25 - times**2), 4.905 * (times - 0.5) * (1.5 - times) / 2)
    rows = "".join(f"{t:.6f},{z:.6f}\n" for t, z in zip(times, height, strict=True))
    toml = FLOOR.replace("position = 0.01", "position = 0.0001")
    measurement = read_measurement(experiment(tmp_path, csv="t_s,z_m\n" + rows, toml=toml))
    assert thinned(measurement, estimate_noise(measurement)).trials[0].rows.tolist() == sorted(
        {*range(2, 14), *range(2, 122, 6), *range(2 + 54, 2 + 66), 121}
    )
    monkeypatch.setattr("hlcs.kinds.trajectories.thinning.MOST_SEARCHED", 120)
    assert thinned(measurement, estimate_noise(measurement)) is measurement


def test_what_thinning_hides_is_judged_on_all_rows(tmp_path, monkeypatch, generator):
    """Of every tenth row an oscillation of one turn in ten rows is a constant, which the start absorbs; all rows show it."""
    times = np.arange(3000) / 1000
    values = 1.0 + 0.05 * times + 0.001 * np.sin(2 * np.pi * 100 * times + 0.7) + 0.001 * generator.standard_normal(3000)
    path = experiment(
        tmp_path,
        csv="t_s,z_m\n" + "".join(f"{t:.4f},{z:.7f}\n" for t, z in zip(times, values, strict=True)),
        toml=TOML.replace("position = 0.01", "position = 0.001") + "[surroundings]\ngravity = 0.0\n",
    )
    monkeypatch.setattr("hlcs.kinds.trajectories.thinning.MOST_SEARCHED", 300)
    measurement = read_measurement(path)
    prepared = prepare(thinned(measurement, estimate_noise(measurement)))
    few, _ = judge(prepared.problem, prepared.base)
    problem, fit = on_all_rows(measurement)(prepared.problem, prepared.base)
    every, _ = judge(problem, fit)
    assert few.adequate and not every.adequate and fit.count == 3000
    assert hlcs.diagnose(path, candidates=["linear_drag"]).verdict == "unexplained"


def test_long_rolling_is_computed_in_long_steps_and_bouncing_is_not(tmp_path, monkeypatch, generator):
    """A rolling ball moves uniformly whatever the step: chi2 is that of noise, 1 within five of its standard deviations.

    A ball that bounces does not stand still in long steps: what comes out is what came out without trying them.
    """
    toml = FLOOR.replace("position = 0.01", "position = 0.001")
    times = np.arange(0, 8, 1 / 60)
    table = np.column_stack([0.4 * times, 0.03 + 0 * times]) + 0.001 * generator.standard_normal((len(times), 2))
    rows = "".join(f"{t:.6f},{x:.6f},0,{z:.6f}\n" for t, (x, z) in zip(times, table, strict=True))
    measurement = read_measurement(experiment(tmp_path, csv="t_s,x_m,y_m,z_m\n" + rows, toml=toml))
    monkeypatch.setattr("hlcs.kinds.trajectories.preparation.LONG", 500)
    prepared = prepare(measurement)
    assert any("motion of 7.98 s is computed in steps" in note for note in prepared.notes)
    there = np.concatenate([prepared.problem.recordings[0].channel == channel for channel in (0, 2)]).reshape(2, -1)
    assert all(abs(np.mean(prepared.base.linear.r[0][inside] ** 2) - 1) < 5 * np.sqrt(2 / len(times)) for inside in there)

    times = np.arange(120) / 60
    height = np.where(times < 0.5, 4.905 * (0.25 - times**2), 4.905 * (times - 0.5) * (1.5 - times) / 2) * (times < 1.5)
    rows = "".join(
        f"{t:.6f},{z + 0.03 + e:.6f}\n" for t, z, e in zip(times, height, 0.001 * generator.standard_normal(120), strict=True)
    )
    measurement = read_measurement(experiment(tmp_path, csv="t_s,z_m\n" + rows, toml=toml))
    monkeypatch.setattr("hlcs.kinds.trajectories.preparation.LONG", 100)
    with pytest.warns(InputWarning, match="does not stand still in longer ones"):
        tried = prepare(measurement)
    monkeypatch.setattr("hlcs.kinds.trajectories.preparation.LONG", 5000)
    assert tried.base.chi2 == prepare(measurement).base.chi2


def test_outcome_tables(tmp_path):
    path = tmp_path / "o.csv"
    path.write_text("height_m,fall_time_s\n1,0.45\n1,0.46\n2,0.64\n")
    table, notes = read_outcomes(path)
    assert table.outcome == "fall_time_s" and table.setting.tolist() == [0, 0, 1] and not notes
    path.write_text("height_m,fall_time_s\n1,0.45\n1,0.45\n2,0.64\n")
    assert "digit for digit" in read_outcomes(path)[1][0]
    path.write_text("height_m\n1\n1\n2\n")
    with pytest.raises(InputError, match="0 outcome columns"):
        read_outcomes(path)


@pytest.mark.parametrize(("rho", "white"), [(0.0, 0.0), (0.6, 0.0), (0.6, 0.1), (0.9, 0.9), (0.95, 0.4)])
@pytest.mark.parametrize("jitter", [0.0, 0.9])
def test_the_filter_is_the_cholesky_factor(generator, rho, white, jitter):
    """The lower factor of a covariance is unique, so the filter must give that of LAPACK: to rounding, times the condition."""
    times = np.arange(80) + jitter * generator.uniform(0, 1, 80)
    covariance = (1 - white) * np.power(max(rho, 1e-12), np.abs(times[:, None] - times))
    covariance[np.diag_indices(80)] = 1.0
    lower, values = np.linalg.cholesky(covariance), generator.standard_normal((80, 3))
    tolerance = 1e-15 * 80 * np.linalg.cond(covariance)
    filter = correlation(times, rho, white, 1.0)
    assert np.allclose(coloured(filter, np.eye(80)), lower, atol=1e-13)
    assert np.allclose(whitened(filter, values), np.linalg.solve(lower, values), atol=tolerance)
    assert np.isclose(2 * np.sum(np.log(filter.root)), np.linalg.slogdet(covariance)[1], rtol=1e-12, atol=1e-12)


def test_draws_of_noise_follow_its_covariance_to_the_last_bit():
    """L L^T is the covariance, exactly known numbers included; what changes it by rounding changes the draws by rounding.

    The tolerance is 1e-16 times the condition of the known part (about 1e4), and a factor of 100 for sums of some dozen terms.
    """
    covariance = np.array([[5.6e-4, 5.5e-5, -3.9e-6], [5.5e-5, 1.3e-3, 3.7e-3], [-3.9e-6, 3.7e-3, 9.0e-2]])
    for known in ([], [0], [2], [0, 1, 2]):
        matrix = covariance.copy()
        matrix[known], matrix[:, known] = 0.0, 0.0
        assert np.allclose(lower_factor(matrix) @ lower_factor(matrix).T, matrix, rtol=1e-12, atol=0)
    assert np.allclose(lower_factor(np.ones((3, 3))), np.eye(3)[:1].repeat(3, 0))  # numbers that say the same are drawn once
    channel, times = np.zeros(40, int), np.arange(40) / 60.0

    def draws(matrix):
        kind = Correlated(0.002, 0.5, 0.1, 900.0, matrix)
        noise = Noise(kind, None, 1 / 60, "stated")
        return noise.drawer([Recording(channel, np.arange(40), times, noise.chain(channel, times), ())])(0, 250)

    bits = covariance * (1 + 2.0**-52 * np.array([[1, -1, 1], [-1, -1, 1], [1, 1, 1]]))
    assert np.any(bits != covariance) and np.allclose(draws(bits), draws(covariance), rtol=0, atol=1e-10)


def test_draws_made_some_at_a_time_take_every_set_of_noise_parameters():
    """With noise as good as certain of its sigma save for one very uncertain log sigma, every column has a size of its own."""
    kind = Correlated(0.002, 0.0, 0.0, 900.0, np.diag([1.0, 0.0, 0.0]))
    noise, channel, times = Noise(kind, None, 1 / 60, "stated"), np.zeros(4000, int), np.arange(4000) / 60.0
    draw = noise.drawer([Recording(channel, np.arange(4000), times, noise.chain(channel, times), ())])
    sizes = np.concatenate([draw(0, 50) for _ in range(8)], axis=1).std(axis=0)
    first, again = sizes.reshape(2, 200)
    assert len(np.unique(np.round(first, 3))) > 150
    assert np.allclose(first, again, rtol=0.1)  # the scatter of a standard deviation of 4,000 numbers is 1.1 %


def test_whitening_undoes_the_correlation(generator):
    """Covariance of whitened AR(1) noise is the identity: checked by algebra, L^-1 C L^-T = 1 to rounding."""
    times = np.cumsum(generator.uniform(0.5, 1.5, 30))
    links = chain(np.zeros(30, int), times, np.full(30, 0.2), {0: (0.7, 0.1)}, 1.0)
    covariance = 0.04 * (0.9 * 0.7 ** np.abs(times[:, None] - times[None]) + 0.1 * np.eye(30))
    white = whiten(links, whiten(links, covariance).T)
    assert np.allclose(white, np.eye(30), atol=1e-10)
    values = generator.standard_normal(30)
    assert np.allclose(colour(links, whiten(links, values)), values, atol=1e-10)


def test_a_coordinate_set_to_zero_tells_nothing_of_the_noise(tmp_path):
    """Eight throws in a plane, sigma stated, y written as zero: rho of x and z, 0.6 within three standard errors of 0.04."""
    text = TOML.replace("0.01", "0.003")
    generator, times = np.random.default_rng(4), np.arange(60) / 60
    for k in range(8):
        seen = flight(np.zeros(3), np.array([3.0, 0.0, 4.0]), times) + correlated(generator, (60, 3), 0.003, 0.6) * [1, 0, 1]
        (tmp_path / f"throw_{k}.csv").write_text(recording(times, seen))
        text += f'[[trial]]\nfile = "throw_{k}.csv"\n'
    (tmp_path / "throws.toml").write_text(text)
    noise = estimate_noise(read_measurement(read_experiment_file(tmp_path / "throws.toml")))
    assert noise.position == 0.003 and noise.rho == pytest.approx(0.6, abs=0.12)


@pytest.mark.parametrize("rho", [0.0, 0.6, 0.8])
def test_noise_is_estimated_without_bias_from_the_fitted_curve(generator, rho):
    """54 pieces of 30 samples, each with six fitted numbers: sigma and rho within four standard errors of the truth."""
    series = []
    for _ in range(54):
        noise = generator.standard_normal(30)
        for k in range(1, 30):
            noise[k] = rho * noise[k - 1] + np.sqrt(1 - rho**2) * noise[k]
        series.append((np.arange(30.0), noise, polynomials(np.arange(30.0), 5)))
    found = fit_noise(series, 1.0, white=0.0)
    assert abs(found.rho - rho) < max(4 * np.sqrt(found.covariance[1, 1]), 0.05)
    assert abs(np.log(found.sigma)) < 4 * np.sqrt(found.covariance[0, 0])


def test_an_isolated_outlier_is_found_and_smooth_misfit_is_not(generator):
    values = np.sin(np.linspace(0, 3, 60)) * 50 + generator.standard_normal(60)
    assert not isolated_outliers(values).any()
    values[20] += 15
    assert np.flatnonzero(isolated_outliers(values)).tolist() == [20]


@pytest.mark.parametrize("clock, advice", [("frames", "frame numbers"), ("milliseconds", "milliseconds")])
def test_times_that_are_not_seconds_are_refused(tmp_path, clock, advice):
    """A drop of 2 m lasts 0.64 s; told in frames of a 60 Hz camera or in milliseconds it would hang in the air for minutes."""
    seconds = np.arange(0, 0.6, 1 / 60)
    told = np.arange(len(seconds)) if clock == "frames" else 1000.5 * seconds
    lines = [f"{t:g},{2.0 - 0.5 * 9.81 * s * s:.4f}" for t, s in zip(told, seconds, strict=True)]
    refused(experiment(tmp_path, "t_s,z_m\n" + "\n".join(lines) + "\n"), "a.csv, column t_s:", "in the air", advice)


def test_a_number_with_an_underscore_is_not_another_number(tmp_path):
    """Python reads 0_95 as 95; a whole file of them would be one of another unit."""
    rows = "".join(f"{0.1 * k:.1f},{1 - 0.05 * k * k:.4f}\n" for k in range(8))
    refused(experiment(tmp_path, csv="t_s,z_m\n" + rows.replace("0.95", "0_95")), "row 3", "column z_m", "0_95")


@pytest.mark.parametrize(
    ("columns", "values", "words"),
    [
        ("gravity_m_s2", -9.81, ("column gravity_m_s2", "between 0 and 300")),
        ("gravity_m_s2", 0, ("gravity is 0", "9.81")),
        ("restitution", 5, ("column restitution", "between 0 and 1")),
        ("friction", 31, ("column friction", "between 0 and 10")),
        ("fluid_viscosity_pa_s", 1e300, ("fluid_viscosity_pa_s",)),
        ("spin_rad_s", 1e12, ("spin_rad_s",)),
        ("slope", 20, ("column slope", "rise over run")),
        ("mass_kg", 1200, ("density", "units are kg and m")),
    ],
)
def test_an_input_of_a_table_has_the_bounds_of_the_file(tmp_path, columns, values, words):
    """The third row of the file is the wrong one: a comment stands above the header."""
    rows = "".join(f"{values},{fall}\n" for fall in ("1,0.45", "1,0.452", "2,0.64"))
    (tmp_path / "o.csv").write_text(f"# drops\n{columns},height_m,fall_time_s\n{rows}")
    (tmp_path / "o.toml").write_text(
        'kind = "outcomes"\n[body]\nshape = "sphere"\nradius = 0.05\nmass = 1.2\n[measurement]\nnoise = 0.003\nfile = "o.csv"\n'
    )
    with pytest.raises(InputError) as problem:
        hlcs.compare(tmp_path / "o.toml")
    for word in (*words, "o.csv, row 3"):
        assert word in str(problem.value)


def test_a_noise_in_millimetres_is_told(tmp_path):
    with pytest.warns(InputWarning, match=r"measurement.noise.position: 2 m is hardly meant.*not in mm"):
        read_experiment_file(experiment(tmp_path, toml=TOML.replace("0.01", "2")))
