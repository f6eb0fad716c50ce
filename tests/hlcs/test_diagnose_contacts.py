"""Recordings on a floor and what acts through a drag: laws that look alike come as a set, no case ends in a crash."""

import numpy as np
import pytest
from throws import G, csv, drag_per_metre, flight, write_drops, write_throws
from tosses import write_tosses

import hlcs
from hlcs.data.notes import Stopped
from hlcs.selection.search import Search
from minibullet.errors import InputError

BLOCK = (
    'kind = "trajectory"\ntitle = "block"\n[body]\nshape = "box"\nsize = [0.12, 0.08, 0.04]\nmass = 0.35\n[surroundings]\n'
    "gravity = 9.81\nfriction = 0.3\nfloor = { height = 0.0, normal = [0.0, 0.0, 1.0] }\n[measurement]\n"
    "noise = { position = 0.001 }\n"
)


def write_slides(folder, rate, seed=3):
    """A block pushed along the floor, filmed from above (x, y), slowed by mu g + rate v until it stops (closed form)."""
    generator, text = np.random.default_rng(seed), BLOCK
    for k, (speed, heading) in enumerate(((1.0, 0.0), (1.8, 1.6), (2.4, 3.1), (1.4, 4.5))):
        brake = 0.3 * G
        stop = np.log(1 + rate * speed / brake) / rate
        times = np.arange(0, stop + 0.2, 1 / 60)
        t = np.minimum(times, stop)
        way = (speed + brake / rate) * (1 - np.exp(-rate * t)) / rate - brake / rate * t
        seen = way[:, None] * [np.cos(heading), np.sin(heading)] + 1e-3 * generator.standard_normal((len(times), 2))
        (folder / f"push_{k}.csv").write_text(csv(times, seen, ("x_m", "y_m")))
        text += f'[[trial]]\nfile = "push_{k}.csv"\ngroup = "day {k % 2}"\n'
    path = folder / "block.toml"
    path.write_text(text)
    return path


def test_laws_that_slow_a_block_alike_come_as_a_set(tmp_path):
    """mu + slope v on a level floor is a drag rate g slope: identical under water; and no height is measured, so the floor is
    assumed. In air a drag of 0.5 per second on 0.35 kg is beyond what air does (0.1 at the most), so friction it is."""
    path = write_slides(tmp_path, 0.5)
    in_air = hlcs.diagnose(path, candidates=["linear_drag", "viscous_friction", "friction"])
    assert in_air.verdict == "effect" and in_air.effects == ("viscous_friction",)
    path.write_text(path.read_text().replace("gravity = 9.81\n", "gravity = 9.81\nfluid_density = 1000.0\n"))
    diagnosis = hlcs.diagnose(path, candidates=["linear_drag", "viscous_friction", "friction"])
    assert diagnosis.verdict == "ambiguous" and set(diagnosis.ambiguous[0]) == {"linear_drag", "viscous_friction"}
    assert any("no height" in note for note in diagnosis.notes)


def write_windy_throws(folder):
    """A wind u along x: in the frame of the air the throw is one in still air."""
    generator, wind, text = np.random.default_rng(5), np.array([2.0, 0.0, 0.0]), ""
    times = np.arange(0, 1.0, 1 / 60)
    for k in range(8):
        heading, speed = np.pi / 2 * (k % 4) + 0.2, 4.0 + k
        velocity = speed * np.array([0.8 * np.cos(heading), 0.8 * np.sin(heading), 0.6])
        seen = flight(np.array([0.0, 0.0, 1.5]), velocity - wind, times, drag_per_metre(0.5)) + times[:, None] * wind
        (folder / f"throw_{k}.csv").write_text(csv(times, seen + 0.004 * generator.standard_normal((60, 3))))
        text += f'[[trial]]\nfile = "throw_{k}.csv"\ngroup = "day {k % 2}"\n'
    path = folder / "throws.toml"
    path.write_text(
        'kind = "trajectory"\n[body]\nshape = "sphere"\nradius = 0.0335\nmass = 0.0577\n[surroundings]\n'
        "fluid_density = 1.2\n[measurement]\nnoise = { position = 0.004 }\n" + text
    )
    return path


