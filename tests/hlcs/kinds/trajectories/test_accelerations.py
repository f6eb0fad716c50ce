"""Accelerometers: slides, falls and spins in closed form; a reading is the mean of v' - g over the time between two."""

import numpy as np
import pytest

import hlcs
from hlcs.data.recordings import read_recordings
from hlcs.kinds.protocol import Options
from hlcs.kinds.trajectories.preparation import prepare
from hlcs.selection.eligibility import candidates_for
from hlcs.selection.search import Search
from hlcs.simulation.track import Track
from minibullet.errors import InputError

G, RATE, SIGMA = 9.81, 100.0, 0.02
BOX = {"shape": "box", "size": [0.15, 0.075, 0.01], "mass": 0.2}  # a phone
CUBE = {"shape": "box", "size": [0.1, 0.1, 0.1], "mass": 0.05}
AREA = 6 * 0.1**2 / 4  # mean projected area of a cube: a quarter of its surface (Cauchy 1832) [m2]
DRAG, DENSITY = 1.05, 1.2
DROPPED = {"position": [0.0, 0.0, 5.0], "velocity": [0.0, 0.0, 0.0]}
NAMES = ("ax_m_s2", "ay_m_s2", "az_m_s2")


def read(times, velocity):
    """Mean acceleration over 1/RATE about each time, cut at the ends of the recording, of a velocity in closed form, (n,)."""
    begin, end = (np.clip(times + half, times[0], times[-1]) for half in (-0.5 / RATE, 0.5 / RATE))
    return (velocity(end) - velocity(begin)) / (end - begin)


def frame(times, readings, seed):
    """A recording of readings (n, 3) with white noise."""
    noisy = readings + SIGMA * np.random.default_rng(seed).standard_normal(readings.shape)
    return {"t_s": times, **dict(zip(NAMES, noisy.T, strict=True))}


def slide(friction, speed, seed, heading=0.0, samples=50):
    """A phone that slides in a heading, stops after v0 / (mu g), and lies still."""
    times = np.arange(samples) / RATE
    along = read(times, lambda t: np.maximum(speed - friction * G * t, 0.0))
    return frame(times, np.column_stack([along * np.cos(heading), along * np.sin(heading), 0 * times + G]), seed)


def fall(coefficient, seed, spin=0.0):
    """A cube in free fall, v = -v_t tanh(g t / v_t), v_t^2 = 2 m g / (rho C A); along body axes that turn about x with `spin`."""
    times = np.arange(100) / RATE
    force = 0 * times
    if coefficient:
        limit = np.sqrt(2 * CUBE["mass"] * G / (DENSITY * coefficient * AREA))
        force = read(times, lambda t: -limit * np.tanh(G * t / limit)) + G
    turn = spin * times
    return frame(times, np.column_stack([0 * times, force * np.sin(turn), force * np.cos(turn)]), seed)


def experiment(frames, body, axes="world", start=None, noise=SIGMA, **sections):
    trials = [{"start": start} for _ in frames] if start else None
    return hlcs.Experiment.from_frames(
        frames, body=body, noise={"acceleration": noise}, trials=trials, measurement={"accelerometer": axes}, **sections
    )


def sliding(friction, **diagnose):
    """Slides along x and along y: along x alone a friction that depends on the direction does the same."""
    frames = [slide(0.31, speed, seed, heading) for seed, (speed, heading) in enumerate(((0.8, 0.0), (1.1, np.pi / 2)))]
    around = {"floor": {"height": 0.0}, "friction": friction, "fluid_density": 0.0}
    return experiment(frames, BOX, surroundings=around, diagnose=diagnose)


OFFSET = (0.15, -0.08, 0.1)  # of an accelerometer in a phone [m/s2]


def off(readings):
    """A recording by an instrument that is off."""
    return readings | {name: readings[name] + shift for name, shift in zip(NAMES, OFFSET, strict=True)}


