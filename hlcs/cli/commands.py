"""The command `hlcs`: thin wrappers round the package's functions. Work and words live elsewhere.

Exit statuses are the business of `hlcs.cli.error_handling`. A verdict is a result: 0.
"""

from contextlib import nullcontext

import click

from hlcs.cli import error_handling
from hlcs.cli.options import (
    SEED,
    allow_outside_option,
    effects_option,
    example,
    json_option,
    output_options,
    path_option,
    placement_options,
    progress_bar,
    publish,
    quiet_option,
    workers_option,
)
from hlcs.files import folders
from hlcs.placement.procedure import PlacementTest


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(package_name="hlcs")
def commands():
    """Place concrete armour units on a computer, compare with the laboratory, and find what the model is missing."""


@commands.command()
@output_options
@click.option("--seed", type=int, default=1, show_default=True, help="of the orientations")
@example("hlcs demo --out out")
def demo(seed, out, json_file, quiet):
    """The main job in under a minute, beside the laboratory.

    A five-layer placement test of Cubipods on the triangular grid, with the settings of the paper. In --out: layers.csv,
    result.json, report.html (one file, opens offline), scene.glb, structure.png, poses.npz, and settings.toml, which
    `hlcs place` repeats exactly.
    """
    _place(PlacementTest(seed=seed), out, json_file, quiet)


@commands.command()
@click.argument("file", required=False, metavar="[TEST.toml]")
@placement_options
@allow_outside_option
@output_options
@example("hlcs place --grid RPG --layers 3 --friction 0.36 --out out", "hlcs place out/settings.toml")
def place(file, allow_outside, out, json_file, quiet, **settings):
    """One placement test, from a file, options, or both.

    TEST.toml has a table [placement] with the names below, such as falling_distance = 0.25. Options win over it.
    """
    from hlcs.placement.placement_file import make_placement, read_placement_file

    test = read_placement_file(file, allow_outside=allow_outside, **settings) if file else make_placement(settings)
    _place(test, out, json_file, quiet)


def _place(test, out, json_file, quiet):
    """Run a test, print it beside the laboratory's, write its files."""
    from hlcs.placement import comparison, report

    measured = comparison.laboratory_for(test)
    with folders.result_folder(out) if out else nullcontext() as folder:
        with progress_bar("layers", test.layers, quiet) as bar:
            result = test.run(progress=lambda layer: bar.update())
        if folder:
            report.write(result, folder)
    text = result.summary()
    if measured is not None:
        text += f"\n\n{comparison.compare_layers(result, measured)}"
    publish(result.to_dict(), text, json_file, out, quiet)


@commands.command()
@click.argument("table", type=click.Choice(["table1", "table2", "table3", "blind", "figures", "ladder", "all"]))
@click.option("--repeats", type=click.IntRange(1, 10_000), help="tests a case; 5, for table1 1, for ladder 8")
@workers_option
@click.option("--seed", type=SEED, default=1, show_default=True, help="of the first test; the others follow")
@click.option("--friction", type=float, help="of a contact; left out: both 0.36, which is what Bullet makes of 0.6, and 0.6")
@click.option("--margin", type=float, help="collision margin round each unit, in Dn  [default: 0]")
@click.option("--shape", type=click.Choice(["pieces", "hull"]), help="the true unit or its convex hull  [default: pieces]")
@click.option("--rows", type=int, help="of the first layer  [default: 8]")
@click.option("--columns", type=int, help="of the first layer  [default: 8]")
@click.option("--layers", type=int, help="[default: 5]")
@output_options
@example("hlcs reproduce table2 --repeats 5 --json t2.json", "hlcs reproduce figures --out docs/images")
def reproduce(table, repeats, workers, seed, out, json_file, quiet, **settings):
    """The paper's tables and figures, beside its own columns.

    table1: sensitivity, three layers, one parameter at a time. table2: RPG and TPG on a flat bottom. table3: TPG on a 4 % slope.
    blind: layer against blind reference. figures: the true unit beside its hull, the plot and the picture of the README.
    ladder (not part of all): the naive model, one hull a unit, diagnosed on table2 with table3 held out.
    """
    from hlcs.paper import reproduce_files
    from hlcs.paper.reproduce import TABLES, Plan

    plan = Plan({name: value for name, value in settings.items() if value is not None}, repeats, seed, workers)
    documents, texts = {}, []
    with folders.result_folder(out) if out else nullcontext() as folder:
        for name in TABLES if table == "all" else (table,):
            with progress_bar(name, None, quiet) as bar:
                documents[name], text = reproduce_files.run(name, plan, folder, None if quiet else bar.start)
            texts.append(text + "\n")
            if not quiet and not out:  # shown at once where a broken terminal takes no files with it
                error_handling.say(texts.pop())
    publish(documents if table == "all" else documents[table], "\n".join(texts), json_file, out, quiet)


@commands.command()
@click.argument("file", metavar="EXPERIMENT.toml")
@effects_option(", used under [model]")
@allow_outside_option
@click.option("--seed", type=SEED, default=0, show_default=True, help="of the simulations (layer data)")
@workers_option
@output_options
@example("hlcs compare drop.toml --out out")
def compare(file, effects_file, allow_outside, seed, workers, out, json_file, quiet):
    """Where, and by how much, does the model miss the measurement."""
    from hlcs.compare import compare as compare_file

    if out:
        folders.check_folder(out)  # refused now, not after minutes
    comparison = compare_file(
        file, effects_file=effects_file, seed=seed, workers=workers, progress=not quiet, allow_outside=allow_outside
    )
    if out:
        comparison.save(out)
    publish(comparison.to_json(), comparison.summary(), json_file, out, quiet)


