"""Small experiment files for the tests: one recording of a falling ball, and the message with which one is refused."""

import pytest

from hlcs.data.experiment_file import read_experiment_file
from hlcs.data.outcome_tables import read_outcomes
from hlcs.data.recordings import read_recordings
from minibullet.errors import InputError

TOML = 'kind = "trajectory"\n[body]\nshape = "sphere"\nradius = 0.03\nmass = 0.05\n[measurement]\nnoise = { position = 0.01 }\n'
FLOOR = TOML + "[surroundings]\nfloor = { height = 0.0 }\n"


def experiment(folder, csv="", toml=TOML, trial='file = "a.csv"\n', name="a.csv"):
    """An experiment folder with one recording; the path of its TOML."""
    lines = "".join(f"{0.1 * k:.1f},{1 - 0.05 * k * k:.4f}\n" for k in range(8))
    (folder / name).write_text(csv or "t_s,z_m\n" + lines)
    path = folder / "e.toml"
    path.write_text(toml + f"[[trial]]\n{trial}")
    return path


def measured(path):
    """What an experiment file holds: Recordings or an OutcomeTable."""
    file = read_experiment_file(path)
    return (read_outcomes if file.kind == "outcomes" else read_recordings)(file)


def refused(path, *words):
    """The message with which reading is refused; it holds all the words."""
    with pytest.raises(InputError) as problem:
        measured(path)
    message = str(problem.value)
    assert "\n" not in message
    for word in words:
        assert word in message, message
