"""Outcomes that never come: what the model under test says of such rows, in words, and how a fit goes on beside them.

`simulation.outcome_motion` foretells nan where a body floats, a block is held, a ball stays down. Such a row was measured all the
same, so the model is wrong there, and no difference says by how much. It then misses by all that was measured: large, finite, and
the same for every model that says never. A model under which the outcome comes to be is judged by its difference as ever.
"""

import numpy as np

WHY = {  # outcome -> what the model says of the body, what to check
    "fall_time_s": ("the body floats and never comes down", "mass, size and fluid"),
    "passage_time_s": ("the body floats and never passes the marks", "mass, size and fluid"),
    "range_m": ("the body floats and never comes down", "mass, size and fluid"),
    "rebound_height_m": ("the body floats and never strikes the floor", "mass, size and fluid"),
    "bounce_time_s": ("there is no such bounce, as the body stays down or floats", "restitution, mass and fluid"),
    "bounce_interval_s": ("there is no next bounce, as the body stays down or floats", "restitution, mass and fluid"),
    "slide_time_s": ("the body does not slide there: friction holds or stops it before", "friction, slope and speed"),
    "stop_distance_m": ("the body never stops there: nothing holds it", "friction and slope"),
}
VALUES, NEAR = 25, 0.01  # of a friction or a restitution that are tried, and part of the way to zero where it should be seen
WAYLESS = ("the body never stops there: nothing holds it", "friction and slope")  # of a slide_time_s


def all_that_was_measured(predicted, values, never):
    """Outcomes (n,) with zero in place of nan where the model under test says never too: the residual is then all of `values`.

    never: rows of which the model under test says that (n,). Elsewhere nan stays: no fit goes where an outcome is lost.
    """
    return np.where(never & np.isnan(predicted), np.zeros_like(values), predicted)


def told(table, never):
    """The sentences on the rows (n,) of which the model under test says that their outcome never comes."""
    rows = np.flatnonzero(never)
    if not len(rows):
        return ()
    first = rows[np.argmin(table.rows[rows])]
    inputs = ", ".join(f"{name} = {values[first]:g}" for name, values in table.inputs.items())
    why, what = WHY[table.outcome]
    if table.outcome == "slide_time_s" and "distance_m" not in table.inputs:
        why, what = WAYLESS
    many = "all rows" if len(rows) == len(never) else f"{len(rows)} of {len(never)} rows"
    return (
        f"{table.file.name}, {many}, the first row {table.rows[first]}"
        + (f" ({inputs})" if inputs else "")
        + f": the model says "
        f"that {why}; these rows count as missed by all that was measured: check {what}",
    )


def other_settings(search):
    """[({effect: its numbers}, None)] to begin fits from where a setting, the friction or the restitution that the file states,
    does nothing near the stated value: the value of its plausible range that leaves least.

    While a friction holds a block, or lets a ball roll, a little less of it changes nothing, and no derivative tells that much
    less would.
    """
    found, base = [], search.base

    def left(name, number, value):
        return search.preview.left_from({name: {number: float(value)}}, base.initial_states)

    for entry in search.candidates.values():
        if not entry.setting or len(entry.free) != 1 or entry.free[0].null is None:
            continue
        name, free = entry.name, entry.free[0]
        if left(name, free.name, (1 - NEAR) * free.null + NEAR * free.low) != left(name, free.name, free.null):
            continue
        tried = np.linspace(free.low, free.high, VALUES)
        least, value = min((left(name, free.name, value), value) for value in tried)
        found += [({name: {free.name: float(value)}}, None)] if least < base.chi2 else []
    return tuple(found)
