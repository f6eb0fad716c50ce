"""A sphere sinks in glycerine: the viscosity is found from times and from recordings, by the closed form of Stokes's law."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import hlcs
from hlcs.data.experiment_file import read_experiment_file
from hlcs.data.outcome_tables import read_outcomes
from hlcs.kinds.outcomes.problem import fastest_rows

G, ETA, GLYCERINE, STEEL = 9.81, 1.4, 1260.0, 7800.0
DRAGS = ("quadratic_drag", "drag_crisis")
HEIGHTS = np.repeat(np.linspace(0.1, 0.8, 6), 3)


def sphere(rate, lift, inertia):
    """(radius, mass, rate of decay, acceleration) of a steel sphere; rate: 6 pi eta r / m [1/s]."""
    radius = np.sqrt(4.5 * ETA / (STEEL * rate))
    mass, displaced = STEEL * 4 / 3 * np.pi * radius**3, GLYCERINE * 4 / 3 * np.pi * radius**3
    moved = mass + inertia * displaced
    return radius, mass, 6 * np.pi * ETA * radius / moved, (mass - lift * displaced) * G / moved


def sunk(t, k, g):
    """Way from rest under v' = g - k v."""
    return g / k * (t + np.expm1(-k * t) / k)


def head(kind, radius, mass, extra=""):
    body = f'[body]\nshape = "sphere"\nradius = {radius}\nmass = {mass}\n'
    return f'kind = "{kind}"\n{body}[surroundings]\nfluid_density = {GLYCERINE}\n{extra}'


@pytest.mark.parametrize("rate, others", [(1.0, DRAGS), (10.0, ()), (100.0, DRAGS), (1000.0, ())])  # other drags take their time
def test_the_viscosity_is_found_from_times(tmp_path, rate, others):
    """Times to 0.2 % of their median, and the lift is stated: 18 of them tell the viscosity to 0.1 %."""
    radius, mass, k, g = sphere(rate, 1.0, 0.5)
    exact = np.array([brentq(lambda t, h=h: sunk(t, k, g) - h, 1e-9, 1e7, xtol=1e-13) for h in HEIGHTS])
    sigma = 0.002 * float(np.median(exact))
    times = exact + sigma * np.random.default_rng(3).standard_normal(len(exact))
    (tmp_path / "t.csv").write_text(
        "height_m,fall_time_s\n" + "".join(f"{h},{t:.8g}\n" for h, t in zip(HEIGHTS, times, strict=True))
    )
    stated = '[model]\neffects = [{ name = "buoyancy", fluid_density = 1260.0 }, { name = "added_mass", coefficient = 0.5 }]\n'
    path = tmp_path / "e.toml"
    path.write_text(head("outcomes", radius, mass, f'{stated}[measurement]\nfile = "t.csv"\nnoise = {sigma}\n'))
    found = hlcs.diagnose(path, candidates=["stokes_drag", "sphere_drag", "linear_drag", "clock_offset", *others])
    assert (found.verdict, found.effects) == ("effect", ("stokes_drag",)), (found.ambiguous, found.parameters)
    assert found.parameters["stokes_drag"]["viscosity"]["value"] == pytest.approx(ETA, rel=0.02)


def test_the_lift_is_expected_where_only_the_slow_fall_shows_it(tmp_path):
    """Without a drag a bead falls 0.8 m in 0.4 s, and its lift changes that by milliseconds; with it in, the lift of the stated
    glycerine is a sixth of its weight, for which the viscosity would be found a sixth too large."""
    radius, mass, k, g = sphere(300.0, 1.0, 0.5)
    exact = np.array([brentq(lambda t, h=h: sunk(t, k, g) - h, 1e-9, 1e7, xtol=1e-13) for h in HEIGHTS])
    times = exact + 0.1 * np.random.default_rng(3).standard_normal(len(exact))
    (tmp_path / "t.csv").write_text(
        "height_m,fall_time_s\n" + "".join(f"{h},{t:.8g}\n" for h, t in zip(HEIGHTS, times, strict=True))
    )
    path = tmp_path / "e.toml"
    path.write_text(head("outcomes", radius, mass, '[measurement]\nfile = "t.csv"\nnoise = 0.1\n'))
    found = hlcs.diagnose(
        path, candidates=["stokes_drag", "sphere_drag", "linear_drag", "buoyancy", "added_mass", "clock_offset"]
    )
    assert found.verdict != "unexplained" and {"stokes_drag", "buoyancy"} <= set(found.effects), found.sets
    assert found.parameters["stokes_drag"]["viscosity"]["value"] == pytest.approx(ETA, rel=0.02)


