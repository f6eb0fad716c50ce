"""A finished placement test looked at again: how a layer fell, and where its plates lay."""

from typing import NamedTuple

import numpy as np

import minibullet as mb
from hlcs.placement import plate_readings


class Fall(NamedTuple):
    """How one layer fell."""

    layer: int
    times: np.ndarray  # (f,) since it was let go [s], the last one at rest
    poses: np.ndarray  # (f, n, 7) positions [m] and orientations of its units
    result: object  # the PlacementResult


def record_fall(test, layer, every=0.05, most=41):
    """Run a PlacementTest up to `layer` and keep the poses of its units as they fall: a `Fall`.

    every: time between two frames [s]; most: frames at most, the last of which is where the units came to rest.
    """
    count, frames, steps = test.grid.units(test.rows, test.columns, layer), [], 0
    stride = max(1, round(every / test.time_step))

    def watch(number, world):
        nonlocal steps
        if number != layer:
            return
        if steps % stride == 0 and len(frames) < most - 1:
            units = world.bodies[-count:]  # the layer was added last
            frames.append((steps * test.time_step, [[*unit.position, *unit.orientation] for unit in units]))
        steps += 1

    result = test.run(watch=watch)
    times, poses = zip(*frames, (steps * test.time_step, result.poses[layer - 1]), strict=True)
    return Fall(layer, np.array(times), np.array(poses), result)


def lay_plates(result, layer):
    """The plates on a layer (numbered from 1) of a PlacementResult, laid again: `plate_readings.Readings`.

    The heights are those of the result, as long as every unit of the layer had come to rest; the poses are not stored with it.
    """
    test, dn = result.test, result.test.unit.nominal_diameter
    world, built = mb.World([], test.settings), []
    for number, poses in enumerate(result.poses[:layer], start=1):
        built.append(
            [
                world.add(
                    test.unit.shape(test.shape), density=test.density, position=pose[:3], orientation=pose[3:], fixed=True,
                    margin=test.settings.margin, name=f"{number}.{unit}",
                )
                for unit, pose in enumerate(poses, start=1)
            ]
        )  # fmt: skip
    standing = [unit for unit, inside in zip(built[-1], result.in_layer[layer - 1], strict=True) if inside]
    places = test.plate_places(layer, result.aims[layer - 1])
    return plate_readings.read_plates(built, standing, test.bed, places, dn, test.settings, test.plate_margin * dn)
