"""Beads that sink slowly in a tube whose width is not stated: the walls slow the larger ones more. Closed forms."""

import numpy as np
from hard_cases import write

import hlcs

G, GLASS, LIQUID, VISCOSITY, TUBE = 9.81, 2500.0, 1255.0, 1.2, 0.019


def final_speed(radius):
    """Of a sphere on the axis of a tube, by Stokes's law and the factor of W. L. Haberman and R. M. Sayre (1958), [m/s]."""
    q = radius / TUBE
    walls = (1 - 0.75857 * q**5) / (1 - 2.105 * q + 2.0865 * q**3 - 1.7068 * q**5 + 0.72603 * q**6)
    return 2 * (GLASS - LIQUID) * G * radius**2 / (9 * VISCOSITY * walls)


def test_the_tube_is_found_though_without_it_the_stated_density_runs_away(tmp_path):
    """Five sizes, films of a minute and more, 0.3 mm of noise. A drag by viscosity and inertia in a liquid nearly as dense as the
    beads leaves less than Stokes's law where the walls are not in the model; from there nothing is foreseen of them."""
    generator, recordings, trials = np.random.default_rng(4), [], []
    for k, radius in enumerate((7.5e-4, 1e-3, 1.5e-3, 5e-4, 1.25e-3)):
        speed = final_speed(radius)
        times = np.arange(60) * min(100.0, 0.4 / speed) / 60
        rows = np.column_stack([0 * times, 0 * times, 0.5 - speed * times])
        recordings.append((times, rows + 3e-4 * generator.standard_normal(rows.shape)))
        trials.append(
            f'[[trial]]\nfile = "r{k}.csv"\nbody = {{ radius = {radius}, mass = {GLASS * 4 / 3 * np.pi * radius**3} }}\n'
        )
    settings = (
        f'[body]\nshape = "sphere"\nradius = 1e-3\nmass = 1e-5\n[surroundings]\ngravity = {G}\nfluid_density = {LIQUID}\n'
        "[measurement]\nnoise = { position = 3e-4 }\n"
    )
    path = write(tmp_path, recordings, settings)
    path.write_text('kind = "trajectory"\n' + settings + "".join(trials))
    diagnosis = hlcs.diagnose(path)
    assert diagnosis.verdict == "effect" and set(diagnosis.effects) == {"stokes_drag", "tube_drag", "buoyancy"}
    for name, number, true in (("stokes_drag", "viscosity", VISCOSITY), ("tube_drag", "inverse_radius", 1 / TUBE)):
        told = diagnosis.parameters[name][number]
        assert told["low"] <= true <= told["high"]
