"""A body given as a mesh file: the same answers as the same solid by its name, or a complaint when the experiment is read."""

import numpy as np
import pytest
from boxes import COLUMNS, MESH, NAMED, thrown, write_box
from throws import correlated, csv

import hlcs
from minibullet import rotations


def slid(folder, body):
    """Four slides to rest on a rough floor (friction 0.3), on the largest face; -> path of the experiment, which says 0.3."""
    generator, trials = np.random.default_rng(5), ""
    for k in range(4):
        times, speed = np.arange(0, 0.9, 1 / 60), 1.0 + 0.4 * k
        rest = speed / (0.3 * 9.81)
        way = np.where(times < rest, speed * times - 0.3 * 9.81 * times**2 / 2, speed * rest / 2)
        place = np.column_stack([way, 0 * way, 0.03 + 0 * way]) + correlated(generator, (len(times), 3), 0.001, 0.0)
        down = rotations.exponential(np.array([0, np.pi / 2, 0]))  # the face across x lies on the floor
        turn = rotations.product(rotations.exponential(correlated(generator, (len(times), 3), 0.003, 0.0)), down)
        (folder / f"slide_{k}.csv").write_text(csv(times, np.hstack([place, turn]), COLUMNS))
        trials += f'[[trial]]\nfile = "slide_{k}.csv"\ngroup = "day {k % 2}"\n'
    path = folder / "slid.toml"
    path.write_text(
        'kind = "trajectory"\n[body]\n' + body + "mass = 1.5\n[surroundings]\nfluid_density = 0.0\nfriction = 0.3\n"
        "floor = { height = 0.0 }\n[measurement]\nnoise = { position = 0.001, orientation = 0.003 }\n" + trials
    )
    return path


def same(one, other, tolerance):
    """Equal words, and numbers equal within a relative tolerance, however they stand in each other."""
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        return all(same(one[key], other[key], tolerance) for key in one)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(same(*pair, tolerance) for pair in zip(one, other, strict=True))
    if isinstance(one, float):
        return one == pytest.approx(other, rel=tolerance, abs=tolerance)
    return one == other


# 32-bit numbers of the file are right to 1e-7 of the size; fits stop where chi2 falls by less than 1e-2 of itself.
@pytest.mark.parametrize("write", [thrown, slid])
def test_a_box_from_a_file_and_a_box_by_name_compare_alike(write, tmp_path):
    write_box(tmp_path, at=(0.3, -0.2, 0.5))
    named, mesh = (hlcs.compare(write(tmp_path, body)) for body in (NAMED, MESH))
    assert named.adequate and mesh.adequate
    assert len(mesh.where) == len(named.where) and same(mesh.where, named.where, 1e-3)


def test_a_box_from_a_file_and_a_box_by_name_are_diagnosed_alike(tmp_path):
    """Throws that a drag linear in speed brakes, 0.4 per second: the same verdict, effects and numbers."""
    write_box(tmp_path, at=(0.3, -0.2, 0.5))
    named, mesh = (hlcs.diagnose(thrown(tmp_path, body, drag=0.4, more="mass = 1.5\n"), progress=False) for body in (NAMED, MESH))
    assert named.verdict == mesh.verdict and named.effects == mesh.effects and "linear_drag" in str(mesh)
    assert same(*(one.to_json()["parameters"] for one in (mesh, named)), 1e-3)
