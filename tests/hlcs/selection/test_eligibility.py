"""Which candidates can take part."""

import numpy as np
from experiments import measured

from hlcs.selection.eligibility import all_alike

G = 9.81


BALL = '[body]\nshape = "sphere"\nradius = 0.02\nmass = 0.0027\n[surroundings]\nfluid_density = 1.2\n'


def test_recordings_that_all_run_alike_cannot_tell_a_calibration_from_a_force(tmp_path):
    times = np.arange(30) / 60
    for name, heights in (("alike", (2.0, 2.0)), ("unlike", (2.0, 3.0))):
        text = ""
        for k, height in enumerate(heights):
            rows = "".join(f"{t:.6f},{height - G * t * t / 2 + 1e-3 * np.cos(40 * t + k):.6f}\n" for t in times)
            (tmp_path / f"{name}{k}.csv").write_text("t_s,z_m\n" + rows)
            text += f'[[trial]]\nfile = "{name}{k}.csv"\n'
        path = tmp_path / f"{name}.toml"
        path.write_text(f'kind = "trajectory"\n{BALL}[measurement]\nnoise = {{ position = 0.002 }}\n{text}')
        assert all_alike(measured(path).trials) == (name == "alike")
