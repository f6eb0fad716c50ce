"""The fluid that an experiment takes place in: what it does to the body by itself, and what the file says of it.

No world may contradict its own file: where a fluid is stated, or left out (then it is air), its drag, buoyancy and added mass
act on the body and stand in the model under test, but for what is hidden; where 0.0 is stated nothing of a fluid acts.
"""

from dataclasses import dataclass

AIR, AIR_VISCOSITY = 1.2, 1.8e-5  # [kg/m3], [Pa s]
STATES = {"stated": 0.45, "left out": 0.35, "vacuum": 0.2}  # shares of the cases
DRAG = ("linear_drag", "quadratic_drag", "drag_crisis")  # forms of one law: one of them acts, not two
OF_FLUID = (*DRAG, "buoyancy", "added_mass", "uniform_flow", "magnus", "spin_decay", "mass_offset", "history_force")
SPHERES_MASS = 0.6  # most that a fluid adds to a sphere: 0.5 of its own far from walls (Lamb), a fifth more beside them
COEFFICIENTS = {"sphere": (0.47, 0.5), "box": (1.05, 0.68)}  # drag (Hoerner), added mass (Lamb; DNV-RP-C205)


@dataclass(frozen=True)
class Around:
    """Density that is true [kg/m3], what [surroundings] says of it, and the fluid's entries in the model under test."""

    density: float
    stated: dict
    model: tuple[dict, ...]


def around(rng, hidden=(), shape="sphere"):
    """An experiment in air, stated or left out, or in a vacuum; what is hidden does not stand in the model."""
    state = str(rng.choice(list(STATES), p=list(STATES.values())))
    if state == "vacuum" and set(hidden) & set(OF_FLUID):
        state = "left out"
    if state == "vacuum":
        return Around(0.0, {"fluid_density": 0.0}, ())
    coefficient, moved_along = COEFFICIENTS[shape]
    entries = [
        {"name": "buoyancy", "fluid_density": AIR},
        {"name": "added_mass", "coefficient": moved_along, "fluid_density": AIR},
        {"name": "quadratic_drag", "drag_coefficient": coefficient, "fluid_density": AIR},
    ]
    out = {*hidden, *(DRAG if set(hidden) & set(DRAG) else ())}
    stated = {"fluid_density": AIR, "fluid_viscosity": AIR_VISCOSITY} if state == "stated" else {}
    return Around(AIR, stated, tuple(entry for entry in entries if entry["name"] not in out))


def rivals(names, surrounding):
    """Of the names those that can be missing: nothing of a fluid in a vacuum, and nothing that stands in the model already."""
    inside = {entry["name"] for entry in surrounding.model}
    return tuple(name for name in names if name not in inside and (surrounding.density or name not in OF_FLUID))


def displaced(inputs, effects, mass):
    """Mass of the fluid displaced, and of the fluid that moves along, over the mass of a body with the volume `inputs` name."""
    volume = inputs.get("volume", 0.0)
    lifted = effects.get("buoyancy", {}).get("fluid_density", 0.0) * volume / mass
    return lifted, effects.get("added_mass", {}).get("coefficient", 0.0) * inputs.get("fluid_density", 0.0) * volume / mass
