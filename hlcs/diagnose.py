"""Diagnose: which effect is missing from the model."""

from dataclasses import fields

from hlcs.effects import own_classes
from hlcs.kinds import open_experiment
from hlcs.kinds.protocol import Experiment, Options
from hlcs.records import Diagnosis, NextExperiment, untested
from hlcs.selection.verdict import Selection

OWN = ("left_out", "next_experiment")  # of a Selection: what a Diagnosis has not


def diagnose(path, candidates=None, effects_file=None, seed=0, workers=None, progress=False, effects=None, allow_outside=False):
    """Find what is missing from the model of an experiment file; returns a Diagnosis.

    path: experiment file; candidates: names to try (None = the file's list, or all that fit); effects_file: Python file with
    effects of your own, run as code; effects: the same as classes or values; seed, workers: for layer data (paired simulations);
    progress: print what is being tried; allow_outside: let the experiment file name files outside its own folder. Raises
    InputError where the input is at fault.
    """
    options = Options(own_classes(effects, effects_file), seed, workers, progress, _logger(progress))
    file, experiment = open_experiment(path, options, allow_outside)
    return diagnosis_of(experiment, file.candidates if candidates is None else candidates)


def diagnosis_of(experiment: Experiment, candidates=None):
    """The Diagnosis of an Experiment; candidates: names to try, None = all that fit."""
    common = {"kind": experiment.kind, "title": experiment.title, "noise": experiment.noise}
    if experiment.judgeable:
        selection = experiment.search(candidates)
        told = {entry.name: getattr(selection, entry.name) for entry in fields(Selection) if entry.name not in OWN}
        open_question = selection.verdict in ("ambiguous", "unexplained")
        following = selection.next_experiment(selection.verdict) if open_question else None
        return Diagnosis(**common, **told, verdict=selection.verdict, next_experiment=following)
    names = experiment.names(candidates)
    return Diagnosis(
        **common,
        verdict="cannot_judge",
        effects=(),
        parameters={},
        ambiguous=(),
        error={"measure": experiment.measure, "unit": experiment.unit, "fitted": None, "held_out": None},
        steps=(),
        adequate={"before": None, "after": None, "statistic": None, "p": None},
        candidates=tuple(untested(name, experiment.unjudged) for name in names),
        where=(),
        next_experiment=NextExperiment(experiment.advice, (), None, {}),
        notes=experiment.notes,
    )


def _logger(progress):
    """A function that shows what is being tried: on a terminal in one line, otherwise nothing."""
    if not progress:
        return lambda text: None
    from tqdm import tqdm

    bar = tqdm(bar_format="{desc} {elapsed}", leave=False, disable=None)

    def log(text):
        bar.set_description_str(text)
        bar.refresh()

    return log
