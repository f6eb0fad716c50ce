"""What the effects of [model] need of the body and of the fluid, and an experiment file does not state.

Such a model would be computed with a body that nobody has described. What an effect needs is said by its class (`needs`) and by
its numbers (`Parameter.body_known`), as for what a diagnosis tries.
"""

from hlcs.data.bodies import SHAPES
from hlcs.data.rigid_body import known_to_drag, unstated
from hlcs.effects.library import class_named
from minibullet.effects.contract import Need, parameters
from minibullet.errors import InputError

OF_THE_BODY = {Need.MASS_AND_SIZE: "needs the mass and the size of the body", Need.SIZE: "needs the size of the body"}
UNITS = {"mass": "kg", "size": "[x, y, z] in m", "mesh": "a file"}  # of what states a body; lengths in m are the rest


def check_needs(file, own, seen):
    """Refuse effects of an ExperimentFile's [model] that need more of the body, or of the fluid, than is stated.

    seen: what has a body and surroundings: the recordings, or the rows of a table.
    """
    bodies = dict.fromkeys(each.body for each in seen)
    vacuum = not any(each.surroundings.fluid_density for each in seen)
    for key, entries in (("model.effects", file.effects), ("model.replaced", file.replaced)):
        for entry in entries:
            kind = class_named(entry["name"], own)
            said = next(filter(None, (_of_body(kind, entry, body) for body in bodies)), "")
            if said := said or vacuum and _of_fluid(kind, entry):
                raise InputError(f"{file.place(key)}: {entry['name']} {said}")


def _acting(kind, entry):
    """The Parameters of the numbers that an entry states off their null values."""
    known = parameters(kind)
    stated = [(known.get(key.partition(" ")[0]), value) for key, value in entry.items() if key != "name"]
    return [number for number, value in stated if number and not number.given and value != number.null]


def _of_body(kind, entry, body):
    """What an entry needs of a body that is not stated, and what to do, in words; "" where all is."""
    acting = _acting(kind, entry)
    if not acting:
        return ""
    need = next((need for need in kind.needs if need in OF_THE_BODY), None)
    missing = [key for key in unstated(body) if need is Need.MASS_AND_SIZE or need and key in SHAPES[body.shape]]
    by_area = [number for number in acting if number.body_known] if not known_to_drag(body) else []
    what, instead = OF_THE_BODY.get(need), ""
    if by_area:
        missing = ["mass"] if body.drag_area is not None else unstated(body)
        what = f"{OF_THE_BODY[Need.MASS_AND_SIZE]} for its {by_area[0].name}"
        instead = "".join(
            f", or give {name} in its place" for name, known in parameters(kind).items() if known.body_known is False
        )
    if not missing:
        return ""
    keys = " and ".join(f"body.{key}" for key in missing)
    remedy = " and ".join(f"body.{key} ({UNITS.get(key, 'm')})" for key in missing)
    return f"{what}, and {keys} {'is' if len(missing) == 1 else 'are'} not stated; state {remedy}{instead}"


def _of_fluid(kind, entry):
    """Why an entry says nothing in a vacuum, and what to do, in words; "" where its numbers need no density of the file."""
    density = parameters(kind).get("fluid_density")
    acting = [number for number in _acting(kind, entry) if number.body_known is not False]
    if not (density and density.given and acting) or "fluid_density" in entry:
        return ""
    return (
        "acts through the fluid, and the file states a vacuum (fluid_density = 0.0); leave it out, state the density of the "
        "fluid, or give it a fluid_density of its own"
    )
