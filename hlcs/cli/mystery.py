"""`hlcs mystery`: data sets with a hidden effect."""

import click

import hlcs.mystery as mystery_sets
from hlcs.cli import error_handling
from hlcs.cli.options import example, json_option, path_option, publish, quiet_option


@click.group()
def mystery():
    """Data sets with a hidden effect, to be found."""


@mystery.command("list")
@json_option
@quiet_option
@example("hlcs mystery list")
def mystery_list(json_file, quiet):
    """One name a line with its title."""
    titles = {name: mystery_sets.title(name) for name in mystery_sets.names()}
    publish(titles, "\n".join(f"{name:18} {title}" for name, title in titles.items()), json_file, None, quiet)


@mystery.command("copy")
@click.argument("name")
@path_option("--out", metavar="DIR", help="folder for the data set; left out: ./NAME")
@quiet_option
@example("hlcs mystery copy north-window --out case")
def mystery_copy(name, out, quiet):
    """Copy a data set into a folder."""
    file = mystery_sets.copy(name, out or name)
    if not quiet:
        error_handling.say(f"now: hlcs diagnose {file}")


@mystery.command("reveal")
@click.argument("name")
@json_option
@quiet_option
@example("hlcs mystery reveal north-window")
def mystery_reveal(name, json_file, quiet):
    """Tell the hidden effect."""
    publish({"name": name, **mystery_sets.answer(name)}, mystery_sets.reveal(name), json_file, None, quiet)
