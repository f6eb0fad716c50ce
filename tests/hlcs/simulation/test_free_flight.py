"""Free flight against closed forms."""

import numpy as np

from hlcs.data.experiment_file import Body, Surroundings
from hlcs.data.recordings import Trial
from hlcs.simulation.model import Model

G = 9.81


def test_a_drag_that_answers_within_a_step_is_flown_in_shorter_steps():
    """A bead of 1 mm falls from rest in water: v = V tanh(g' t/V), V/g = 16 ms, flown with steps of 33 ms to 1 um."""
    bead = Body(shape="sphere", radius=5e-4, mass=2.6e-6)
    around = Surroundings(fluid_density=1000.0)
    model = Model(fixed=({"name": "quadratic_drag", "drag_coefficient": 2.5},))
    times = np.linspace(0, 1, 40)
    still = Trial("bead.csv", "1", times, np.zeros((40, 3)), np.full((40, 4), np.nan), {}, bead, around)
    start = np.array([0, 0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 0, 0])
    position, _ = model.run(still, start, times)
    per_metre = 2.5 * 1000 * np.pi * 5e-4**2 / (2 * 2.6e-6)
    exact = -np.log(np.cosh(np.sqrt(G * per_metre) * times)) / per_metre
    assert np.abs(position[:, 2] - exact).max() < 1e-6
