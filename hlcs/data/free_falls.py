"""Falls, slides and rebounds beside those that nothing hinders: what is faster stands in other units, or in another column.

Gravity alone bounds them: a body let go comes no sooner than through nothing, a slide no sooner than without friction, and no
floor at rest gives back more than it gets. No effect and no noise is asked for.
"""

import warnings

import numpy as np

from minibullet.errors import InputError, InputWarning

LENGTHS = {"feet": 0.3048, "inches": 0.0254, "centimetres": 0.01, "millimetres": 0.001}  # m
BRAKED = (0.8, 1.05)  # part of the pull of gravity that a fall shows whose unit is known by it: air may brake it by a fifth
TWICE = 2.0  # how far a fall may be from that of gravity alone for its clock to be known by it: drag or a bounce make it slower
TOO_FAST = 1.5  # times the pull from which falls are told: no shipped effect makes a body fall so fast
FAR_TOO_FAST = 25.0  # from which a table is refused: its times are five times too short, which no clock that starts late makes
GAINED = 1.5  # energy after an impact over that before it: at most 1, and 1.1^2/0.9^2 where each speed is off by a tenth
AS_FREE = 1.5  # times gravity that a fall timed by hand through light drag may seem to have, and one over that
SLOWING = 1.3  # mean speed of the shortest fall over that of the longest: 1 at most, but for errors of a tenth in each time
# outcome -> what it is of, the power of their ratio that is one of energies
IMPACTS = {"rebound_height_m": ("height_m", 1), "rebound_speed_m_s": ("impact_speed_m_s", 2)}
HARDEST = 3.0  # no friction is larger, not that of soft rubber on dry stone
CONVERTED = ", or let hlcs import convert the file"  # the end of each remedy of units


def check_free(table, gravity):
    """Refuse what is impossible in an OutcomeTable: columns that are exchanged, units in which bodies come far too soon; warn of
    what is less so."""
    if table.outcome in IMPACTS:
        _check_rebounds(table)
    if not gravity > 1:
        return
    if table.outcome == "fall_time_s" and "height_m" in table.inputs:
        _check_exchanged(table, gravity)
    if table.outcome == "range_m" and "angle_deg" in table.inputs:
        _check_launch(table, gravity)
    if table.outcome == "stop_distance_m" and not {"slope", "angle_deg"} & table.inputs.keys():
        _tell_hard_stops(table, gravity)
    free, pull = free_times(table, gravity)
    known = np.isfinite(free) & (table.values > 0) & (pull > 0)
    sooner = float(np.median((free[known] / table.values[known]) ** 2)) if known.any() else 0.0
    if sooner > TOO_FAST:
        _tell_sooner(table, sooner, float(np.median(pull[known])), gravity)


def free_times(table, gravity):
    """(least time in which each row of a table can come about [s], pull along its way [m/s2]), each (n,).

    Through nothing, and without friction: a bounce comes after the first impact. Not a number where no time is known.
    """
    none, inputs = np.zeros(len(table.values)), table.inputs
    speed, gravity = inputs.get("speed_m_s", inputs.get("start_speed_m_s", none)), inputs.get("gravity_m_s2", gravity) + none
    begin, way, pull = none, inputs.get("height_m"), gravity
    if table.outcome == "slide_time_s":
        way, pull = inputs.get("distance_m"), gravity * np.sin(_angles(inputs, none))
    elif table.outcome == "passage_time_s":
        begin, way = inputs.get("mark_1_m", none), inputs.get("mark_2_m")
    elif table.outcome not in ("fall_time_s", "bounce_time_s"):
        way = None
    if way is None:
        return none + np.nan, pull
    with np.errstate(all="ignore"):
        until_end, until_begin = (2 * part / (speed + np.sqrt(speed**2 + 2 * pull * part)) for part in (way, begin))
        return np.where(way > 0, until_end - np.nan_to_num(until_begin), np.nan), pull


def _check_launch(table, gravity):
    """Refuse angles of throws that go too far through nothing at so many degrees, and not at so many radians."""
    angles, speed = table.inputs["angle_deg"], table.inputs["speed_m_s"]
    pull = table.inputs.get("gravity_m_s2", gravity)

    def far(angle):
        up = speed * np.sin(angle)
        with np.errstate(all="ignore"):
            free = speed * np.cos(angle) * (up + np.sqrt(up**2 + 2 * pull * table.inputs.get("height_m", 0.0))) / pull
            return float(np.nanmedian(table.values / free))

    in_degrees, in_radians = far(np.deg2rad(angles)), far(angles)
    if 0 < np.abs(angles).max() <= np.pi / 2 and in_degrees > TOO_FAST and in_radians < BRAKED[1]:
        raise InputError(
            f"{table.file}, column angle_deg: throws go {in_degrees:.3g} times as far as through nothing at so small an angle; "
            f"units that cannot be right: angles in degrees: these look like radians, multiply them by 57.2958{CONVERTED}"
        )


