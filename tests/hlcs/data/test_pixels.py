"""Recordings in pixels: their length stated, stated as uncertain, or not at all."""

import numpy as np
from experiments import TOML, experiment, refused

import hlcs

OTHERS = ("length_scale", "linear_drag", "tilted_gravity")
G, PIXEL = 9.81, 0.002
BALL = {"shape": "sphere", "radius": 0.03, "mass": 0.5}  # so heavy that air takes 0.1 % of its fall


def drops(scale=1.0, seed=1):
    """Frames of four drops of 2 m in pixels of 2 mm times `scale`, read to half a pixel."""
    draw, times, frames = np.random.default_rng(seed), np.arange(0.0, 0.63, 1 / 60), []
    for speed in (0.0, 0.5, 1.0, 1.5):
        heights = (2.0 - speed * times - G * times**2 / 2) / (PIXEL * scale)
        frames.append({"t_s": times, "z_px": heights + 0.5 * draw.standard_normal(len(times))})
    return frames


def told(scale, candidates=(*OTHERS, "time_scale"), **measurement):
    trials = [{"group": str(index % 2)} for index in range(4)]
    measured = hlcs.Experiment.from_frames(
        drops(scale),
        BALL,
        {"fluid_density": 0.0},
        noise={"position": 0.5 * PIXEL},
        trials=trials,
        measurement={"metres_per_pixel": PIXEL, **measurement},
    )
    return hlcs.diagnose(measured, candidates=candidates)


def test_pixels_of_the_stated_length_miss_nothing():
    assert told(1.0).verdict == "complete" and told(1.0, metres_per_pixel_sd=0.02 * PIXEL).verdict == "complete"


def test_an_uncertain_length_is_fitted_within_its_error():
    """Pixels 0.7 % longer than stated to 1 %."""
    found = told(1.007, candidates=OTHERS, metres_per_pixel_sd=0.01 * PIXEL)
    assert (found.verdict, found.effects) == ("effect", ("length_scale",))
    number = found.parameters["length_scale"]["factor"]
    assert number["low"] < 1 / 1.007 < number["high"] and number["high"] - number["low"] < 0.01


def test_what_is_stated_as_uncertain_is_plausible_within_twice_its_error():
    """Pixels 15 % longer than stated: beyond the tenth by which a ruler misleads, not beyond what a stated 10 % may be off by."""
    for error, doubted in ((0.10, False), (0.05, True)):
        found = told(1.15, candidates=("length_scale",), metres_per_pixel_sd=error * PIXEL)
        assert found.effects == ("length_scale",)
        assert ("beyond" in found.parameters["length_scale"]["factor"]) == doubted


def test_what_is_stated_as_uncertain_is_blamed_before_a_clock_that_does_the_same():
    """A clock slow by half as much does the same: with an error stated the scale is nine times as likely."""
    weights = [
        {tuple(entry["effects"]): entry["weight"] for entry in told(1.007, **stated).sets}
        for stated in ({}, {"metres_per_pixel_sd": 0.01 * PIXEL})
    ]
    assert 0.2 < weights[0]["length_scale",] < 0.8 and weights[1]["length_scale",] > 0.9


def test_a_length_that_cannot_be_is_refused_by_its_place(tmp_path):
    rows = "".join(f"{0.1 * k:.1f},{500 - 25 * k * k}\n" for k in range(8))
    path = experiment(tmp_path, csv="t_s,z_px\n" + rows)
    refused(path, "a.csv, row 1: column 'z_px': how long is a pixel? Write metres_per_pixel = 0.002 [m] under [measurement]")

    def stated(text):
        return experiment(tmp_path, csv="t_s,z_px\n" + rows, toml=TOML + text)

    refused(stated("metres_per_pixel = 0.0\n"), "line 8: measurement.metres_per_pixel: must be greater than 0, got 0")
    refused(stated("metres_per_pixel_sd = 0.1\n"), "measurement.metres_per_pixel_sd: the error of what?")
    both = "metres_per_pixel = 0.002\nmetres_per_pixel_sd = 0.002\n"
    refused(
        stated(both), "line 9: measurement.metres_per_pixel_sd: 0.002 m beside pixels of 0.002 m: measure a ruler in the view"
    )
    metres = experiment(tmp_path, csv="t_s,z_m\n" + rows, toml=TOML + "metres_per_pixel = 0.002\n")
    refused(
        metres, "a.csv, row 1: column 'z_m' is in metres", "call it 'z_px' where it is in pixels, or leave metres_per_pixel out"
    )
    two = experiment(tmp_path, csv="t_s,z_m,z_px\n" + rows.replace("\n", ",1\n"), toml=TOML + "metres_per_pixel = 0.002\n")
    refused(two, "column 'z_px' beside 'z_m'; keep one of them")
