"""`hlcs compare` and `hlcs diagnose`: a model against a measurement."""

from dataclasses import replace

import click

from hlcs.cli.options import (
    SEED,
    allow_outside_option,
    details_option,
    effects_option,
    example,
    output_options,
    path_option,
    publish,
    workers_option,
)
from hlcs.compare import compare as compare_file
from hlcs.diagnose import diagnose as diagnose_file
from hlcs.files import folders
from hlcs.kinds.experiment import check_target
from minibullet.errors import InputError


@click.command()
@click.argument("file", metavar="EXPERIMENT.toml")
@effects_option(", used under [model]")
@allow_outside_option
@click.option("--seed", type=SEED, default=0, show_default=True, help="of the simulations (layer data)")
@workers_option
@details_option
@output_options
@example("hlcs compare drop.toml --out out")
def compare(file, effects_file, allow_outside, seed, workers, details, out, json_file, quiet):
    """Where, and by how much, does the model miss the measurement."""
    if out:
        folders.check_folder(out)  # refused now, not after minutes
    comparison = compare_file(
        file, effects_file=effects_file, seed=seed, workers=workers, progress=not quiet, allow_outside=allow_outside
    )
    if out:
        comparison.save(out)
    publish(comparison.to_json(), comparison.summary(details), json_file, out, quiet)


@click.command()
@click.argument("file", metavar="EXPERIMENT.toml")
@click.option("--candidates", help="names of effects to try, with commas; left out: the file's, or all that fit")
@effects_option("")
@allow_outside_option
@path_option("--plots", metavar="DIR", help="draw residuals, ranking, and the error falling")
@path_option("--apply", "mended", metavar="NEW.toml", help="write the experiment with what was found added to its model")
@click.option("--seed", type=SEED, default=0, show_default=True, help="of the simulations (layer data)")
@workers_option
@details_option
@output_options
@example("hlcs diagnose drop.toml --plots plots --json drop.json", "hlcs diagnose drop.toml --apply drop_2.toml")
def diagnose(file, candidates, effects_file, allow_outside, plots, mended, seed, workers, details, out, json_file, quiet):
    """Which effect is missing, and how sure is that."""
    names = [name.strip() for name in candidates.split(",") if name.strip()] if candidates is not None else None
    if names == []:
        raise InputError("--candidates names no effect; name some with commas between them, or leave it out for all that fit")
    for folder in filter(None, (out, plots)):
        folders.check_folder(folder)  # refused now, not after minutes
    if mended:
        check_target(mended, file)
    diagnosis = diagnose_file(
        file,
        candidates=names,
        effects_file=effects_file,
        seed=seed,
        workers=workers,
        progress=not quiet,
        allow_outside=allow_outside,
    )
    nothing, not_written = "", None
    if mended and diagnosis.add:
        try:
            diagnosis = replace(diagnosis, mended=diagnosis.apply(diagnosis.experiment).save(mended))
        except InputError as problem:  # told behind what was found
            not_written = problem
    elif mended:
        nothing = f"\n\nNothing was found that could be added: {mended} is not written."
    for folder in filter(None, (out, plots)):
        diagnosis.save(folder)
    if diagnosis.learned and (out or plots):
        diagnosis = replace(diagnosis, learned=diagnosis.learned.in_folder(out or plots))
    publish(diagnosis.to_json(), diagnosis.summary(details) + nothing, json_file, out or plots, quiet)
    if not_written:
        raise not_written