@commands.command()
@click.argument("file", metavar="EXPERIMENT.toml")
@click.option("--candidates", help="names of effects to try, with commas; left out: the file's, or all that fit")
@effects_option("")
@allow_outside_option
@path_option("--plots", metavar="DIR", help="draw residuals, ranking, and the error falling")
@click.option("--seed", type=SEED, default=0, show_default=True, help="of the simulations (layer data)")
@workers_option
@output_options
@example("hlcs diagnose drop.toml --plots plots --json drop.json")
def diagnose(file, candidates, effects_file, allow_outside, plots, seed, workers, out, json_file, quiet):
    """Which effect is missing, and how sure is that."""
    from hlcs.diagnose import diagnose as diagnose_file

    names = [name.strip() for name in candidates.split(",") if name.strip()] if candidates is not None else None
    for folder in filter(None, (out, plots)):
        folders.check_folder(folder)  # refused now, not after minutes
    diagnosis = diagnose_file(
        file,
        candidates=names,
        effects_file=effects_file,
        seed=seed,
        workers=workers,
        progress=not quiet,
        allow_outside=allow_outside,
    )
    for folder in filter(None, (out, plots)):
        diagnosis.save(folder)
    publish(diagnosis.to_json(), diagnosis.summary(), json_file, out or plots, quiet)


@commands.command()
@click.argument("file", metavar="SWEEP.toml")
@path_option("--store", default="runs.sqlite", show_default=True, help="the file of finished runs; a sweep goes on from it")
@workers_option
@allow_outside_option
@click.option("--dask", metavar="ADDRESS", help="a Dask scheduler such as tcp://host:8786 (extra 'sweep')")
@output_options
@example("hlcs sweep friction.toml --store runs.sqlite --workers 4 --out out")
def sweep(file, store, workers, allow_outside, dask, out, json_file, quiet):
    """Many runs; killed and started again, it goes on.

    SWEEP.toml has [placement] with what all runs share, as in `hlcs place`, and [sweep] with lists, such as
    friction = [0.3, 0.6] and seed = [1, 2, 3].
    """
    from hlcs.placement import parameter_sweep as sweeps

    plan = sweeps.read_sweep_file(file, allow_outside)
    sweeps.check_store(store)  # before it is said that anything is kept there
    error_handling.keep(f"finished runs are kept in {store}: the same command goes on from there")
    with folders.result_folder(out) if out else nullcontext() as folder:
        with progress_bar("runs", None, quiet) as bar:
            outcome = sweeps.run_sweep(plan, store, workers, dask, bar.start)
        if folder:
            sweeps.write_sweep(plan, outcome, folder)
    publish(sweeps.document(plan, outcome), sweeps.summary_text(plan, outcome), json_file, out, quiet)


@commands.command()
@output_options
@example("hlcs doctor")
def doctor(out, json_file, quiet):
    """Versions, optional parts, and a ten-second self-test.

    The self-test asks the collision library, the engine, and one small placement test. Exit status 1 if it fails.
    """
    from hlcs.cli import doctor as examination

    report = examination.examine()
    with folders.result_folder(out) if out else nullcontext() as folder:
        if folder:
            folders.write_json(folder / "doctor.json", report)
    publish(report, examination.text_of(report), json_file, out, quiet)
    return 0 if report["passed"] else 1


@commands.group()
def mystery():
    """Data sets with a hidden effect, to be found."""


@mystery.command("list")
@json_option
@quiet_option
@example("hlcs mystery list")
def mystery_list(json_file, quiet):
    """One name a line with its title."""
    from hlcs import mystery as mysteries

    titles = {name: mysteries.title(name) for name in mysteries.names()}
    publish(titles, "\n".join(f"{name:18} {title}" for name, title in titles.items()), json_file, None, quiet)


@mystery.command("copy")
@click.argument("name")
@path_option("--out", metavar="DIR", help="folder for the data set; left out: ./NAME")
@quiet_option
@example("hlcs mystery copy north-window --out case")
def mystery_copy(name, out, quiet):
    """Copy a data set into a folder."""
    from hlcs import mystery as mysteries

    file = mysteries.copy(name, out or name)
    if not quiet:
        error_handling.say(f"now: hlcs diagnose {file}")


@mystery.command("reveal")
@click.argument("name")
@json_option
@quiet_option
@example("hlcs mystery reveal north-window")
def mystery_reveal(name, json_file, quiet):
    """Tell the hidden effect."""
    from hlcs import mystery as mysteries

    publish({"name": name, **mysteries.answer(name)}, mysteries.reveal(name), json_file, None, quiet)


def run(arguments=None):
    """Run the command; returns what the commands return, raises what they raise."""
    return commands.main(args=arguments, prog_name="hlcs", standalone_mode=False)


def main(arguments=None):
    """Run the command under the net; returns the exit status."""
    return error_handling.under(lambda: run(arguments))
