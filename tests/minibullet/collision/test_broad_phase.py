"""The list of close pairs: nothing that may touch is missing, whatever moves; order and groups as promised."""

import numpy as np
from scipy.spatial.distance import cdist

import minibullet as mb
from minibullet.collision import broad_phase


def test_overlapping_boxes_are_found_exactly(generator):
    """Against every pair tried: same pairs, sorted, a < b; two fixed bodies and two different groups are no pair."""
    low = generator.uniform(0.0, 3.0, (60, 3))
    high = low + generator.uniform(0.2, 0.8, (60, 3))
    moving, group = generator.random(60) < 0.6, generator.integers(-1, 3, 60)
    expected = [
        (a, b)
        for a in range(60)
        for b in range(a + 1, 60)
        if (low[a] <= high[b]).all() and (low[b] <= high[a]).all() and (moving[a] or moving[b])
        and not (group[a] >= 0 and group[b] >= 0 and group[a] != group[b])
    ]  # fmt: skip
    assert len(expected) > 20
    assert [tuple(pair) for pair in broad_phase.overlapping(low, high, moving, group)] == expected


def test_no_contact_is_missed_while_bodies_fly_about(generator):
    """The list is kept while bodies move less than its skin: each pair of spheres whose free paths end in touch within a step is
    among the contacts of that step."""
    world = mb.World(settings=mb.Settings(restitution=1.0, friction=0.0))
    places = np.stack(np.meshgrid(*[np.arange(3) * 0.3] * 3), axis=-1).reshape(-1, 3)
    for place in places:
        velocity = generator.normal(scale=2.0, size=3) - 4.0 * (place - 0.3)
        world.add(mb.Sphere(0.1), density=1000.0, position=place, velocity=velocity)
    row = {body.name: k for k, body in enumerate(world.bodies)}
    seen = 0
    for _ in range(60):
        ahead = np.array([body.position + body.velocity * world.settings.time_step for body in world.bodies])
        meeting = {tuple(pair) for pair in np.argwhere(np.triu(cdist(ahead, ahead) < 0.2, 1)).tolist()}
        world.step()
        table = world.contacts.to_dataframe()
        assert meeting <= {tuple(sorted((row[a], row[b]))) for a, b in zip(table.body_a, table.body_b, strict=True)}
        seen += len(meeting)
    assert seen > 10  # the test has seen spheres that meet
