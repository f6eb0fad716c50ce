"""Outcome tables that are refused: what no laboratory can have measured, in a sentence each."""

import warnings

import numpy as np

from hlcs.data.bodies import SHAPES, impossible_density, refuse_unsized
from hlcs.data.combinations import too_narrow
from hlcs.data.free_falls import remedy
from hlcs.data.quantities import NEEDED_INPUTS, OUTCOMES, ROW_KEYS
from hlcs.data.rigid_body import rigid_body
from hlcs.effects.needs_of_model import check_needs
from hlcs.files.limits import unlikely
from hlcs.simulation import outcome_motion
from hlcs.simulation.row_setups import row_setups
from minibullet.errors import LIKE, InputError, InputWarning, nearest

# Measured over predicted: outside these bounds no effect is missing, a unit is wrong.
PLAUSIBLE = {
    "fall_time_s": (0.2, 300.0),
    "stop_distance_m": (0.02, 50.0),
    "slide_time_s": (0.05, 300.0),
    "passage_time_s": (0.1, 300.0),
    "bounce_time_s": (0.2, 300.0),
    "bounce_interval_s": (0.05, 300.0),
    "range_m": (0.01, 50.0),
}


def check_table(file, table, own=()):
    """Refuse a table whose outcome or whose model needs an input or a body that is not there, or a noise stated for another
    outcome; own: effect classes of the user's own."""
    for key in file.noise:
        if key not in ("outcome", table.outcome):
            raise InputError(
                f"{file.path}: measurement.noise.{key}: the table's outcome is {table.outcome}; write noise = "
                f"{{ {table.outcome} = {file.noise[key]:g} }}"
            )
        if file.noise[key] > (largest := float(np.max(np.abs(table.values)))):
            file.source.warn(
                "noise",
                f"{file.noise[key]:g} {OUTCOMES[table.outcome]} is more than every {table.outcome}, at most {largest:g}; it is "
                "one standard deviation in the unit of the column",
                "measurement",
            )
    for column in NEEDED_INPUTS[table.outcome]:
        if column not in table.inputs:
            near = nearest(column, table.inputs, LIKE)
            hint = f"; is it '{near}'?" if near else ""
            raise InputError(f"{table.file}: {table.outcome} needs the column '{column}'{hint}")
    if table.outcome == "slide_time_s" and not {"distance_m", "speed_m_s"} & set(table.inputs):
        raise InputError(f"{table.file}: slide_time_s needs the column 'distance_m' (way to slide) or 'speed_m_s' (time to stop)")
    _check_columns(file, table)
    _check_rows(table)
    _tell_unlikely(table)
    setups = row_setups(file, table)
    for row, setup in enumerate(setups):
        refuse_unsized(file.source, setup.body, False, "body")
        rigid_body(setup.body)
        complaint = impossible_density(setup.body) or too_narrow(setup.body, setup.surroundings)
        if not setup.surroundings.gravity > 0:
            complaint = "gravity is 0; nothing falls, slides or stops without it: give gravity in m/s2, 9.81 on Earth"
        if complaint:
            raise InputError(f"{table.file}, row {table.rows[row]}: {complaint}")
    check_needs(file, own, setups)


def _check_columns(file, table):
    """Refuse columns that the outcome does not depend on, and two that say the same: nothing is passed over in silence."""
    used = outcome_motion.USES[table.outcome]
    for column in table.inputs:
        if column not in (*used, *ROW_KEYS):
            can = f"it depends on {', '.join(used)}" if used else "it depends on the body alone"
            raise InputError(
                f"{table.file}, column {column}: {table.outcome} does not depend on it; {can}, beside body, fluid and floor: "
                "leave the column out"
            )
    if {"slope", "angle_deg"} <= set(table.inputs):
        raise InputError(f"{table.file}, columns slope and angle_deg: both say how steep the floor is; leave one of them out")
    if "radius_m" in table.inputs and "radius" not in SHAPES[file.body.shape]:
        keys = ", ".join(SHAPES[file.body.shape])
        raise InputError(
            f'{table.file}, column radius_m: a body of shape "{file.body.shape}" has none, its size is body.{keys}; leave '
            "the column out, or state another shape"
        )


