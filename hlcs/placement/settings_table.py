"""The settings of a placement test as a flat dictionary of plain values: the [placement] of a file, the key of a stored run."""

import hashlib
from dataclasses import fields

from hlcs.placement.grids import RPG, TPG
from hlcs.placement.sea_bottom import Flat, Slope, Survey
from minibullet.effects.contract import name_of, parameters
from minibullet.errors import InputError

SURVEY_FILE, UNIT_FILE, STANDING_FILE = "bottom.csv", "unit.obj", "standing.csv"


def placement_table(test):
    """The [placement] that gives this very test again: a flat dictionary of every key. A surveyed bed becomes
    SURVEY_FILE, a unit from a mesh UNIT_FILE, units that stand STANDING_FILE."""
    table = {field.name: getattr(test, field.name) for field in fields(test)}
    table["grid"], table["stacking"] = grid_words(test.grid), test.grid.stacking
    table["bottom"] = bottom_words(test.bottom)
    table["armour"] = test.armour if isinstance(test.armour, str) else UNIT_FILE
    table["standing"] = STANDING_FILE if test.standing else ""
    table["effects"] = tuple(
        {"name": name_of(effect), **{name: getattr(effect, name) for name in parameters(effect)}} for effect in test.effects
    )
    return table


def settings_of(test):
    """What the key of a stored run is made of: every setting; in place of files (a surveyed bed, a mesh, units that stand)
    the hashes of what is in them."""
    table = placement_table(test)
    if not isinstance(test.armour, str):
        table["armour"] = "mesh:" + test.armour.digest
    if test.standing:
        table["standing"] = "standing:" + test.standing.digest
    if isinstance(test.bottom, Survey):
        table["bottom"] = "survey:" + hashlib.sha256(test.bottom.csv_text().encode()).hexdigest()
    return table


def grid_words(grid):
    """What `Grid.parse` turns into this grid again (but for its stacking)."""
    for known in (TPG, RPG):
        if grid.stacked(known.stacking) == known:
            return known.name
    return f"{grid.spacing_x!r},{grid.spacing_y!r}" + (",triangular" if grid.triangular else "")


def bottom_words(bottom):
    """What `parse_bottom` turns into this bottom again; a survey is SURVEY_FILE."""
    if isinstance(bottom, Flat):
        return "flat"
    if isinstance(bottom, Slope):
        return f"slope:{bottom.grade!r}"
    if isinstance(bottom, Survey):
        return SURVEY_FILE
    raise InputError(
        f"placement: a bottom of your own ({type(bottom).__name__}) cannot be written to a file; use Flat, Slope or Survey"
    )
