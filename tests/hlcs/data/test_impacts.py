"""Impacts read from samples, against bounces in closed form."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hard_cases import CELLULOID, RUBBER, per_metre
from hard_cases import bouncing as bouncing_in_air

from hlcs.data.experiment_file import Body, Surroundings
from hlcs.data.impacts import flights_of, impacts_between, read_drag, read_impacts, sides_of
from hlcs.data.recordings import Recordings, Trial
from hlcs.data.shown_by_impacts import (
    differing_from_model,
    impact_lines,
    mean_and_trend,
    rebounds_shown,
    restitution_of_single_impacts,
    sliding_friction,
)
from hlcs.estimation.correlated_noise import CorrelatedNoise
from hlcs.estimation.noise_model import Noise


def bouncing(restitution, friction, sigma, rate=240.0, speed=3.0, height=1.5, shape="sphere", seed=3):
    """A ball of 5 cm thrown over a floor: parabolas between blows with e(v) and mu that act on a point (no spin)."""
    generator = np.random.default_rng(seed)
    times, place, moving, now = np.arange(0, 2.5, 1 / rate), np.array([0.0, 0.0, height]), np.array([speed, 0.0, 0.0]), 0.0
    rows, blows = [], []
    for t in times:
        while True:
            root = (moving[2] + np.sqrt(max(moving[2] ** 2 + 2 * 9.81 * (place[2] - 0.05), 0.0))) / 9.81
            if now + root > t:
                break
            now, place = now + root, place + moving * root - np.array([0, 0, 0.5 * 9.81 * root**2])
            moving = moving - np.array([0, 0, 9.81 * root])
            down = -moving[2]
            if down < 0.3:
                return rows_to_trial(times[: len(rows)], rows, sigma, generator, shape), blows
            e = restitution(down)
            blows.append((now, down, e))
            moving = np.array([moving[0] - friction * (1 + e) * down, 0.0, e * down])
        step = t - now
        rows.append(place + moving * step - np.array([0, 0, 0.5 * 9.81 * step**2]))
    return rows_to_trial(times, rows, sigma, generator, shape), blows


def impacts_of(trial, sigma):
    """The impacts of one recording, no drag taken off."""
    return impacts_between(trial, *sides_of(trial, sigma), 0.0)


def rows_to_trial(times, rows, sigma, generator, shape):
    position = np.array(rows) + sigma * generator.normal(size=(len(rows), 3))
    body = Body(shape="sphere", radius=0.05, mass=0.1) if shape == "sphere" else Body(shape="box", size=(0.1, 0.1, 0.1), mass=0.1)
    return Trial("ball.csv", "1", times, position, np.full((len(rows), 4), np.nan), {}, body, Surroundings(floor_height=0.0))


def test_every_blow_of_a_bouncing_ball_is_found_with_its_restitution_and_friction():
    """e = 0.7, mu = 0.05, noise 0.5 mm: moments to a fifth of a frame, e and mu within four of their own standard errors."""
    trial, blows = bouncing(lambda v: 0.7, 0.05, 5e-4)
    found = impacts_of(trial, 5e-4)
    known = [blow for blow in blows if blow[0] < trial.times[-1] - 5 / 240]  # five samples after it
    assert len(found) == len(known) >= 3
    for one, (moment, down, _) in zip(found, known, strict=True):
        assert one.time == pytest.approx(moment, abs=0.2 / 240)
        assert one.speed == pytest.approx(down, abs=0.1)
        assert abs(one.restitution - 0.7) < 4 * one.restitution_error < 0.1
        assert abs(one.friction - 0.05) < 4 * one.friction_error < 0.1


def cube(times, height, angle, sigma, seed=5):
    """A recording of a cube of 10 cm at these heights of its centre [m], turned by these angles about y [rad]."""
    draw = np.random.default_rng(seed)
    angle = angle + sigma / 0.1 * draw.standard_normal(len(times))
    place = np.column_stack([0 * times, 0 * times, height]) + sigma * draw.standard_normal((len(times), 3))
    turns = np.column_stack([np.cos(angle / 2), 0 * angle, np.sin(angle / 2), 0 * angle])
    body = Body(shape="box", size=(0.1, 0.1, 0.1), mass=0.8)
    return Trial("cube.csv", "1", times, place, turns, {}, body, Surroundings(floor_height=0.0))


@pytest.mark.parametrize(
    ("tilt", "turning", "restitution", "seed"),
    [(0.3, 0.0, 0.4, 5), (0.3, 4.0, 0.4, 5), (0.6, -3.0, 0.4, 5)] + [(0.3, 0.0, 0.0, seed) for seed in range(5)],
)
def test_the_edge_on_which_a_cube_lands_shows_its_restitution(tilt, turning, restitution, seed):
    """Whatever its tilt and spin, within four errors; none at all is read from either side of zero. Its lower edge falls without
    friction on the floor; Newton's law for the edge gives a blow J along the normal with J = (1 + e) m v / (1 + m x2 / I),
    I = m a2 / 6, x its arm."""
    times, moment, inertia = np.arange(0.0, 0.45, 1 / 240), 0.35, 0.1**2 / 6  # over the mass [m2]
    x, z = 0.05 * np.array([np.cos(tilt) - np.sin(tilt), -np.sin(tilt) - np.cos(tilt)])  # the edge from the centre
    speed = 9.81 * moment + turning * x  # of approach of the edge; its velocity is v_z - omega_y x
    blow = (1 + restitution) * speed / (1 + x**2 / inertia)  # over the mass
    since, after = times - moment, times > moment
    height = -z - 9.81 * moment * since + np.where(after, blow, 0.0) * since - 9.81 * since**2 / 2
    angle = tilt + turning * since - np.where(after, x * blow / inertia, 0.0) * since
    (found,) = impacts_of(cube(times, height, angle, 3e-4, seed), 3e-4)
    assert found.time == pytest.approx(moment, abs=0.2 / 240) and found.speed == pytest.approx(speed, abs=0.05)
    assert abs(found.restitution - restitution) < 4 * found.restitution_error < 0.1


def test_a_ball_that_stays_where_it_falls_shows_no_restitution():
    """Within four errors: gravity does not pull what lies on its floor, whose heights less its share would be bent upwards."""
    times, moment = np.arange(0.0, 1.0, 1 / 240), 0.45
    height = 0.05 + 9.81 / 2 * np.maximum(moment**2 - times**2, 0.0)
    for seed in range(5):
        rows = np.column_stack([0 * times, 0 * times, height])
        (found,) = impacts_of(rows_to_trial(times, rows, 5e-4, np.random.default_rng(seed), "sphere"), 5e-4)
        assert abs(found.restitution) < 4 * found.restitution_error < 0.01


def test_a_body_that_slides_on_after_its_impact_shows_its_friction():
    """Within four errors for mu = 0.3: the floor goes on to push and to rub, and what it gave is counted for both over the same
    time. The rubbing over 0.15 s beside the push at the moment of contact would be 7 to 14 % too much."""
    times, moment = np.arange(0.0, 0.9, 1 / 240), 0.34
    since, speed = np.maximum(times - moment, 0.0), 9.81 * moment
    height = 0.05 + 9.81 / 2 * np.maximum(moment**2 - times**2, 0.0)
    along = 3.0 * times - 0.3 * (speed * since + 9.81 / 2 * since**2)
    for seed in range(5):
        trial = rows_to_trial(times, np.column_stack([along, 0 * times, height]), 5e-4, np.random.default_rng(seed), "sphere")
        (found,) = impacts_of(trial, 5e-4)
        assert abs(found.friction - 0.3) < 4 * found.friction_error < 0.02
        assert found.slip == pytest.approx(3.0, abs=0.05)


def test_the_friction_of_contacts_that_slide_is_told_beside_those_that_grip():
    """mu = 0.37; of 12 contacts 5 slide, the others take any share of it; errors 0.004 to 0.03. It lies within 1.645 errors
    in nine of ten of 200 draws: 170 at least, 180 less 2.4 standard deviations of such a count (188 here)."""
    draw, inside = np.random.default_rng(11), 0
    for _ in range(200):
        errors = draw.uniform(0.004, 0.03, 12)
        shares = np.where(np.arange(12) < 5, 1.0, draw.uniform(size=12))
        value, error = sliding_friction(0.37 * shares + errors * draw.standard_normal(12), errors)
        inside += abs(value - 0.37) < 1.645 * error
    assert inside >= 170


def test_the_restitution_of_impacts_that_agree_is_told_beside_double_ones():
    """e = 0.3; of 10 impacts 6 are of one point, the others read anything from 0 to 1: within 1.645 errors in 170 of 200 draws at
    least, as for the friction."""
    draw, inside = np.random.default_rng(12), 0
    for _ in range(200):
        errors = draw.uniform(0.004, 0.03, 10)
        single = np.where(np.arange(10) < 6, 0.3, draw.uniform(size=10))
        value, error = restitution_of_single_impacts(single + errors * draw.standard_normal(10), errors)
        inside += abs(value - 0.3) < 1.645 * error
    assert inside >= 170


def test_a_cube_that_lies_or_slides_on_its_floor_has_no_impacts():
    """Whatever the seed: carried, its height is steady; less the share of gravity it is bent, and full of kinks."""
    times = np.arange(0.0, 1.0, 1 / 240)
    for seed in range(5):
        assert impacts_of(cube(times, np.full(len(times), 0.05), 0 * times, 3e-4, seed), 3e-4) == []


def test_restitution_that_falls_with_speed_shows_as_a_trend_and_a_constant_one_does_not():
    """e = 0.9 - 0.05 v against e = 0.7: the slope within four errors of -0.05, and within three of zero."""
    for law, slope in ((lambda v: 0.9 - 0.05 * v, -0.05), (lambda v: 0.7, 0.0)):
        found = [one for seed in range(4) for one in impacts_of(bouncing(law, 0.0, 5e-4, seed=seed)[0], 5e-4)]
        _, _, trend, error = mean_and_trend(
            [one.restitution for one in found], [one.restitution_error for one in found], [one.speed for one in found]
        )
        assert abs(trend - slope) < 4 * error and (abs(trend) > 3 * error) == (slope != 0.0)


def test_free_flight_has_no_impacts_and_a_box_no_restitution_of_its_centre():
    """A throw that never lands: none; a box: friction but no e, because its corner is not its centre; heights alone: e only."""
    trial, _ = bouncing(lambda v: 0.7, 0.05, 5e-4)
    short = trial.times < 0.4
    thrown = Trial(
        "throw.csv", "1", trial.times[short], trial.position[short], trial.orientation[short], {}, trial.body, trial.surroundings
    )
    assert impacts_of(thrown, 5e-4) == []
    box = impacts_of(bouncing(lambda v: 0.7, 0.05, 5e-4, shape="box")[0], 5e-4)
    assert box and all(one.restitution is None and one.friction is not None for one in box)
    trial.position[:, :2] = np.nan
    heights = impacts_of(trial, 5e-4)
    assert heights and all(one.friction is None and one.restitution is not None for one in heights)
    text = "\n".join(impact_lines(heights, {"restitution": 0.5, "friction": 0.3}))
    assert "the model has 0.5" in text and Path("ball.csv").name in text


def test_a_search_begins_with_what_the_impacts_show_where_the_model_has_something_else():
    """e = 0.7, mu = 0.05, read from some 25 blows; a model that has them already is told nothing."""
    found = [one for seed in range(6) for one in impacts_of(bouncing(lambda v: 0.7, 0.05, 5e-4, seed=seed)[0], 5e-4)]
    first = differing_from_model(found, Surroundings(floor_height=0.0, restitution=0.4, friction=0.3))
    assert first["restitution"]["coefficient"] == pytest.approx(0.7, abs=0.02)
    assert first["friction"]["coefficient"] == pytest.approx(0.05, abs=0.02)
    assert differing_from_model(found, Surroundings(floor_height=0.0, restitution=0.7, friction=0.05)) == {}
    falling = [one for seed in range(6) for one in impacts_of(bouncing(lambda v: 0.8 * v**-0.15, 0.0, 5e-4, seed=seed)[0], 5e-4)]
    law = differing_from_model(falling, Surroundings(floor_height=0.0, restitution=0.8))["velocity_dependent_restitution"]
    assert law["exponent"] == pytest.approx(0.15, abs=0.02)
    assert differing_from_model(found[:3], Surroundings(floor_height=0.0)) == {}  # three blows are no basis


@pytest.mark.parametrize("at_one", [0.8, 0.83])
def test_impacts_show_the_restitution_at_one_metre_a_second_beside_how_it_falls_with_speed(generator, at_one):
    """e = e_1 v^-0.05 read to 0.003 at speeds of 1 to 4 m/s, where the file states 0.8; 20 readings tell e_1 to 0.0013. Alone
    either number hides the other: at e_1 = 0.83 the mean is 0.8. Whether e_1 is that of the file is for a fit to say."""
    speeds = np.geomspace(1.0, 4.0, 20)
    read = at_one * speeds**-0.05 + 0.003 * generator.standard_normal(20)
    told = {"restitution_error": 0.003, "friction": None, "friction_error": None}
    impacts = [SimpleNamespace(restitution=e, speed=v, **told) for e, v in zip(read, speeds, strict=True)]
    (shown,) = rebounds_shown(impacts, Surroundings(floor_height=0.0, restitution=0.8), {})
    assert shown["restitution"]["coefficient"] == pytest.approx(at_one, abs=4 * 0.0013)
    assert shown["velocity_dependent_restitution"]["exponent"] == pytest.approx(0.05, abs=0.01)


def test_an_impact_that_ends_in_rest_hides_no_power_of_speed(generator):
    """e = 0.7 v^-0.4, steeper than any ball is known for, read to 0.005 at 1 to 4 m/s, and one impact that the body does not
    leave: it is no rebound, and the other twenty tell the power and e_1 to 0.006."""
    speeds = np.append(np.geomspace(1.0, 4.0, 20), 0.8)
    read = np.append(0.7 * speeds[:-1] ** -0.4 + 0.005 * generator.standard_normal(20), -0.004)
    told = {"restitution_error": 0.005, "friction": None, "friction_error": None}
    impacts = [SimpleNamespace(restitution=e, speed=v, **told) for e, v in zip(read, speeds, strict=True)]
    (shown,) = rebounds_shown(impacts, Surroundings(floor_height=0.0, restitution=0.7), {})
    assert shown["velocity_dependent_restitution"]["exponent"] == pytest.approx(0.4, abs=4 * 0.006)
    assert shown["restitution"]["coefficient"] == pytest.approx(0.7, abs=4 * 0.006)


def test_a_sample_on_the_wrong_side_of_an_impact_moves_no_restitution():
    """At 60 pictures a second, noise 1 mm, e = 0.74, over 40 throws: every reading within four of its errors.

    An impact that is too near the end of a recording to be read lends its samples to a kink before it: readings from -0.8 to 0.6.
    """
    for seed in range(40):
        trial, _ = bouncing(lambda v: 0.74, 0.0, 1e-3, rate=60.0, seed=seed, height=1.0 + 0.01 * seed)
        for one in impacts_of(trial, 1e-3):
            assert abs(one.restitution - 0.74) < 4 * one.restitution_error, (seed, one)


def dropped(body, drag, seed):
    """Six recordings of a ball let fall in air from 0.70 to 0.80 m, e = 0.8, 120 pictures a second, noise 1 mm; closed form."""
    generator, times, trials = np.random.default_rng(seed), np.arange(0, 1.1, 1 / 120), []
    for number in range(6):
        place = 1e-3 * generator.standard_normal((len(times), 3))
        place[:, 2] += body["radius"] + bouncing_in_air(0.7 + 0.02 * number, times, per_metre(drag, **body), 0.8)
        turns = np.full((len(times), 4), np.nan)
        trials.append(
            Trial(f"{number}.csv", "1", times, place, turns, {}, Body("sphere", **body), Surroundings(floor_height=0.0))
        )
    return tuple(trials)


@pytest.mark.parametrize(("body", "most"), [(RUBBER, 0.004), (CELLULOID, 0.012)])
def test_drag_takes_little_from_a_restitution(body, most):
    """Left in, it takes 0.9 % from e of a rubber ball and 3.7 % from that of a table-tennis ball. Taken off by what the bends of
    all flights show, less than `most` is left (0.1 % and 0.6 % over 120 impacts)."""
    noise = Noise(CorrelatedNoise(1e-3, 0.0, 0.0, np.zeros((3, 3))), None, 1 / 120, "stated")
    seen, left_in = [], []
    for seed in range(3):
        trials = dropped(body, 0.47, seed)
        seen += [one.restitution for one in read_impacts(Recordings(None, trials, None, ()), noise)]
        left_in += [one.restitution for trial in trials for one in impacts_of(trial, 1e-3)]
    assert len(seen) == len(left_in) == 36
    assert abs(np.mean(seen) / 0.8 - 1) < most < 0.8 * abs(np.mean(left_in) / 0.8 - 1)


@pytest.mark.parametrize(("stated", "count"), [(0.87, 0), (0.8, 2)])
def test_a_restitution_and_a_drag_are_shown_together(stated, count):
    """Impacts at 4 to 2 m/s that show e = 0.87, flights that show a drag: where the file states 0.8, both hide each other. A file
    that states 0.87 leaves but the drag."""
    told = {"restitution_error": 0.01, "friction": None, "friction_error": None}
    read = zip((0.86, 0.88, 0.87, 0.88, 0.865, 0.865), np.linspace(4.0, 2.0, 6), strict=True)
    impacts = [SimpleNamespace(restitution=e, speed=v, **told) for e, v in read]
    drags = {"quadratic_drag": {"drag_coefficient": 0.47}, "linear_drag": {"rate": 0.4}}
    together = rebounds_shown(impacts, Surroundings(floor_height=0.0, restitution=stated), drags)
    assert [set(shown) for shown in together] == [{"restitution", name} for name in drags][:count]
    for shown, name in zip(together, drags, strict=False):
        assert shown["restitution"]["coefficient"] == pytest.approx(0.87, abs=0.01) and shown[name] == drags[name]


@pytest.mark.parametrize(("body", "error"), [(RUBBER, 0.0035), (CELLULOID, 0.006)])
def test_drag_is_read_from_all_of_a_flight_between_two_impacts(body, error):
    """Six such flights of 0.55 s tell k to 0.0025 and 0.0045 / m; the 0.15 s beside each impact alone, to 0.0073 and 0.0085. The
    root mean square of twelve is off by more than 40 % once in a hundred times."""
    read = np.array([read_drag([sides_of(trial, 1e-3) for trial in dropped(body, 0.47, seed)]) for seed in range(12)])
    assert np.sqrt(np.mean((read - per_metre(0.47, **body)) ** 2)) < error


def test_impacts_that_follow_at_once_leave_no_flight_between_them():
    """One sample is between them, and shows no drag: no line goes through it."""
    flight, sides = sides_of(dropped(CELLULOID, 0.47, 0)[0], 1e-3)
    after = sides[0][1]
    at_once = slice(after.start - 4, after.start + 1), slice(after.start + 1, after.stop)
    twice = [sides[0], at_once, *sides[1:]]
    assert len(flights_of(flight, twice)) == len(flights_of(flight, sides))
    assert read_drag([(flight, twice)]) == pytest.approx(read_drag([(flight, sides)]), rel=0.1)  # but for two samples the same


def test_flights_without_drag_are_not_bent_straight():
    """In a vacuum nothing is taken off: the readings keep every bit."""
    trials = dropped(RUBBER, 1e-9, 0)
    noise = Noise(CorrelatedNoise(1e-3, 0.0, 0.0, np.zeros((3, 3))), None, 1 / 120, "stated")
    assert read_drag([sides_of(trial, 1e-3) for trial in trials]) == 0.0
    assert list(read_impacts(Recordings(None, trials, None, ()), noise)) == [
        one for trial in trials for one in impacts_of(trial, 1e-3)
    ]