def _tell_unlikely(table):
    """Warn of the first row of each input that is hardly meant, as of a setting in the file."""
    for column, values in table.inputs.items():
        told = (unlikely(ROW_KEYS.get(column, ("", column))[1], each) for each in values)
        if odd := next(((row, said) for row, said in zip(table.rows, told, strict=True) if said), None):
            warnings.warn(f"{table.file}, row {odd[0]}, column {column}: {odd[1]}", InputWarning, stacklevel=3)


def _check_rows(table):
    """Refuse a bounce that is no whole number, a way that took no time, none that took some, and marks that are not passed one
    after the other."""
    names = [name for name in ("height_m", "distance_m", "impact_speed_m_s", "mark_2_m") if name in table.inputs]
    ways = [table.inputs[name] for name in names]
    if ways and not ways[0].any() and table.values.any():
        raise InputError(
            f"{table.file}, column {names[0]}: 0 in all rows, where {table.outcome} is up to {table.values.max():g} "
            f"{OUTCOMES[table.outcome]}: nothing comes of nothing; give what was set in each row"
        )
    if OUTCOMES[table.outcome] == "s" and ways and (none := np.flatnonzero((table.values == 0) & (ways[0] > 0))).size:
        row, what = none[np.argmin(table.rows[none])], "leave out the rows that were not timed"
        if table.outcome == "bounce_time_s":
            what = "times count from the release: where they count from the first impact, add the time of the fall to each"
        raise InputError(
            f"{table.file}, row {table.rows[row]}, column {table.outcome}: 0 s over a way of {ways[0][row]:g} m; {what}"
        )
    bounce, low = table.inputs.get("bounce", np.ones(1)), table.inputs.get("mark_1_m", np.zeros(len(table.values)))
    if (broken := np.flatnonzero(bounce != np.round(bounce))).size:
        row = broken[0]
        raise InputError(f"{table.file}, row {table.rows[row]}, column bounce: {bounce[row]:g}; bounces are counted 1, 2, ..")
    if "mark_2_m" in table.inputs and (wrong := np.flatnonzero(table.inputs["mark_2_m"] <= low)).size:
        row = wrong[0]
        raise InputError(
            f"{table.file}, row {table.rows[row]}, column mark_2_m: {table.inputs['mark_2_m'][row]:g} where the first mark is "
            f"{low[row]:g}: marks are depths below the release, the second one lower"
        )


def check_magnitude(file, table, expected):
    """Refuse outcomes that a whole unit lies between; expected: what the model under test foretells of each row (n,).

    Rows whose outcome never comes under it, nan, say nothing of units.
    """
    ratios = table.values / np.where(np.abs(expected) < 1e-12, np.inf, expected)
    if table.outcome not in PLAUSIBLE or np.isnan(ratios).all():
        return
    ratio = float(np.nanmedian(ratios))
    low, high = PLAUSIBLE[table.outcome]
    if file.surroundings.in_liquid and table.outcome in ("fall_time_s", "passage_time_s"):
        high = np.inf  # a grain sinks through honey a thousand times as long as it falls
    if low <= ratio <= high:
        return
    outside = (ratios < low) | (ratios > high)
    row = int(np.nanargmin(np.where(outside, np.abs(ratios - ratio), np.nan)))
    what = remedy(max(ratio, 1e-9) ** -2, ratio) if OUTCOMES[table.outcome] == "s" else remedy(ratio, 1.0)
    raise InputError(
        f"{table.file}, row {table.rows[row]}, column {table.outcome}: {table.values[row]:g} where {expected[row]:.3g} is "
        f"expected; units that cannot be right: {what}"
    )