def test_wind_is_found_with_the_drag_it_acts_through(tmp_path):
    """Neither the drag nor the wind is in the model, and without the drag the wind cannot stand."""
    path = write_windy_throws(tmp_path)
    diagnosis = hlcs.diagnose(path, candidates=["quadratic_drag", "linear_drag", "uniform_flow", "tilted_gravity"])
    assert diagnosis.verdict == "effect" and diagnosis.effects == ("quadratic_drag", "uniform_flow")
    assert abs(diagnosis.parameters["uniform_flow"]["velocity_x"]["value"] - 2.0) < 0.15


def test_effects_are_told_by_their_removal(tmp_path):
    """The flow goes with the drag that it acts through."""
    diagnosis = hlcs.diagnose(write_windy_throws(tmp_path), candidates=["quadratic_drag", "uniform_flow"])
    told = {entry.effect: entry for entry in diagnosis.candidates}
    assert diagnosis.effects == ("quadratic_drag", "uniform_flow")
    assert told["quadratic_drag"].evidence > told["uniform_flow"].evidence > 1000
    assert all(entry.why.startswith("accepted: chi2 falls by") for entry in told.values())


def test_a_search_that_has_spent_its_steps_says_what_it_left_out(tmp_path, monkeypatch):
    """With no step left for a fit nothing is found, that is said, and the model is not called adequate."""
    monkeypatch.setattr("hlcs.estimation.budget.FLIGHT_LIMIT", 1.0)
    diagnosis = hlcs.diagnose(write_windy_throws(tmp_path), candidates=["quadratic_drag", "uniform_flow"])
    assert diagnosis.effects == () and diagnosis.verdict == "unexplained"
    assert any("left out" in note and "sets of effects that might do as well" in note for note in diagnosis.notes)


def test_ctrl_c_in_a_search_gives_what_is_fitted_by_then(tmp_path, monkeypatch):
    """The drag alone is fitted first, then the wind beside it; what is to come after either is not waited for."""
    expand, fitted = Search.expand, []

    def interrupted(search):
        fitted[:] = search.fits
        if len(fitted) == 3:
            raise KeyboardInterrupt
        expand(search)

    monkeypatch.setattr(Search, "expand", interrupted)
    diagnosis = hlcs.diagnose(write_windy_throws(tmp_path), candidates=["quadratic_drag", "uniform_flow"])
    assert fitted == [set(), {"quadratic_drag"}, {"quadratic_drag", "uniform_flow"}]
    assert diagnosis.effects == ("quadratic_drag", "uniform_flow")
    assert any(note.startswith("stopped by Ctrl-C") for note in diagnosis.notes)


