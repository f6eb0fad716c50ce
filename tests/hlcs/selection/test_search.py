"""The search: what a later term drives to its bound goes."""

import numpy as np
from experiments import measured

from hlcs.estimation.cross_validation import CrossValidation
from hlcs.kinds.trajectories.preparation import prepare
from hlcs.selection.eligibility import candidates_for
from hlcs.selection.search import Search
from hlcs.simulation.model import Term

G = 9.81


BALL = '[body]\nshape = "sphere"\nradius = 0.02\nmass = 0.0027\n[surroundings]\nfluid_density = 1.2\n'


def test_what_a_later_term_drives_to_its_bound_goes(tmp_path):
    """A fall a fifth too fast asks for a clock 10 % slow, and 5 % is the most: however much it gains, it does not stay."""
    times = np.arange(60) / 60
    for k in range(4):
        fall = np.column_stack([k * times, 0 * times, 20.0 - 0.6 * G * times**2])
        rows = "".join(f"{t:.6f},{x:.6f},{y:.6f},{z:.6f}\n" for t, (x, y, z) in zip(times, fall, strict=True))
        (tmp_path / f"f{k}.csv").write_text("t_s,x_m,y_m,z_m\n" + rows)
    path = tmp_path / "e.toml"
    path.write_text(
        f'kind = "trajectory"\n{BALL}[measurement]\nnoise = {{ position = 0.004 }}\n'
        + "".join(f'[[trial]]\nfile = "f{k}.csv"\ngroup = "{k % 2}"\n' for k in range(4))
    )
    measurement = measured(path)
    prepared = prepare(measurement)
    entries, _ = candidates_for(measurement, False, ["time_scale", "linear_drag"])
    search = Search(prepared.problem, entries, CrossValidation(measurement.trials, measurement.file.hold_out))
    model = prepared.base.model
    for entry in reversed(entries):
        model = model.with_term(Term(entry, tuple(entry.absent.items())))
    fit = prepared.problem.fit(model)
    without = prepared.problem.fit(model.without(0))
    assert fit.model.names == ("time_scale", "linear_drag") and fit.at_bound[fit.numbers_of(0)] == (True,)
    assert without.chi2 - fit.chi2 > 1000
    assert search.prune(fit).model.names == ("linear_drag",)
