"""No point of a body goes farther than the bounds say."""

import numpy as np

import minibullet as mb
from minibullet.dynamics.integrate import moved
from minibullet.dynamics.motion_bounds import path_bound


def test_path_bound_holds_for_every_point_of_the_body(generator):
    """(|v| + |omega| R) t against where the points of a turning box really go."""
    twist = generator.normal(size=(1, 6)) * (1, 1, 1, 5, 5, 5)
    corner = np.array([0.3, 0.4, 1.2])
    bound = path_bound(twist, np.array([1.3]), 0.1)[0]
    place, pose = moved(np.zeros((1, 3)), np.array([[1.0, 0, 0, 0]]), twist, 0.1)
    assert np.linalg.norm(place[0] + mb.rotations.rotate(pose[0], corner) - corner) <= bound