AT_REST = "start = { velocity = [0.0, 0.0, 0.0] }\n"


@pytest.mark.parametrize(
    ("rate", "way", "start", "others"),
    [
        (10.0, 0.3, "", ["quadratic_drag"]),
        (100.0, 0.3, "", ["quadratic_drag"]),
        (1000.0, 0.05, "", []),  # 6 s at 8 mm/s: at its final speed from the first millisecond on
        (100.0, 0.3, AT_REST, ["quadratic_drag"]),
    ],
)
def test_the_viscosity_is_found_from_recordings_of_a_sphere_that_sinks(tmp_path, rate, way, start, others):
    """What the file states of the liquid is found beside it: its lift, and the fluid that moves along where the data show it."""
    radius, mass, k, g = sphere(rate, 1.0, 0.5)
    draw, times, text = np.random.default_rng(1), np.linspace(0.0, way * k / g + 1 / k, 60), ""
    for index in range(4):
        heights = 1 - sunk(times, k, g) + 0.0005 * draw.standard_normal(60)
        rows = "".join(f"{t:.6f},{z:.6f}\n" for t, z in zip(times, heights, strict=True))
        (tmp_path / f"{index}.csv").write_text("t_s,z_m\n" + rows)
        text += f'[[trial]]\nfile = "{index}.csv"\ngroup = "{index % 2}"\n{start}'
    path = tmp_path / "e.toml"
    path.write_text(head("trajectory", radius, mass, "[measurement]\nnoise = { position = 0.0005 }\n" + text))
    found = hlcs.diagnose(path, candidates=["stokes_drag", "sphere_drag", "linear_drag", "buoyancy", "added_mass", *others])
    assert found.verdict == "effect" and {"stokes_drag", "buoyancy"} <= set(found.effects) <= {
        "stokes_drag",
        "buoyancy",
        "added_mass",
    }
    assert found.parameters["stokes_drag"]["viscosity"]["value"] == pytest.approx(ETA, rel=0.02)


def test_a_drag_in_proportion_to_speed_is_the_viscosity_only_where_the_flow_may_creep(tmp_path):
    """As thin as water, a marble has Reynolds numbers of ten thousand: the flow does not creep, and a crisis is out of reach."""
    rows = "".join(f"{h},{np.sqrt(2 * h / G) * (1.2 + 0.01 * k):.6f}\n" for h in (0.1, 0.2, 0.4) for k in range(3))
    (tmp_path / "t.csv").write_text("height_m,fall_time_s\n" + rows)
    path = tmp_path / "e.toml"
    for viscosity, kept, left in (("fluid_viscosity = 1e-3\n", "linear_drag", "stokes_drag"), ("", "stokes_drag", "linear_drag")):
        path.write_text(head("outcomes", 0.003, 8.8e-4, viscosity + '[measurement]\nfile = "t.csv"\n'))
        opened = hlcs.Experiment.read(path).opened(hlcs.kinds.protocol.Options())
        names, why = opened.names(None), opened._candidates(None)[1]
        assert kept in names and left in why and "drag_crisis" in why


BEADS = (0.00015, 0.00025, 0.0004, 0.0006, 0.0009)  # radii [m]


