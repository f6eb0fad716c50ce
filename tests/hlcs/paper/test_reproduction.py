"""`hlcs.reproduce`: the command's table as a result; what it draws are the numbers of its document."""

import json

import pytest
from matplotlib.figure import Figure

import hlcs
from hlcs.paper.reproduction import Reproduction

SMALL = {"repeats": 2, "workers": 1, "friction": 0.36, "margin": 0.0, "layers": 2, "rows": 3, "columns": 3}


@pytest.fixture(scope="module")
def table3():
    return hlcs.reproduce("table3", **SMALL)


def test_the_picture_shows_the_means_of_the_document(table3):
    means = [layer["mean"] for layer in table3.document["grids"]["TPG"]["layers"]]
    (ax,) = table3.plot()
    model = next(line for line in ax.containers if line.get_label().startswith("model, friction 0.36"))
    assert model.lines[0].get_ydata().tolist() == means and ax.get_xlabel() and ax.get_ylabel()
    assert table3.to_dataframe()["mean"].tolist() == means


def test_axes_that_are_given_are_drawn_into_and_another_number_of_them_is_refused(table3):
    axes = Figure().subplots(1, 2)
    assert table3.plot(axes[0])[0] is axes[0] and axes[0].has_data() and not axes[1].has_data()
    with pytest.raises(hlcs.InputError, match="ax holds 2 Axes; this picture has 1"):
        table3.plot(axes)


def test_sensitivity_and_workability_are_drawn_from_their_documents_alone():
    """A document as its JSON gives it back, where no structure is null and not nan."""
    rows = [{"parameter": "friction", "value": value, "error": 0.1 * value, "error_low": None, "error_high": None}
            for value in (0.36, 0.6)]  # fmt: skip
    parameters = [{"parameter": "friction", "lowest": 0.036, "highest": 0.06, "matters": False}]
    sensitivity = Reproduction({"table": "table1", "rows": rows, "parameters": parameters, "base": {"friction": 0.36}})
    (ax,) = sensitivity.plot()
    (bar,) = [patch for patch in ax.patches if patch.get_height() == 0.8]
    assert (bar.get_x(), bar.get_width()) == (pytest.approx(3.6), pytest.approx(2.4))  # per cent
    case = {"spacing_x": 1.58, "spacing_y": 1.27, "placement_scatter": 0.1, "units": 50}
    counts = {name: {"mean": lost, "low": None, "high": None} for name, lost in (("lost", 1.0), ("misplaced", 5.0))}
    shares = [
        float(ax.images[0].get_array()[0, 0]) for ax in Reproduction({"table": "workability", "cases": [case | counts]}).plot()
    ]
    assert shares == [pytest.approx(2.0), pytest.approx(10.0)]
    assert len(sensitivity.to_dataframe()) == 2


def test_what_is_saved_is_what_the_command_writes(table3, tmp_path, hlcs):
    numbers = [f"--{name}={value}" for name, value in SMALL.items()]
    status, _, told = hlcs("reproduce", "table3", *numbers, "--out", str(tmp_path / "command"), "--quiet")
    assert status == 0, told
    table3.save(tmp_path / "saved")
    for place in ("saved", "command"):
        assert {"table3.json", "table3.txt", "table3.png"} <= {file.name for file in (tmp_path / place).iterdir()}
    ours, theirs = (json.loads((tmp_path / place / "table3.json").read_text("utf-8")) for place in ("saved", "command"))
    assert all(ours[key] == theirs[key] for key in ("table", "seeds", "settings"))
    assert ours["grids"]["TPG"]["layers"] == theirs["grids"]["TPG"]["layers"]


def test_a_table_without_a_picture_is_left_to_the_command():
    with pytest.raises(hlcs.InputError, match="reproduce: table = 'ladder'"):
        hlcs.reproduce("ladder")
