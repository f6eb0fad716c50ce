"""`hlcs import`: exports of instruments and spreadsheets as an experiment."""

import click

from hlcs.cli.options import PathName, example, json_option, path_option, publish, quiet_option
from hlcs.importing import FORMATS, import_measurements
from hlcs.importing.axes import ORDERS, UPS
from hlcs.importing.units import CHOICES


class Pair(click.ParamType):
    """NAME=VALUE as a pair of texts, split at the last =; with number=True the value is a number."""

    name = "pair"

    def __init__(self, like, number=False):
        self.like, self.number = like, number

    def convert(self, value, param, ctx):
        if isinstance(value, tuple):
            return value
        name, _, right = (part.strip() for part in value.rpartition("="))
        try:
            if name and (right or not self.number):
                return name, float(right) if self.number else right
        except ValueError:
            pass
        return self.fail(f"'{value}': write it as {self.like}", param, ctx)


@click.command("import")
@click.argument("files", metavar="FILE...", nargs=-1, required=True, type=PathName())
@click.option("--as", "form", type=click.Choice(list(FORMATS)), required=True, help="what wrote the files")
@path_option("--out", metavar="DIR", required=True, help="folder for the experiment file and its CSV files")
@path_option("--static", metavar="FILE", help="an export of the body at rest: the noise is taken from it")
@click.option("--up", type=click.Choice(UPS), help="axis of the file that points up; none: seen from above, motion on the floor")
@click.option(
    "--length-unit", type=click.Choice(CHOICES["length"]), help="of positions, where the file does not say it, or is wrong"
)
@click.option("--time-unit", type=click.Choice(CHOICES["time"]), help="of times, likewise")
@click.option("--frame-rate", type=float, metavar="PER_SECOND", help="times are frame numbers over this")
@click.option("--rotation-order", type=click.Choice(ORDERS), help="of Euler angles, about the axes of the turned body")
@click.option(
    "--column",
    type=Pair('"Höhe [cm]=z_m"'),
    multiple=True,
    metavar="NAME=COLUMN",
    help="what a column is, NAME= to leave it out; may be repeated",
)
@click.option("--only", multiple=True, metavar="NAME", help="a point mass, rigid body or marker to take; may be repeated")
@click.option(
    "--constant",
    type=Pair("height_m=0.80", True),
    multiple=True,
    metavar="COLUMN=VALUE",
    help="a column of a table that is the same in every row, or of recordings a number of the body or its surroundings, "
    "such as mass_kg=0.0577; may be repeated",
)
@click.option("--release-time", type=float, metavar="SECONDS", help="when the body was let go, on the clock of a list of sounds")
@json_option
@quiet_option
@example(
    "hlcs import drop.txt --as tracker --length-unit cm --out drop",
    'hlcs import falls.csv --as csv --column "Höhe [cm]=height_m" --column "Zeit [s]=fall_time_s" --out falls',
)
def import_(files, form, out, static, json_file, quiet, **overrides):
    """Read exports of Tracker, phyphox, OptiTrack Motive or a spreadsheet, and write them as an experiment.

    What the files do not say is assumed, and every assumption is listed here and in the experiment file. What no file can
    know, such as the mass, is marked "fill in" there.
    """
    for name in ("column", "constant"):
        overrides[name] = dict(overrides[name]) or None
    overrides["only"] = overrides["only"] or None
    found = import_measurements(files, form, out, static, **overrides)
    publish(found.to_json(), found.summary(), json_file, None, quiet)
