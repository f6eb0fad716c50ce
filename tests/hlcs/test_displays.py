"""Results as a notebook and a prompt show them: the numbers of the report are in, and text from files is only text."""

from dataclasses import replace

import numpy as np
from throws import write_throws

import hlcs
import minibullet as mb
from hlcs.placement.comparison import compare_layers

TITLE = "<script>alert(1)</script>"


def titled(path):
    """The experiment file with a title that a browser would obey."""
    path.write_text(path.read_text().replace('title = "throws"', f'title = "{TITLE}"'))
    return path


def test_a_comparison_in_a_notebook_is_its_report(tmp_path):
    comparison = hlcs.compare(titled(write_throws(tmp_path, count=4)))
    shown = comparison._repr_html_()
    assert TITLE not in shown and "&lt;script&gt;" in shown and "throw_3.csv" in shown.replace("<wbr>", "")


def test_a_diagnosis_in_a_notebook_has_its_verdict_and_its_figure(tmp_path, capsys):
    """With progress shown, which outside a terminal is nothing."""
    diagnosis = hlcs.diagnose(titled(write_throws(tmp_path, count=4)), candidates=["quadratic_drag"], progress=True)
    shown = diagnosis._repr_html_()
    assert TITLE not in shown and diagnosis.verdict in shown and "data:image/png;base64," in shown
    assert capsys.readouterr().out == ""


def test_layers_in_a_notebook_are_a_table():
    table = hlcs.laboratory("table2", grid="TPG")
    assert f"{table.mean[0]:.3f}".rstrip("0") in table._repr_html_() and "<table" in table._repr_html_()
    comparison = replace(compare_layers(table, table), title=TITLE)
    shown = comparison._repr_html_()
    assert TITLE not in shown and "<table" in shown
    assert comparison.to_dict()["layers"][0]["relative_error"] == 0.0
    axes = comparison.plot()
    assert {"model", "measured"} <= {text.get_text() for text in axes.get_legend().get_texts()}


def test_pieces_and_bodies_tell_what_they_are():
    assert repr(mb.Box(1, 1, 1).pieces[0]) == "ConvexPiece(8 vertices, 6 faces, radius=0.0)"
    world = mb.World()
    body = world.add(mb.Sphere(0.5), mass=1.0, name="u17", position=(1, 2, 3))
    assert "u17" in repr(body)
    assert np.array_equal(world.bodies[0].position, (1, 2, 3))


def test_an_experiment_in_a_notebook_lists_the_effects_of_its_model(tmp_path):
    experiment = hlcs.Experiment.read(titled(write_throws(tmp_path, count=4))).with_effects([mb.QuadraticDrag(0.47)])
    shown = experiment._repr_html_()
    assert TITLE not in shown and "<td>quadratic_drag</td><td>drag_coefficient = 0.47</td>" in shown