def passages(folder, fluid=1000.0, eta=1e-3, stated=1e-3, bead=2500.0, radii=BEADS, noise=0.01):
    """Beads, of glass and 0.3 to 1.8 mm in water, between marks 0.1 and 0.4 m below their release, by Schiller and Naumann's
    curve; fluid, bead: densities [kg/m3]; eta, stated: viscosity, and what the file says [Pa s]."""
    rows, draw = "radius_m,mass_kg,mark_1_m,mark_2_m,passage_time_s\n", np.random.default_rng(8)
    for radius in radii:
        volume = 4 / 3 * np.pi * radius**3

        def slope(_, state, radius=radius, volume=volume):
            reynolds = max(2 * radius * fluid * state[1] / eta, 1e-12)
            drag = 6 * np.pi * eta * radius * state[1] * (1 + 0.15 * reynolds**0.687)
            return state[1], ((bead - fluid) * volume * G - drag) / (bead * volume)

        way = solve_ivp(slope, (0, 60), (0, 0), "LSODA", dense_output=True, rtol=1e-9, atol=1e-12).sol
        first, last = (brentq(lambda t, mark=mark, way=way: way(t)[0] - mark, 1e-6, 60) for mark in (0.1, 0.4))
        for _ in range(4):
            time = last - first + noise * draw.standard_normal()
            rows += f"{radius},{bead * volume:.6g},0.1,0.4,{time:.3f}\n"
    (folder / "t.csv").write_text(rows)
    path = folder / "e.toml"
    surroundings = f"[surroundings]\nfluid_density = {fluid}\nfluid_viscosity = {stated}\n"
    path.write_text(f'kind = "outcomes"\n[body]\nshape = "sphere"\n{surroundings}[measurement]\nfile = "t.csv"\n')
    return path


def test_beads_in_water_are_held_back_by_what_their_reynolds_numbers_tell(tmp_path):
    """Reynolds numbers of 12 to 440: by twice its mean speed the largest would seem beyond the law."""
    found = hlcs.diagnose(
        passages(tmp_path), candidates=["sphere_drag", *DRAGS, "stokes_drag", "linear_drag", "buoyancy", "added_mass"]
    )
    assert found.verdict == "effect" and {"sphere_drag", "buoyancy"} <= set(found.effects), found.sets
    told = found.parameters["sphere_drag"]["viscosity"]
    # 20 times to 0.01 s tell the viscosity beside the lift to 0.88 %, by the derivatives of these falls: 90 % in 1.74 of that
    assert told["value"] == pytest.approx(1e-3, rel=3 * 0.0088)
    assert told["high"] - told["low"] == pytest.approx(
        2 * 1.74 * 0.0088e-3, rel=0.6
    )  # the noise is that of 15 degrees of freedom
    assert found.reynolds["sphere_drag"]["holds"] is True


def test_a_wrong_viscosity_is_told_beside_the_lift_that_the_file_states(tmp_path):
    """Steel beads of 2 to 6 mm in glycerine, Reynolds numbers up to 0.6: the curve of a sphere in place of Stokes's law. And
    without the lift of the stated glycerine, a sixth of the weight, its viscosity would be a sixth too large."""
    path = passages(tmp_path, 1258.0, 1.1, 1.4, 7800.0, (0.001, 0.0015, 0.002, 0.0025, 0.003), 0.05)
    open_to_doubt = hlcs.diagnose(path)  # in a narrow tube Stokes's law would hold the large ones back as well
    assert "sphere_drag" in open_to_doubt.effects and "tube_radius" in open_to_doubt.next_experiment.text
    path.write_text(path.read_text().replace("[measurement]", "tube_radius = 2.0\n[measurement]"))  # a tank
    found = hlcs.diagnose(path)
    assert (found.verdict, set(found.effects) - {"tube_drag"}) == ("effect", {"sphere_drag", "buoyancy"}), found.sets
    assert found.parameters["sphere_drag"]["viscosity"]["value"] == pytest.approx(1.1, rel=0.02)