def _tell_hard_stops(table, gravity):
    """Warn of stops on the level, v^2/(2 g d), that no friction makes, and a usual one does were speeds in kilometres an hour."""
    pull, there = table.inputs.get("gravity_m_s2", gravity), table.values > 0
    stopped = table.inputs["speed_m_s"] ** 2 / (2 * pull * np.where(there, table.values, np.inf))
    friction = float(np.median(stopped[there])) if there.any() else 0.0
    if friction > HARDEST and friction / 3.6**2 < HARDEST / 2:
        where = f"{table.file}, columns speed_m_s and {table.outcome}"
        told = f"{where}: stops as by a friction of {friction:.3g}; speeds are in m/s, are these in km/h?"
        warnings.warn(told, InputWarning, stacklevel=4)


def _angles(inputs, none):
    """How steep the floor of each row is (n,) [rad]."""
    return np.deg2rad(inputs["angle_deg"]) if "angle_deg" in inputs else np.arctan(inputs.get("slope", none))


def _tell_sooner(table, sooner, pull, gravity):
    """Refuse, or warn of, rows that come about as if pulled `sooner` times as strongly as they can be."""
    ways = [name for name in ("angle_deg", "slope", "height_m", "distance_m", "mark_1_m", "mark_2_m") if name in table.inputs]
    where, seen = f"{table.file}, columns {', '.join(ways)} and {table.outcome}", sooner * pull
    told, units, remedies = f"a fall of {seen:.3g} m/s2 where gravity is {pull:.3g} m/s2", question(sooner), remedy(sooner)
    if table.outcome == "slide_time_s":
        told = f"a slide of {seen:.3g} m/s2 where gravity pulls by {pull:.3g} m/s2 down such a slope without friction"
        units, remedies = "angles are in degrees, " + units, f"angles in degrees (radians times 57.2958), {remedies}"
        angles = np.abs(table.inputs.get("angle_deg", np.full(1, np.inf)))
        if angles.max() <= np.pi / 2 and seen < TOO_FAST * gravity * np.median(np.sin(angles)):
            units = "angles are in degrees, are these in radians?"
            remedies = f"angles in degrees: these look like radians, multiply them by 57.2958{CONVERTED}"
    if sooner > FAR_TOO_FAST:
        raise InputError(f"{where}: {told}; units that cannot be right: {remedies}")
    warnings.warn(f"{where}: {told}; {units}", InputWarning, stacklevel=4)


def question(lengths):
    """What may be meant by lengths so many times too large, the end of a warning."""
    return f"lengths are in m, {f'are these in {unit}?' if (unit := _unit_of(lengths)) else 'times in s'}"


def remedy(lengths, times=None):
    """What to do with lengths so many times too large if times are right, or times so many times too large if lengths are (None:
    as a fall has them), the end of a refusal."""
    times = lengths**-0.5 if times is None else times
    if unit := _unit_of(lengths):
        what = f"these look like {unit}, multiply them by {LENGTHS[unit]:g}"
    elif 1 / TWICE < times / 1000 < TWICE:
        what = "these look like milliseconds, divide them by 1000"
    else:
        what = "multiply centimetres by 0.01, millimetres by 0.001, divide milliseconds by 1000"
    return f"lengths in m, times in s: {what}{CONVERTED}"


def _unit_of(lengths):
    """The unit in LENGTHS of lengths so many times too large; None where it is none of these."""
    return next((unit for unit, size in LENGTHS.items() if BRAKED[0] <= lengths * size <= BRAKED[1]), None)


def _check_exchanged(table, gravity):
    """Refuse heights and times of falls that stand in each other's column."""
    heights, times = table.inputs["height_m"], table.values
    falls = float(np.median(2 * heights / np.maximum(times, 1e-9) ** 2))
    if not 1 / AS_FREE < falls / gravity < AS_FREE and exchanged(heights, times, gravity):
        raise InputError(
            f"{table.file}, columns height_m and fall_time_s: a fall of {falls:.3g} m/s2 where gravity is "
            f"{gravity:.3g} m/s2, ever slower on its way; exchanged, all rows are free falls: are the columns mixed up?"
        )


def exchanged(heights, times, gravity):
    """Would all falls from rest (n,), (n,) be free ones were heights and times exchanged, and is none possible as they stand?

    A body that was let go only gets faster or keeps its speed, in whatever fluid: the longer way has the higher mean speed.
    """
    if not (heights.min() > 0 and times.min() > 0):
        return False
    free = 2 * times / heights**2 / gravity  # of a fall through `times` [m] in `heights` [s]: 1 where it is free
    speeds = heights / times
    shortest, longest = (np.median(speeds[heights == end]) for end in (heights.min(), heights.max()))
    return bool(free.min() > 1 / AS_FREE and free.max() < AS_FREE and shortest > SLOWING * longest)


def _check_rebounds(table):
    """Refuse rebounds with far more energy than the impacts had; warn where every one has more: no reading is off in all rows."""
    before, power = IMPACTS[table.outcome]
    struck = table.inputs.get(before, np.zeros(1)) > 0
    if not struck.all():
        return
    ratio = table.values / table.inputs[before]
    told = (
        f"{table.file}, columns {before} and {table.outcome}: a rebound has {np.median(ratio):.3g} times what it came with (the "
        "median), and no floor at rest gives back more than it gets; are the columns mixed up, or in two units?"
    )
    if np.median(ratio**power) > GAINED:
        raise InputError(told)
    if (ratio > 1).all():
        warnings.warn(told, InputWarning, stacklevel=4)
