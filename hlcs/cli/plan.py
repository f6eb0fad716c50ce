"""`hlcs plan`: what would find an effect, before the experiment."""

import click
import numpy as np

from hlcs.cli.options import allow_outside_option, effects_option, example, json_option, publish, quiet_option
from hlcs.kinds.experiment import Experiment
from hlcs.kinds.protocol import Options
from hlcs.report.plan import text
from hlcs.selection import planning
from minibullet.errors import InputError


class Number(click.ParamType):
    """NAME=VALUE as a pair."""

    name = "number"

    def convert(self, value, param, ctx):
        if isinstance(value, tuple):
            return value
        name, equals, number = (part.strip() for part in value.partition("="))
        try:
            if name and equals:
                return name, float(number)
        except ValueError:
            pass
        return self.fail(f"'{value}': write PARAMETER=VALUE with a number, such as drag_coefficient=0.47", param, ctx)


def _once(at):
    """The numbers of --at as a dictionary; InputError where one is given twice."""
    names = [name for name, _ in at]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise InputError(f"--at {twice} is given {names.count(twice)} times; give each number once")
    return dict(at)


@click.command()
@click.argument("file", metavar="EXPERIMENT.toml")
@click.option("--effect", required=True, metavar="NAME", help="what is to be found")
@click.option("--at", type=Number(), multiple=True, required=True, metavar="PARAMETER=VALUE", help="its size; may be repeated")
@click.option("--power", type=float, default=0.9, show_default=True, help="probability with which it is to be found")
@effects_option("")
@allow_outside_option
@json_option
@quiet_option
@example("hlcs plan drop.toml --effect quadratic_drag --at drag_coefficient=0.47 --power 0.9")
def plan(file, effect, at, power, effects_file, allow_outside, json_file, quiet):
    """How many recordings, how long and how precise, find an effect of this size.

    The experiment file is a pilot: recordings, or rows of a table, like those that are planned.
    """
    experiment = Experiment.read(file, allow_outside, effects_file)
    experiment = experiment.opened(Options(experiment.user_effects))
    with np.errstate(invalid="ignore", over="ignore"):  # of numbers beyond all measure, which are refused in a line of their own
        found = planning.plan(experiment, effect, _once(at), power)
    publish(found.to_json(), text(found), json_file, None, quiet)
