"""Options of `hlcs place`: one for every setting of a placement test."""

from dataclasses import fields

import click

from hlcs.placement.procedure import PlacementTest

CHOICES = {
    "reference": ["layer", "blind"],
    "shape": ["pieces", "hull"],
    "crowding": ["turn", "redraw", "lift"],
    "stacking": ["ABC", "ABA"],
    "damping_law": ["bullet", "per_step"],
    "solver": ["exact", "gauss_seidel", "sequential_impulse"],
}
KINDS = {"nominal_diameter": float, "plate_rows": str}  # of options whose default does not tell
HELP = {
    "grid": "TPG, RPG, or two spacings in Dn: A,B or A,B,triangular",
    "layers": "how many",
    "rows": "of the first layer",
    "columns": "of the first layer",
    "bottom": "flat, slope:0.04, mound:HEIGHT,CREST,GRADE,LENGTH (m), or a survey bed.csv (x_m,y_m,z_m; on a grid or scattered)",
    "reference": "each layer aimed from the layer below, or blindly",
    "shape": "the true unit, or its convex hull",
    "armour": "cubipod, cube, or a mesh file of the unit: FILE.stl, FILE.obj (lengths in m, or see --side)",
    "side": "of the unit's cube, m; of a unit from a file: metres per unit of its lengths",
    "nominal_diameter": "of the unit, m, in place of --side",
    "friction": "of a contact",
    "restitution": "of a contact",
    "linear_damping": "Eq. 6",
    "angular_damping": "Eq. 7",
    "damping_law": "Bullet's, or Eqs. 6-7 as printed",
    "margin": "round each unit, in Dn",
    "falling_distance": "above the layers below, in Dn",
    "density": "of the units, kg/m3",
    "seed": "of the orientations",
    "stacking": "of a triangular grid",
    "time_step": "s",
    "iterations": "most sweeps of the solver a step",
    "tolerance": "residual at which a step is solved",
    "solver": "how contacts are solved",
    "settle_time": "longest wait for a layer, s",
    "plates": "measuring plates along each side of a layer",
    "crowding": "of hanging units that overlap: turned about the vertical, drawn again, or lifted",
    "plate_rows": "rows of plates on each layer, such as 4,3,3,2,1, in place of as many as along x",
    "plate_margin": "round each plate, in Dn",
    "standing": "repair: a CSV of units that stand, such as damaged.csv (layer,x_m,y_m,z_m,qw,qx,qy,qz)",
    "placement_scatter": "standard deviation of the aims from layer 2 on, in Dn",
    "placement_offset_x": "by which each layer misses its aim more than the one below, in Dn",
    "placement_offset_y": "the same in y",
    "yaw_constraint": "concentration of the first headings about x",
    "lost_units": "fraction left out",
    "sequential_placement": "rows of a layer one after another",
    "unit_by_unit": "units of a layer one after another",
    "loose_lower_layers": "no layer is ever fixed",
    "vibration": "shaking along x after each layer, in g",
    "bottom_roughness": "standard deviation of the bed's heights, in Dn",
    "inertia_factor": "moments of inertia over the true ones",
    "tip_share": "of the first layer's units that stand on a tip",
    "set_back": "least distance of a layer's edge from that of the layer below, in spacings",
    "walls": "side walls of a flume, half a spacing beyond the first layer",
}


def placement_options(command):
    """One option for every field of PlacementTest; those not given are left out of the keywords."""
    defaults = {field.name: field.default for field in fields(PlacementTest)}
    defaults |= {"nominal_diameter": None, "stacking": "ABC", "grid": "TPG"}

    def given(**keywords):
        return command(**{name: value for name, value in keywords.items() if value is not None or name not in defaults})

    given.__name__, given.__doc__ = command.__name__, command.__doc__
    given.__click_params__ = getattr(command, "__click_params__", [])
    for name in reversed(list(HELP)):
        default = defaults[name]
        if isinstance(default, bool):
            given = click.option("--" + name.replace("_", "-"), name, is_flag=True, default=None, help=HELP[name])(given)
            continue
        kind = click.Choice(CHOICES[name]) if name in CHOICES else KINDS.get(name, type(default))
        default = f"{default:.4g}" if isinstance(default, float) else default
        shown = "" if default in (None, "", ()) else f"  [default: {default}]"
        given = click.option("--" + name.replace("_", "-"), name, type=kind, help=HELP[name] + shown)(given)
    return given
