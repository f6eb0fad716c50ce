"""An outcome table through both verbs: what a diagnosis finds can be written back into the file, however far it lies."""

import numpy as np
import pytest

import hlcs
from hlcs.data.notes import Stopped
from hlcs.kinds.outcomes import experiment
from hlcs.kinds.protocol import Options
from minibullet.errors import InputError

HEIGHTS = np.repeat(np.linspace(0.5, 9.0, 8), 4)


def falls(folder, ruler, model=""):
    """The experiment file of falls in a vacuum; a height of 1 m on the ruler is `ruler` m; 2 ms of scatter."""
    seconds = np.sqrt(2 * HEIGHTS / ruler / 9.81) + 0.002 * np.tile([-1.0, 1.0, 1.0, -1.0], 8)
    rows = "".join(f"{height},{time:.6f}\n" for height, time in zip(HEIGHTS, seconds, strict=True))
    (folder / "t.csv").write_text("height_m,fall_time_s\n" + rows)
    file = folder / "e.toml"
    body = 'kind = "outcomes"\n[body]\nshape = "sphere"\nradius = 0.03\nmass = 0.05\n[surroundings]\nfluid_density = 0.0\n'
    file.write_text(body + '[measurement]\nfile = "t.csv"\n' + model)
    return file


def test_a_number_found_beyond_what_is_plausible_can_be_written_back(tmp_path):
    """A ruler of 0.8 (plausible from 0.9): found, and its model is taken from a file with a note, and misses nothing."""
    found = hlcs.diagnose(falls(tmp_path, 0.8), candidates=["length_scale"])
    (factor,) = found.parameters["length_scale"].values()
    assert found.effects == ("length_scale",) and factor["value"] == pytest.approx(0.8, abs=0.01)
    seen = hlcs.compare(falls(tmp_path, 0.8, found.model.to_toml()))
    assert seen.adequate and any("lies below what is plausible (0.9 to 1.1)" in note for note in seen.notes)


def test_what_no_law_allows_stays_refused_by_file_and_line(tmp_path):
    with pytest.raises(InputError, match=r"e.toml, line 11: model.effects: length_scale: factor = -1 must be at least 0.009"):
        hlcs.compare(falls(tmp_path, 1.0, '[model]\neffects = [{ name = "length_scale", factor = -1.0 }]\n'))


def test_ctrl_c_ends_all_searches_over_a_table_and_is_told(tmp_path, monkeypatch):
    """Errors of inputs may ask for a second search: after Ctrl-C there is none, and the note of the first one stays."""
    searches = []

    class EndedSearch(experiment.Search):
        def run(self, *given):
            searches.append(self)
            found = super().run(*given)
            self.budget.stopped = True
            return found

    monkeypatch.setattr(experiment, "Search", EndedSearch)
    file = falls(tmp_path, 0.6)
    file.write_text(file.read_text() + "input_sd = { height_m = 0.05 }\n")
    found = hlcs.diagnose(file, candidates=["length_scale"])
    assert len(searches) == 1 and Stopped.among(found.notes)


def test_a_table_without_inputs_is_told_by_its_rows(tmp_path):
    """A ball of radius 50 mm that lies 52 mm high, to 0.2 mm."""
    rows = "".join(f"{0.052 + 0.0002 * (-1) ** k:.4f}\n" for k in range(8))
    (tmp_path / "t.csv").write_text("rest_height_m\n" + rows)
    file = tmp_path / "e.toml"
    body = 'kind = "outcomes"\n[body]\nshape = "sphere"\nradius = 0.05\nmass = 0.1\n[surroundings]\nfloor = { height = 0.0 }\n'
    file.write_text(body + '[measurement]\nfile = "t.csv"\n')
    prepared = hlcs.Experiment.read(file).opened(Options())._prepared
    assert prepared.problem.worst(prepared.base)[0].startswith("the rows (whose mean")


def test_where_another_gravity_would_do_the_gravity_of_the_place_is_asked_for(tmp_path):
    """Falls at 9.772 m/s2, as in Quito, told as at 9.81: no ruler and no clock need be wrong. Nowhere it is 9.5, where both may
    be a little wrong; at 1.62 of the Moon both would have to be off by more than is plausible."""
    for gravity, asked in ((9.772, True), (9.5, False), (1.62, True)):
        heights = np.repeat(np.linspace(0.5, 2.0, 6), 6)
        times = np.sqrt(2 * heights / gravity) + 2e-4 * np.random.default_rng(3).standard_normal(len(heights))
        frame = {"height_m": heights, "fall_time_s": times}
        body = {"shape": "sphere", "radius": 0.0125, "mass": 0.0638}
        table = hlcs.Experiment.from_frames([frame], body, {"fluid_density": 0.0}, kind="outcomes")
        found = hlcs.diagnose(table, candidates=["length_scale", "time_scale"])
        assert found.verdict == "ambiguous"
        assert ("surroundings.gravity" in str(found)) == asked


def test_a_scale_of_rebounds_is_told_not_to_be_that_of_the_drops(tmp_path):
    """One ruler for both shows no scale: the ratio of two heights has none."""
    heights = np.repeat(np.linspace(0.5, 2.0, 6), 5)
    rebounds = 0.64 * heights + 0.005 * np.random.default_rng(3).standard_normal(len(heights))
    frame, body = {"height_m": heights, "rebound_height_m": rebounds}, {"shape": "sphere", "radius": 0.02, "mass": 0.04}
    table = hlcs.Experiment.from_frames([frame], body, {"restitution": 0.75, "floor": {"height": 0.0}}, kind="outcomes")
    found = hlcs.diagnose(table, candidates=["length_scale"])
    assert "wrong scale of rebound_height_m, not of height_m" in str(found).replace("\n", " ")