def offset_told(found):
    """Are the three numbers of the offset told within four standard errors (an interval of 90 % holds 1.6), and no worse than
    their noise allows? A quarter of the noise is four times the error of a mean of some 250 readings."""
    numbers = found.parameters["accelerometer_offset"]
    return all(
        number["low"] - 1.5 * (half := number["high"] - number["low"]) < true < number["high"] + 1.5 * half and half < SIGMA
        for number, true in ((numbers[axis], true) for axis, true in zip("xyz", OFFSET, strict=True))
    )


@pytest.mark.parametrize("friction", [0.31, pytest.param(0.4, marks=pytest.mark.slow)])
def test_an_accelerometer_that_is_off_is_told_from_a_friction(friction):
    """What it reads while the phone lies still tells; the floor is taken to have 0.31 or 0.4."""
    frames = [off(slide(0.31, speed, seed, heading)) for seed, (speed, heading) in enumerate(((0.8, 0.0), (1.1, np.pi / 2)))]
    around = {"floor": {"height": 0.0}, "friction": friction, "fluid_density": 0.0}
    found = hlcs.diagnose(experiment(frames, BOX, surroundings=around))
    assert found.verdict == "effect" and set(found.effects) == {"accelerometer_offset", *["friction"] * (friction != 0.31)}
    assert offset_told(found)


def held_and_struck(held, falls, seed, push=0.0, samples=200):
    """A phone in a hand that shakes by 0.3 m/s2 and opens over 40 ms, let go at `held`, on a cushion after `falls` [s]: decaying
    blows of 60 m/s2. The hand goes down and up before it throws, by so many times gravity."""
    times = np.arange(samples) / RATE
    since = times - held - falls
    blow = G + 60 * np.exp(-np.maximum(since, 0.0) / 0.02) * np.cos(200 * since)
    swing = np.select([times < held - 0.4, times < held - 0.2], [1.0, 1.0 - push], 1.0 + push)
    hand = (G * swing + 0.3 * np.sin(7 * times)) * np.clip((held - times) / 0.04, 0.0, 1.0)
    along = np.where(times < held, hand, np.where(since < 0, 0.0, blow))
    return off(frame(times, np.column_stack([0 * times, 0 * times, along]), seed))


@pytest.mark.parametrize(("push", "stated"), [(0.0, {}), (0.0, {"velocity": [0.0, 0.0, 0.0]}), (0.8, {})])
def test_a_fall_is_read_from_the_release_to_the_impact(push, stated):
    """The readings in the hand and on the cushion are left out: they would be an offset of many times its size."""
    frames = [held_and_struck(0.9, 0.555, 1, push), held_and_struck(0.7, 0.545, 2, push)]
    still = {"orientation": [1.0, 0.0, 0.0, 0.0], "angular_velocity": [0.0, 0.0, 0.0]} | stated
    around = {"fluid_density": 0.0}
    found = hlcs.diagnose(experiment(frames, BOX, axes="body", start=still, surroundings=around))
    assert (found.verdict, found.effects) == ("effect", ("accelerometer_offset",)) and offset_told(found)
    told = [note for note in found.notes if "left out" in note]
    assert "frame 1 (0.89 s), frame 2 (0.69 s): rests in the hand at first" in told[0]
    assert told[1].startswith("frame 1 (1.45 s), frame 2 (1.24 s): strikes something") and len(told) == 2


def pushed(friction, rests, pushes, seed):
    """A phone that lies for `rests`, is pushed for `pushes` [s] by 4 m/s2 in the mean, slides by itself, and lies again."""
    times = np.arange(300) / RATE
    since, speed = times - rests, 4 * pushes
    push = 2 * np.pi * np.sin(np.pi * since / pushes)
    ended = rests + pushes + speed / (friction * G)
    along = np.select([since < 0, since < pushes, times < ended], [0 * times, push, 0 * times - friction * G])
    return off(frame(times, np.column_stack([along, 0 * times, 0 * times + G]), seed))


