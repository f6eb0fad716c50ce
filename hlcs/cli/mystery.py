"""`hlcs mystery`: data sets with a hidden effect."""

import shlex

import click

import hlcs.mystery as mystery_sets
from hlcs.cli.options import SEED, example, json_option, path_option, publish, quiet_option
from hlcs.files import folders


@click.group()
def mystery():
    """Data sets with a hidden effect, to be found."""


@mystery.command("list")
@json_option
@quiet_option
@example("hlcs mystery list")
def mystery_list(json_file, quiet):
    """One name a line with its room and its title."""
    titles = {name: mystery_sets.title(name) for name in mystery_sets.names()}
    lines = [f"{name:18} {room:17} {titles[name]}" for room, sets in mystery_sets.rooms().items() for name in sets]
    publish({"format": 1, "titles": titles}, "\n".join(lines), json_file, None, quiet)


@mystery.command("copy")
@click.argument("name")
@path_option("--out", metavar="DIR", help="folder for the data set; left out: ./NAME")
@json_option
@quiet_option
@example("hlcs mystery copy north-window --out case")
def mystery_copy(name, out, json_file, quiet):
    """Copy a data set into a folder."""
    file = mystery_sets.copy(name, out or name)
    words = f"now: {shlex.join(['hlcs', 'diagnose', str(file)])}\nthe answer: {shlex.join(['hlcs', 'mystery', 'reveal', name])}"
    publish({"format": 1, "experiment": str(file)}, words, json_file, None, quiet)


@mystery.command("make")
@click.option("--effect", required=True, help="what is hidden: a name of `hlcs effects`; a wrong one is told which there are")
@click.option("--strength", type=float, required=True, help="what it changes, in standard deviations of the noise; 0: nothing")
@click.option("--seed", type=SEED, default=0, show_default=True, help="another seed, another data set")
@path_option("--out", metavar="DIR", required=True, help="new folder for the data set and its sealed answer")
@json_option
@quiet_option
@example("hlcs mystery make --effect restitution --strength 8 --seed 3 --out case")
def mystery_make(effect, strength, seed, out, json_file, quiet):
    """Make a new data set with a hidden effect."""
    file = mystery_sets.make(effect, strength, seed, out)
    written = sorted(path.name for path in file.parent.iterdir() if not path.name.startswith("."))
    words = f"for students, without the answer: hlcs mystery copy {out} --out DIR\nthe answer: hlcs mystery reveal {out}"
    publish({"format": 1, "experiment": str(file), "files": written}, words, json_file, out, quiet)


@mystery.command("reveal")
@click.argument("name")
@click.option("--no-fit", is_flag=True, help="tell what is hidden, at once, without fitting it to the data")
@path_option("--out", metavar="DIR", help="folder for the text and the picture before and after")
@json_option
@quiet_option
@example("hlcs mystery reveal north-window", "hlcs mystery reveal gym-floor --out answer")
def mystery_reveal(name, no_fit, out, json_file, quiet):
    """Tell the hidden effect, its true number, and the number that the data give.

    NAME: a packaged set, or the folder of one that was made.
    """
    from hlcs.reveal import reveal  # the whole diagnosis: `list` and `copy` start without it

    if out:
        folders.check_folder(out)  # refused now, not after the fit
    found = reveal(name, not no_fit, progress=not quiet)
    if out:
        found.save(out)
    publish(found.to_dict(), found.summary(), json_file, out, quiet)
