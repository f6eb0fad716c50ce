"""Units, axes, floors, clocks, copies: what no body does is refused, what is odd is told."""

import warnings

import numpy as np
import pytest
from experiments import FLOOR, TOML, experiment, measured, refused
from throws import write_throws

import hlcs
from hlcs.data.validation import extent_of_box
from minibullet import rotations
from minibullet.errors import InputError, InputWarning


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
    notes = measured(experiment(tmp_path, csv="t_s,z_m\n" + rows, toml=FLOOR)).notes
    assert any("positions are of the centre" in note for note in notes)


def test_a_camera_that_leans_shows_a_slide_below_its_floor(tmp_path):
    """By 5 degrees: half a metre away the floor seems 4 cm lower. That is an error to be found, not one to be refused."""
    rows = "".join(f"{0.02 * k:.2f},{0.02 * k:.4f},{0.03 - 0.09 * 0.02 * k:.4f}\n" for k in range(60))
    notes = measured(experiment(tmp_path, csv="t_s,x_m,z_m\n" + rows, toml=FLOOR)).notes
    assert any("check floor.height" in note for note in notes)


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
            assert measured(path).trials
    # where the stated start agrees with what stands there, the box is on its edge indeed, and seen too low
    start = f"start = {{ orientation = [0.0, 0.0, {d:.6f}, {c:.6f}] }}"
    trial = f'file = "a.csv"\n{start}\n'
    assert measured(experiment(tmp_path, csv="t_s,x_m,y_m,z_m,qw,qx,qy,qz\n" + rows, toml=toml, trial=trial)).trials


def test_a_box_that_keeps_its_depth_in_the_floor_while_it_turns_has_its_scalar_first(tmp_path):
    """A box topples by 60 degrees about an edge, its floor stated 3 cm too high: with the scalar last it would hang above it."""
    toml = FLOOR.replace('"sphere"', '"box"').replace("radius = 0.03", "size = [0.15, 0.1, 0.3]")
    half, none = np.radians(np.linspace(5.0, 65.0, 40)) / 2, np.zeros(40)
    topples = np.column_stack([np.cos(half), none, np.sin(half), none])
    falls = rotations.product(topples, np.tile([np.cos(0.75), 0.0, 0.0, np.sin(0.75)], (40, 1)))
    heights = extent_of_box(falls, (0.15, 0.1, 0.3), (0.0, 0.0, 1.0)) - 0.03
    table = np.column_stack([0.01 * np.arange(40), 0.001 * np.arange(40), none, heights, falls])
    rows = "".join(",".join(f"{value:.6f}" for value in row) + "\n" for row in table)
    assert measured(experiment(tmp_path, csv="t_s,x_m,y_m,z_m,qw,qx,qy,qz\n" + rows, toml=toml)).trials


def test_a_static_recording_that_drifts_is_refused(tmp_path):
    path = experiment(tmp_path, toml=TOML.replace("noise = { position = 0.01 }", 'static = "rest.csv"'))
    rows = "".join(f"{0.1 * k:.1f},{1 - 0.03 * k + 0.001 * (k % 3):.4f}\n" for k in range(40))
    (tmp_path / "rest.csv").write_text("t_s,z_m\n" + rows)
    refused(path, "rest.csv", "z_m", "at rest")


def test_a_static_recording_that_drifts_by_a_few_times_its_scatter_is_told(tmp_path):
    """12 mm of drift, 6 mm from half to half, three times a scatter of 2 mm, which the noise read from it would hold."""
    path = experiment(tmp_path, toml=TOML.replace("noise = { position = 0.01 }", 'static = "rest.csv"'))
    heights = 1.0 + 0.0003 * np.arange(40) + 0.002 * (-1.0) ** np.arange(40)
    (tmp_path / "rest.csv").write_text("t_s,z_m\n" + "".join(f"{k / 10:.1f},{z:.4f}\n" for k, z in enumerate(heights)))
    with pytest.warns(InputWarning, match="rest.csv', column z_m: drifts by 0.006 m, 3 times its scatter"):
        measured(path)


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
    measurement = measured(experiment(tmp_path, "t_s,z_m\n" + lines))
    notes = " ".join(measurement.notes)
    assert "1 gap, 0.5 s at t_s = 0.4" in notes and "1 of 10 samples missing" in notes


