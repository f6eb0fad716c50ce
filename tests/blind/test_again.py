"""The experiments that verdicts ask for, made on the hidden cause: what was made first stays as it was, and what joins it is what
was asked for. Designs are those that the analyst names (`hlcs.estimation.designs`, `hlcs.kinds.outcomes.designs`, layers)."""

import csv
import io
import json
import tomllib

import numpy as np
import pytest

from hlcs.data.experiment_file import read_experiment_file
from hlcs.data.outcome_tables import read_outcomes
from hlcs.kinds.layers.data import read_layers

from . import again, generate, run
from .generator import deck
from .generator.case import write_case
from .generator.layers import BASE, TESTS

SEED = 11


def made(family, kind, table=False, then=None):
    """(rows of the data as dicts, files, answer) of one case."""
    dealt = deck.Dealt(kind, family, 0, table, "white", False)
    files, answer = deck.make(SEED, 0, dealt, then)
    name = next((name for name in ("outcomes.csv", "layers.csv") if name in files), None)
    return list(csv.DictReader(io.StringIO(files[name]))) if name else None, files, answer


def joined(family, kind, design, count, table=True):
    """(rows of before, rows that a design adds) of a table."""
    before, _, answer = made(family, kind, table)
    after, _, same = made(family, kind, table, (design, count))
    assert answer == same
    assert [{key: row[key] for key in before[0]} for row in after[: len(before)]] == before
    return after[: len(before)], after[len(before) :]


@pytest.mark.parametrize("value", [4.0, [4.0, 20.0]])
def test_rows_of_a_table_take_the_values_of_a_design_in_turn(value):
    _, more = joined("flight", "degenerate", {"height_m": value}, 5)
    assert [row["height_m"] for row in more] == (["4"] * 5 if value == 4.0 else ["4", "20", "4", "20", "4"])
    assert {row["group"] for row in more} == {"recommended"}


def fall_time(height, mass, radius, inside):
    """Time of a fall from rest of a ball in air, of whose effects those `inside` act [s]."""
    air = 1.2 * 4 / 3 * np.pi * radius**3 / mass  # displaced, over the mass
    moving = 1 + 0.5 * air * ("added_mass" in inside)
    g = 9.81 * (1 - air * ("buoyancy" in inside)) / moving
    k = max(0.5 * 1.2 * 0.47 * np.pi * radius**2 / mass / moving * ("quadratic_drag" in inside), 1e-9)
    return np.arccosh(np.exp(k * height)) / np.sqrt(g * k)


def test_rows_of_another_body_fall_as_its_mass_says():
    """Nothing is hidden from a ball in air: t = arcosh(exp(k h)) / sqrt(g k), k the drag and g the pull per mass that moves.
    Wrong inputs (mass 2 %, size 1 %) change the drag by 4 % and that a tenth of the time at most."""
    old, more = joined("flight", "null", {"height_m": 10.0, "mass_kg": [0.02, 2.0]}, 200)
    assert len({row["mass_kg"] for row in old}) == 1
    file = tomllib.loads(made("flight", "null", True)[1]["experiment.toml"])
    radius, inside = file["body"]["radius"], {law["name"] for law in file["model"]["effects"]}
    for mass in (0.02, 2.0):
        seen = np.mean([float(row["fall_time_s"]) for row in more if float(row["mass_kg"]) == mass])
        assert seen == pytest.approx(fall_time(10.0, mass, radius, inside), rel=0.005)


def test_rows_down_a_slope_go_further_and_up_a_slope_less():
    """Nothing is hidden from a block: ln(1 + k v^2 / a) / 2 k with a = g (mu cos - sin). Wrong inputs: 4 % of a drag that takes a
    twentieth of the way."""
    old, more = joined("slide", "null", {"speed_m_s": 3.5, "angle_deg": [-5.0, 5.0]}, 100)
    assert {row["angle_deg"] for row in old} == {"0"}
    file = tomllib.loads(made("slide", "null", True)[1]["experiment.toml"])
    inside = {law["name"] for law in file["model"]["effects"]}
    area = (0.12 * 0.08 + 0.08 * 0.04 + 0.04 * 0.12) / 2
    k = max(0.5 * 1.2 * 1.05 * area / 0.35 * ("quadratic_drag" in inside), 1e-9)
    for angle in (-5.0, 5.0):
        seen = np.mean([float(row["stop_distance_m"]) for row in more if float(row["angle_deg"]) == angle])
        a = 9.81 * (0.30 * np.cos(np.deg2rad(angle)) - np.sin(np.deg2rad(angle)))
        assert seen == pytest.approx(np.log1p(k * 3.5**2 / a) / (2 * k), rel=0.01)


def test_a_row_that_this_table_cannot_have_is_refused_by_name():
    for design in ({"height_m": 2.0, "colour": 1.0}, {"mass_kg": 0.1}):
        with pytest.raises(KeyError):
            made("flight", "degenerate", True, (design, 3))


