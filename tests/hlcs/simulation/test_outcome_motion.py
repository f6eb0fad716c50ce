"""What tables of outcomes are compared with, against closed forms: falls, rebounds, slides and rest, as a user meets them."""

from math import atan, degrees

import numpy as np
import pytest

import hlcs

G = 9.81
SPEEDS, FRICTIONS, HEIGHTS = (0.5, 1.0, 3.0), (0.2, 0.5), (0.3, 1.0, 4.0)
PAIRS = [(v, mu) for v in SPEEDS for mu in FRICTIONS]
SLOPE = 0.1
COS, SIN = 1 / np.hypot(1, SLOPE), SLOPE / np.hypot(1, SLOPE)

TABLES = {  # columns of the inputs, rows with the outcome last
    "fall_time_s": ("height_m", [(h, np.sqrt(2 * h / G)) for h in HEIGHTS]),
    "fall_time_s elsewhere": ("height_m,gravity_m_s2", [(h, g, np.sqrt(2 * h / g)) for h in HEIGHTS for g in (1.62, 24.8)]),
    "rebound_height_m": ("height_m,restitution", [(h, e, e * e * h) for h in HEIGHTS for e in (0.3, 0.9)]),
    "rebound_height_m of a series": (
        "height_m,restitution,bounce",
        [(h, e, n, e ** (2 * n) * h) for h in HEIGHTS for e in (0.0, 0.3, 0.9) for n in (1, 2, 5)],
    ),
    "stop_distance_m": ("speed_m_s,friction", [(v, mu, v * v / (2 * mu * G)) for v, mu in PAIRS]),
    "stop_distance_m on a slope": (
        "speed_m_s,friction,angle_deg",
        [(v, mu, degrees(atan(SLOPE)), v * v / (2 * G * (mu * COS - SIN))) for v, mu in PAIRS],
    ),
    "slide_time_s to the stop": ("speed_m_s,friction", [(v, mu, v / (mu * G)) for v, mu in PAIRS]),
    "slide_time_s from rest": (
        "distance_m,friction,slope",
        [(d, mu, SLOPE, np.sqrt(2 * d / (G * (SIN - mu * COS)))) for d in (0.5, 2.0) for mu in (0.0, 0.02)],
    ),
    "slide_time_s of a ball that grips": (  # a solid one: from 2/7 of the slope on, 0.0286
        "distance_m,friction,slope",
        [(d, mu, SLOPE, np.sqrt(2 * d / (5 / 7 * G * SIN))) for d in (0.5, 2.0) for mu in (0.03, 0.07, 0.2)],
    ),
    "slide_time_s through a mark": (
        "distance_m,speed_m_s,friction",
        [(0.1, v, mu, (v - np.sqrt(v * v - 0.2 * mu * G)) / (mu * G)) for v, mu in PAIRS if v * v > 0.2 * mu * G],
    ),
    "range_m": (
        "speed_m_s,angle_deg,height_m",
        [
            (v, a, h, v * c / G * (v * s + np.sqrt((v * s) ** 2 + 2 * G * h)))
            for v, a, h in (
                (3.0, 0.0, 0.8),
                (5.0, 30.0, 0.0),
                (5.0, 60.0, 1.2),
                (20.0, 45.0, 0.0),
                (4.0, -20.0, 0.5),
                (5.0, 90.0, 1.0),
            )
            for c, s in ((np.cos(np.deg2rad(a)), np.sin(np.deg2rad(a))),)
        ],
    ),
    "range_m of a ball that rolls off a table": (
        "speed_m_s,height_m",
        [(v, h, v * np.sqrt(2 * h / G)) for v in SPEEDS for h in HEIGHTS],
    ),
    "range_m on level ground": (
        "speed_m_s,angle_deg",
        [(v, a, v * v * np.sin(np.deg2rad(2 * a)) / G) for v in SPEEDS for a in (15.0, 45.0)],
    ),
    "rest_height_m": ("radius_m", [(r, r) for r in (0.02, 0.1, 0.3)]),
}


@pytest.mark.parametrize("case", TABLES)
def test_outcomes_are_those_of_the_closed_form(case, tmp_path):
    """The file has 10 digits; slides are integrated in steps: a mark a hair before the stop is late by 7e-6 of the time."""
    columns, rows = TABLES[case]
    outcome = case.split(" ")[0]
    lines = [",".join(f"{x:.10g}" for x in row) + "\n" for row in rows]
    (tmp_path / "o.csv").write_text(f"{columns},{outcome}\n" + "".join(lines))
    (tmp_path / "e.toml").write_text(
        'kind = "outcomes"\n[body]\nshape = "sphere"\nradius = 0.05\nmass = 0.5\n'
        "[surroundings]\nfluid_density = 0.0\nfloor = { height = 0.0 }\n"
        '[measurement]\nfile = "o.csv"\nnoise = 0.001\n'
    )
    frame = hlcs.compare(tmp_path / "e.toml").to_dataframe()
    assert len(frame) == len(rows)
    np.testing.assert_allclose(frame["residual"], 0, atol=1e-5 * max(row[-1] for row in rows))


@pytest.mark.parametrize(
    ("body", "height"),
    [
        ('shape = "box"\nsize = [0.2, 0.3, 0.4]', 0.2),
        ('shape = "cubipod"\nside = 0.1', 0.075),
        ('shape = "mesh"\nmesh = "wedge.obj"', 0.05),
    ],
)
def test_a_body_rests_at_the_height_of_its_centre(body, height, tmp_path):
    """Half a box; half a cube and its protrusion of a quarter; a third of the height of a wedge 0.15 high."""
    (tmp_path / "wedge.obj").write_text(
        "".join(f"v {x} {y} {z}\n" for y in (0, 1) for x, z in ((0, 0), (0.2, 0), (0.1, 0.15)))
        + "f 1 2 3\nf 6 5 4\nf 1 4 5 2\nf 2 5 6 3\nf 3 6 4 1\n"
    )
    (tmp_path / "o.csv").write_text("mass_kg,rest_height_m\n" + f"1,{height}\n2,{height}\n3,{height}\n")
    (tmp_path / "e.toml").write_text(
        f'kind = "outcomes"\n[body]\n{body}\n[surroundings]\nfluid_density = 0.0\n'
        'floor = { height = 0.0 }\n[measurement]\nfile = "o.csv"\nnoise = 0.001\n'
    )
    np.testing.assert_allclose(hlcs.compare(tmp_path / "e.toml").to_dataframe()["residual"], 0, atol=1e-12)