@pytest.mark.parametrize("surroundings, number", [("fluid_viscosity = 0.9\n", ""), ("", ", viscosity = 0.9")])
def test_a_viscosity_that_is_not_as_stated_is_told_by_its_own_name(tmp_path, surroundings, number):
    """It falls by 8 % for each degree. A drag in the model takes the number from [surroundings], or states its own: either may be
    wrong, and no other form of the law is set beside it."""
    path = passages(tmp_path, 1258.0, 1.1, 1.4, 7800.0, (0.001, 0.0015, 0.002, 0.0025, 0.003), 0.005)
    lift = '{ name = "buoyancy" }, { name = "added_mass", coefficient = 0.5 }, '
    model = f'{surroundings}[model]\neffects = [{lift}{{ name = "sphere_drag"{number} }}]\n[measurement]'
    path.write_text(path.read_text().replace("fluid_viscosity = 1.4\n", "").replace("[measurement]", model))
    found = hlcs.diagnose(path)
    assert (found.verdict, found.effects) == ("effect", ("sphere_drag",)), found.sets
    told = found.parameters["sphere_drag"]["viscosity"]
    assert told["value"] == pytest.approx(1.1, rel=2e-3) and told["stated"] == 0.9  # times of 3 to 30 s, each to 5 ms


def test_the_highest_speed_of_a_fall_is_twice_its_mean_where_it_is_free_and_its_mean_where_it_is_slow(tmp_path):
    """2 h/T of a free fall through h; of one that takes 20 times as long the mean and 1/400 of it more."""
    free = np.sqrt(2 * HEIGHTS / G)
    for times, expected in ((free, 2 * HEIGHTS / free), (20 * free, HEIGHTS / (20 * free) * (1 + 1 / 400))):
        rows = "".join(f"{h},{t:.10g}\n" for h, t in zip(HEIGHTS, times, strict=True))
        (tmp_path / "t.csv").write_text("height_m,fall_time_s\n" + rows)
        (tmp_path / "e.toml").write_text(head("outcomes", 0.001, 3e-5, '[measurement]\nfile = "t.csv"\n'))
        file = read_experiment_file(tmp_path / "e.toml")
        found = fastest_rows(file, read_outcomes(file))
        np.testing.assert_allclose(np.sort(found), np.sort(expected), rtol=1e-8)


BATHS = (0.8, 1.2, 1.7)  # Pa s: one glycerine at three temperatures; the Reynolds numbers stay below 0.03


def baths(folder, model):
    """Two recordings in each bath, each with the viscosity of its own stated, noise 0.1 mm; way under v' = g - k v."""
    radius, mass, rate, g = sphere(200.0, 1.0, 0.5)
    times, draw, text = np.arange(0, 3.0, 0.05), np.random.default_rng(14), ""
    for number, eta in enumerate(2 * BATHS):
        z = -sunk(times, rate * eta / ETA, g) + 1e-4 * draw.standard_normal(len(times))
        rows = "".join(f"{t:.2f},{height:.6f}\n" for t, height in zip(times, z, strict=True))
        (folder / f"r{number}.csv").write_text(f"t_s,z_m\n{rows}")
        text += f'[[trial]]\nfile = "r{number}.csv"\ngroup = "{eta}"\nfluid_viscosity = {eta}\n'
        text += "start = { velocity = [0.0, 0.0, 0.0] }\n"
    path = folder / "e.toml"
    lift = '{ name = "buoyancy" }, { name = "added_mass", coefficient = 0.5 }'
    effects = f"[model]\neffects = [{lift}{model}]\n[measurement]\nnoise = {{ position = 1e-4 }}\n"
    path.write_text(head("trajectory", radius, mass, effects + text))
    return path


def test_a_drag_without_a_number_takes_the_viscosity_that_each_recording_states(tmp_path):
    """Stokes's law with eta of 0.8, 1.2 and 1.7 Pa s is exact here: nothing but noise is left, and no number to be found."""
    stated = hlcs.diagnose(baths(tmp_path, ', { name = "stokes_drag" }'), candidates=["stokes_drag", "quadratic_drag"])
    assert stated.verdict == "complete", stated.effects
    assert not any("viscosities" in note for note in stated.notes)