def test_layer_tests_join_the_rows_of_their_grid():
    """Seven more tests, the campaigns in turn; the other grid stays as it was, byte for byte."""
    before, _, answer = made("layers", "single")
    after, _, same = made("layers", "single", then=({"grid": "TPG", "bottom_slope": 0.0}, 7))
    assert answer == same and len(after) == len(before)
    assert [row for row in after if row["grid"] == "RPG"] == [row for row in before if row["grid"] == "RPG"]
    tests = [int(row["tests"]) for row in after if row["grid"] == "TPG" and row["layer"] == "1"]
    assert sum(tests) == TESTS * len(tests) + 7 and max(tests) - min(tests) <= 1


def test_layer_tests_by_other_hands_are_a_campaign_of_their_own():
    before, _, _ = made("layers", "null")
    after, _, _ = made("layers", "null", then=({"grid": "RPG", "campaign": "another"}, 40))
    new = after[len(before) :]
    assert after[: len(before)] == before
    assert {(row["grid"], row["tests"], row["campaign"]) for row in new} == {("RPG", "41", "recommended")}
    ratio = [float(row["mean"]) / mean for row, mean in zip(new, BASE["RPG"], strict=True)]
    assert np.std(ratio) < 0.02 < 0.2 > abs(np.mean(ratio) - 1)  # its hands move all layers alike, by about a hundredth


def test_a_grid_that_nobody_placed_is_refused():
    with pytest.raises(KeyError, match="1.5,1.3"):
        made("layers", "null", then=({"grid": "1.5,1.3", "bottom_slope": 0.0}, 7))


@pytest.mark.parametrize(
    ("family", "kind", "table", "design"),
    [
        ("flight", "degenerate", True, {"height_m": [0.5, 20.0], "radius_m": 0.1}),
        ("slide", "degenerate", True, {"speed_m_s": 3.5, "angle_deg": [-5.0, 5.0]}),
        ("layers", "single", False, {"grid": "RPG", "bottom_slope": 0.0, "campaign": "another"}),
    ],
)
def test_the_files_of_the_second_round_are_read_by_the_analyst(tmp_path, family, kind, table, design):
    write_case(tmp_path, made(family, kind, table, (design, 6))[1])
    file = read_experiment_file(tmp_path / "experiment.toml")
    if table:
        assert set(design) <= set(read_outcomes(file).inputs) and "recommended" in read_outcomes(file).groups
    else:
        assert all(measured.judgeable for measured in read_layers(file).sets)


def test_the_recording_that_is_to_be_repeated_is_the_one_named():
    _, files, _ = made("flight", "null")
    names = sorted(name for name in files if name.startswith("recording"))
    _, after, _ = made("flight", "null", then=({"repeat": names[0]}, 2))
    new = sorted(set(after) - set(files))
    assert len(new) == 2
    durations = [float(after[name].strip().splitlines()[-1].split(",")[0]) for name in (names[0], *new)]
    assert durations == pytest.approx([durations[0]] * 3, abs=0.05)  # the recorder's clock starts anew each time: a frame or two


def test_every_kind_of_experiment_is_made_and_scored(tmp_path, monkeypatch):
    """Ambiguous verdicts on a table and on layers; the second verdict, a stub, knows the truth."""
    cases = [
        deck.Dealt("degenerate", "flight", 0, True, "white", False),
        deck.Dealt("single", "layers", 0, False, "tests", False),
    ]
    monkeypatch.setattr(deck, "deal_all", lambda *_: cases)
    generate.generate(tmp_path, SEED, 2)
    answers = json.loads((tmp_path / "answers.json").read_text(encoding="utf-8"))["cases"]
    (tmp_path / "verdicts").mkdir()
    designs = {"case_0001": {"height_m": [0.5, 10.0], "mass_kg": 1.0}, "case_0002": {"grid": "TPG", "bottom_slope": 0.0}}
    for name, design in designs.items():
        truth = answers[name]["effects"]
        told = {"verdict": "ambiguous", "effects": truth, "ambiguous": [["plate_bias"]]}
        told["next_experiment"] = {"separates": [*truth, "plate_bias"], "tests_needed": 40, "design": design}
        (tmp_path / "verdicts" / f"{name}.json").write_text(json.dumps(told), encoding="utf-8")

    def truthful(cases, out, *_):
        out.mkdir(parents=True)
        for folder in cases.iterdir():
            told = {"verdict": "effect", "effects": answers[folder.name]["effects"]}
            (out / f"{folder.name}.json").write_text(json.dumps(told), encoding="utf-8")
        return []

    monkeypatch.setattr(run, "verdicts", truthful)
    again.main(["--out", str(tmp_path)])
    outcome = json.loads((tmp_path / "again.json").read_text(encoding="utf-8"))
    assert {name: one["how"] for name, one in outcome.items()} == {
        "case_0001": "height_m and mass_kg",
        "case_0002": "grid and bottom_slope",
    }
    assert all(one["settled"] for one in outcome.values())
