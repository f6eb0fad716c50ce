"""Diagnose: which effect is missing from the model."""

from collections.abc import Iterable
from dataclasses import fields, replace

from hlcs.effects import own_classes
from hlcs.kinds.experiment import Experiment
from hlcs.kinds.protocol import OpenExperiment, Options
from hlcs.records import Diagnosis, Found, NextExperiment, untested
from minibullet.errors import InputError, shown_value


def diagnose(
    experiment, candidates=None, effects_file=None, seed=0, workers=None, progress=False, effects=None, allow_outside=False
):
    """Find what is missing from the model of an experiment; returns a Diagnosis.

    experiment: an Experiment, or the path of an experiment file; candidates: a name or names to try (None = the file's list, or
    all that fit); effects_file: Python file with effects of your own, run as code; effects: the same as classes or values; seed,
    workers: for layer data (paired simulations); progress: print what is being tried; allow_outside: let the experiment file name
    files outside its own folder. Raises InputError where the input is at fault.
    """
    experiment = Experiment.read(experiment, allow_outside, effects_file).with_user_effects(own_classes(effects))
    opened = experiment.opened(Options(experiment.user_effects, seed, workers, progress, _logger(progress)))
    names = experiment.file.candidates if candidates is None else _names(candidates)
    found = diagnosis_of(opened, names)
    return replace(found, experiment=experiment)


def _names(candidates):
    """A name or names of candidates as a list; InputError where there is none."""
    names = [candidates] if isinstance(candidates, str) else list(candidates) if isinstance(candidates, Iterable) else []
    if not names or not all(isinstance(name, str) for name in names):
        told = "give a name or a list of names of effects, or leave it out for all that fit"
        raise InputError(f"candidates: got {shown_value(candidates)}; {told}")
    return names


def diagnosis_of(experiment: OpenExperiment, candidates=None):
    """The Diagnosis of an OpenExperiment; candidates: names to try, None = all that fit."""
    common = {"kind": experiment.kind, "title": experiment.title}
    if experiment.judgeable:
        selection = experiment.search(candidates)
        told = {entry.name: getattr(selection, entry.name) for entry in fields(Found)}
        if doubted := selection.starts_shown or selection.noise_shown:
            following = NextExperiment(doubted["next"], (), None)
        else:
            following = selection.next_experiment(selection.verdict)
        # the noise after the search: what settings scatter by is known beside what was found
        return Diagnosis(**common, **told, noise=experiment.noise, verdict=selection.verdict, next_experiment=following)
    names = experiment.names(candidates)
    return Diagnosis(
        **common,
        noise=experiment.noise,
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
