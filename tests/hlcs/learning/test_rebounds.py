"""A restitution that depends on the speed of the impact in a way that the library does not know."""

from types import SimpleNamespace

import numpy as np
import pytest

import hlcs
import minibullet as mb
from hlcs.learning import rebounds

G, RADIUS = 9.81, 0.02
FALLEN = np.sqrt(2 * G * np.linspace(0.05, 1.0, 12))  # speeds of impact [m/s]


def impacts(restitution, error=0.002):
    """Readings of impacts at the speeds FALLEN, which stray by half of their errors, up and down in turn."""
    readings = restitution(FALLEN) + error / 2 * (-1.0) ** np.arange(len(FALLEN))
    return [(e, error, speed) for e, speed in zip(readings, FALLEN, strict=True)]


def problem(groups=("a", "b"), bodies=(None, None)):
    around = SimpleNamespace(restitution=0.5)
    trials = [
        SimpleNamespace(group=name, name=name, whole=name, body=body, surroundings=around)
        for name, body in zip(groups, bodies, strict=True)
    ]
    return SimpleNamespace(trials=trials, error=lambda white: float(np.concatenate(white).std()), noise_level=1.0)


def a_fit(chi2, fixed=()):
    """A Fit of 100 readings, one number, of two recordings: white residuals alone."""
    columns = [np.ones((50, 1)) * sign for sign in (1, -1)]
    white = [np.sqrt(chi2 / 100) * (-1.0) ** np.arange(50) for _ in range(2)]
    model = SimpleNamespace(terms=(), fixed=fixed)
    projected = SimpleNamespace(projected=(white, columns))
    numbers = dict(estimate=np.zeros(1), ends=(-1e9, 1e9), belief=(np.zeros(1), np.zeros(1)))
    return SimpleNamespace(chi2=chi2, freedom=100, linearization=projected, model=model, **numbers)


@pytest.mark.parametrize(
    ("readings", "where"),
    [
        (impacts(lambda speed: 0.8 + 0 * speed), problem()),
        (impacts(lambda speed: 0.8 - 2e-4 * speed), problem()),  # less than the readings tell
        (impacts(lambda speed: 0.9 - 0.03 * speed)[:7], problem()),
        (impacts(lambda speed: 0.9 - 0.03 * speed), problem(groups=("a", "a"))),
        (impacts(lambda speed: 0.9 - 0.03 * speed), problem(bodies=("rubber", "steel"))),
        ([], problem()),
    ],
)
def test_without_a_change_that_impacts_show_no_law_is_tried(readings, where, monkeypatch):
    monkeypatch.setattr(rebounds, "_refitted", None)
    assert rebounds.learn_rebounds(where, a_fit(1e4), a_fit(1e4), readings, None, "group") is None


def test_a_law_of_the_file_itself_and_what_cannot_be_simulated_leave_the_verdict_as_it_is(monkeypatch):
    readings, own = impacts(lambda speed: 0.9 - 0.03 * speed), ({"name": "velocity_dependent_restitution", "exponent": 0.1},)
    monkeypatch.setattr(rebounds, "_refitted", None)
    assert rebounds.learn_rebounds(problem(), a_fit(1e4, own), a_fit(1e4), readings, None, "group") is None

    def refused(*_):
        raise hlcs.InputError("leaves the finite numbers")

    monkeypatch.setattr(rebounds, "_refitted", refused)
    assert rebounds.learn_rebounds(problem(), a_fit(1e4), a_fit(1e4), readings, None, "group") is None


@pytest.mark.parametrize(("left", "told"), [(500.0, True), (2000.0, False), (1e4, False)])
def test_a_law_is_told_where_it_leaves_less_than_a_tenth_of_what_known_effects_leave(left, told, monkeypatch):
    """Of 9,900 units beyond noise: 400, or 1,900, or all."""
    monkeypatch.setattr(rebounds, "_refitted", lambda *_: a_fit(left))
    monkeypatch.setattr(rebounds, "_told", lambda *_: "told")
    readings = impacts(lambda speed: 0.9 - 0.03 * speed)
    found = rebounds.learn_rebounds(problem(), a_fit(1e6), a_fit(1e4), readings, lambda problem, fit: fit, "group")
    assert found == ("told" if told else None)