def test_a_slide_begins_where_the_push_ends_and_its_friction_is_as_sure_as_its_readings():
    """Of n readings of a steady slide the mean is off by sigma/sqrt(n), and the friction by as much over g. Where the phone stops
    tells its unknown speed, and nothing of the friction: a fit that is stuck a sample aside of it was five times as sure."""
    frames = [pushed(0.28, 0.9, 0.25, 1), pushed(0.28, 1.0, 0.28, 2), pushed(0.28, 1.1, 0.31, 3)]
    around, names = {"floor": {"height": 0.0}, "friction": 0.4, "fluid_density": 0.0}, ["friction", "accelerometer_offset"]
    found = hlcs.diagnose(experiment(frames, BOX, surroundings=around, diagnose={"candidates": names}))
    assert found.verdict == "effect" and set(found.effects) == set(names) and offset_told(found)
    number = found.parameters["friction"]["coefficient"]
    readings = sum(4 * pushes / (0.28 * G) * RATE for pushes in (0.25, 0.28, 0.31))
    half = 1.645 * SIGMA / G / np.sqrt(readings)
    assert (number["high"] - number["low"]) / 2 == pytest.approx(half, rel=0.3)  # the offset is known three times as well
    assert number["value"] == pytest.approx(0.28, abs=2.5 * half)
    (note,) = [note for note in found.notes if "pushed" in note]
    assert note.startswith("frame 1 (1.1 s), frame 2 (1.3 s), frame 3 (1.4 s): rests on its floor, and is pushed, at first")


def test_a_phone_that_lies_without_a_floor_is_told():
    """What falls reads nothing, but for its drag."""
    frames = [slide(0.31, 0.0, 1), fall(DRAG, 2)]
    compared = hlcs.compare(experiment(frames, BOX, surroundings={"fluid_density": DENSITY}))
    (note,) = [note for note in compared.notes if "reads gravity" in note]
    assert note.startswith("frame 1: reads gravity") and "state surroundings.floor" in note


@pytest.mark.parametrize("speed", [0.0, 12.0])
def test_no_drag_is_taken_for_a_hand_or_an_impact(speed):
    """A cube that is thrown down twice as fast as it sinks feels four times its weight at first, one at rest nothing; in the end
    both feel all of it."""
    times, limit = np.arange(300) / RATE, 6.0
    root = np.arctanh(speed / limit) if speed < limit else np.arctanh(limit / speed)
    fast = np.tanh(G * times / limit + root) if speed < limit else 1 / np.tanh(G * times / limit + root)
    readings = frame(times, np.column_stack([0 * times, 0 * times, G * fast**2]), 5)
    start = {"position": [0.0, 0.0, 50.0]}
    compared = hlcs.compare(experiment([readings], CUBE, start=start, surroundings={"fluid_density": DENSITY}))
    assert len(compared.to_dataframe()) == 900 and not any("left out" in note for note in compared.notes)


def test_an_accelerometer_that_is_off_hides_no_drag():
    frames = [off(fall(DRAG, k)) for k in (0, 1)]
    found = hlcs.diagnose(experiment(frames, CUBE, start=DROPPED, surroundings={"fluid_density": DENSITY}))
    assert found.verdict == "effect" and found.effects == ("quadratic_drag", "accelerometer_offset") and offset_told(found)


def test_a_velocity_that_acts_by_its_square_takes_no_misfit_away():
    """A fall of unknown start, read along its way alone, with an error of 0.1 m/s2: a velocity across it would change readings
    by its square, of which there is no slope. What is left is what the best start along it leaves."""
    wrong = [off(fall(DRAG, k)) for k in (0, 1)]
    frames = [{"t_s": each["t_s"], "az_m_s2": each["az_m_s2"]} for each in wrong]
    model = {"effects": [{"name": "quadratic_drag", "drag_coefficient": DRAG}]}
    opened = experiment(frames, CUBE, surroundings={"fluid_density": DENSITY}, model=model).opened(Options())
    fit = prepare(opened.measurement).base
    left = [sum(float(part @ part) for part in parts) for parts in (fit.linearization.white, fit.linearization.projected[0])]
    assert left[0] == pytest.approx(left[1], abs=0.1)


