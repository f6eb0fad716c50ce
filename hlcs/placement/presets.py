"""Settings by one name: `--preset paper`, the paper's own settings as far as they are printed or can be inferred.

Printed: restitution, dampings, margin and falling distance (section 3.2.4), and the numbers of plates 12, 9, 9, 6, 3 (section 4).
Inferred: a contact friction of 0.36, because Bullet multiplies the 0.6 of two bodies; plates in rows of three; the margin on the
plates too; 60 steps a second and 10 iterations, the program's own defaults in 2019. The number of units is not stated, and no
preset sets it. docs/errata.md says what each does.
"""

from minibullet.errors import InputError, known_one

PAPER = {
    "friction": 0.36,
    "margin": 0.008,
    "plate_margin": 0.008,
    "plates": 3,
    "plate_rows": (4, 3, 3, 2, 1),
    "restitution": 0.0,
    "linear_damping": 0.0,
    "angular_damping": 0.0,
    "falling_distance": 0.25,
    "time_step": 1.0 / 60.0,
    "iterations": 10,
}
PRESETS = {"paper": PAPER}


def preset(name):
    """The settings of a preset, keys as in [placement]; none for None. InputError with the nearest name for an unknown one."""
    if name is not None and name not in PRESETS:
        raise InputError(f"preset '{name}': unknown; {known_one(name, PRESETS, 'the nearest known preset is')}")
    return dict(PRESETS[name]) if name is not None else {}
