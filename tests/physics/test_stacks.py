"""Section 1.4, rest: a body at rest stays where it is, whatever stands on it and however long.

stack of 10   base force N m g, no drift      long rest   30 minutes      heavy on light   ratio up to 10^4
"""

import numpy as np
import pytest
import small_worlds as sw

import minibullet as mb


@pytest.mark.slow
def test_case_26_stack_of_ten_does_not_drift(record_case):
    """Ten 1 m boxes of one tonne, mu = 0.6, 60 s: base force 98 100 N, drift and overlap under a millionth of the size."""
    world = sw.make(friction=0.6)
    world.add_plane()
    boxes = [world.add(mb.Box(1, 1, 1), density=1000.0, position=(0, 0, 0.5 + i)) for i in range(10)]
    world.run(60.0)
    drift = max(np.linalg.norm(box.position - (0, 0, 0.5 + i)) for i, box in enumerate(boxes))
    record_case(26, "stack of 10, 60 s: drift", drift, 1e-6, "m", peer="0.028 m; DART 4.7e-6 m (20 s)")
    overlap = sw.overlap_of_boxes(boxes, np.ones(3))
    record_case(26, "stack of 10, 60 s: overlap", overlap, 1e-6, "m", peer="3.7e-4 m; DART 3.1e-6 m")
    record_case(26, "stack of 10, 60 s: base force, relative error", sw.floor_force(world) / 98100.0 - 1, 1e-8, peer="1e-10")


@pytest.mark.slow
def test_case_27_cube_rests_half_an_hour_without_creeping(record_case):
    """A 0.5 m cube on a fixed 1 m cube, 432 000 steps."""
    world = sw.make(friction=0.6)
    world.add(mb.Box(1, 1, 1), density=1000.0, position=(0, 0, 0.5), fixed=True)
    cube = world.add(mb.Box(0.5, 0.5, 0.5), density=1000.0, position=(0, 0, 1.25))
    world.run(1800.0)
    record_case(27, "cube at rest for 30 minutes: drift", np.linalg.norm(cube.position - (0, 0, 1.25)), 1e-9, "m", peer="0.022 m")


@pytest.mark.parametrize(
    ("ratio", "peer"), [(10, "7e-5 m"), (100, "3.6e-3 m"), (1000, "0.059 m; DART 1.7e-4 m"), (10000, "1.0 m; DART 3e-2 m")]
)
def test_case_28_heavy_box_does_not_sink_into_a_light_one(record_case, ratio, peer):
    """1 m boxes, 1 kg below, 10 s: centres at 0.5 and 1.5 m."""
    world = sw.make(friction=0.6)
    world.add_plane()
    boxes = [world.add(mb.Box(1, 1, 1), mass=mass, position=(0, 0, 0.5 + i)) for i, mass in enumerate((1.0, float(ratio)))]
    world.run(10.0)
    error = max(np.linalg.norm(box.position - (0, 0, 0.5 + i)) for i, box in enumerate(boxes))
    record_case(28, f"heavy on light, ratio {ratio}: distance from rest", error, 1e-6, "m", peer=peer)
