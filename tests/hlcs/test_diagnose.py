"""Diagnose names what is missing from recordings made by closed forms and a fine Runge-Kutta, and stays silent on noise."""

import json

import numpy as np
import pytest
from experiments import measured
from throws import G, drag_per_metre, flight, write_throws

import hlcs
import minibullet as mb
from minibullet.errors import InputError


def test_noise_alone_is_complete(tmp_path):
    diagnosis = hlcs.diagnose(write_throws(tmp_path, rho=0.6, seed=5))
    assert diagnosis.verdict == "complete" and diagnosis.effects == () and diagnosis.next_experiment is None
    assert "smallest effects" in str(diagnosis)


def test_quadratic_drag_is_found_with_its_coefficient(tmp_path):
    """C = 0.5; strength about 4 sigma over speeds 2 to 9 m/s, so the form is decided and C known to a few per cent."""
    diagnosis = hlcs.diagnose(write_throws(tmp_path, drag_per_metre=drag_per_metre(0.5)))
    assert diagnosis.verdict in ("effect", "ambiguous") and diagnosis.effects == ("quadratic_drag",)
    number = diagnosis.parameters["quadratic_drag"]["drag_coefficient"]
    assert abs(number["value"] - 0.5) < 0.06 and number["low"] < number["value"] < number["high"]
    held = diagnosis.error["held_out"]
    assert held["after"] < 1.1 * held["noise"] < held["before"]
    assert diagnosis.steps[0]["effects"] == [] and diagnosis.steps[-1]["effects"] == ["quadratic_drag"]
    reduced = {"before": diagnosis.steps[0]["chi2_per_freedom"], "after": diagnosis.steps[-1]["chi2_per_freedom"]}
    assert diagnosis.adequate["chi2_per_freedom"] == reduced  # one number of one name, in the table and in the details


@pytest.mark.parametrize("tolerance, met", [(0.002, False), (0.05, True)])
def test_what_is_left_beyond_the_noise_is_set_beside_the_tolerance_of_the_user(tmp_path, tolerance, met):
    """A drag that no candidate explains. Left is its rms beside the best line and the fall of each throw, by ordinary least
    squares without noise; 3 % are a standard error and a half of an rms of 1,440 readings with a noise of 4 mm."""
    k, squares = drag_per_metre(0.5), []
    path = write_throws(tmp_path, drag_per_metre=k)
    path.write_text(path.read_text().replace("[[trial]]", f"[diagnose]\ntolerance = {tolerance}\n[[trial]]", 1))
    times = np.arange(0, 1.0, 1 / 60)
    for throw in range(8):
        heading, speed = np.pi / 2 * (throw % 4) + 0.2, 2.0 + throw
        velocity = speed * np.array([0.8 * np.cos(heading), 0.8 * np.sin(heading), 0.6])
        seen = flight(np.array([0.0, 0.0, 1.5]), velocity, times, drag_per_metre=k)
        seen[:, 2] += G * times**2 / 2
        squares.append((seen - np.polynomial.polynomial.polyval(times, np.polynomial.polynomial.polyfit(times, seen, 1)).T) ** 2)
    diagnosis = hlcs.diagnose(path, candidates=["spin_decay"])
    assert diagnosis.verdict == "unexplained"
    told = diagnosis.to_json()["tolerance"]
    assert told == {"value": tolerance, "unit": "m", "left": pytest.approx(np.sqrt(np.mean(squares)), rel=0.03), "met": met}
    assert f"tolerance of {1000 * tolerance:g} mm is {'met' if met else 'not met'}" in str(diagnosis)


def test_tilted_gravity_and_tilted_frame_come_as_a_set(tmp_path):
    diagnosis = hlcs.diagnose(write_throws(tmp_path, tilt=(0.01, 0.004)))
    assert diagnosis.verdict == "ambiguous" and set(diagnosis.ambiguous[0]) == {"tilted_gravity", "tilted_frame"}
    assert diagnosis.next_experiment.tests_needed >= 1 and set(diagnosis.next_experiment.separates) == set(diagnosis.ambiguous[0])


def test_unknown_noise_cannot_be_judged(tmp_path):
    diagnosis = hlcs.diagnose(write_throws(tmp_path, static=False))
    assert diagnosis.verdict == "cannot_judge" and "static" in diagnosis.next_experiment.text
    assert diagnosis.to_json()["adequate"]["after"] is None


def test_the_answer_does_not_depend_on_the_order_of_the_data(tmp_path):
    answers = []
    for order in (1, -1):
        folder = tmp_path / str(order)
        folder.mkdir()
        path = write_throws(folder, order=order, tilt=(0.006, 0.0))
        answers.append(hlcs.diagnose(path, candidates=["tilted_gravity", "linear_drag"][::order]))
    assert answers[0].verdict == answers[1].verdict and answers[0].effects == answers[1].effects
    a, b = (answer.parameters["tilted_gravity"]["angle_x"]["value"] for answer in answers)
    assert a == pytest.approx(b, rel=1e-4)  # the starts are refined to a fraction of their error, not to rounding


