"""Placement tests as TOML: `hlcs place TEST.toml`, the [placement] of layer experiments and sweeps, settings.toml of a result.

[placement]
grid = "TPG"            # every field of hlcs.PlacementTest by its own name; what is left out has its default
layers = 5
nominal_diameter = 1.07 # m, in place of `side`
stacking = "ABA"        # of a triangular grid
bottom = "bed.csv"      # relative to the file
armour = "unit.obj"     # likewise
effects = [{ name = "rolling_friction", arm = 0.02 }]   # of the engine's library, beside gravity
"""

from dataclasses import fields
from math import isfinite
from pathlib import Path

import minibullet as mb
from hlcs.files.limits import LARGEST
from hlcs.files.toml_files import TomlFile
from hlcs.placement import validation
from hlcs.placement.grids import TPG, Grid
from hlcs.placement.mesh_units import ENDINGS, parse_armour, unit_of
from hlcs.placement.procedure import PlacementTest
from hlcs.placement.sea_bottom import parse_bottom
from hlcs.placement.standing_units import parse_standing
from minibullet.effects import library
from minibullet.effects.contract import parameters
from minibullet.errors import InputError, known_one, shown, shown_value

FIELDS = tuple(field.name for field in fields(PlacementTest))
KEYS = (*FIELDS, "nominal_diameter", "stacking")
TYPES = {field.name: type(field.default) for field in fields(PlacementTest)}
SECTIONS = {"": ["title", "placement"], "placement": list(KEYS)}
EXAMPLE = '[{ name = "rolling_friction", arm = 0.02 }]'


def read_placement_file(path, allow_outside=False, defaults=None, **overrides):
    """The PlacementTest of a TOML file; overrides (keys as in the file) win. InputError names file, line, key and remedy.

    allow_outside: let it name a survey outside its own folder; defaults: settings of what neither states, such as a preset's.
    """
    file = TomlFile(path, SECTIONS, allow_outside)
    if "kind" in file.values:
        raise InputError(f"{file.path}: is an experiment file, which is compared: hlcs compare {file.path}")
    file.known(file.values, "")
    if "placement" not in file.values:
        raise InputError(f"{file.path}: [placement] is missing; write the settings of the test under it")
    return placement_of(file, defaults, **overrides)


def placement_of(file, defaults=None, **overrides):
    """The PlacementTest of the [placement] table of a TomlFile over `defaults`; overrides (keys as in the file) win."""
    table = {**(defaults or {}), **checked_table(file, overrides)}
    return make_placement({**table, **overrides}) if overrides else _at(file, None, make_placement, table)


def checked_table(file, skipped=()):
    """The [placement] table of a TomlFile, keys and values checked one by one but for those `skipped`, its bottom read."""
    table = file.values.get("placement", {})
    if not isinstance(table, dict):
        file.fail("placement", "must be a table: [placement]")
    for key in table:
        if key not in KEYS:
            file.fail(key, f"unknown key; {known_one(key, KEYS)}", "placement")
    if "nominal_diameter" in skipped or "side" in skipped:
        table = {key: value for key, value in table.items() if key not in ("nominal_diameter", "side")}
    if "bottom" not in skipped:
        table = with_bottom(table, file, "placement")
    for key, reading in (("armour", with_armour), ("standing", with_standing)):
        if key not in skipped:
            table = reading(table, file, "placement")
    for key in table:  # one by one first, so that the complaint can name the line
        if key not in skipped:
            check_value(file, "placement", key, table[key], _size(table))
    return table


def with_bottom(table, file, section):
    """A table under `section` of a TomlFile with its bottom, where it has one, read: a survey lies beside the file."""
    text = table.get("bottom")
    if not isinstance(text, str):
        return table
    if text.strip().lower().endswith(".csv"):
        file.file_of(text.strip(), "bottom", section)
    return {**table, "bottom": _at(file, "bottom", parse_bottom, text, file.path.parent, section=section)}


def with_armour(table, file, section):
    """A table under `section` of a TomlFile with its armour, where that is a mesh file, read: it lies beside the file."""
    return _with_file(table, file, section, "armour", ENDINGS, parse_armour)


def with_standing(table, file, section):
    """A table under `section` of a TomlFile with its standing units, where it has them, read: they lie beside the file."""
    return _with_file(table, file, section, "standing", (".csv",), parse_standing)


def _with_file(table, file, section, key, endings, parse):
    text = table.get(key)
    if not (isinstance(text, str) and text.strip().lower().endswith(endings)):
        return table
    file.file_of(text.strip(), key, section)
    return {**table, key: _at(file, key, parse, text, file.path.parent, section=section)}


