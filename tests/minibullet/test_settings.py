"""Settings refuse by field, value and rule; what is allowed goes through unchanged."""

import dataclasses

import numpy as np
import pytest

import minibullet as mb


@pytest.mark.parametrize(
    ("field", "value", "rule"),
    [
        ("time_step", 0.0, "> 0"),
        ("time_step", -1e-3, "> 0"),
        ("time_step", float("nan"), "> 0"),
        ("friction", -0.1, ">= 0"),
        ("friction", float("inf"), ">= 0"),
        ("friction", "0.5", ">= 0"),
        ("restitution", 1.1, "between 0 and 1"),
        ("restitution", -0.1, "between 0 and 1"),
        ("margin", -1e-3, ">= 0"),
        ("linear_damping", 1.5, "between 0 and 1"),
        ("angular_damping", -0.5, "between 0 and 1"),
        ("iterations", 0, "whole number >= 1"),
        ("iterations", 2.5, "whole number >= 1"),
        ("iterations", True, "whole number >= 1"),
        ("tolerance", 0.0, "> 0"),
        ("damping_law", "linear", "bullet, per_step"),
        ("solver", "magic", "exact, gauss_seidel, sequential_impulse"),
    ],
)
def test_unusable_numbers_are_refused_in_one_line(field, value, rule):
    """The message names the field, its value and the rule; zero time steps and zero iterations included."""
    with pytest.raises(mb.InputError) as refused:
        mb.Settings(**{field: value})
    message = str(refused.value)
    assert "\n" not in message and field in message and repr(value) in message and rule in message


def test_a_variant_is_a_replaced_value():
    """Frozen: a setting cannot change under a world; dataclasses.replace makes a checked variant."""
    settings = mb.Settings()
    with pytest.raises(dataclasses.FrozenInstanceError):
        settings.friction = 0.9
    assert dataclasses.replace(settings, friction=0.9).friction == 0.9
    with pytest.raises(mb.InputError):
        dataclasses.replace(settings, time_step=0.0)


def test_a_world_takes_only_settings():
    """A dict or a number in their place is refused by name."""
    with pytest.raises(mb.InputError, match="must be a Settings value"):
        mb.World(settings={"friction": 0.5})


def test_whole_numbers_are_numbers():
    """1 and 1.0 are one setting, and of one type: kernels would be compiled again for another."""
    given = mb.Settings(time_step=1, friction=np.float64(1), iterations=50.0)
    assert given == mb.Settings(time_step=1.0, friction=1.0, iterations=50)
    assert [type(getattr(given, name)) for name in ("time_step", "friction", "iterations")] == [float, float, int]
