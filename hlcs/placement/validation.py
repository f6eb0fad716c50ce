"""Can a placement test be meant, and can it be computed?"""

import warnings
from math import sqrt

from hlcs.files.limits import MOST_STEPS, unlikely
from minibullet.errors import InputError, InputWarning

IN_DN = ("margin", "falling_distance", "plate_margin", "placement_scatter", "placement_offset_x", "placement_offset_y")
UNITS = dict.fromkeys((*IN_DN, "bottom_roughness"), "Dn") | {  # of the settings of a test that are no pure numbers
    "side": "m",
    "density": "kg/m3",
    "time_step": "s",
    "settle_time": "s",
    "vibration": "g",
    "set_back": "spacings",
}
MOST_UNITS = 100_000  # of a test: 1,500 units take a minute or more, so a day
MOST_FALL = 0.5  # of its size that a body may fall in a step: beyond that two can pass through each other unseen


def tell_unlikely(test):
    """Warn of settings of a PlacementTest that are hardly meant."""
    numbers = dict(vars(test))
    if not isinstance(test.armour, str):  # its side is a scale; what can be judged is how large the unit is
        numbers |= {"side": test.unit.side}
    for name, value in numbers.items():
        if said := unlikely(name, value):
            warnings.warn(f"placement: {name} = {said}", InputWarning, stacklevel=4)  # where the test is made


def check_effort(test):
    """InputError for a PlacementTest that would compute for weeks, or whose units fall through each other in one step."""
    steps = test.settle_time / test.time_step
    if steps > MOST_STEPS:
        raise InputError(
            f"placement: time_step = {test.time_step:g} s makes {steps:.3g} steps of a layer with settle_time = "
            f"{test.settle_time:g} s, at most {MOST_STEPS:.0e} are computed; take time_step >= "
            f"{test.settle_time / MOST_STEPS:.2g} s, or a shorter settle_time"
        )
    units = sum((test.rows - below) * (test.columns - below) for below in range(test.layers))
    if units > MOST_UNITS:
        raise InputError(
            f"placement: {test.rows} rows, {test.columns} columns and {test.layers} layers are {units} units; at "
            f"most {MOST_UNITS} are placed: take fewer"
        )
    size = test.unit.side
    speed = sqrt(2 * 9.81 * (test.falling_distance + 1) * size)  # after its fall, and down into a gap of its own size
    if speed * test.time_step > MOST_FALL * size:
        raise InputError(
            f"placement: a unit of side = {size:g} m falls by {speed * test.time_step:.2g} m in one time_step = "
            f"{test.time_step:g} s, more than half its size, and would pass through others; take time_step <= "
            f"{MOST_FALL * size / speed:.2g} s"
        )