def test_viscosities_that_differ_are_told_where_one_number_would_be_found_for_all(tmp_path):
    """One number in place of 0.8 to 1.7 Pa s leaves final speeds that are wrong by a third: the note says what to write."""
    told = [note for note in hlcs.compare(baths(tmp_path, "")).notes if "viscosities of 0.8 to 1.7 Pa s" in note]
    assert len(told) == 1 and '{ name = "sphere_drag" } without a number' in told[0]


def test_viscosities_of_rows_are_told_likewise(tmp_path):
    """What the columns say is enough for a drag without a number: [surroundings] need not say it again."""
    radius, mass, rate, g = sphere(200.0, 1.0, 0.5)
    rows = "".join(
        f"{h},{eta},{brentq(lambda t: sunk(t, rate * eta / ETA, g) - h, 1e-9, 1e7) * (1 + k * 1e-3):.5f}\n"  # noqa: B023
        for h in HEIGHTS[:3]
        for eta in BATHS
        for k in (-1, 1)
    )
    (tmp_path / "t.csv").write_text(f"height_m,fluid_viscosity_pa_s,fall_time_s\n{rows}")
    path = tmp_path / "e.toml"
    path.write_text(head("outcomes", radius, mass, '[measurement]\nfile = "t.csv"\n'))
    told = [note for note in hlcs.compare(path).notes if "viscosities of 0.8 to 1.7 Pa s" in note]
    assert len(told) == 1 and told[0].endswith('{ name = "sphere_drag" } without a number in [model] effects')
    lift = '{ name = "buoyancy" }, { name = "added_mass", coefficient = 0.5 }, { name = "stokes_drag" }'
    model = f'[model]\neffects = [{lift}]\n[measurement]\nfile = "t.csv"\n'
    path.write_text(head("outcomes", radius, mass, model))
    assert hlcs.compare(path).adequate


def in_a_tube(folder, narrow, seed=5):
    """Path of a table: six sizes of steel beads sink 0.2 m in glycerine in a tube of 20 mm radius, or in a tank; 1 % noise.

    narrow: part of the radius of a bead over that of the tube that its walls count for, 1 or 0. Steady speeds by Stokes's law
    and, of a tube, the series of H. Faxen (1922), which that of the effect follows to 0.1 % here.
    """
    generator, rows = np.random.default_rng(seed), ""
    for radius in np.repeat([0.5e-3, 0.75e-3, 1e-3, 1.5e-3, 2e-3, 3e-3], 5):
        q = narrow * radius / 0.02
        speed = 2 / 9 * (STEEL - GLYCERINE) * G * radius**2 / ETA * (1 - 2.104 * q + 2.09 * q**3 - 0.95 * q**5)
        time = 0.2 / speed * (1 + 0.01 * generator.standard_normal())
        rows += f"{radius},{STEEL * 4 / 3 * np.pi * radius**3:.8g},0.05,0.25,{time:.8g}\n"
    (folder / "t.csv").write_text(f"radius_m,mass_kg,mark_1_m,mark_2_m,passage_time_s\n{rows}")
    path = folder / "e.toml"
    path.write_text(head("outcomes", 1e-3, 3e-5, '[measurement]\nfile = "t.csv"\n'))
    return path


def test_the_walls_of_a_tube_are_found_where_beads_differ_in_size(tmp_path):
    """The largest has 0.15 of its radius, for which the walls add 44 %: without them the viscosity follows the size."""
    found = hlcs.diagnose(in_a_tube(tmp_path, 1.0))
    assert (found.verdict, set(found.effects)) == ("effect", {"stokes_drag", "buoyancy", "tube_drag"}), found.sets
    tube, viscosity = found.parameters["tube_drag"]["inverse_radius"], found.parameters["stokes_drag"]["viscosity"]
    assert tube["low"] < 50.0 < tube["high"] and 0.3 * tube["value"] > tube["high"] - tube["low"]
    assert viscosity["low"] < ETA < viscosity["high"] and "is a tube of" in str(found)