@pytest.mark.parametrize(
    "told, advice",
    [
        (
            lambda seconds: np.round(60 * seconds),
            "these look like frame numbers, divide them by the frame rate (about 60 a second",
        ),
        (lambda seconds: np.round(60 * seconds) // 2 * 2, "by the fall about 60 of them are one second; divide frame numbers"),
        (lambda seconds: 1000.5 * seconds, "these look like milliseconds, divide them by 1000"),
        (lambda seconds: np.round(1000 * seconds), "these look like milliseconds, divide them by 1000"),
        (lambda seconds: 100000 + np.round(1000 * seconds), "these look like milliseconds, divide them by 1000"),
        (lambda seconds: 1e6 * seconds, "by the fall about 1e+06 of them are one second"),
    ],
)
def test_times_that_are_not_seconds_are_refused_by_what_they_look_like(tmp_path, told, advice):
    """A drop of 2 m lasts 0.64 s; in pictures, every second one of them, ms or us it would hang in the air for minutes. Counts go
    up by one; of what is not counted gravity tells: g/n^2 where n units are a second."""
    seconds = np.arange(0, 0.6, 1 / 60)
    told = told(seconds)
    kept = np.r_[True, np.diff(told) > 0]
    told, seconds = told[kept], seconds[kept]
    lines = [f"{t:.10g},{2.0 - 0.5 * 9.81 * s * s:.4f}" for t, s in zip(told, seconds, strict=True)]
    refused(experiment(tmp_path, "t_s,z_m\n" + "\n".join(lines) + "\n"), "a.csv, column t_s:", "in the air", advice)


@pytest.mark.parametrize("unit_of_time, advice", [(60, "frame numbers"), (1000 / 7, "milliseconds")])
def test_throws_whose_times_are_not_seconds_are_refused(tmp_path, unit_of_time, advice):
    path = write_throws(tmp_path, static=False, noise="noise = { position = 0.004 }")
    for file in tmp_path.glob("throw_*.csv"):
        rows = [line.split(",", 1) for line in file.read_text().splitlines()]
        file.write_text("\n".join([",".join(rows[0]), *(f"{float(t) * unit_of_time:.3f},{rest}" for t, rest in rows[1:])]) + "\n")
    with pytest.raises(InputError, match=f"throw_0.csv, column t_s: .*{advice}"):
        hlcs.compare(path)


@pytest.mark.parametrize(("toml", "moves", "warned"), [(TOML, 0.0, True), (TOML, 1e-3, False), (FLOOR, 0.0, False)])
def test_a_body_at_which_nothing_moves_is_warned_of_in_the_air_alone(tmp_path, recwarn, toml, moves, warned):
    rows = "".join(f"{0.02 * k:.2f},{1.0 + moves * (k % 2)}\n" for k in range(12))
    measured(experiment(tmp_path, "t_s,z_m\n" + rows, toml))
    assert any("no position changes in 12 samples" in str(one.message) for one in recwarn) == warned


@pytest.mark.parametrize(("factor", "words"), [(100.0, "these look like centimetres"), (1 / 0.3048, "are these in feet")])
def test_units_of_a_short_recording_above_a_floor_are_checked(tmp_path, factor, words):
    """14 pictures of a fall of a metre: too few for segments between impacts, and no impact makes a fall faster."""
    times = np.arange(14) / 30
    rows = "".join(f"{t:.6f},{factor * (1.02 - 4.905 * t**2):.5f}\n" for t in times)
    toml = 'kind = "trajectory"\n[body]\nshape = "sphere"\nradius = 0.02\nmass = 0.05\n'
    toml += "[surroundings]\nfloor = { height = 0.0 }\n[measurement]\nnoise = { position = 0.001 }\n"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises((InputError, InputWarning), match=words):
            measured(experiment(tmp_path, "t_s,z_m\n" + rows, toml))


@pytest.mark.parametrize(("step", "words"), [(1.0, "these look like frame numbers"), (1000 / 60, "milliseconds by 1000")])
def test_times_of_a_cart_that_are_not_seconds_are_questioned(step, words):
    """Nothing falls, so that gravity tells no clock; nobody films a cart once a second."""
    times = np.arange(20) * step
    cart, ball = {"t_s": times, "x_m": 0.5 * np.arange(20) / 60}, {"shape": "sphere"}
    with pytest.warns(InputWarning, match=words):
        hlcs.compare(hlcs.Experiment.from_frames(cart, body=ball, measurement={"planar": True}, noise={"position": 0.01}))


def test_few_samples_of_a_body_at_rest_on_its_floor_are_no_fall(tmp_path, generator):
    """Five readings a 240th of a second apart, off by 3 mm: a parabola through them bends by a hundred m/s2."""
    ball = {"shape": "sphere", "radius": 0.03, "mass": 0.05}
    for _ in range(100):
        rest = {"t_s": np.arange(5) / 240, "z_m": 0.03 + 0.003 * generator.standard_normal(5)}
        floor = {"floor": {"height": 0.0}}
        measured(
            hlcs.Experiment.from_frames(rest, body=ball, surroundings=floor, noise={"position": 0.003})
            .save(tmp_path / "e.toml")
            .file.path
        )


def test_a_floor_is_checked_wherever_the_zero_of_the_positions_lies(tmp_path):
    rows = "".join(f"{0.02 * k:.2f},{6 + 0.02 * k:.4f},-0.9700\n" for k in range(40))
    refused(experiment(tmp_path, csv="t_s,x_m,z_m\n" + rows, toml=FLOOR), "below its floor")