def test_a_user_s_own_effect_takes_part(tmp_path):
    """A constant push that the library does not know: 0.06 m/s2 along (1, 1, 0), found by ten lines in a file."""
    own = tmp_path / "own.py"
    own.write_text(
        "from dataclasses import dataclass\nimport numpy as np\nimport minibullet as mb\n\n\n@dataclass(frozen=True)\n"
        'class SidePush(mb.Effect):\n    """A constant push, force = mass * push."""\n\n'
        '    push: float = mb.parameter(0.0, unit="m/s2", low=-1, high=1, null=0.0)\n    isotropic = False\n\n'
        "    def forces(self, bodies, time):\n        wrench = np.zeros((len(bodies.mass), 6))\n"
        "        wrench[:, 0] = wrench[:, 1] = self.push * bodies.mass\n        return wrench\n"
    )
    path = write_throws(tmp_path, tilt=(0.06 / G, -0.06 / G))
    diagnosis = hlcs.diagnose(path, candidates=["linear_drag"], effects_file=own)
    assert diagnosis.effects == ("side_push",)
    assert diagnosis.parameters["side_push"]["push"]["value"] == pytest.approx(0.06, abs=0.01)


def test_an_unknown_candidate_is_named(tmp_path):
    with pytest.raises(InputError, match="quadratic_drag"):
        hlcs.diagnose(write_throws(tmp_path, count=2), candidates=["quadratc_drag"])


def test_result_file_and_pictures(tmp_path):
    diagnosis = hlcs.diagnose(write_throws(tmp_path, tilt=(0.01, 0.0)), candidates=["tilted_gravity", "quadratic_drag"])
    folder = diagnosis.save(tmp_path / "out")
    answer = json.loads((folder / "result.json").read_text())
    assert {
        "format",
        "kind",
        "title",
        "verdict",
        "effects",
        "parameters",
        "ambiguous",
        "error",
        "steps",
        "adequate",
        "candidates",
        "where",
        "next_experiment",
    } <= set(answer)
    assert answer["candidates"][0]["accepted"] and answer["adequate"]["after"] is True
    pictures = {path.stem for path in folder.glob("*.png")} - {"diagnosis"}
    assert {"fit", "ranking", "error", "residuals_time"} <= pictures
    assert (folder / "report.html").read_text().count("data:image/png") == len(pictures)
    assert "tilted_gravity" in (folder / "model.toml").read_text()
    assert "tilted_gravity" in str(diagnosis.model) and len(diagnosis.plot()) == 4


def test_the_mended_model_can_be_run(tmp_path):
    """diagnosis.model predicts a new throw: the tilt of 0.01 rad moves it by g 0.01 t^2/2 along y."""
    diagnosis = hlcs.diagnose(write_throws(tmp_path, tilt=(0.01, 0.0)), candidates=["tilted_gravity"])

    trial = measured(tmp_path / "throws.toml").trials[0]
    start = np.r_[0, 0, 0, 0, 0, 5, 1, 0, 0, 0, 0, 0, 0]
    position, _ = diagnosis.model.run(trial, start, np.array([0.0, 1.0]))
    assert position[1, 1] == pytest.approx(G * 0.01 / 2, rel=0.15)


def test_restitution_is_found_in_bounces(tmp_path):
    """Balls dropped on a floor, closed form with e = 0.8 against a model that says 0.7."""
    generator, entries = np.random.default_rng(2), []
    for k, height in enumerate((0.4, 0.6, 0.8, 1.0, 0.5, 0.9)):
        times = np.arange(0, 0.8, 1 / 60)
        fall, speed = np.sqrt(2 * height / G), np.sqrt(2 * G * height)
        after = np.maximum(times - fall, 0)
        z = np.where(times < fall, height - G * times**2 / 2, 0.8 * speed * after - G * after**2 / 2) + 0.05
        seen = np.column_stack([0 * times, 0 * times, z]) + 0.003 * generator.standard_normal((len(times), 3))
        rows = "".join(f"{t:.6f},{a:.6f},{b:.6f},{c:.6f}\n" for t, (a, b, c) in zip(times, seen, strict=True))
        (tmp_path / f"d{k}.csv").write_text("t_s,x_m,y_m,z_m\n" + rows)
        entries.append(f'[[trial]]\nfile = "d{k}.csv"\nstart = {{ velocity = [0, 0, 0], angular_velocity = [0, 0, 0] }}\n')
    path = tmp_path / "e.toml"
    path.write_text(
        'kind = "trajectory"\n[body]\nshape = "sphere"\nradius = 0.05\nmass = 0.4\n[surroundings]\n'
        "restitution = 0.7\nfloor = { height = 0.0 }\n[measurement]\nnoise = { position = 0.003 }\n" + "".join(entries)
    )
    diagnosis = hlcs.diagnose(path, candidates=["restitution", "linear_drag", "friction"])
    assert diagnosis.effects == ("restitution",)
    assert diagnosis.parameters["restitution"]["coefficient"]["value"] == pytest.approx(0.8, abs=0.01)


def test_outcome_table_with_a_late_clock(tmp_path):
    """Fall times 20 ms too long at every height: an offset of the clock, not drag."""
    generator = np.random.default_rng(4)
    heights = np.repeat(np.linspace(0.5, 9, 8), 4)
    times = np.sqrt(2 * heights / G) + 0.02 + 0.004 * generator.standard_normal(32)
    rows = "".join(f"{h},{t:.6f}\n" for h, t in zip(heights, times, strict=True))
    (tmp_path / "o.csv").write_text("height_m,fall_time_s\n" + rows)
    path = tmp_path / "e.toml"
    path.write_text('kind = "outcomes"\n[body]\nshape = "sphere"\nradius = 0.05\nmass = 0.5\n[measurement]\nfile = "o.csv"\n')
    diagnosis = hlcs.diagnose(path)
    assert "clock_offset" in {diagnosis.effects[0], *(name for names in diagnosis.ambiguous for name in names)}
    assert isinstance(mb.effects.library(), dict) and diagnosis.verdict in ("effect", "ambiguous")
