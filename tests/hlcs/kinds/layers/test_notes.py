"""What a report on layers says beside its tables."""

from layer_tables import experiment, measured

from hlcs.kinds.layers.data import read_layers
from hlcs.kinds.layers.notes import campaign_notes, left_out


def test_first_layers_of_two_sets_are_compared_with_each_other(tmp_path):
    tables = [measured("TPG", 1, "a"), measured("RPG", 2, "b", shift=0.026)]
    tables[1].loc[0, "cv"] = 0.01
    first, term = campaign_notes(read_layers(experiment(tmp_path, tables)).sets)
    assert "1.324 (RPG flat) against 1.298 (TPG flat), 2.0 % apart" in first and "sigma" in first
    assert term.startswith("campaign term 1.25 %")


def test_sets_that_cannot_be_judged_are_named(tmp_path):
    tables = [measured("TPG", 1, "a"), measured("RPG", 2, "b")]
    tables[0]["tests"] = ""
    measurement = read_layers(experiment(tmp_path, tables))
    (note,) = left_out(measurement, measurement.sets[1:])
    assert note.startswith("TPG flat: not judged")
    assert left_out(measurement, ()) == []  # where none can be, the verdict says so


def test_keys_that_mean_nothing_beside_a_placement_are_told(tmp_path):
    diagnose = 'hold_out = "grid"\n[surroundings]\nfriction = 0.6\n[model]\ntime_step = 0.01'
    notes = read_layers(experiment(tmp_path, [measured("TPG", 1, "a")], diagnose=diagnose)).notes
    assert [note.split(" is not used")[0] for note in notes] == ["[surroundings]", "[model] time_step"]
