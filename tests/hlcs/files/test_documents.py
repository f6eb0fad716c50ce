"""Results as JSON and TOML: what is written can be read back, and what cannot be written is refused by its key."""

import dataclasses
import json
import math
import tomllib
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hlcs.files import documents


def test_json_of_numpy_and_records():
    class Pair(NamedTuple):
        low: float
        high: float

    @dataclasses.dataclass
    class Record:
        path: Path
        interval: Pair

    text = documents.to_json(
        {"a": np.arange(3), "b": np.float32(0.5), "c": float("nan"), "d": Record(Path("x"), Pair(0.0, 1.0)), "e": np.bool_(True)}
    )
    assert json.loads(text) == {
        "a": [0, 1, 2],
        "b": 0.5,
        "c": None,
        "d": {"path": "x", "interval": {"low": 0.0, "high": 1.0}},
        "e": True,
    }
    assert "NaN" not in text


def test_json_refuses_by_key():
    with pytest.raises(ValueError, match=r"layers\[1\]\.t = inf"):
        documents.to_json({"layers": [{"t": 0.0}, {"t": math.inf}]})
    with pytest.raises(TypeError, match="model is a set"):
        documents.to_json({"model": {1}})


scalars = (
    st.booleans() | st.integers(-(2**60), 2**60) | st.floats(allow_nan=False) | st.text(st.characters(exclude_categories=["Cs"]))
)
values = st.recursive(
    scalars, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text('ab-_ ."é'), inner, max_size=3), max_leaves=8
)


@given(st.dictionaries(st.text("abcxyz_-. \n"), values, max_size=5))
def test_toml_reads_back_equal(table):
    """Whatever nested settings are written, the standard library's reader gives them back."""
    assert tomllib.loads(documents.to_toml(table)) == table
    assert tomllib.loads(documents.to_toml(table, inline=True)) == table


def test_toml_looks_like_an_experiment_file():
    text = documents.to_toml(
        {
            "kind": "layers",
            "seed": None,
            "placement": {"side": 1.0, "start": [0, 1.5]},
            "trial": [{"file": "a.csv"}, {"file": "b.csv"}],
        }
    )
    assert text.splitlines() == [
        *('kind = "layers"', "", "[placement]", "side = 1.0", "start = [0, 1.5]", ""),
        *("[[trial]]", 'file = "a.csv"', "", "[[trial]]", 'file = "b.csv"'),
    ]


def test_tables_within_tables_are_written_between_braces_where_asked():
    text = documents.to_toml(
        {"model": {"effects": [{"name": "a", "x": 1.0}, {"name": "b"}]}, "trial": [{"start": {"v": [0.0]}}]}, inline=True
    )
    assert text.splitlines() == [
        *("[model]", "effects = [", '  { name = "a", x = 1.0 },', '  { name = "b" },', "]", ""),
        *("[[trial]]", "start = { v = [0.0] }"),
    ]