SOME = {"candidates": ["friction", "load_dependent_friction"]}


@pytest.mark.parametrize(
    "diagnose", [SOME, pytest.param({}, marks=pytest.mark.slow)], ids=["two candidates", "the whole library"]
)
def test_friction_is_read_from_how_a_phone_slows_down_on_a_floor(diagnose):
    """a = -mu g until it stops; its speed at the start is told by when it stops, and stated nowhere."""
    found = hlcs.diagnose(sliding(0.4, **diagnose))
    assert not any("isolated" in note for note in found.notes)  # readings about the stop stand alone, and are good
    number = found.parameters["friction"]["coefficient"]
    assert found.verdict == "effect" and found.effects == ("friction",) and found.error["unit"] == "m/s2"
    half = number["high"] - number["low"]
    assert number["low"] - half / 2 < 0.31 < number["high"] + half / 2  # four standard errors: the interval holds 90 %


def test_a_fit_finds_the_friction_of_slides_that_end_long_after_the_model_has_stopped():
    """Where a body stops a reading leaps, and its derivative there says nothing of the samples farther off."""
    frames = [slide(0.28, speed, seed, samples=100) for seed, speed in enumerate((0.8, 1.1, 1.5, 1.9))]
    around = {"floor": {"height": 0.0}, "friction": 0.45, "fluid_density": 0.0}
    opened = experiment(frames, BOX, surroundings=around).opened(Options())
    prepared = prepare(opened.measurement)
    chosen, _ = candidates_for(opened.measurement, True, ["friction"])
    search = Search(prepared.problem, chosen, prepared.base)
    fit = prepared.problem.fit(search.preview.model_with({"friction": {"coefficient": 0.45}}))
    assert fit.converged and search.noise_alone(fit)
    assert fit.estimate[0] == pytest.approx(0.28, abs=4 * np.sqrt(fit.covariance[0, 0]))


def test_a_slide_with_the_right_friction_is_complete():
    assert hlcs.diagnose(sliding(0.31, **SOME)).verdict == "complete"


def test_a_phone_that_slides_down_ever_faster_is_no_phone_that_slides_up_and_stops():
    """Let go at rest on a slope of 25 degrees, v' = g (sin a - mu cos a); nobody states that start."""
    slope, friction, times = np.radians(25), 0.22, np.arange(40) / RATE
    down = G * (np.sin(slope) - friction * np.cos(slope)) * np.array([np.cos(slope), 0.0, -np.sin(slope)])
    frames = [frame(times, np.tile(down + [0.0, 0.0, G], (40, 1)), seed) for seed in range(2)]
    floor = {"height": 0.0, "normal": [np.sin(slope), 0.0, np.cos(slope)]}
    lying = {"orientation": [np.cos(slope / 2), 0.0, np.sin(slope / 2), 0.0]}
    compared = hlcs.compare(experiment(frames, BOX, start=lying, surroundings={"floor": floor, "friction": friction}))
    assert compared.error["rms"] == pytest.approx(SIGMA, rel=0.15)  # 240 readings: a standard error of 5 %


@pytest.mark.parametrize("coefficient", [0.0, DRAG])
def test_drag_and_nothing_else_is_read_in_free_fall(coefficient):
    around = {"fluid_density": DENSITY}
    found = hlcs.diagnose(experiment([fall(coefficient, k) for k in (0, 1)], CUBE, start=DROPPED, surroundings=around))
    if not coefficient:
        assert found.verdict == "complete" and not found.effects
        return
    number = found.parameters["quadratic_drag"]["drag_coefficient"]
    half = number["high"] - number["low"]
    assert found.verdict == "effect" and found.effects == ("quadratic_drag",)
    assert number["low"] - half / 2 < DRAG < number["high"] + half / 2


