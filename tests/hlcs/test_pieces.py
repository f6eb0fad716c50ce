"""Recordings of tumbling bodies are cut where small changes grow; what is left out is told; times in frames are refused."""

from types import SimpleNamespace

import numpy as np
import pytest
from throws import csv, write_throws

import hlcs
from hlcs.data.experiment_file import read_experiment_file
from hlcs.data.measurement import read_measurement
from hlcs.estimation.effort import LIMIT, UNITS, screened, unit
from hlcs.kinds.trajectories.preparation import prepare
from hlcs.simulation.model import Model
from hlcs.simulation.simulator import Shots
from minibullet import rotations
from minibullet.errors import InputError

CUBE = (
    'kind = "trajectory"\n[body]\nshape = "box"\nsize = [0.1, 0.1, 0.1]\nmass = 0.37\n[surroundings]\ngravity = 9.81\n'
    "friction = 0.2\nfloor = { height = 0.0 }\n[measurement]\nnoise = { position = 0.001, orientation = 0.01 }\n"
)


def write_tosses(folder, speeds, seconds=0.9, seed=4):
    """Cubes tossed on a floor, through the model itself at a fifth of its step: only how they are cut is tested with them."""
    generator, text = np.random.default_rng(seed), CUBE
    for k in range(len(speeds)):
        (folder / f"t{k}.csv").touch()
        text += f'[[trial]]\nfile = "t{k}.csv"\ngroup = "day {k % 2}"\n'
    path = folder / "tosses.toml"
    path.write_text(text)
    trial = SimpleNamespace(**{name: getattr(read_experiment_file(path).trials[0], name) for name in ("body", "surroundings")})
    times = np.arange(0, seconds, 1 / 120)
    for k, speed in enumerate(speeds):
        turn = generator.standard_normal(4)
        spin = 3 * speed * generator.standard_normal(3)
        start = np.concatenate([[0, 0, 0.15], [speed, 0, 0], turn / np.linalg.norm(turn), spin])
        whole = SimpleNamespace(times=times, position=np.zeros((len(times), 3)), recording="", start={}, **vars(trial))
        ((position, turns),) = Shots(Model(), (whole,), [0.0], True, 1 / 1200).simulate(Model(), start[None], np.zeros(1, int))
        seen = position + 0.001 * generator.standard_normal(position.shape)
        turns = rotations.product(rotations.exponential(0.01 * generator.standard_normal((len(times), 3))), turns)
        (folder / f"t{k}.csv").write_text(csv(times, np.hstack([seen, turns]), ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")))
    return path


def test_a_tumble_is_cut_and_every_piece_is_followed(tmp_path):
    prepared = prepare(read_measurement(write_tosses(tmp_path, [1.8, 1.5])))
    problem, whole = prepared.problem, prepared.measurement.trials
    assert len(problem.trials) > len(whole) and any("cut into" in note for note in prepared.notes)
    for trial in whole:
        its = [piece for piece in problem.trials if (piece.recording or piece.name) == trial.name]
        assert np.array_equal(np.concatenate([piece.times for piece in its]), trial.times)
        assert all(trial.times[piece.first_row] == piece.times[0] and piece.group == trial.group for piece in its)
    assert prepared.base.chi2 < 2 * prepared.base.freedom


@pytest.mark.slow
def test_friction_that_differs_from_the_file_s_is_found_in_tosses(tmp_path):
    path = write_tosses(tmp_path, [1.8, 1.5, 1.6, 1.7])
    path.write_text(path.read_text().replace("friction = 0.2", "friction = 0.45"))
    found = hlcs.diagnose(path, candidates=["friction", "restitution", "linear_drag", "adhesion", "tilted_gravity"])
    assert found.effects == ("friction",)
    assert found.parameters["friction"]["coefficient"]["value"] == pytest.approx(0.2, abs=0.02)


def test_few_recordings_are_screened_where_all_cost_too_much(tmp_path):
    measurement = read_measurement(write_tosses(tmp_path, [1.0] * 9))
    few, many, notes = screened(measurement, contact=True)
    assert 1 <= len(few.trials) < len(many.trials) <= 9 and unit(few.trials, 1 / 240) * UNITS <= LIMIT
    assert {trial.group for trial in few.trials} == {"day 0", "day 1"} and "t0.csv" in notes[0] and "9 recordings" in notes[0]
    assert screened(measurement, contact=False)[0] is measurement


@pytest.mark.parametrize("unit_of_time, advice", [(60, "frame numbers"), (1000 / 7, "milliseconds")])
def test_times_that_are_not_seconds_are_refused(tmp_path, unit_of_time, advice):
    path = write_throws(tmp_path, static=False, noise="noise = { position = 0.004 }")
    for file in tmp_path.glob("throw_*.csv"):
        rows = [line.split(",", 1) for line in file.read_text().splitlines()]
        file.write_text("\n".join([",".join(rows[0]), *(f"{float(t) * unit_of_time:.3f},{rest}" for t, rest in rows[1:])]) + "\n")
    with pytest.raises(InputError, match=f"throw_0.csv, column t_s: .*{advice}"):
        hlcs.compare(path)


def test_a_sample_that_stands_alone_is_told_beside_a_rest_that_is_left_out(tmp_path):
    """A puck slides for 0.5 s and rests for 3 s; row 12 was read 5 cm off. Both are said, the row as it stands in the file."""
    generator, times = np.random.default_rng(2), np.arange(210) / 60
    moving = np.minimum(times, 0.5)
    seen = np.column_stack([0.981 * moving - 0.981 * moving**2, 0 * times, 0.05 + 0 * times])
    seen += 0.0005 * generator.standard_normal(seen.shape)
    seen[10, 0] += 0.05
    (tmp_path / "a.csv").write_text(csv(times, seen))
    path = tmp_path / "puck.toml"
    path.write_text(CUBE.replace("position = 0.001", "position = 0.0005") + '[[trial]]\nfile = "a.csv"\n')
    notes = " ".join(prepare(read_measurement(path)).notes)
    assert "at rest from t_s" in notes and "1 isolated samples set aside for all models: x row 12" in notes