def test_the_law_is_an_effect_that_keeps_all_rules():
    source = rebounds._source("Restitution falls.", 2.0, change=-0.06, exponent=1.0)
    kind = rebounds.module_of(source, "learned_effect", "learned_effect.py").LearnedRestitution
    assert mb.check_effect(kind())
    assert kind().at(0.84, 4.0) == pytest.approx(0.9 - 0.03 * 4.0)


def drop(height, duration, restitution):
    """Heights (n,) of the centre of a ball let fall, 120 a second: parabolas between impacts, in closed form."""
    times = np.arange(0.0, duration, 1 / 120)
    begin, level, speed, seen = 0.0, height, 0.0, []
    for time in times:
        while time - begin >= (lands := (speed + np.sqrt(speed**2 + 2 * G * (level - RADIUS))) / G):
            impact = G * lands - speed
            begin, level, speed = begin + lands, RADIUS, restitution(impact) * impact
        seen.append(level + speed * (time - begin) - G * (time - begin) ** 2 / 2)
    return times, np.array(seen)


def test_a_restitution_that_falls_in_a_straight_line_is_learned_and_compares(tmp_path, generator):
    """e = 0.9 - 0.03 v, of balls let fall from 0.2 to 1 m and read to 1 mm: the exponent to 0.1, e to 0.003 at all speeds."""
    text = (
        f'kind = "trajectory"\n[body]\nshape = "sphere"\nradius = {RADIUS}\nmass = 0.03\n[surroundings]\nfluid_density = 0.0\n'
        "floor = { height = 0.0, normal = [0.0, 0.0, 1.0] }\nfriction = 0.3\nrestitution = 0.85\n"
        "[measurement]\nnoise = { position = 0.001 }\n"
    )
    for k, height in enumerate((0.2, 0.45, 0.7, 1.0)):
        times, seen = drop(height, 1.2, lambda speed: 0.9 - 0.03 * speed)
        seen = seen + 1e-3 * generator.standard_normal(len(seen))
        rows = "".join(f"{t:.6f},{z:.6f}\n" for t, z in zip(times, seen, strict=True))
        (tmp_path / f"drop_{k}.csv").write_text("t_s,z_m\n" + rows)
        start = "{ velocity = [0.0, 0.0, 0.0], angular_velocity = [0.0, 0.0, 0.0] }"
        text += f'[[trial]]\nfile = "drop_{k}.csv"\nstart = {start}\n'
    (tmp_path / "drops.toml").write_text(text)
    found = hlcs.diagnose(tmp_path / "drops.toml", candidates=["friction"])
    law = found.learned
    assert found.verdict == "unexplained" and (law.variable, law.form) == ("speed", "power")
    assert law.numbers["exponent"]["value"] == pytest.approx(1.0, abs=0.1) and "falls with the speed" in str(found)
    np.testing.assert_allclose(law.band["law"], 0.9 - 0.03 * law.band["places"], atol=0.003)
    assert law.held_out["after"] < 1.15e-3 < 1e-2 < law.held_out["before"]  # the noise, and what half of the drops tell of it
    path = tmp_path / "mended" / "drops.toml"
    path.parent.mkdir()
    mended = found.apply(hlcs.Experiment.read(tmp_path / "drops.toml")).save(path)
    seen = hlcs.compare(path, allow_outside=True, effects_file=path.parent / "learned_effect.py")
    assert mended and seen.added == ("restitution", "learned_restitution")
    assert seen.error["rms"] < 1.1e-3 and not seen.before.adequate