def spinning(spin_stated):
    start = {**DROPPED, "orientation": [1.0, 0.0, 0.0, 0.0], "angular_velocity": [spin_stated, 0.0, 0.0]}
    frames = [fall(DRAG, seed, spin=6.0) for seed in (3, 4)]
    model = {"effects": [{"name": "quadratic_drag", "drag_coefficient": DRAG}]}
    return experiment(frames, CUBE, "body", start, surroundings={"fluid_density": DENSITY}, model=model)


def test_the_axes_of_a_spinning_body_turn_with_it():
    """A drag straight up is read as (0, sin wt, cos wt) by a body that turns about x; with another spin it is not."""
    assert hlcs.compare(spinning(6.0)).adequate
    assert not hlcs.compare(spinning(-6.0)).adequate


def test_a_start_that_no_acceleration_tells_leaves_the_fit_as_it_is():
    """In a vacuum all speeds read alike: the unstated velocity has no column, and stays finite."""
    thrown = experiment([fall(0.0, 5)], CUBE, surroundings={"fluid_density": 0.0})
    base = prepare(thrown.opened(Options()).measurement).base
    assert not np.concatenate(base.linearization.state_columns).any() and base.linearization.state_columns[0].shape[1] == 3
    assert np.array_equal(base.initial_states[0, :6], np.zeros(6)) and hlcs.compare(thrown).adequate


def test_a_mean_acceleration_over_a_window_is_the_change_of_velocity_in_it():
    """v = t^2 between nodes a step apart: exact where the window is a step long, whatever its phase."""
    nodes = np.linspace(0.0, 1.0, 11)
    velocity = np.zeros((11, 1, 3))
    velocity[:, 0, 2] = nodes**2
    track = Track(nodes, 0 * velocity, velocity, np.zeros((11, 1, 4)), 0 * velocity, np.zeros((10, 1), bool))
    times = np.array([[0.3, 0.37, 0.52]])
    mean = track.mean_acceleration(times, np.array([[0.1]]))[0, :, 2]
    np.testing.assert_allclose(mean, 2 * times[0], rtol=1e-12)  # d(t^2)/dt; both ends err alike


@pytest.mark.parametrize("stop", [0.3, 0.317, 0.34])
def test_a_slide_that_stops_inside_a_step_is_read_as_if_steps_were_short(stop):
    """Nodes 1/30 s apart see v0 - a t until it stops: the mean over any window is that of the closed form, to rounding."""
    nodes, slowing = np.arange(31) / 30, 3.0
    velocity = np.zeros((31, 1, 3))
    velocity[:, 0, 0] = np.maximum(slowing * (stop - nodes), 0.0)
    track = Track(nodes, 0 * velocity, velocity, np.zeros((31, 1, 4)), 0 * velocity, np.zeros((30, 1), bool))
    times = np.linspace(0.2, 0.5, 40)[None]
    begin, end = times[0] - 0.005, times[0] + 0.005
    due = (np.maximum(slowing * (stop - end), 0.0) - np.maximum(slowing * (stop - begin), 0.0)) / 0.01
    np.testing.assert_allclose(track.mean_acceleration(times, np.array([[0.01]]))[0, :, 0], due, atol=1e-11)


LYING = {"orientation": [1.0, 0.0, 0.0, 0.0], "angular_velocity": [0.0, 0.0, 0.0]}
REFUSED = [
    ({"axes": None}, ("column 'ax_m_s2'", "accelerometer = ")),
    ({"axes": "body"}, ("start = { orientation", "[[trial]]")),
    ({"scale": 1000.0}, ("not in cm/s2",)),
    ({"scale": 1 / G}, ("multiples of g", "9.81")),
    ({"scale": -1.0}, ("turn the sign",)),
    ({"shift": -G}, ("taken out",)),
    ({"shift": -G, "columns": ("t_s", "ax_m_s2", "az_m_s2")}, ("taken out",)),
    ({"shift": -G, "columns": ("t_s", "az_m_s2")}, ("taken out",)),
    ({"swap": True}, ("gravity is read in column ay_m_s2",)),
    ({"shift": -G, "axes": "body", "start": LYING}, ("taken out",)),
    ({"scale": 1 / G, "axes": "body", "start": LYING}, ("multiples of g",)),
    ({"planar": True}, ("planar", "floor")),
]


