"""`hlcs effects`: the catalogue of what may be missing from a model."""

import click

from hlcs.cli.options import effects_option, example, json_option, publish, quiet_option
from hlcs.effects import own_classes
from hlcs.effects.catalogue import FAMILIES
from hlcs.kinds.catalogue import named, whole_catalogue
from hlcs.report import catalogue


@click.command()
@click.argument("name", required=False)
@effects_option(", to be listed too")
@json_option
@quiet_option
@example("hlcs effects", "hlcs effects quadratic_drag")
def effects(name, effects_file, json_file, quiet):
    """The effects that a model may lack: law, numbers with units, typical values, what each is confused with.

    Without a NAME: a list of all. The same stands in the documentation, with pictures.
    """
    own = own_classes(None, effects_file)
    if name is not None:
        facts = named(name, own)
        publish({"format": 1, **facts.to_json()}, catalogue.one(facts), json_file, None, quiet)
        return
    found = whole_catalogue(own)
    document = {"format": 1, "effects": [facts.to_json() for facts in found]}
    publish(document, catalogue.all_of(found, FAMILIES), json_file, None, quiet)