def test_ctrl_c_before_a_search_ends_everything(tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("hlcs.kinds.trajectories.experiment.prepare", interrupted)
    with pytest.raises(KeyboardInterrupt):
        hlcs.diagnose(write_windy_throws(tmp_path))


def test_a_second_whole_law_of_drag_is_not_tried_beside_a_stated_one(tmp_path):
    path = write_throws(tmp_path)
    path.write_text(path.read_text() + '[model]\neffects = [{ name = "quadratic_drag", drag_coefficient = 0.5 }]\n')
    diagnosis = hlcs.diagnose(path, candidates=["drag_crisis", "tilted_gravity"])
    why = {finding.effect: finding.why for finding in diagnosis.candidates}
    assert why["drag_crisis"].startswith("not tried") and "leave that out of [model] effects" in why["drag_crisis"]


def test_a_table_takes_a_model_with_effects(tmp_path):
    heights = np.repeat([1.0, 2.0, 4.0, 8.0], 4)
    k = drag_per_metre(0.47)
    times = np.arccosh(np.exp(k * heights)) / np.sqrt(G * k) + 0.004 * np.random.default_rng(1).standard_normal(16)
    (tmp_path / "falls.csv").write_text(
        "height_m,fall_time_s\n" + "".join(f"{h},{t:.5f}\n" for h, t in zip(heights, times, strict=True))
    )
    (tmp_path / "falls.toml").write_text(
        'kind = "outcomes"\n[body]\nshape = "sphere"\nradius = 0.0335\nmass = 0.0577\n[surroundings]\nfluid_density = 1.2\n'
        '[model]\neffects = [{ name = "quadratic_drag", drag_coefficient = 0.47 }]\n[measurement]\nfile = "falls.csv"\n'
    )
    assert hlcs.diagnose(tmp_path / "falls.toml").verdict == "complete"


def test_a_misspelt_candidate_is_refused_by_compare(tmp_path):
    path = write_throws(tmp_path)
    path.write_text(path.read_text() + '[diagnose]\ncandidates = ["quadratic_darg"]\n')
    with pytest.raises(InputError, match="quadratic_drag"):
        hlcs.compare(path)


def test_a_tilt_is_read_right_from_the_way_a_body_drifts_until_it_lands(tmp_path):
    """Let go h above the floor, gravity tilted by a: it lands h tan a aside and stays. A step of 1/240 s is 3 % of the fall."""
    tilt, generator, entries = 0.038, np.random.default_rng(6), []
    for k, height in enumerate((0.03, 0.045, 0.06, 0.075, 0.09, 0.11)):
        times = np.arange(30) / 60
        falling = np.minimum(times, np.sqrt(2 * height / (G * np.cos(tilt)))) ** 2 / 2 * G
        track = np.column_stack([np.sin(tilt) * falling, 0 * times, 0.05 + height - np.cos(tilt) * falling])
        seen = track + 1e-4 * generator.standard_normal(track.shape)
        rows = "".join(f"{t:.6f},{x:.6f},{y:.6f},{z:.6f}\n" for t, (x, y, z) in zip(times, seen, strict=True))
        (tmp_path / f"d{k}.csv").write_text("t_s,x_m,y_m,z_m\n" + rows)
        start = "{ velocity = [0.0, 0.0, 0.0], angular_velocity = [0.0, 0.0, 0.0], orientation = [1.0, 0.0, 0.0, 0.0] }"
        entries.append(f'[[trial]]\nfile = "d{k}.csv"\ngroup = "{k % 2}"\nstart = {start}\n')
    path = tmp_path / "e.toml"
    path.write_text(
        'kind = "trajectory"\n[body]\nshape = "box"\nsize = [0.1, 0.1, 0.1]\nmass = 2.3\n'
        "[surroundings]\nfriction = 0.6\nfloor = { height = 0.0, normal = [0.0, 0.0, 1.0] }\n"
        "[measurement]\nnoise = { position = 1e-4 }\n" + "".join(entries)
    )
    diagnosis = hlcs.diagnose(path, candidates=["tilted_gravity"])
    assert diagnosis.effects == ("tilted_gravity",)
    lean = {name: number["value"] for name, number in diagnosis.parameters["tilted_gravity"].items()}
    assert np.hypot(*lean.values()) == pytest.approx(tilt, rel=0.015)  # four standard errors


def test_a_bouncing_ball_tells_its_noise_where_it_does_not_strike(tmp_path):
    """Stated noise, no static recording: that readings do not hang together is told by the stretches without a blow."""
    diagnosis = hlcs.diagnose(write_drops(tmp_path, 0.002), candidates=["restitution", "length_scale", "margin_offset"])
    assert diagnosis.verdict == "effect" and diagnosis.effects == ("restitution",)
    assert diagnosis.parameters["restitution"]["coefficient"]["value"] == pytest.approx(0.5, abs=0.01)  # four standard errors


@pytest.mark.slow
def test_friction_that_differs_from_the_file_s_is_found_in_tosses(tmp_path):
    path = write_tosses(tmp_path, [1.8, 1.5, 1.6, 1.7])
    path.write_text(path.read_text().replace("friction = 0.2", "friction = 0.45"))
    found = hlcs.diagnose(path, candidates=["friction", "restitution", "linear_drag", "adhesion", "tilted_gravity"])
    assert found.effects == ("friction",)
    assert found.parameters["friction"]["coefficient"]["value"] == pytest.approx(0.2, abs=0.02)


def test_ctrl_c_while_the_data_are_looked_at_anew_leaves_what_was_found(tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("hlcs.kinds.trajectories.experiment.beside", interrupted)
    found = hlcs.diagnose(write_windy_throws(tmp_path), candidates=["quadratic_drag", "uniform_flow"])
    assert Stopped.among(found.notes) and found.effects
