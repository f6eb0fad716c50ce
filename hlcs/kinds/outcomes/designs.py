"""More rows for an outcome table: at which value of which input they could be measured."""

import numpy as np

from hlcs.data.bodies import impossible_density
from hlcs.data.quantities import INPUTS
from hlcs.estimation.designs import BY_HAND, HIGH, Design, octaves
from hlcs.simulation.row_setups import row_setup

BEYOND = (0.25, 0.5, 2.0, 4.0)  # factors on the measured range of an input: what a laboratory can arrange
SLOPES = (-10.0, -5.0, 5.0, 10.0)  # of a floor that was level: boards on a wedge [degrees]
BODY = ("mass_kg", "radius_m")
GIVEN = (
    "friction",
    "restitution",
    "gravity_m_s2",
    "fluid_density_kg_m3",
    "fluid_viscosity_pa_s",
    "tube_radius_m",
    "spin_rad_s",
    "bounce",
)  # not to be chosen
ON_A_FLOOR = ("stop_distance_m", "slide_time_s")  # outcomes of a body that slides
SLOPED = ("slope", "angle_deg")
BOARD = 3.0  # longest board that is set on a wedge [m]
ARRANGED = {"height_m": HIGH, "speed_m_s": BY_HAND, "distance_m": HIGH}  # as far as anybody goes who has not gone further yet
TOO_LONG = 4.0  # times the largest outcome measured: the widest step of an input, so that the noise is still the same


def rows_of(file, table, other_bodies):
    """[(Design, {input: value})] of one further row each."""
    ways = levels(file, table, other_bodies)
    usual = dict(table.inputs)
    for name in ways:
        usual.setdefault(name, np.full(len(table.values), stated(file, name)))
    main = table.main
    order = np.argsort(usual[main], kind="stable") if main else np.arange(len(table.values))
    places = dict.fromkeys(int(order[k]) for k in (0, len(order) // 2, -1))
    found = {}
    for place in places:
        base = {name: float(values[place]) for name, values in usual.items()}
        for name, values in ways.items():
            for value, far in values:
                row = base | {name: value}
                others = {key for key in row if key in table.inputs and np.ptp(table.inputs[key]) > 0}
                changed = {name} if name in table.inputs or value != base[name] else set()  # not the mass that all rows have
                told = {key: row[key] for key in row if key in others | changed}
                found.setdefault(tuple(row.items()), (Design(said(told, table.outcome), told, far, "measure more rows "), row))
    return [entry for entry in found.values() if possible(file, entry[1]) and arranged(table, entry[1])]


def levels(file, table, other_bodies):
    """{input: [(value, octaves beyond what was measured)]} of all that can be chosen."""
    chosen = [name for name in table.inputs if name not in GIVEN and (other_bodies or name not in BODY)]
    if other_bodies:
        chosen += [name for name in BODY if name not in chosen and stated(file, name)]
    ways = {name: around(table.inputs.get(name, np.array([stated(file, name)]))) for name in chosen}
    if table.outcome in ON_A_FLOOR and not set(SLOPED) & set(table.inputs) and longest_way(table) <= BOARD:
        ways["angle_deg"] = [(angle, 1.0) for angle in SLOPES]
    return ways


def around(values):
    """Values within the measured range and beyond it, two digits each: [(value, octaves beyond)]."""
    low, high = float(values.min()), float(values.max())
    inside = {low: 0.0, high: 0.0, rounded((low + high) / 2): 0.0}
    beyond = {rounded(end * factor): octaves(factor) for factor in BEYOND for end in ((low,) if factor < 1 else (high,))}
    return sorted((beyond | inside).items())


def rounded(value):
    return float(f"{value:.2g}")


def stated(file, name):
    """What the file says of an input that is no column, 0 for a slope; None where it says nothing."""
    if name == "radius_m" and file.body.shape != "sphere":
        return None
    return {"mass_kg": file.body.mass, "radius_m": file.body.radius}.get(name, 0.0)


def longest_way(table):
    """The longest way on the floor that a table of slides has seen [m]."""
    return float(np.max(table.values if table.outcome == "stop_distance_m" else table.inputs.get("distance_m", 0.0)))


def arranged(table, row):
    """Can a row be arranged: its height, speed and way no larger than what was measured already, or than any laboratory has?"""
    return all(
        row[name] <= max(most, float(np.max(table.inputs[name]))) for name, most in ARRANGED.items() if name in table.inputs
    )


def said(row, outcome):
    """A row in words."""
    return "at " + ", ".join(
        f"{name} = {value:g}" + (" (upwards)" if outcome in ON_A_FLOOR and name in SLOPED and value < 0 else "")
        for name, value in row.items()
    )


def possible(file, row):
    """May a row be measured? Its inputs within their limits, its body of a density that there is."""
    if not all(INPUTS[name][0] <= value <= INPUTS[name][1] for name, value in row.items()):
        return False
    if row.get("mark_2_m", np.inf) <= row.get("mark_1_m", 0.0):
        return False
    setup = row_setup(file, {name: np.array([value]) for name, value in row.items()}, 0)
    return not impossible_density(setup.body)
