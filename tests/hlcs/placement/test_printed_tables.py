"""The paper's tables as values: exactly as printed, frozen, and refusing what they do not hold."""

import dataclasses

import numpy as np
import pytest

from hlcs.placement import printed_tables
from minibullet.errors import InputError


@pytest.mark.parametrize(
    ("table", "grid", "mean", "cv", "tests"),
    [
        ("table2", "RPG", [1.319, 1.052, 0.939, 0.949, 0.915], [0.005, 0.014, 0.019, 0.018, 0.040], 5),
        ("table2", "TPG", [1.294, 1.076, 0.980, 0.970, 0.984], [0.008, 0.008, 0.016, 0.022, 0.020], 5),
        ("table3", None, [1.316, 1.022, 0.967, 0.961, 0.946], [0.018, 0.042, 0.047, 0.050, 0.046], 9),
    ],
)
def test_laboratory_is_as_printed(table, grid, mean, cv, tests):
    """Typed a second time from the page: equality, no tolerance."""
    lab = printed_tables.laboratory(table, grid=grid)
    assert lab.mean.tolist() == mean and lab.cv.tolist() == cv and lab.tests.tolist() == [tests] * 5


@pytest.mark.parametrize(
    ("table", "grid", "study", "mean", "cv"),
    [
        ("table2", "RPG", "numerical", [1.319, 1.081, 0.960, 0.935, 0.919], [0.000, 0.007, 0.005, 0.013, 0.019]),
        ("table2", "TPG", "numerical", [1.317, 1.079, 0.980, 0.983, 0.968], [0.000, 0.012, 0.016, 0.011, 0.022]),
        ("table2", "RPG", "centi", [1.321, 1.086, 0.931, 0.943, 0.906], [0.012, 0.049, 0.123, 0.143, 0.112]),
        ("table2", "TPG", "centi", [1.312, 1.125, 1.001, 1.024, 0.991], [0.009, 0.043, 0.082, 0.125, 0.082]),
        ("table3", "TPG", "numerical", [1.329, 1.083, 0.981, 0.977, 0.982], [0.001, 0.021, 0.030, 0.030, 0.039]),
    ],
)
def test_numerical_columns_are_as_printed(table, grid, study, mean, cv):
    """Typed a second time from the page: equality, no tolerance. Centi's number of tests is not in the paper."""
    model = printed_tables.paper_numerical(table, grid=grid, study=study)
    assert model.mean.tolist() == mean and model.cv.tolist() == cv
    assert np.isnan(model.tests).all() if study == "centi" else model.tests.tolist() == [5] * 5


def test_source_is_carried():
    lab = printed_tables.laboratory("table3")
    assert lab.source.startswith("Table 3, section 4, Physical") and lab.bottom_slope == 0.04 and lab.grid == "TPG"


def test_table_1_keeps_its_misprint():
    """L = 1.5 stands beside Dn = 2.14 in print; the file keeps it, the errata explains it."""
    values = printed_tables.sensitivity_values()
    assert values["falling_distance"] == (0.10, 0.15, 0.20, 0.25, 0.30, 0.35, 0.40) and values["side"] == (0.5, 1.0, 1.5)
    assert [row["printed"] for row in printed_tables.rows_of("table1") if row["parameter"] == "side"][-1] == "1.5 (2.14)"


def test_tables_are_frozen():
    lab = printed_tables.laboratory("table2", grid="RPG")
    with pytest.raises(ValueError, match="read-only"):
        lab.mean[0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        lab.grid = "TPG"


def test_dataframe_has_the_columns_of_a_layers_file():
    frame = printed_tables.laboratory("table2", grid="TPG").to_dataframe()
    assert list(frame) == ["grid", "spacing_x", "spacing_y", "bottom_slope", "layer", "mean", "cv", "tests", "campaign"]
    assert len(frame) == 5 and "1.294" in printed_tables.laboratory("table2", grid="TPG").summary()


def test_a_grid_object_is_known_by_its_name():
    class Grid:
        name = "TPG"

    assert printed_tables.laboratory("table2", grid=Grid()).grid == "TPG"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [(("table4", "TPG"), "table = 'table4'"), (("table2", None), "RPG, TPG"), (("table3", "RPG"), "table3 has TPG")],
)
def test_unknown_names_are_refused_by_name(arguments, message):
    with pytest.raises(InputError, match=message):
        printed_tables.laboratory(*arguments)


def test_unknown_study_is_refused():
    with pytest.raises(InputError, match="study = .other.; it must be one of numerical, centi"):
        printed_tables.paper_numerical("table2", "TPG", study="other")
    with pytest.raises(InputError, match="no column 'centi'"):
        printed_tables.paper_numerical("table3", "TPG", study="centi")


def test_design_values_of_other_units_are_told_from_measurements():
    """The paper quotes both tetrapods, each with porosity 50 %: USACE (1984) 1.04, CIRIA, CUR, CETMEF (2007) 1.02."""
    table = printed_tables.design_layer_coefficients()
    tetrapods = table[table["unit"] == "tetrapod"]
    quoted = {source.split(" (")[0]: k for source, k in zip(tetrapods["source"], tetrapods["layer_coefficient"], strict=True)}
    assert quoted == {"USACE": 1.04, "CIRIA, CUR, CETMEF": 1.02} and set(tetrapods["porosity"]) == {0.5}
    assert set(table["kind"]) == {"design value"} and (table["source"].str.len() > 0).all()
    assert "Cubipod" not in set(table["unit"])  # that one is measured: `laboratory`
