"""The error of the time step: extrapolation to a step of zero."""

from types import SimpleNamespace

import numpy as np
from experiments import measured
from hard_cases import TUMBLING, write_cubes

from hlcs.estimation.noise_model import estimate_noise
from hlcs.kinds.trajectories import time_step
from hlcs.kinds.trajectories.preparation import posed
from hlcs.kinds.trajectories.time_step import in_still_steps, richardson, settling
from hlcs.simulation.model import Model
from hlcs.simulation.simulator import Motion


def test_two_steps_are_carried_on_to_zero():
    """An error of first order vanishes, that of a turn and of a reading too."""

    def answer(step):
        half = (0.4 + 2 * step) / 2
        turn = np.array([[np.cos(half), 0.0, 0.0, np.sin(half)]])
        return [Motion(np.array([[1.0 + 3 * step, 0.0, 0.0]]), turn, np.array([[0.0, 0.0, 9.81 - 5 * step]]))]

    ((position, turn, force),) = richardson(answer(0.02), answer(0.01))
    np.testing.assert_allclose(position, [[1.0, 0.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose(turn, [[np.cos(0.2), 0.0, 0.0, np.sin(0.2)]], atol=1e-12)
    np.testing.assert_allclose(force, [[0.0, 0.0, 9.81]], atol=1e-12)


def test_a_recording_that_finds_no_rest_with_shorter_steps_is_not_corrected(monkeypatch):
    """Halving moves one by 0.4, 0.2 and 0.1 sigma; another by 0.1, then by 3, where its body goes another way; one by nothing."""
    monkeypatch.setattr(time_step, "recording_scale", lambda recording: 1.0)
    problem = SimpleNamespace(recordings=[None, None, None], segmented=False)
    problem.changes = lambda before, after: [np.array([b - a]) for a, b in zip(before, after, strict=True)]
    runs = {1: [0.0, 0.0, 5.0], 1 / 2: [0.4, 0.1, 5.0], 1 / 4: [0.6, 3.1, 5.0], 1 / 8: [0.7, 3.3, 5.001]}
    kept = settling(problem, runs)
    assert [kept[share] for share in runs] == [[0.0, 0.0, 5.0], [0.4, 0.0, 5.0], [0.6, 0.0, 5.0], [0.7, 0.0, 5.001]]


def test_the_step_of_segments_is_halved_until_their_chi2_stands_still(monkeypatch):
    """Two segments of 100 readings with chi2 = 100 +- 250 (240 step)^4: halving 1/480 s moves them by 29 in all, 1/960 s by 1.8,
    and 1 % of the readings is 2. That one falls as the other rises makes neither stand still."""
    for signs, finest in (((1, 1), 960), ((1, -1), 960), ((0, 0), 240)):
        simulator = SimpleNamespace(time_step=1 / 240)
        problem = SimpleNamespace(simulator=simulator, step_change="of another path", linearise=lambda model, states: states)

        def improved(problem, model, states=None, signs=signs):
            chi2 = 100 + 250 * np.array(signs) * (240 * problem.simulator.time_step) ** 4
            return chi2, np.full((2, 13), problem.simulator.time_step)

        monkeypatch.setattr(time_step, "improved", improved)
        monkeypatch.setattr(time_step, "fit_at", lambda model, states, linear, converged: states)
        fit = SimpleNamespace(model=None, initial_states=None, count=200, converged=True)
        states = in_still_steps(problem, fit)
        assert simulator.time_step == states[0, 0] == 1 / finest and problem.step_change is None


def test_a_tumble_of_another_engine_is_followed_in_the_step_that_it_needs(tmp_path):
    """The first impact of a cube, its friction that of the engine that recorded it: 78 readings beyond the unknown start leave
    78 +- 12.5. In the step of the model it leaves more by ten of these."""
    rows, truths = (np.loadtxt(TUMBLING / name, delimiter=",", skiprows=1) for name in ("tumbles.csv", "truths.csv"))
    impact = rows[(rows[:, 0] == 8) & (rows[:, 1] == 1) & (rows[:, 2] < 15), 1:]
    recordings = measured(write_cubes(tmp_path, impact, 60, np.random.default_rng(2), truths[8, 2]))
    problem = posed(recordings, estimate_noise(recordings), Model(), True)
    fit = problem.fit(Model())
    assert fit.chi2 > 78 + 10 * 12.5
    assert in_still_steps(problem, fit).chi2 < 78 + 3 * 12.5  # once in a thousand by chance
