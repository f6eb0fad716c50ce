"""Which Reynolds numbers the data reach, and whether a law of drag that was fitted to them is a sphere's there."""

from dataclasses import replace
from math import inf

from hlcs.data.rigid_body import rigid_body
from hlcs.selection.eligibility import grouped, reynolds_numbers
from minibullet.effects.flow import TubeDrag, tube_factor
from minibullet.effects.fluid import (
    SCHILLER_NAUMANN,
    Drag,
    SphereDrag,
    StokesDrag,
    ViscousDrag,
    drag_coefficient_of_sphere,
    dragged_as_much,
)

TABLES = "R. Clift, J. R. Grace and M. E. Weber, Bubbles, Drops, and Particles (1978), ch. 5"
WALLS = "W. L. Haberman and R. M. Sayre, David Taylor Model Basin Report 1143 (1958)"
NOT_KNOWN = {"least": None, "most": None, "holds": None}  # Reynolds numbers
SMOOTH, FELT = (0.38, 0.51), 0.7  # drag coefficients of a smooth sphere from Reynolds numbers of 1,000 to 200,000, and the most
# that one with felt and seams has (R. D. Mehta and J. M. Pallis, Sports Eng. 4 (2001) 177)
CURVE = "L. Schiller and A. Naumann, Z. VDI 77 (1933) 318"


def reached(candidates, parameters, moved, adequate):
    """{law of drag: {least, most, holds, told}} of those among effects with their parameters, as in the result file.

    candidates: {effect: Candidate}; moved: [(body, surroundings, its highest speed [m/s])] of every recording or row; adequate:
    do the effects explain the data, so that what drags is known? least, most: of the Reynolds numbers 2 r rho v/eta at these
    speeds, None where nobody knows the viscosity; holds: is the law with its number a sphere's there; told: sentences. The
    curves are those of spheres: of other bodies the area is told that a drag coefficient refers to, where no file states it.
    """
    laws = {name: candidates[name].kind for name in parameters if issubclass(candidates[name].kind, Drag)}
    spheres = [each for each in moved if each[0].shape == "sphere" and each[0].sized and each[1].fluid_density and each[2] > 0]
    if not spheres:
        areas = [
            rigid_body(body).area for body, _, _ in moved if body.shape != "sphere" and body.sized and body.drag_area is None
        ]
        return {name: _area(areas) for name in laws if areas and "drag_coefficient" in parameters[name]}
    tubes = {name: numbers["inverse_radius"] for name, numbers in parameters.items() if candidates[name].kind is TubeDrag}
    stated = any(around.tube_radius for _, around, _ in spheres)
    widths = {name: _tube(found) for name, found in tubes.items() if found.get("value") and not stated}
    walled = stated or bool(tubes)
    return {name: _reached(kind, parameters[name], spheres, adequate, walled) for name, kind in laws.items()} | widths


def _tube(found):
    """How wide a tube is that was found by its inverse radius, {value, low, high} [1/m]."""
    least, value, most = (f"{1000 / max(found[end], 1e-3):.3g}" for end in ("high", "value", "low"))
    span = f"{least} to {most} mm" if found["low"] > 0 else f"{least} mm or more"
    told = f"That is a tube of {value} mm radius ({span}). State yours as surroundings.tube_radius: it is believed to a tenth."
    return NOT_KNOWN | {"told": told}


def _area(areas):
    """What a drag coefficient refers to, areas of all that moved [m2]."""
    least, most = (f"{end:.3g}" for end in (min(areas), max(areas)))
    span = least if least == most else f"{least} to {most}"
    told = f"The drag coefficient refers to {span} m2, the mean area of the body over all attitudes; where it keeps one, "
    return NOT_KNOWN | {"area": span, "told": f"{told}state its drag_area under [body]."}


