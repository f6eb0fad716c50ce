"""`hlcs reproduce`: the paper's tables and figures again."""

import time

import click

from hlcs.cli import error_handling
from hlcs.cli.options import SEED, ProgressBar, example, out_folder, output_options, preset_option, publish, workers_option
from hlcs.paper import reproduce_files
from hlcs.paper.reproduce import TABLES, Plan
from hlcs.processes.compilation import compile_engine
from minibullet.errors import InputError


@click.command()
@click.argument("table", type=click.Choice([*TABLES, "ladder", "blender", "slope", "set_back", "workability", "all"]))
@click.option(
    "--repeats",
    type=click.IntRange(1, 10_000),
    help="tests a case; 5, for table1 and workability 3, for ladder 8, for blender 20",
)
@workers_option
@click.option("--seed", type=SEED, default=1, show_default=True, help="of the first test; the others follow")
@click.option("--friction", type=float, help="of a contact; left out: both 0.36, which is what Bullet makes of 0.6, and 0.6")
@click.option(
    "--margin", type=float, help="round units and plates, in Dn; left out: both 0 and the paper's 0.008 (table2, table3)"
)
@click.option("--shape", type=click.Choice(["pieces", "hull"]), help="the true unit or its convex hull  [default: pieces]")
@click.option("--rows", type=int, help="of the first layer  [default: 8]")
@click.option("--columns", type=int, help="of the first layer  [default: 8]")
@click.option("--layers", type=int, help="[default: 5]")
@preset_option
@output_options
@example("hlcs reproduce table2 --repeats 5 --json t2.json", "hlcs reproduce table3 --preset paper --out slope")
def reproduce(table, repeats, workers, seed, preset_name, out, json_file, quiet, **settings):
    """The paper's tables and figures, beside its own columns.

    table1: sensitivity, three layers, one parameter at a time. table2: RPG and TPG on a flat bottom. table3: TPG on a 4 % slope.
    blind: layer against blind reference. figures: the true unit beside its hull and, with --out, the
    paper's figures from runs, a falling layer as GIF and as a page. all, with --out: index.html shows each beside the paper's.

    Not part of all: slope: side walls, the flume's rows and columns, units on a tip. set_back: layers that keep back from the
    edge. workability: lost and misplaced units over grid spacing and placement error. ladder: the naive model, one hull a unit,
    diagnosed on table2 with table3 held out. blender: ours at the settings of Blender's own runs, z of every layer, and at our
    defaults the error to the laboratory with its interval over seeds; runs are kept in the cache.
    """
    if table == "ladder" and preset_name:
        raise InputError("reproduce ladder: it starts from the naive model, so it takes no --preset; leave that out")
    plan = Plan({name: value for name, value in settings.items() if value is not None}, repeats, seed, workers, preset_name)
    documents, texts, started = {}, {}, time.perf_counter()
    with out_folder(out) as folder:
        compile_engine(quiet)
        for name in TABLES if table == "all" else (table,):
            with ProgressBar(name, None, quiet) as bar:
                documents[name], text = reproduce_files.run(name, plan, folder, None if quiet else bar.start, out)
            texts[name] = text + "\n"
            if not quiet and not out:  # shown at once where a broken terminal takes no files with it
                error_handling.say(texts.pop(name))
        if table == "all" and folder:
            reproduce_files.write_index(documents, texts, folder, time.perf_counter() - started)
    publish({"format": 1, **documents} if table == "all" else documents[table], "\n".join(texts.values()), json_file, out, quiet)
