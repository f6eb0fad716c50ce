"""Layers, their thickness and their porosity: Eqs. 1 to 3, 13 and 14 of the paper, numbers in, numbers out.

Eqs. 4 to 7 are in `minibullet.dynamics.free_motion`, 8 and 9 in `minibullet.dynamics.impacts`, 10 to 12 in
`hlcs.placement.statistics`; the page docs/paper.md lists all of them. Where the print slips, docs/errata.md says how it is read.
"""

import numpy as np

from hlcs.placement.printed_tables import rows_of
from minibullet.errors import InputError, is_number, shown_value


def nominal_diameter(weight, specific_weight):
    """Dn = (W / gamma)^(1/3) [m], the edge of the cube of equal volume (Eq. 1); weight W [N], specific weight gamma [N/m3].

    InputError where one of them is no positive number.
    """
    _positive(weight=weight, specific_weight=specific_weight)
    return float(np.cbrt(weight / specific_weight))


def armour_thickness(layers, layer_coefficient, diameter):
    """Thickness t = n k Dn [m] of an armour (Eq. 1): n layers, one layer coefficient k for all [-], nominal diameter Dn [m].

    Where every layer has a coefficient of its own it is `structure_height`. InputError where one is no positive number.
    """
    _positive(layers=layers, layer_coefficient=layer_coefficient, nominal_diameter=diameter)
    return layers * layer_coefficient * diameter


def placing_density(layers, layer_coefficient, porosity, diameter):
    """Units per square metre, n k (1 - P) / Dn^2 (Eq. 2) [1/m2]; times Dn^2 it is the packing density [-].

    layers n; layer_coefficient k [-]; porosity P, from 0 to below 1 [-]; diameter Dn [m]. InputError otherwise.
    """
    _positive(layers=layers, layer_coefficient=layer_coefficient, nominal_diameter=diameter)
    if not is_number(porosity) or not 0.0 <= porosity < 1.0:
        raise InputError(f"porosity = {shown_value(porosity)}; it must be a number from 0 to below 1")
    return layers * layer_coefficient * (1.0 - porosity) / diameter**2


def nominal_porosity(layers, height, packing_density):
    """P = 1 - M phi / h (Eq. 2, solved for P) [-]: M layers, their height h [Dn], packing density phi of one layer [-]; nan
    where there is no height."""
    return float(1.0 - layers * packing_density / height) if height > 0.0 else np.nan


def layer_coefficients(heights):
    """k_j = (h_j - h_(j-1)) / Dn (Eq. 3), (M,) [-]: heights (M,) of the envelope above the bottom after each layer [Dn], h_0 = 0;
    nan where either height is. The paper measures h downwards from the laser; the difference is the same."""
    return np.diff(np.asarray(heights, dtype=float), prepend=0.0)


def estimated_layer_coefficients(grid):
    """The paper's estimate of k_1 to k_5 on a horizontal bottom (Eq. 13), (5,) [-]; grid: "RPG" or "TPG", or that Grid."""
    name = getattr(grid, "name", grid)
    found = [float(row["k"]) for row in rows_of("equation13") if row["grid"] == name]
    if not found:
        raise InputError(f"grid = {name!r}; Eq. 13 gives layer coefficients for RPG and TPG")
    return np.array(found)


def structure_height(coefficients, diameter=1.0):
    """H = sum of k_j Dn (Eq. 14): in Dn, or in metres where the nominal diameter Dn [m] is given; nan where a k_j is."""
    return float(np.sum(coefficients) * diameter)


def _positive(**numbers):
    """InputError that names the first of some numbers that is not positive and finite."""
    for name, value in numbers.items():
        if not is_number(value) or not value > 0:
            raise InputError(f"{name} = {shown_value(value)}; it must be a finite number > 0")