def _reached(kind, numbers, spheres, adequate, walled):
    begins, ends = kind.reynolds_of_spheres
    eta = numbers.get("viscosity", {}).get("value") if issubclass(kind, StokesDrag) else None
    found = [
        reynolds_numbers(body, replace(around, fluid_viscosity=eta) if eta else around, speed) for body, around, speed in spheres
    ]
    if any(low != high for low, high in found):
        told = (
            "The viscosity of the liquid is not stated, so its Reynolds numbers are not known, nor whether the law of drag holds"
        )
        return NOT_KNOWN | {"told": f"{told}: write fluid_viscosity."}
    least, most = (float(end(low for low, _ in found)) for end in (min, max))
    span = grouped(most) if grouped(least) == grouped(most) else f"{grouped(least)} to {grouped(most)}"
    reach = f"{'By the fitted viscosity the' if eta else 'The'} data reach Reynolds numbers of {span}"
    if issubclass(kind, SphereDrag):
        told = f"{reach}; the drag of a sphere follows this curve to 5 % up to about {SCHILLER_NAUMANN:g} ({CURVE})."
    elif issubclass(kind, ViscousDrag):
        told = _in_proportion(reach, most, eta if adequate and not walled else None, walled)
    else:
        told = _by_coefficient(reach, least, most, begins, ends)
    holds = begins <= least and most <= ends
    too_large = _of_no_sphere(numbers.get("drag_coefficient", {})) if holds else ""  # slower ones are dragged by more
    return {"least": least, "most": most, "holds": holds and not too_large, "told": told + too_large}


def _in_proportion(reach, most, eta, walled):
    """What the drag of a sphere is beside one in proportion to speed; eta: the viscosity that it gave, None: none, or one that
    explains nothing, or shares that with walls; walled: are the walls of a tube counted already?"""
    if most <= StokesDrag.reynolds_of_spheres[1]:
        told = f"{reach}, where Stokes's law tells the drag of a sphere to {_short(most):.0f} %."
        if walled:
            return told
        walls = " and ".join(f"{100 * tube_factor(1 / across):.0f} % in one of {across}" for across in (50, 10))
        return f"{told} The walls of a tube add to it: {walls} diameters of the sphere (tube_drag; {WALLS})."
    told = f"{reach}; a sphere is dragged in proportion to its speed (Stokes's law) up to about 1 only."
    thinner = dragged_as_much(most) if eta else most
    if thinner > SCHILLER_NAUMANN:
        return told
    if not eta:
        return f"{told} At {grouped(most)} that law is {_short(most):.0f} % too small ({CURVE})."
    return (
        f"{told} One that is held back as much has {grouped(thinner)}, where that law is {_short(thinner):.0f} % too small "
        f"({CURVE}), in a liquid of {eta * most / thinner:.2g} Pa s: the viscosity is told too large."
    )


def _short(reynolds):
    """How much too small Stokes's law is [% of the drag of a sphere]."""
    return 100 * (1 - 24 / reynolds / drag_coefficient_of_sphere(reynolds))


def _by_coefficient(reach, least, most, begins, ends):
    """What the drag coefficient of a sphere does there."""
    if most > ends:
        return f"{reach}; beyond {grouped(ends)} the drag coefficient of a sphere falls to a fraction ({TABLES})."
    if least >= begins:
        until = f" to {grouped(ends)}" if ends < inf else " on"
        return f"{reach}, where this is the form of the drag of a sphere (from about {grouped(begins)}{until}; {TABLES})."
    high, low = (drag_coefficient_of_sphere(number) for number in (least, min(most, SCHILLER_NAUMANN)))
    there = f"{high:.2g}" if f"{high:.2g}" == f"{low:.2g}" else f"from {high:.2g} to {low:.2g}"
    begun = grouped(begins)
    return f"{reach}; the drag coefficient of a sphere is constant from about {begun} on, and {there} here ({CURVE})."


def _of_no_sphere(coefficient):
    """That no sphere has a drag coefficient, {value, low, high}, as large; "" of one that may be one's."""
    if not (coefficient.get("low") or 0.0) > FELT:
        return ""
    return (
        f" A smooth sphere has {SMOOTH[0]:g} to {SMOOTH[1]:g} from 1,000 on, one with felt {FELT:g} at most: see to mass, size "
        "and fluid, and to what else may take so much of the motion."
    )
