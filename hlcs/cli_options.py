"""What the commands of `hlcs` share: options, examples, progress, and the last lines they print."""

import inspect
import sys
from dataclasses import fields

import click

from hlcs import files, interrupts
from hlcs.experiment import PlacementTest

CHOICES = {"reference": ["layer", "blind"], "shape": ["pieces", "hull"], "armour": ["cubipod", "cube"],
           "stacking": ["ABC", "ABA"], "solver": ["exact", "gauss_seidel", "sequential_impulse"]}
HELP = {
    "grid": "TPG, RPG, or two spacings in Dn: A,B or A,B,triangular", "layers": "how many", "rows": "of the first layer",
    "columns": "of the first layer", "bottom": "flat, slope:0.04, or a survey bed.csv (x_m,y_m,z_m)",
    "reference": "each layer aimed from the layer below, or blindly", "shape": "the true unit, or its convex hull",
    "armour": "kind of unit", "side": "of the unit's cube, m",
    "nominal_diameter": "of the unit, m, in place of --side", "friction": "of a contact",
    "restitution": "of a contact", "linear_damping": "Eq. 6", "angular_damping": "Eq. 7", "margin": "round each unit, in Dn",
    "falling_distance": "above the layers below, in Dn", "density": "of the units, kg/m3", "seed": "of the orientations",
    "stacking": "of a triangular grid", "time_step": "s", "iterations": "most sweeps of the solver a step",
    "tolerance": "residual at which a step is solved", "solver": "how contacts are solved",
    "settle_time": "longest wait for a layer, s", "plates": "measuring plates along each side of a layer",
    "placement_scatter": "standard deviation of the aims from layer 2 on, in Dn",
    "placement_offset_x": "by which each layer misses its aim more than the one below, in Dn",
    "placement_offset_y": "the same in y",
    "yaw_constraint": "concentration of the first headings about x", "lost_units": "fraction left out",
    "sequential_placement": "rows of a layer one after another", "loose_lower_layers": "no layer is ever fixed",
    "vibration": "shaking along x after each layer, in g", "bottom_roughness": "standard deviation of the bed's heights, in Dn",
    "inertia_factor": "moments of inertia over the true ones"}


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
        kind = click.Choice(CHOICES[name]) if name in CHOICES else float if name == "nominal_diameter" else type(default)
        default = f"{default:.4g}" if isinstance(default, float) else default
        shown = "" if default is None else f"  [default: {default}]"
        given = click.option("--" + name.replace("_", "-"), name, type=kind, help=HELP[name] + shown)(given)
    return given


def output_options(command):
    """--out, --json, --quiet."""
    command = click.option("--quiet", "-q", is_flag=True, help="print nothing, show no progress")(command)
    command = click.option("--json", "json_file", metavar="FILE", help="the result for a program")(command)
    return click.option("--out", metavar="DIR", help="folder for files: tables, pictures, settings")(command)


def workers_option(command):
    """--workers."""
    return click.option("--workers", type=click.IntRange(1), help="processes  [default: as many as processors]")(command)


def example(*lines):
    """Add real command lines to the end of a command's help."""
    def add(function):
        function.__doc__ = inspect.cleandoc(function.__doc__) + "\n\n\b\nExample:\n" + "\n".join(f"  {line}" for line in lines)
        return function
    return add


class Bar:
    """A progress bar on a terminal, nothing elsewhere."""

    def __init__(self, name, total, quiet):
        self._name, self._quiet, self._bar = name, quiet, None
        if total is not None:
            self.start(total)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self._bar is not None:
            self._bar.close()

    def start(self, total, done=0):
        """Show a bar of so many pieces; returns the function to be called as each one ends."""
        from tqdm import tqdm

        # disable=None: none where stderr is not a terminal
        hidden = True if self._quiet else None
        self._bar = tqdm(total=total, initial=done, desc=self._name, leave=False, disable=hidden, file=sys.stderr)
        self._bar.refresh()
        return self.update

    def update(self):
        """One piece is done."""
        interrupts.check()
        self._bar.update()


def progress_bar(name, total, quiet):
    """A Bar; total None = known only when the work starts."""
    return Bar(name, total, quiet)


def publish(document, json_file, out, quiet):
    """The last words of a command: the JSON file, and where things were written."""
    if json_file:
        files.write_json(json_file, document)
    if out and not quiet:
        click.echo(f"\nwritten to {out}")
