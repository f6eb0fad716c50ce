"""Mass and size of a body count alike whether a key of [body] states them or a column of the table."""

import numpy as np
import pytest

import hlcs
from hlcs.data.experiment_file import read_experiment_file
from hlcs.data.outcome_tables import read_outcomes
from hlcs.kinds.outcomes.problem import row_groups, table_candidates

G, AIR, C, RADIUS = 9.81, 1.2, 0.47, 0.02
LIGHT, HEAVY = 0.0027, 0.0081
HEIGHTS = np.repeat([0.5, 1.0, 1.5, 2.0, 2.5, 3.0], 3)
OF_BODIES = {"added_mass", "buoyancy", "mass_offset", "size_error"}
SPHERE, DISC, AREA = 'shape = "sphere"\n', 'shape = "disc"\nheight = 0.01\n', "drag_area = 0.001257\n"


def fall_time(height, mass):
    """Time of a fall from rest under v' = g - k v^2, k = rho C A / (2 m), in closed form."""
    k = AIR * C * np.pi * RADIUS**2 / (2 * mass)
    return np.arccosh(np.exp(k * height)) / np.sqrt(G * k)


def experiment(folder, body, columns, more=""):
    """The experiment file of a table of these columns {name: values}, under a [body] and other sections."""
    rows = "".join(",".join(f"{value:.9g}" for value in row) + "\n" for row in zip(*columns.values(), strict=True))
    (folder / "t.csv").write_text(",".join(columns) + "\n" + rows)
    path = folder / "e.toml"
    path.write_text(f'kind = "outcomes"\n[body]\n{body}{more}[measurement]\nfile = "t.csv"\nnoise = 0.001\n')
    return path


def falls(columns, masses=LIGHT):
    """Columns of falls in air with white noise of 1 ms, and of these inputs."""
    times = fall_time(HEIGHTS, masses) + 0.001 * np.random.default_rng(3).standard_normal(len(HEIGHTS))
    stated = {"mass_kg": np.broadcast_to(masses, HEIGHTS.shape), "radius_m": np.full(len(HEIGHTS), RADIUS)}
    return {"height_m": HEIGHTS, **{name: stated[name] for name in columns}, "fall_time_s": times}


@pytest.mark.parametrize("keys", [(), ("mass",), ("radius",), ("mass", "radius")])
@pytest.mark.parametrize("columns", [(), ("mass_kg",), ("radius_m",), ("mass_kg", "radius_m")])
@pytest.mark.parametrize("shape", [SPHERE, DISC])
def test_a_column_and_a_key_count_alike(tmp_path, shape, keys, columns):
    if shape is DISC and not {"radius", "radius_m"} & {*keys, *columns}:
        pytest.skip("a disc without a radius is refused")
    body = shape + "".join(f"{key} = {dict(mass=LIGHT, radius=RADIUS)[key]}\n" for key in keys)
    file = read_experiment_file(experiment(tmp_path, body, falls(columns)))
    chosen, absent = table_candidates(file, read_outcomes(file), None, ())
    known = {"mass", "radius"} <= {*keys, *(name.split("_")[0] for name in columns)}
    not_stated = {name for name, why in absent.items() if why == "the mass or the size of the body is not stated"}
    assert (OF_BODIES <= {entry.name for entry in chosen}) == known and bool(not_stated) != known
    (drag,) = (entry for entry in chosen if entry.name == "quadratic_drag")
    assert [number.name for number in drag.free] == ["drag_coefficient" if known else "drag_per_metre"]


def test_a_mass_in_a_column_and_a_stated_area_are_known_to_drag(tmp_path):
    """The range of a drag at the speed of the body then rests on that mass, not on one of 1 kg."""
    ranges = {}
    for body, columns in ((f"mass = {LIGHT}\n", ()), ("", ("mass_kg",))):
        file = read_experiment_file(experiment(tmp_path, body + AREA, falls(columns)))
        chosen, _ = table_candidates(file, read_outcomes(file), ["quadratic_drag", "linear_drag"], ())
        ranges[columns] = [(number.name, number.high) for entry in chosen for number in entry.free]
    assert ranges[()] == ranges[("mass_kg",)] and "drag_coefficient" in dict(ranges[()])


def test_two_masses_of_one_ball_tell_one_drag_coefficient(tmp_path):
    """Balls of 2.7 and 8.1 g: the half width is 1.6 standard errors, and the value is within two of these half widths."""
    masses = np.where(np.arange(len(HEIGHTS)) % 2, LIGHT, HEAVY)
    path = experiment(tmp_path, f"{SPHERE}radius = {RADIUS}\n", falls(("mass_kg",), masses))
    found = hlcs.diagnose(path, candidates=["quadratic_drag", "linear_drag", "clock_offset", "mass_offset"])
    drag = found.parameters["quadratic_drag"]["drag_coefficient"]
    assert (found.verdict, found.effects) == ("effect", ("quadratic_drag",))
    assert drag["value"] == pytest.approx(C, abs=drag["high"] - drag["low"]) and drag["high"] - drag["low"] < 0.05


def test_an_input_that_is_one_in_all_rows_is_not_the_main_one(tmp_path):
    """A mass of all rows before the heights: blocks that are held out, and where the model misses, go by the heights."""
    columns = {"mass_kg": np.full(len(HEIGHTS), LIGHT)} | falls(())
    path = experiment(tmp_path, f"{SPHERE}radius = {RADIUS}\n", columns)
    file = read_experiment_file(path)
    table = read_outcomes(file)
    assert table.main == "height_m"
    assert all(np.ptp(table.inputs["height_m"][block.rows]) == 0 for block in row_groups(file, table))
    assert {row["trial"] for row in hlcs.compare(path).where} == {f"height_m = {height:g}" for height in HEIGHTS}