def check_value(file, section, key, value, size=None):
    """InputError that names the line where a value under `section` of a TomlFile can be no setting; size: rows and columns."""
    others = size or {} if key == "layers" else {"layers": 1}
    _at(file, key, _made, {**others, key: value}, section=section)


def make_placement(table):
    """The PlacementTest of a flat dictionary with the keys of [placement]; InputError names the field."""
    test = _made(table)
    validation.check_effort(test)
    return test


def _made(table):
    """The PlacementTest, each setting judged by itself."""
    table = dict(table)
    for key in table:
        if key not in KEYS:
            raise InputError(f"placement: unknown key '{shown(key)}'; {known_one(key, KEYS)}")
    if "nominal_diameter" in table:
        if "side" in table:
            raise InputError("placement: both side and nominal_diameter are given; leave one of the two out")
        table["side"] = _side(table.pop("nominal_diameter"), table.get("armour", "cubipod"))
    if "grid" in table and not isinstance(table["grid"], str | Grid):
        raise InputError(f'placement: grid = {shown_value(table["grid"])}; it must be text such as "TPG" or "1.5,1.3"')
    if "stacking" in table:
        table["grid"] = Grid.parse(table.get("grid", TPG)).stacked(table.pop("stacking"))
    for key, value in table.items():
        # TOML and JSON write 1 for 1.0: a whole number is welcome where a length is wanted
        if TYPES[key] is float and isinstance(value, int) and not isinstance(value, bool):
            table[key] = float(value)
        if key == "effects":
            table[key] = _effects(value)
        if TYPES[key] in (float, int) and (isinstance(value, bool) or not isinstance(value, int | float)):
            raise InputError(f"placement: {key} = {shown_value(value)}; it must be a number")
        if key in ("reference", "shape", "solver", "damping_law") and not isinstance(value, str):
            raise InputError(f"placement: {key} = {shown_value(value)}; it must be text")
    return PlacementTest(**table)


def _effects(entries):
    """Values of the engine's effects from [{"name": ..., parameter: number, ...}]; such values themselves pass."""
    if not isinstance(entries, list | tuple):
        raise InputError(f"placement: effects = {shown_value(entries)}; it must be a list such as {EXAMPLE}")
    found = []
    for entry in entries:
        if isinstance(entry, mb.Effect):
            found.append(entry)
            continue
        name = entry.get("name") if isinstance(entry, dict) else None
        if not isinstance(name, str):
            raise InputError(f"placement: effects: {shown_value(entry)} has no name; write {EXAMPLE}")
        kinds = library()
        if name not in kinds:
            near = known_one(name, kinds, "the nearest known effect is")
            raise InputError(f"placement: effects: unknown effect {shown_value(name)}; {near}")
        numbers = {key: value for key, value in entry.items() if key != "name"}
        for key, value in numbers.items():
            known = parameters(kinds[name])
            if not known:
                raise InputError(f'placement: effects: {name} has no numbers; write {{ name = "{name}" }}')
            if key not in known:
                near = known_one(key, known, "the nearest is")
                raise InputError(f"placement: effects: {name} has no number {shown_value(key)}; {near}")
            if isinstance(value, int | float) and not abs(value) <= LARGEST:
                raise InputError(f"placement: effects: {name}: {key} = {shown_value(value)}; it must be at most {LARGEST:g}")
        found.append(kinds[name](**numbers))
    return tuple(found)


def _side(nominal_diameter, armour):
    """The side [m] at which a unit of this armour has this nominal diameter [m]."""
    value = nominal_diameter
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value) or value <= 0:
        raise InputError(f"placement: nominal_diameter = {shown_value(value)}; it must be a finite number > 0 (metres)")
    return value / unit_of(parse_armour(armour), 1.0).nominal_diameter


def _size(table):
    """Rows and columns as they stand, so that the number of layers can be judged."""
    return {key: table[key] for key in ("rows", "columns") if isinstance(table.get(key), int)}


def _at(file, key, make, *arguments, section="placement"):
    """make(*arguments); its complaint gets the file and, where the key is known, the line."""
    try:
        return make(*arguments)
    except InputError as problem:
        line = file.line_of(key, section) if key else None
        where = f"{file.path}, line {line}" if line else f"{Path(file.path)}"
        raise InputError(f"{where}: {' '.join(str(problem).split())}") from None  # it may quote a text of several lines
