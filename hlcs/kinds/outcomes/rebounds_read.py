"""What single rebounds of a table show of the restitution, row by row."""

import numpy as np

from hlcs.learning.rebounds import with_restitution
from hlcs.simulation.outcome_motion import fallen

ASKED = np.linspace(0.02, 1.0, 25)  # restitutions, between which that of a row is read: the root of a height is nearly straight
STRIKES_AT = {"rebound_height_m": "height_m", "rebound_speed_m_s": "impact_speed_m_s"}  # outcome -> what tells the speed


def rebounds_read(problem, model):
    """[(restitution, its error, speed of approach [m/s])] of the rows of a table, each after one impact of one body on one floor;
    [] of another table. The restitution is that with which the model foretells the row, fluid and all; rows that no restitution
    foretells, within their error, are left out."""
    table, here = problem.table, problem.setups[0]
    single = table.outcome in STRIKES_AT and np.all(table.inputs.get("bounce", np.ones(1)) == 1)
    if not single or any(setup != here for setup in problem.setups):
        return []
    models = [with_restitution(model, here, float(restitution)) for restitution in ASKED]
    with np.errstate(invalid="ignore"):
        foretold = np.sqrt([problem.predict(each) for each in models])  # (asked, n)
        low, values, high = (np.sqrt(table.values + way * problem.sigmas) for way in (-1, 0, 1))
    speeds, readings = _speeds(problem, model)[problem.back], []
    for row, curve in enumerate(foretold.T):
        if curve[0] <= low[row] and high[row] <= curve[-1]:
            least, value, most = np.interp((low[row], values[row], high[row]), curve, ASKED)
            readings.append((float(value), float(most - least) / 2, float(speeds[row])))
    return readings


def _speeds(problem, model):
    """Speeds with which the body strikes in the settings of a table of rebounds (d,) [m/s]."""
    told = problem.distinct[STRIKES_AT[problem.table.outcome]]
    if problem.table.outcome == "rebound_speed_m_s":
        return told
    effects, _, _ = model.changes(problem.setups[0].surroundings)
    return -fallen(problem.setups, effects, told)[1][:, 2]
