"""Reveal: the sealed answer of a mystery, and what the data themselves give for it when its effects are fitted to them."""

from dataclasses import dataclass, replace

import hlcs.mystery as mystery_sets
from hlcs.diagnose import diagnosis_of
from hlcs.kinds.catalogue import named, whole_catalogue
from hlcs.kinds.experiment import Experiment
from hlcs.kinds.protocol import Options
from hlcs.records import Diagnosis
from hlcs.rendering import Result


@dataclass(frozen=True, eq=False, repr=False)
class Reveal(Result):
    """The answer of `hlcs.reveal`.

    `plot` draws measured and modelled, and the residuals before and after; `save` writes text, numbers and picture.
    """

    name: str  # of the set, or its folder
    answer: dict  # as it was sealed: effects, parameters, text ..
    laws: dict  # {effect: its law in words}, of those that the catalogue has
    diagnosis: Diagnosis | None  # of the data with what is hidden, and what cannot be told from it, as candidates

    def to_dict(self):
        """What `hlcs mystery reveal --json` writes."""
        document = {"format": 1, "name": self.name, **self.answer, "laws": self.laws}
        if self.diagnosis:
            names = ("verdict", "effects", "parameters", "ambiguous", "error", "adequate")
            document["found"] = {key: getattr(self.diagnosis, key) for key in names}
        return document


def reveal(name, fit=True, workers=None, progress=False):
    """Tell what a mystery hides, and what its data give for it; returns a Reveal.

    name: a packaged set, or the folder of one that `hlcs mystery make` wrote; fit: fit what is hidden, and what cannot be told
    from it, to the data; workers: processes, for layer data; progress: print what is being tried. Raises InputError for a name
    that there is not.
    """
    answer, diagnosis = mystery_sets.answer(name), None
    catalogue = {facts.name for facts in whole_catalogue()}
    known = [effect for effect in (*answer["effects"], *answer["tied"]) if effect in catalogue]
    if fit:
        experiment = Experiment.read(mystery_sets.experiment(name))
        opened = experiment.opened(Options(workers=workers, progress=progress))
        diagnosis = replace(diagnosis_of(opened, known), experiment=experiment)  # of nothing hidden it is the model as it is
    laws = {effect: law_of(effect) for effect in answer["effects"] if effect in known}
    return Reveal(str(name), answer, laws, diagnosis)


def law_of(effect):
    """The law of an effect of the catalogue, in words and as its formula where it has one."""
    facts = named(effect)
    return f"{facts.law} {facts.formula}".strip()