@pytest.mark.parametrize("case, words", REFUSED)
def test_what_no_accelerometer_reads_is_refused_with_the_remedy(case, words):
    rows = slide(0.31, 0.8, 0)
    rows = {name: values * (1 if name == "t_s" else case.get("scale", 1.0)) for name, values in rows.items()}
    rows["az_m_s2"] = rows["az_m_s2"] + case.get("shift", 0.0)
    rows = {name: rows[name] for name in case.get("columns", rows)}
    if "swap" in case:
        rows["ay_m_s2"], rows["az_m_s2"] = rows["az_m_s2"], rows["ay_m_s2"]
    axes = case.get("axes", "world")
    measurement = ({"accelerometer": axes} if axes else {}) | ({"planar": True} if "planar" in case else {})
    with pytest.raises(InputError) as problem:
        hlcs.compare(
            hlcs.Experiment.from_frames(
                [rows],
                body=BOX,
                surroundings={"floor": {"height": 0.0}},
                noise={"acceleration": SIGMA},
                measurement=measurement,
                trials=[{"start": case["start"]}] if "start" in case else None,
            )
        )
    assert "\n" not in str(problem.value)
    for word in words:
        assert word in str(problem.value), str(problem.value)


def test_the_noise_of_an_accelerometer_is_read_from_a_phone_at_rest():
    """200 readings of each axis tell a standard deviation to 1 / sqrt(2 * 600) = 3 %; 12 % is four of these."""
    times = np.arange(200) / RATE
    rest = frame(times, np.column_stack([0 * times, 0 * times, 0 * times + G]), 9)
    fell = hlcs.Experiment.from_frames(
        [fall(0.0, 5)],
        body=CUBE,
        surroundings={"fluid_density": 0.0},
        static=rest,
        trials=[{"start": DROPPED}],
        measurement={"accelerometer": "world"},
    )
    seen = hlcs.compare(fell)
    assert seen.noise["source"] == "static recording"
    assert seen.noise["acceleration"] == pytest.approx(SIGMA, rel=0.12)


def test_the_picture_shows_the_channel_that_the_model_misses_most():
    """All of the drag of a fall stands in az."""
    sections = {"surroundings": {"fluid_density": DENSITY}, "diagnose": {"candidates": ["quadratic_drag"]}}
    found = hlcs.diagnose(experiment([fall(DRAG, k) for k in (0, 1)], CUBE, start=DROPPED, **sections))
    assert any(ax.get_ylabel() == "az [m/s2]" for ax in np.ravel(found.plot())[0].figure.axes)


def test_a_ball_that_rolls_turns_its_accelerometer_and_is_not_refused():
    """From rest, ever faster: gravity goes round the axes of the body three times in all."""
    turned = 6 * np.pi * np.linspace(0.0, 1.0, 100) ** 2
    readings = frame(np.arange(100) / RATE, G * np.column_stack([0 * turned, np.sin(turned), np.cos(turned)]), 4)
    ball = {"shape": "sphere", "radius": 0.05, "mass": 0.2}
    rolled = hlcs.Experiment.from_frames(
        [readings],
        body=ball,
        surroundings={"floor": {"height": 0.0}},
        noise={"acceleration": SIGMA},
        measurement={"accelerometer": "body"},
        trials=[{"start": LYING}],
    )
    assert len(read_recordings(rolled.file).trials) == 1
