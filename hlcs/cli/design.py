"""`hlcs design`: which grid, how many layers and which units reach a height."""

import click

from hlcs.cli import error_handling
from hlcs.cli.options import SEED, ProgressBar, example, out_folder, output_options, path_option, publish, workers_option
from hlcs.files import folders
from hlcs.placement import design_check, design_report
from hlcs.placement.design import MOST_LAYERS, Wanted
from hlcs.placement.design import design as make_design
from hlcs.placement.run_store import default_store
from hlcs.processes.compilation import compile_engine


@click.command()
@click.option("--height", type=float, help="to be reached above the bed, m")
@click.option("--crest", type=float, help="level of the crest above datum in place of --height, m")
@click.option("--nominal-diameter", "nominal_diameters", type=float, multiple=True, help="of the units, m; once for every size")
@click.option(
    "--grid", "grids", multiple=True, default=["TPG", "RPG"], show_default=True, help="as in `hlcs place`; more than once"
)
@click.option("--bottom", default="flat", show_default=True, help="flat, slope:0.04, mound:.., or a survey bed.csv (x_m,y_m,z_m)")
@click.option("--probability", type=float, default=0.95, show_default=True, help="with which the height is to be reached")
@click.option("--layers", type=int, help=f"most that are tried  [default: as many as may be needed, up to {MOST_LAYERS}]")
@click.option("--rows", type=int, help="of the first layer, across the structure  [default: 8, or layers + 3]")
@click.option("--columns", type=int, help="of the first layer, along the structure  [default: 8, or layers + 3]")
@click.option("--repeats", type=int, default=20, show_default=True, help="runs of a grid, each of another seed and friction")
@click.option("--seed", type=SEED, default=1, show_default=True, help="of the first run; the next ones follow")
@click.option("--check", "new_runs", type=click.IntRange(1, 10_000), help="so many new runs of the option that was chosen")
@path_option("--store", help="the file of finished runs  [default: designs.sqlite in the cache]")
@workers_option
@output_options
@example("hlcs design --height 5.0 --nominal-diameter 1.07", "hlcs design --crest 3.2 --bottom bed.csv --nominal-diameter 0.8")
def design(new_runs, store, workers, out, json_file, quiet, **wanted):
    """What reaches a height, how surely, with how much concrete.

    Grids, numbers of layers and sizes of Cubipods are placed with many seeds and frictions. Runs are kept: the same command goes
    on after it was stopped, and other heights and sizes on a flat bed need no new ones. In --out: options.csv, design.json,
    design.txt, trade_off.png, and chosen.toml for `hlcs place`. --check runs the chosen option again with other seeds and
    frictions, and counts how often it reaches the height, beside the simulated P; in --out: check.txt.
    """
    wanted = Wanted(**wanted)
    wanted.cases()  # what cannot be placed is refused before anything is compiled
    store = store or default_store("designs.sqlite")
    error_handling.remember(f"finished runs are kept in {store}: the same command goes on from there", goes_on=True)
    with out_folder(out) as folder:
        compile_engine(quiet)
        with ProgressBar("runs", None, quiet) as bar:
            result = make_design(wanted, store, workers, bar.start)
        document, text = result.to_dict(), result.summary()
        if folder:
            design_report.write(result, folder)
        if new_runs:
            with ProgressBar("check", None, quiet) as bar:
                reached = design_check.check(result, store, new_runs, workers, bar.start)
            document["check"] = [each._asdict() for each in reached]
            told = "\n".join(design_check.check_lines(reached, "height" if wanted.crest is None else "level"))
            text = f"{text}\n\n{told}"
            if folder:
                folders.write_text(folder / "check.txt", told + "\n")
    publish(document, text, json_file, out, quiet)
