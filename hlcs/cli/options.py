"""What the commands of `hlcs` share: options, examples, progress, and what they print and write at the end."""

import functools
import inspect
import json
import sys
from contextlib import redirect_stdout
from dataclasses import fields
from pathlib import Path

import click

from hlcs.cli import error_handling
from hlcs.files import folders
from hlcs.placement.procedure import PlacementTest
from hlcs.processes import interrupts

CHOICES = {
    "reference": ["layer", "blind"],
    "shape": ["pieces", "hull"],
    "armour": ["cubipod", "cube"],
    "stacking": ["ABC", "ABA"],
    "solver": ["exact", "gauss_seidel", "sequential_impulse"],
}
HELP = {
    "grid": "TPG, RPG, or two spacings in Dn: A,B or A,B,triangular",
    "layers": "how many",
    "rows": "of the first layer",
    "columns": "of the first layer",
    "bottom": "flat, slope:0.04, or a survey bed.csv (x_m,y_m,z_m)",
    "reference": "each layer aimed from the layer below, or blindly",
    "shape": "the true unit, or its convex hull",
    "armour": "kind of unit",
    "side": "of the unit's cube, m",
    "nominal_diameter": "of the unit, m, in place of --side",
    "friction": "of a contact",
    "restitution": "of a contact",
    "linear_damping": "Eq. 6",
    "angular_damping": "Eq. 7",
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
    "placement_scatter": "standard deviation of the aims from layer 2 on, in Dn",
    "placement_offset_x": "by which each layer misses its aim more than the one below, in Dn",
    "placement_offset_y": "the same in y",
    "yaw_constraint": "concentration of the first headings about x",
    "lost_units": "fraction left out",
    "sequential_placement": "rows of a layer one after another",
    "loose_lower_layers": "no layer is ever fixed",
    "vibration": "shaking along x after each layer, in g",
    "bottom_roughness": "standard deviation of the bed's heights, in Dn",
    "inertia_factor": "moments of inertia over the true ones",
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
        kind = click.Choice(CHOICES[name]) if name in CHOICES else float if name == "nominal_diameter" else type(default)
        default = f"{default:.4g}" if isinstance(default, float) else default
        shown = "" if default is None else f"  [default: {default}]"
        given = click.option("--" + name.replace("_", "-"), name, type=kind, help=HELP[name] + shown)(given)
    return given


class PathName(click.ParamType):
    """A name that the system can take, of something that is there or not: refused now, not after the work."""

    name = "path"

    def convert(self, value, param, ctx):
        try:
            if value.strip():
                Path(value).expanduser().lstat()
                return value
            problem = "it is empty; give a name"
        except FileNotFoundError:
            return value
        except (OSError, ValueError, RuntimeError) as refused:  # RuntimeError: ~ of nobody
            problem = getattr(refused, "strerror", None) or refused
        self.fail(f"'{value[:60]}': {problem}", param, ctx)


SEED = click.IntRange(0, 2**63 - 1)


def path_option(*names, **settings):
    """An option that names a file or a folder."""
    return click.option(*names, type=PathName(), **settings)


def json_option(command):
    """--json FILE; with "-" the command gets standard output itself, and all its other words go to standard error."""

    @functools.wraps(command)
    def given(json_file=None, **others):
        if json_file != "-":
            return command(json_file=json_file, **others)
        stream = sys.stdout
        with redirect_stdout(sys.stderr):
            return command(json_file=stream, **others)

    words = "the result for a program; - is standard output, then all other words go to standard error"
    return path_option("--json", "json_file", metavar="FILE", help=words)(given)


def quiet_option(command):
    """--quiet."""
    return click.option("--quiet", "-q", is_flag=True, help="print nothing, show no progress")(command)


def output_options(command):
    """--out, --json, --quiet."""
    command = json_option(quiet_option(command))
    return path_option("--out", metavar="DIR", help="folder for files: tables, pictures, settings")(command)


def effects_option(words):
    """--effects; words: what it is good for in this command."""
    words = f"a Python file with effects of your own{words}. Effects files are run as code: give only files that you trust"
    return path_option("--effects", "effects_file", metavar="FILE.py", help=words)


def allow_outside_option(command):
    """--allow-outside."""
    words = "let the file name files outside its own folder"
    return click.option("--allow-outside", is_flag=True, help=words)(command)


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


def publish(document, text, json_file, out, quiet):
    """The last words of a command: its JSON, the report, and where things were written; what fails first does not take the rest.

    json_file: name of a file, a stream, or None; out: the folder that was written, or None.
    """
    if out:
        error_handling.keep(f"{out} is written")
    try:
        if hasattr(json_file, "write"):  # in ASCII: the same on every terminal, and nothing in it steers one
            error_handling.say(json.dumps(json.loads(folders.to_json(document)), indent=1).replace("\x7f", "\\u007f"), json_file)
        elif json_file:
            folders.write_json(json_file, document)
            error_handling.keep(f"{json_file} is written")
    finally:
        words = text + (f"\n\nwritten to {out}" if out else "")
        if words and not quiet:
            error_handling.say(words)
