"""The quantities of experiment files and outcome tables: their names, and the values beyond which a number cannot be right."""

import numpy as np

CHANNELS = ("x", "y", "z", "rx", "ry", "rz", "ax", "ay", "az")  # of a recording: position, rotation and reading of an
# accelerometer, each along (about) three axes
CHANNEL_UNITS = ("m", "rad", "m/s2")  # of each three of them
UNLIKELY = 0.001  # chance: what noise alone does as rarely it is not taken to have done

AROUND = {
    "gravity": (0.0, 300.0),
    "fluid_density": (0.0, 25000.0),
    "fluid_viscosity": (0.0, 1e4),
    "tube_radius": (1e-6, 1e3),
    "friction": (0.0, 10.0),
    "restitution": (0.0, 1.0),
}  # lowest and highest value of what surrounds a body, SI

OUTCOMES = {  # of a table -> unit
    "fall_time_s": "s",
    "rebound_height_m": "m",
    "stop_distance_m": "m",
    "slide_time_s": "s",
    "rest_height_m": "m",
    "passage_time_s": "s",
    "bounce_time_s": "s",
    "bounce_interval_s": "s",
    "rebound_speed_m_s": "m/s",
    "range_m": "m",
}
NEEDED_INPUTS = {  # without which an outcome has no law
    "fall_time_s": ("height_m",),
    "rebound_height_m": ("height_m",),
    "stop_distance_m": ("speed_m_s",),
    "slide_time_s": (),
    "rest_height_m": (),
    "passage_time_s": ("mark_2_m",),
    "bounce_time_s": ("height_m", "bounce"),
    "bounce_interval_s": ("height_m", "bounce"),
    "rebound_speed_m_s": ("impact_speed_m_s",),
    "range_m": ("speed_m_s",),
}
INPUTS = {  # lowest and highest value of each input of a table
    "height_m": (0, 1e3),
    "slope": (-10, 10),
    "speed_m_s": (0, 400),
    "angle_deg": (-90, 90),
    "distance_m": (0, 1e4),
    "mass_kg": (1e-9, 1e7),
    "radius_m": (1e-6, 1e2),
    "friction": AROUND["friction"],
    "restitution": AROUND["restitution"],
    "gravity_m_s2": AROUND["gravity"],
    "fluid_density_kg_m3": AROUND["fluid_density"],
    "fluid_viscosity_pa_s": AROUND["fluid_viscosity"],
    "tube_radius_m": AROUND["tube_radius"],
    "spin_rad_s": (-1e5, 1e5),
    "start_speed_m_s": (0, 400),
    "mark_1_m": (0, 1e3),
    "mark_2_m": (0, 1e3),
    "bounce": (1, 100),
    "impact_speed_m_s": (0, 400),
}
ROW_KEYS = {  # of a row, or stated of all of them -> where the file states it (section, key)
    "mass_kg": ("body", "mass"),
    "radius_m": ("body", "radius"),
    "friction": ("surroundings", "friction"),
    "restitution": ("surroundings", "restitution"),
    "gravity_m_s2": ("surroundings", "gravity"),
    "fluid_density_kg_m3": ("surroundings", "fluid_density"),
    "fluid_viscosity_pa_s": ("surroundings", "fluid_viscosity"),
    "tube_radius_m": ("surroundings", "tube_radius"),
}


def unit_of(channel, otherwise):
    """Unit of a channel of a recording by its name; `otherwise` where it is the name of something else, such as an outcome."""
    return CHANNEL_UNITS[CHANNELS.index(channel) // 3] if channel in CHANNELS[3:] else otherwise


def have_unit(channel, unit):
    """Which channels, by number (n,), have that unit: boolean (n,); a table has one channel, 0, whatever its unit."""
    return np.asarray(channel) // 3 == (CHANNEL_UNITS.index(unit) if unit in CHANNEL_UNITS else 0)
