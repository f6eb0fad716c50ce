"""Bodies that roll down a board, filmed from the side: no camera sees how far they are across it."""

import numpy as np
import pytest

import hlcs
from hlcs.data.recordings import read_recordings
from hlcs.kinds.trajectories.preparation import posed, prepare
from hlcs.selection.eligibility import candidates_for
from hlcs.simulation.model import Term
from minibullet.errors import InputError

G, RADIUS, MASS, SIGMA, ARM = 9.81, 0.02, 0.26, 0.0005, 0.0004
SLOPE = np.radians(3.0)
NORMAL, DOWN = np.array([np.sin(SLOPE), 0.0, np.cos(SLOPE)]), np.array([np.cos(SLOPE), 0.0, -np.sin(SLOPE)])
FLOOR = {"floor": {"height": 0.0, "normal": NORMAL.tolist()}, "friction": 0.4, "restitution": 0.5}
SPEEDS = (0.0, 0.2, 0.4, 0.1)  # at the first frame [m/s]


def rolls(arm=0.0, inertia=0.4, seed=7):
    """Frames of balls, of a moment of inertia in m r^2, that roll without slip: (1 + inertia) a = g (sin - arm / r cos)."""
    draw, frames = np.random.default_rng(seed), []
    fall = G * (np.sin(SLOPE) - arm / RADIUS * np.cos(SLOPE)) / (1 + inertia)
    for speed in SPEEDS:
        times = np.arange(0, 1.3, 1 / 60)
        place = NORMAL * RADIUS + np.outer(speed * times + fall * times**2 / 2, DOWN)
        seen = place + SIGMA * draw.standard_normal(place.shape)
        frames.append({"t_s": times, "x_m": seen[:, 0], "z_m": seen[:, 2]})
    return frames


def experiment(frames, **body):
    body = {"shape": "sphere", "radius": RADIUS, "mass": MASS} | body
    trials = [{"group": str(index)} for index in range(len(frames))]
    return hlcs.Experiment.from_frames(frames, body, FLOOR, noise={"position": SIGMA}, trials=trials)


def test_resistance_to_rolling_is_found_from_the_side():
    """A frame that leans by arm / radius leaves the same on one slope."""
    found = hlcs.diagnose(experiment(rolls(ARM)), candidates=["rolling_friction", "tilted_gravity", "friction", "quadratic_drag"])
    assert found.verdict == "ambiguous" and found.ambiguous == (("rolling_friction", "tilted_gravity"),)
    number = found.parameters["rolling_friction"]["arm"]
    assert abs(number["value"] - ARM) < 3 / 1.645 * (number["high"] - number["low"]) / 2  # 3 standard errors


@pytest.mark.parametrize("part", [0.25, 1.5, 2.0])
def test_a_fit_finds_its_way_from_a_wrong_number(part):
    """Begun from balls that slip for a tenth of a second, which make up for all resistance, it ends in the noise."""
    recordings = read_recordings(experiment(rolls(ARM)).file)
    prepared = prepare(recordings)
    (rolling,) = candidates_for(recordings, True, ["rolling_friction"], ())[0]
    problem = posed(recordings, prepared.noise, prepared.base.model, contact=True)
    fit = problem.fit(prepared.base.model.with_term(Term(rolling, (("arm", part * ARM),))), prepared.base.initial_states)
    count = sum(map(len, fit.linearization.white))
    assert fit.chi2 < count + 4 * np.sqrt(2 * count)  # four standard deviations above the mean


def test_a_ball_with_the_inertia_of_a_cylinder_rolls_like_one():
    frames = rolls(inertia=0.5)
    with pytest.raises(InputError, match=r'on its round side.*shape = "sphere", radius = 0.02, inertia = \[I, I, I\]'):
        hlcs.compare(experiment(frames, shape="cylinder", height=0.1))
    turn = dict.fromkeys(("qw", "qx"), np.full(78, np.sqrt(0.5))) | dict.fromkeys(("qy", "qz"), np.zeros(78))  # its axis along y
    lying = [frame | turn for frame in frames]
    assert "on its round side" in str(hlcs.compare(experiment(lying, shape="cylinder", height=0.1)).notes)
    inertia = MASS * RADIUS**2 / 2
    assert hlcs.compare(experiment(frames, inertia=[inertia] * 3)).adequate
