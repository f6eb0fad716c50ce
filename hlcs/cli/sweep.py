"""`hlcs sweep`: many placement tests."""

import click

from hlcs.cli import error_handling
from hlcs.cli.options import (
    ProgressBar,
    allow_outside_option,
    example,
    out_folder,
    output_options,
    path_option,
    publish,
    workers_option,
)
from hlcs.placement import parameter_sweep, sweep_report
from hlcs.processes.compilation import compile_engine


@click.command()
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
    plan = parameter_sweep.read_sweep_file(file, allow_outside)
    parameter_sweep.check_store(store)  # before it is said that anything is kept there
    error_handling.remember(f"finished runs are kept in {store}: the same command goes on from there", goes_on=True)
    with out_folder(out) as folder:
        if not dask:
            compile_engine(quiet)
        with ProgressBar("runs", None, quiet) as bar:
            found = parameter_sweep.SweepResult(plan, parameter_sweep.run_sweep(plan, store, workers, dask, bar.start))
        if folder:
            sweep_report.write(found, folder)
    publish(found.to_dict(), found.summary(), json_file, out, quiet)
