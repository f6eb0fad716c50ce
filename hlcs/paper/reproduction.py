"""`hlcs.reproduce`: a table or figure of the paper again, as a result that prints, draws and saves itself."""

from dataclasses import dataclass

from hlcs.paper import reproduce_files
from hlcs.paper.reproduce import Plan
from hlcs.rendering import Result
from minibullet.errors import InputError, one_of, shown_value


@dataclass(frozen=True, eq=False, repr=False)
class Reproduction(Result):
    """What `hlcs reproduce` tells of one table."""

    document: dict  # what --json writes: numbers with their settings and versions

    @property
    def table(self):
        """Name of the table: "table1" .. "table3", "figures", "workability"."""
        return self.document["table"]

    def to_dict(self):
        """The document, for a program."""
        return self.document

    def to_dataframe(self):
        """One row a layer of every grid and setting (table2, table3, figures), a value of a parameter (table1), or a case
        (workability); lengths in Dn, angles in degrees."""
        import pandas as pd

        if self.table in ("table1", "workability"):
            return pd.DataFrame(self.document["rows" if self.table == "table1" else "cases"])
        return pd.DataFrame(
            [
                {"setting": words, "grid": grid, **layer}
                for words, grids in reproduce_files.settings_of(self.document).items()
                for grid, found in grids.items()
                for layer in found["layers"]
            ]
        )


def reproduce(table, repeats=None, seed=1, workers=None, preset=None, progress=None, **settings):
    """Run a table or figure of the paper again; returns a Reproduction.

    table: "table1" (sensitivity, one parameter at a time), "table2" (both grids on a flat bottom), "table3" (TPG on a 4 % slope),
    "figures" (the true unit beside its convex hull), "workability" (lost and misplaced units); repeats: tests of a case, None:
    the table's own number; seed: of the first test, the others follow it; workers: processes, None: as many as processors;
    preset: name of settings, such as "paper"; progress: function of a number of runs that returns a bar to be told of each, None:
    no bar; settings: of a `PlacementTest` that differ from its defaults. Raises InputError for a table or a setting that there is
    not. What has no picture (blind, slope, set_back, ladder, blender) is run by the command `hlcs reproduce` alone.
    """
    if table not in reproduce_files.PICTURES:
        raise InputError(f"reproduce: table = {shown_value(table)}; {one_of(table, reproduce_files.PICTURES)}")
    plan = Plan(settings, repeats, seed, workers, preset)
    return Reproduction(reproduce_files.run(table, plan, progress=progress)[0])