def test_a_tube_that_the_data_contradict_is_told_beside_the_one_that_they_show(tmp_path):
    """Walls of 20 mm radius, 50 /m, where the file states a tank of 2 m, 0.5 /m to a tenth."""
    path = in_a_tube(tmp_path, 1.0)
    path.write_text(path.read_text().replace("[measurement]", "tube_radius = 2.0\n[measurement]"))
    found = hlcs.diagnose(path)
    assert "tube_drag" in found.effects
    assert "lies above the 0.5 1/m that the file states, by more than twice the 10 %" in " ".join(str(found).split())


def test_a_tube_is_not_told_where_there_are_no_walls(tmp_path):
    found = hlcs.diagnose(in_a_tube(tmp_path, 0.0))
    assert (found.verdict, set(found.effects)) == ("effect", {"stokes_drag", "buoyancy"}), found.sets


def test_a_stated_tube_is_believed_and_fills_in_its_effect(tmp_path):
    """Of one size of bead nothing tells the walls from the viscosity but what the file states of the tube."""
    path = in_a_tube(tmp_path, 1.0)
    model = '[model]\neffects = [{ name = "stokes_drag", viscosity = 1.4 }, { name = "tube_drag" }, { name = "buoyancy" }]\n'
    text = path.read_text().replace("[measurement]", f"tube_radius = 0.02\n{model}[measurement]")
    path.write_text(text)
    assert hlcs.compare(path).adequate
    path.write_text(text.replace("tube_radius = 0.02\n", ""))
    with pytest.raises(hlcs.InputError, match="tube_drag stands without a number; give inverse_radius"):
        hlcs.compare(path)


def test_a_bead_that_does_not_fit_into_its_tube_is_refused(tmp_path):
    """The largest has 3 mm: in the file the tube is compared with the body that it states, in a row with the row's."""
    path = in_a_tube(tmp_path, 1.0)
    text = path.read_text()
    path.write_text(text.replace("[measurement]", "tube_radius = 0.0025\n[measurement]"))
    with pytest.raises(
        hlcs.InputError, match=r"t.csv, row 28: 0.0025 m, and the body has a radius of 0.003 m: it does not fit in"
    ):
        hlcs.compare(path)
    path.write_text(text.replace("[measurement]", "tube_radius = 0.001\n[measurement]"))
    with pytest.raises(hlcs.InputError, match=r"line 8: surroundings.tube_radius: 0.001 m, and the body has a radius of 0.001 m"):
        hlcs.compare(path)


def test_each_row_may_state_a_tube_of_its_own(tmp_path):
    """Half of the rows were measured in a tank: with the effect in the model each takes its own tube; else that is told."""
    (narrow := tmp_path / "narrow").mkdir()
    (wide := tmp_path / "wide").mkdir()
    rows = [path.parent.joinpath("t.csv").read_text().split() for path in (in_a_tube(narrow, 1.0), in_a_tube(wide, 0.0))]
    table = "".join(f"{row},{tube}\n" for tube, some in zip((0.02, 50.0), rows, strict=True) for row in some[1:])
    (wide / "t.csv").write_text(f"{rows[0][0]},tube_radius_m\n{table}")
    path = wide / "e.toml"
    found = hlcs.compare(path)
    assert any("tubes of 0.02 to 50 m radius are stated, and tube_drag finds one for all" in note for note in found.notes)
    model = '[model]\neffects = [{ name = "stokes_drag", viscosity = 1.4 }, { name = "buoyancy" }, { name = "tube_drag" }]\n'
    path.write_text(path.read_text().replace("[measurement]", f"{model}[measurement]"))
    found = hlcs.compare(path)
    assert found.adequate and not any("tubes of" in note for note in found.notes)
