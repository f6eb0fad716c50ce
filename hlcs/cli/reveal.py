"""`hlcs mystery reveal`: the sealed answer, and what the data themselves give for it when its effects are fitted to them."""

import hlcs.mystery as mystery_sets
from hlcs.diagnose import diagnose
from hlcs.effects.catalogue import facts_of
from hlcs.effects.library import classes
from hlcs.files import folders
from hlcs.report import reveal
from hlcs.report.page import png


def law_of(effect):
    """The law of an effect of the library, in words and as its formula where it has one."""
    facts = facts_of(classes()[effect])
    return f"{facts.law} {facts.formula}".strip()


def revealed(name, fit=True, progress=False):
    """(what a program reads, text, diagnosis or None) of a mystery; fit: fit what is hidden, and what cannot be told from it, to
    the data."""
    answer, diagnosis = mystery_sets.answer(name), None
    known = [effect for effect in (*answer["effects"], *answer["tied"]) if effect in classes()]
    if fit:
        diagnosis = diagnose(mystery_sets.experiment(name), candidates=known, progress=progress)
    laws = {effect: law_of(effect) for effect in answer["effects"] if effect in known}
    document = {"name": str(name), **answer, "laws": laws}
    if diagnosis:
        names = ("verdict", "effects", "parameters", "ambiguous", "error", "adequate")
        document["found"] = {key: getattr(diagnosis, key) for key in names}
    return document, reveal.told(answer, laws, diagnosis), diagnosis


def save(document, text, diagnosis, out):
    """Write reveal.json, reveal.txt and, where something was fitted, before_and_after.png into the folder `out`."""
    found = {"reveal.json": folders.to_json(document).encode(), "reveal.txt": (text + "\n").encode()}
    if diagnosis and diagnosis.pictures:
        found["before_and_after.png"] = png(reveal.before_and_after(diagnosis))
    folders.save_files(out, found)
