"""Units in the names of columns: "Höhe [cm]", "Time (s)", "t/ms", "x_mm", "Zeit s"; and what they are in SI."""

import math
import re
import unicodedata

from hlcs.data.outcome_tables import SD
from hlcs.importing.found import Assumption
from minibullet.errors import InputError, shown

UNITS = {  # quantity -> unit -> its size in the unit of the project
    "time": {"s": 1.0, "sec": 1.0, "sek": 1.0, "second": 1.0, "seconds": 1.0, "secondes": 1.0, "secondi": 1.0, "segundos": 1.0,
             "sekunden": 1.0, "milliseconds": 1e-3, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9, "min": 60.0},
    "length": {"m": 1.0, "meter": 1.0, "metre": 1.0, "meters": 1.0, "metres": 1.0, "mètres": 1.0, "metros": 1.0, "metri": 1.0,
               "centimètres": 0.01, "centimetri": 0.01, "millimètres": 1e-3, "millimetri": 1e-3, "milimetros": 1e-3,
               "cm": 0.01, "centimeters": 0.01, "centimetres": 0.01, "centimetros": 0.01, "centímetros": 0.01, "mm": 1e-3,
               "millimeters": 1e-3, "millimetres": 1e-3, "milímetros": 1e-3, "km": 1e3, "in": 0.0254, "inch": 0.0254,
               "inches": 0.0254, "ft": 0.3048, "feet": 0.3048, "yd": 0.9144, "yds": 0.9144, "yard": 0.9144, "yards": 0.9144},
    "speed": {"m/s": 1.0, "cm/s": 0.01, "mm/s": 1e-3, "km/h": 1 / 3.6, "ft/s": 0.3048, "mph": 0.44704},
    "acceleration": {"m/s2": 1.0, "m/s^2": 1.0, "m/s²": 1.0, "g": 9.80665},
    "mass": {"kg": 1.0, "g": 1e-3},
    "angle": {"deg": 1.0, "°": 1.0, "degrees": 1.0, "rad": 180.0 / math.pi},  # columns of tables have angle_deg
    "rate of turn": {"rad/s": 1.0, "deg/s": math.pi / 180.0, "°/s": math.pi / 180.0, "rpm": math.pi / 30.0},
    "density": {"kg/m3": 1.0, "kg/m^3": 1.0, "kg/m³": 1.0, "g/cm3": 1e3, "g/cm^3": 1e3, "g/cm³": 1e3, "g/ml": 1e3, "kg/l": 1e3},
    "viscosity": {"Pa s": 1.0, "pa s": 1.0, "pa·s": 1.0, "pas": 1.0, "mpa s": 1e-3, "mpa·s": 1e-3, "mpas": 1e-3, "cp": 1e-3},
    "pixels": {"px": 1.0, "pixel": 1.0, "pixels": 1.0},
    "share": {"1": 1.0, "-": 1.0, "%": 0.01},
}  # fmt: skip
SUFFIXES = {"_kg_m3": "density",
            "_pa_s": "viscosity", "_m_s2": "acceleration", "_rad_s": "rate of turn", "_m_s": "speed", "_kg": "mass",
            "_deg": "angle", "_px": "pixels", "_s": "time", "_m": "length"}  # fmt: skip
SI = {
    "time": "s",
    "length": "m",
    "speed": "m/s",
    "acceleration": "m/s2",
    "mass": "kg",
    "angle": "degrees",
    "rate of turn": "rad/s",
    "density": "kg/m3",
    "viscosity": "Pa s",
    "pixels": "pixels",
}
CHOICES = {"length": ("m", "cm", "mm", "km", "in", "ft"), "time": ("s", "ms", "us", "min")}  # of the options
KNOWN = {unit for quantity, units in UNITS.items() if quantity != "share" for unit in units}
IN_BRACKETS = re.compile(r"(.*?)\s*[\[(]([^\[\]()]*)[\])]\s*")
AFTER_SLASH = re.compile(r"(.*?\S)\s*(?:/|\bin\b)\s*(\S+)")
AFTER_UNDERSCORE = re.compile(r"(.+?)_(?!min$)([^_]+)", re.IGNORECASE)  # "t_min" may be the least one
AFTER_BLANK = re.compile(r"(.*[^\W\d].*?)\s+(?!in$|min$)(\S+)", re.IGNORECASE)  # likewise "Time min"


def quantity_of(column):
    """What a column of the project measures, by the unit at the end of its name; "share" for a number without unit.

    The error of an input has its unit.
    """
    column = column.removesuffix(SD)
    return next((quantity for suffix, quantity in SUFFIXES.items() if column.endswith(suffix)), "share")


def split_unit(name):
    """(name, unit) of a column as people write it; unit "" where none is stated: "Höhe [cm]" -> ("höhe", "cm").

    The name comes in small letters, with one blank between words.
    """
    text = unicodedata.normalize("NFC", name).strip().strip("'\"")
    unit = ""
    if found := IN_BRACKETS.fullmatch(text):
        text, unit = found.groups()
    else:
        for pattern in (AFTER_SLASH, AFTER_UNDERSCORE, AFTER_BLANK):
            if (found := pattern.fullmatch(text)) and _plain(found[2]) in KNOWN:
                text, unit = found.groups()
                break
    return " ".join(text.lower().replace("_", " ").split()), _plain(unit)


def _plain(unit):
    unit = unicodedata.normalize("NFC", unit).strip().rstrip(".").lower().replace("μ", "µ").replace("**", "^")
    return re.sub(r"^(in|en|em) +", "", unit)  # "Zeit (in s)"


def factor_of(quantity, unit, place):
    """What a number in that unit is to be multiplied by; InputError that begins with `place` for a unit nobody knows."""
    if unit not in UNITS[quantity]:
        known = ", ".join(UNITS[quantity])
        said = f"; write one of them, or state --{quantity}-unit" if quantity in CHOICES else "; write one of them"
        raise InputError(f"{place}: '{shown(unit)}' is not known as a unit of {quantity}; known are {known}{said}")
    return UNITS[quantity][unit]


def scale(quantity, stated, overrides, where, place):
    """(factor to the project's unit, [Assumption] where the file does not say it).

    quantity; stated: unit that the file names, or ""; overrides: Overrides; where: what has the unit, in words; place: how a
    complaint begins.
    """
    said = {"length": overrides.length_unit, "time": overrides.time_unit}.get(quantity)
    option = f"--{quantity}-unit" if quantity in CHOICES else ""
    if said:
        told = f"{where} in {said}, as {option} says" + (f", though the file says {stated}" if stated and stated != said else "")
        return factor_of(quantity, said, option), [Assumption(told, option)] if stated and stated != said else []
    if stated:
        return factor_of(quantity, stated, place), []
    if quantity == "share":
        return 1.0, []
    return 1.0, [Assumption(f"{where} in {SI[quantity]}: the file names no unit", option)]
