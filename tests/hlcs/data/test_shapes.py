"""Discs, cylinders, cones, and bodies of which only the area that a drag meets is known."""

import numpy as np
import pytest
from experiments import TOML, experiment, refused

import hlcs
from hlcs.data.experiment_file import Body, read_experiment_file
from hlcs.data.rigid_body import rigid_body

R, H, M = 0.1, 0.3, 2.0
# volume, surface, and inertia across and along the axis about the centre of mass, of uniform solids
SOLIDS = {
    "disc": (np.pi * R**2 * H, 2 * np.pi * R * (R + H), M * (3 * R**2 + H**2) / 12, M * R**2 / 2),
    "cylinder": (np.pi * R**2 * H, 2 * np.pi * R * (R + H), M * (3 * R**2 + H**2) / 12, M * R**2 / 2),
    "cone": (np.pi * R**2 * H / 3, np.pi * R * (R + np.hypot(R, H)), M * (3 * R**2 / 20 + 3 * H**2 / 80), 3 * M * R**2 / 10),
}


@pytest.mark.parametrize("shape", SOLIDS)
def test_a_solid_has_the_volume_area_and_inertia_of_its_formula(shape):
    """To what a base of 32 sides makes of a circle: 0 of a cylinder, 0.5 % of the round part of a cone."""
    volume, surface, across, along = SOLIDS[shape]
    body = rigid_body(Body(shape=shape, radius=R, height=H, mass=M))
    assert body.volume == pytest.approx(volume, rel=1e-9) and body.area == pytest.approx(surface / 4, rel=5e-3)
    assert body.inertia == pytest.approx((across, across, along), rel=5e-3)
    np.testing.assert_allclose(body.shape.centre_of_mass, 0.0, atol=1e-12)


def test_a_drag_area_takes_the_place_of_that_of_the_shape():
    body = rigid_body(Body(radius=R, mass=M, drag_area=0.2))
    assert body.area == 0.2 and body.shape.surface_area / 4 == 0.2 and body.volume == pytest.approx(4 / 3 * np.pi * R**3)


def falls(per_metre, scatter=0.002):
    """Times of a body let go, v' = g - k v^2, five repeats at each height."""
    heights = np.repeat(np.linspace(0.5, 2.5, 6), 5)
    times = np.arccosh(np.exp(per_metre * heights)) / np.sqrt(9.81 * per_metre)
    return {"height_m": heights, "fall_time_s": times + scatter * np.random.default_rng(6).standard_normal(len(heights))}


@pytest.mark.parametrize(
    ("body", "area", "number"),
    [
        ({"shape": "disc", "radius": 0.1, "height": 0.002, "mass": 0.02}, (2 * np.pi * 0.1 * 0.102) / 4, "drag_coefficient"),
        ({"mass": 0.001, "drag_area": 0.03}, 0.03, "drag_coefficient"),  # a coffee filter
        ({"shape": "cone", "radius": 0.1, "height": 0.05}, None, "drag_per_metre"),  # of unknown mass
    ],
)
def test_the_drag_of_a_light_body_is_found_by_the_number_that_is_known(body, area, number):
    """C = 0.8 on its area: from 0.3 to 14 1/m, each told to a fraction of a per cent by times to 2 ms."""
    truth = 0.8 if area else 14.0
    per_metre = 0.5 * 1.2 * 0.8 * area / body["mass"] if area else truth
    measured = hlcs.Experiment.from_frames(falls(per_metre), body, {"fluid_density": 1.2}, kind="outcomes")
    found = hlcs.diagnose(measured, candidates=["quadratic_drag", "linear_drag", "clock_offset"])
    assert found.effects == ("quadratic_drag",) and found.verdict == "effect"
    (numbers,) = [{name: entry} for name, entry in found.parameters["quadratic_drag"].items()]
    assert list(numbers) == [number] and numbers[number]["value"] == pytest.approx(truth, rel=0.02)
    assert not any("beyond" in note for note in found.notes)


def test_sizes_belong_to_their_shapes(tmp_path):
    body = TOML.replace("radius = 0.03", "height = 0.03")
    refused(experiment(tmp_path, toml=body), "line 4: body.height", '"disc", "cylinder" or "cone", but the shape is "sphere"')
    body = TOML.replace('"sphere"', '"cone"').replace("radius = 0.03", "radius = 0.3\nheight = -1.0")
    refused(experiment(tmp_path, toml=body), "line 5: body.height: must be between 1e-06 and 1000, got -1")
    refused(experiment(tmp_path, toml=TOML.replace("mass", "drag_area = 0\nmass")), "body.drag_area: must be greater than 0")
    heavy = TOML.replace('"sphere"', '"disc"').replace("mass = 0.05", "height = 0.001\nmass = 500")
    refused(experiment(tmp_path, toml=heavy), "mass and size give a density of 1.77e+08 kg/m3, which no body has")
    assert read_experiment_file(experiment(tmp_path, toml=TOML.replace("mass", "drag_area = 0.01\nmass"))).body.drag_area == 0.01
