"""Direct readings: how many standard deviations of one reading a suspect's numbers are."""

import numpy as np
import pytest

from hlcs.effects import classes
from hlcs.effects.measurement import ClockOffset, LengthScale
from hlcs.effects.witnesses import OF_LAYERS, WITNESSES, Camera
from minibullet.effects import Buoyancy, TiltedGravity

CAMERA = Camera(sigma=0.002, step=0.01, extent=1.5)


@pytest.mark.parametrize(
    ("kind", "numbers", "size"),
    [
        (LengthScale, {"factor": 1.02}, 0.02 * 1.5 / 0.002),
        (ClockOffset, {"offset": 0.05}, 0.05 * np.sqrt(12) / 0.01),
        (TiltedGravity, {"angle_x": 0.03, "angle_y": 0.04}, 0.05 * 1.5 / 0.002),
        (Buoyancy, {"fluid_density": 1000.0}, 100.0),
        (Buoyancy, {"fluid_density": 1.0}, 20.0),
    ],
)
def test_a_reading_is_as_sharp_as_its_instrument(kind, numbers, size):
    assert WITNESSES[kind].size(numbers, CAMERA) == pytest.approx(size, rel=1e-12)


def test_witnesses_are_of_shipped_classes_and_say_what_to_do():
    assert set(WITNESSES) <= set(classes().values())
    assert WITNESSES[LengthScale].text.format(extent=1.5) == "hold a ruler of 1.5 m beside what is measured"
    assert all(text and text == text.strip() for text in OF_LAYERS.values())
