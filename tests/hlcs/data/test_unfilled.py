"""Places that say "fill in" are asked for by line, key and what belongs there."""

import pytest

from hlcs.data.experiment_file import read_experiment_file
from minibullet.errors import InputError

TEXT = """kind = "trajectory"   # "fill in" here is only a comment
[body]
radius = 0.03
mass = "fill in"        # kg: weigh it
[measurement]
noise.position = "fill in"
[[trial]]
file = "a.csv"
[[trial]]
file = "a.csv"
radius = "fill in"      # m
start = { velocity = "fill in" }
"""


def test_the_first_place_is_told_with_its_comment_and_the_others_by_their_lines(tmp_path):
    path = tmp_path / "e.toml"
    path.write_text(TEXT)
    with pytest.raises(InputError) as problem:
        read_experiment_file(path)
    assert str(problem.value) == (
        f'{path}, line 4: body.mass: still says "fill in"; write its value (kg: weigh it); '
        "then also line 6 (measurement.noise.position), line 11 (trial.radius), line 12 (trial.start.velocity)"
    )


def test_a_number_that_a_diagnosis_withheld_is_left_to_the_model(tmp_path):
    """It knows the range of each number, and says so when the model is built."""
    path = tmp_path / "e.toml"
    (tmp_path / "a.csv").write_text("t_s,z_m\n0,1\n1,2\n")
    path.write_text(
        'kind = "trajectory"\n[model]\neffects = [{ name = "linear_drag", rate = "fill in" }]\n[[trial]]\nfile = "a.csv"\n'
    )
    assert read_experiment_file(path).effects == ({"name": "linear_drag", "rate": "fill in"},)
