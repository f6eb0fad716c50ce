"""Tables of layers as a user writes them: read, or refused by file, row and column."""

import numpy as np
import pytest
from layer_tables import HEADER, PAPER, experiment, measured

import hlcs
from hlcs.kinds.layers.data import odd_notes, read_layer_sets, read_layers
from hlcs.kinds.layers.notes import campaign_notes
from hlcs.placement.printed_tables import laboratory


def test_papers_tables_are_read_as_three_sets(tmp_path):
    file = experiment(tmp_path, [laboratory(*names).to_dataframe() for names in PAPER], 'shape = "hull"')
    data = read_layers(file)
    assert [one.name for one in data.sets] == ["RPG flat", "TPG flat", "TPG 4 % slope"]
    assert [one.layers for one in data.sets] == [5, 5, 5] and data.hold_out == "campaign"
    assert data.test.shape == "hull" and data.sets[2].placed(data.test).bottom.grade == 0.04


@pytest.mark.parametrize(
    ("row", "what"),
    [
        ("TPG,1.58,1.27,0,1,1.3,0.01,5,a\nTPG,1.58,1.27,0,1,1.3,0.01,5,a", "row 3, column layer"),
        (
            "TPG,1.58,1.27,0,1,1.3,0.01,5,a\nTPG,1.58,1.27,0,3,1.0,0.01,5,a",
            "has no layer 2; layers are numbered from 1 without gaps",
        ),
        (
            "new,1.58,1.27,0,1,1.3,0.01,5,a\nnew,1.6,1.27,0,2,1.0,0.01,5,a",
            r"new, campaign 'a' \(from row 3\) has no layer 1: row 2 has it with spacing_x = 1.58 \(here 1.6\); layers of one",
        ),
        ("TPG,1.58,1.27,0,51,1.3,0.01,5,a", "row 2, column layer: '51'; it must be a whole number, from 1 to 50"),
        ("TPG,1.58,1.27,0,1,x,0.01,5,a", "row 2, column mean: 'x'"),
        ("TPG,1.58,1.27,0,1,131.9,0.01,5,a", "row 2, column mean"),
        ("TPG,1.58,1.27,0,1,1.3,1.4,5,a", "row 2, column cv: '1.4'"),
        ("TPG,1.58,1.27,0,1,nan,0.01,5,a", "row 2, column mean"),
        ("TPG,1.58,1.27,0,1,1.3,0.01,4.5,a", "row 2, column tests"),
        ("TPG,1.58,1.27,4,1,1.3,0.01,5,a", "row 2, column bottom_slope"),
        ("new,,1.27,0,1,1.3,0.01,5,a", "row 2, column spacing_x"),
        (",1.58,1.27,0,1,1.3,0.01,5,a", "row 2, column grid"),
        ("TPG,1.58,1.27,0,1,1.3,0.01,5,a,extra", "row 2"),
        ("", "has no rows"),
    ],
)
def test_bad_tables_are_refused_by_file_row_and_column(tmp_path, row, what):
    path = tmp_path / "bad.csv"
    path.write_text(f"{HEADER}\n{row}\n")
    with pytest.raises(hlcs.InputError, match=what) as complaint:
        read_layer_sets(path)
    assert "bad.csv" in str(complaint.value) and "\n" not in str(complaint.value)


def test_quick_settings_scale_with_the_unit(tmp_path):
    large, small = (
        read_layers(experiment(tmp_path, [measured("TPG", 1, "a")], f"nominal_diameter = {size}")).test for size in (1.0, 0.038)
    )
    assert large.time_step == pytest.approx(1 / 120) and small.time_step == pytest.approx(np.sqrt(0.038) / 120)
    stated = read_layers(experiment(tmp_path, [measured("TPG", 1, "a")], "nominal_diameter = 0.038\ntime_step = 0.001")).test
    assert stated.time_step == 0.001 and stated.settle_time == small.settle_time


def test_sets_of_one_name_are_told_apart_by_what_differs(tmp_path):
    """By their spacings; of their first layers the thinnest is compared with the thickest: 0.1 sqrt(5) / hypot(0.02, 0.018)."""
    rows = [
        (spacing, layer, first - 0.1 * (layer - 1))
        for spacing, first in ((1.2, 1.0), (1.3, 0.95), (1.4, 0.9))
        for layer in (1, 2)
    ]
    lines = [f"mine,{spacing},1.3,0,{layer},{mean:.3f},0.02,5,lab" for spacing, layer, mean in rows]
    (tmp_path / "layers.csv").write_text("\n".join([HEADER, *lines]) + "\n")
    sets = read_layer_sets(tmp_path / "layers.csv")
    assert [one.name for one in sets] == [f"mine {spacing} x 1.3 Dn flat" for spacing in (1.2, 1.3, 1.4)]
    (note,) = [note for note in campaign_notes(sets) if note.startswith("first layers")]
    assert (
        "1.000 (mine 1.2" in note and "against 0.900 (mine 1.4" in note and "8.3 sigma" in note
    )  # 0.1 / hypot(0.02, 0.018) * sqrt(5)


def test_what_is_hardly_meant_in_a_table_of_layers_is_told(tmp_path):
    """Per cent for a fraction, heights of structures for coefficients of layers, spacings in the other order."""
    rows = ["TPG,1.27,1.58,0,1,1.294,0.3,5,lab", "TPG,1.27,1.58,0,2,2.370,0.4,5,lab", "RPG,,,0,1,1.29,0.01,5,lab"]
    (tmp_path / "layers.csv").write_text("\n".join([HEADER, *rows]) + "\n")
    scatter, heights, spacings = odd_notes(read_layer_sets(tmp_path / "layers.csv"))
    (tmp_path / "layers.csv").write_text(
        "\n".join([HEADER, "TPG,1.27,1.58,0,1,1.294,0.01,5,lab", "TPG,,,0.05,1,1.3,0.01,5,lab"]) + "\n"
    )
    assert "1.27 x 1.58 Dn" in odd_notes(read_layer_sets(tmp_path / "layers.csv"))[0]
    assert "cv up to 0.4" in scatter and "one layer alone" in heights and "1.27 x 1.58 Dn" in spacings
