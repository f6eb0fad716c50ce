"""What `compare` and `diagnose` answer: frozen values that print, draw, save and speak JSON."""

from dataclasses import asdict, dataclass, field
from enum import Enum
from typing import Any, NamedTuple

from hlcs.data.frames import what_is
from hlcs.data.model_entries import found_entry, to_add
from hlcs.files.documents import plain
from hlcs.rendering import Pictures, Result, table_of
from minibullet.errors import InputError

VERDICTS = {
    "complete": "nothing is missing at this precision",
    "effect": "it is known what is missing",
    "ambiguous": "one of several is missing, and these data cannot tell which",
    "unexplained": "more is missing than the library knows",
    "cannot_judge": "the noise or the number of tests is unknown",
}


class Judgement(Result):
    """A result whose report opens in plain words."""

    def summary(self, details=False):
        """The printed report; details: with the statistics."""
        return self._renderer().text(self, details)


@dataclass(frozen=True, repr=False)
class Comparison(Judgement):
    """The answer of `hlcs.compare` for an experiment file: the model beside the measurement.

    `plot` draws residuals against time, height and speed (or the inputs of a table), and measured over model; `save` writes
    comparison.json, residuals.csv, comparison.txt and comparison.png."""

    kind: str
    title: str
    adequate: bool | None  # None where the noise is unknown
    statistic: float | None
    p: float | None
    error: dict  # rms, noise and bias in their unit
    where: tuple[dict, ...]  # where the model misses, the worst first
    noise: dict
    notes: tuple[str, ...] = ()
    table: Any = field(default=None, compare=False)  # one entry an observation: name -> array (n,)
    trials: tuple[str, ...] = ()
    channels: tuple[str, ...] = ()  # names of the channels that the table numbers
    against: tuple[str, ...] = ()  # columns of the table that residuals are drawn against
    impacts: tuple = ()  # of data.impacts.Impact: what the samples around each impact with the floor show
    at_impacts: dict = field(default_factory=dict)  # restitution and friction that the model has there, effects in it included
    advice: str = ""  # how to make the noise known, where it is not
    following: str = field(default="", compare=False)  # the command to type next, where the model misses
    before: "Comparison | None" = field(default=None, compare=False)  # of the model without what was added
    added: tuple[str, ...] = ()  # names of the effects that were added, () = there is no before
    replaced: tuple[str, ...] = ()  # those of them that stood there before, with other numbers
    noise_shown: dict | None = None  # as of Found
    starts_shown: dict | None = None  # as of Found

    def to_json(self):
        """The comparison as a dictionary of plain numbers and texts."""
        names = "kind title adequate p statistic error where noise noise_shown starts_shown notes added".split()
        impacts = [asdict(impact) for impact in self.impacts]
        before = self.before and {name: getattr(self.before, name) for name in ("adequate", "p", "statistic", "error")}
        return plain({"format": 1, **{name: getattr(self, name) for name in names}, "impacts": impacts, "before": before})

    @property
    def errors(self):
        """Rows {model, error, over_noise, bias, adequate}: before, after and noise; where nothing was added model and noise."""
        told = [("before", self.before), ("after", self)] if self.before else [("model", self)]
        rows = [
            {
                "model": name,
                "error": one.error["rms"],
                "over_noise": one.error["rms"] / one.error["noise"] if one.error["noise"] else None,
                "bias": one.error.get("bias"),
                "adequate": one.adequate,
            }
            for name, one in told
        ]
        return (*rows, {"model": "noise", "error": self.error["noise"], "over_noise": 1.0, "bias": None, "adequate": None})

    def to_dataframe(self, table="observations"):
        """A table of the comparison as a pandas frame.

        "observations": one row each with trial, channel, time, height, speed (or its inputs), measured, model, residual, sigmas;
        "errors": before, after and noise; "where": where the model misses; "impacts": what each impact with the floor shows."""
        others = {"errors": self.errors, "where": self.where, "impacts": [asdict(impact) for impact in self.impacts]}
        return self._observations() if table == "observations" else table_of({"observations": ()} | others, table)

    def _observations(self):
        import pandas as pd

        frame = pd.DataFrame(self.table or {})
        if "trial" in frame and self.trials:
            frame["trial"] = [self.trials[number] for number in frame["trial"]]
            frame["channel"] = [self.channels[number] for number in frame["channel"]]
        return frame


class Explanation(NamedTuple):
    """A reason, for decisions, and the sentence that gives it with its numbers, for reading only."""

    reason: Enum
    why: str


class Sentence(Enum):
    """Base of reasons: the value of a member is its sentence, with places for numbers and names."""

    def __call__(self, **words):
        """The Explanation with these numbers and names."""
        return Explanation(self, self.value.format(**words))


class Reason(Sentence):
    """What became of a candidate; "at" is its family, where the kind of measurement says so."""

    ACCEPTED = "accepted{at}: chi2 falls by {gain:.0f}{price}{held_out}{same}"
    IMPLIED = (
        "implied by the fluid, stated or air{at}: chi2 falls by {gain:.0f} alone, another effect would need {odds:.0f}{same}"
    )
    NOT_TOLD_APART = "does as well as {others}{at}: not to be told apart here{label}"
    OTHER_FORM = "of one set ({form}) with {better}, which explains the data better"
    SUSPECTED = "suspected: {why}"
    INVISIBLE = "cannot be seen in these data: what it does is absorbed by the unknown start or by what is in the model"
    NO_DRAG = "nothing for it to act on: the drag that it acts through is not in the model; add that first"
    EXPLAINED_TOO = "explains a part too{at}: {why}"
    BEYOND_ITS_LAW = "beyond what its law allows{at}: {why}"
    NOT_SEEN = "not seen{at}: {why}"
    NOT_TRIED = "not tried: {why}"
    NOT_JUDGED = "not judged: the noise is unknown"
    ON_FEWER_RECORDINGS = "on {count} recordings: {why}"


@dataclass(frozen=True)
class Finding:
    """What became of one candidate."""

    effect: str
    fitted: float | None  # error with it [unit of the error]
    held_out: float | None
    evidence: float | None  # fall of the cost: of -2 log of the posterior probability
    accepted: bool
    same_as: tuple[str, ...] = ()
    why: str = ""
    cosines: dict = field(default_factory=dict)
    visible_from: str = ""  # smallest value these data could have shown
    called: str = ""  # what it is in plain words
    lacking: bool = True  # is it a law that the model lacks? Else something else that the data show: a camera that leans
    remains: dict = field(default_factory=dict)  # what is left with it: effects, chi2_per_freedom, error, foreseen (not fitted)
    reason: Reason = field(kw_only=True)  # what `why` says in words; not in the result file


def untested(effect, explanation):
    """The Finding on a candidate without any numbers."""
    return Finding(effect, None, None, None, False, **explanation._asdict())


@dataclass(frozen=True)
class NextExperiment:
    """An experiment to do next."""

    text: str
    separates: tuple[str, ...]
    tests_needed: int | None
    design: dict = field(default_factory=dict)

    def __str__(self):
        return self.text


@dataclass(frozen=True, kw_only=True)
class Found:
    """What a search found, in any kind of measurement; fields as in the result file, plus `model`, the mended model."""

    effects: tuple[str, ...]
    parameters: dict  # effect -> name -> {value, low, high, unit}; 90 % intervals; stated: what the model has; usual: beyond that
    ambiguous: tuple[tuple[str, ...], ...]
    error: dict
    steps: tuple[dict, ...]
    adequate: dict
    candidates: tuple[Finding, ...]
    where: tuple[dict, ...]
    notes: tuple[str, ...] = ()
    sets: tuple[dict, ...] = ()  # of comparable weight, the heaviest first: effects, weight, chi2, held_out, parameters
    inclusion: dict = field(default_factory=dict)  # effect -> weight of all fitted sets that hold it
    explained: float | None = None  # share of the excess of chi2 over its expectation that the final model removes
    tolerance: dict | None = None  # what the user needs beside what is left: value, unit, left, met
    learned: Any = None  # learning.Learned: the law that explains what no effect does, if any
    absorbing: dict = field(default_factory=dict)  # parameters of what only absorbs, where nothing was found; not in the result
    reynolds: dict = field(default_factory=dict)  # law of drag -> least, most Reynolds number, holds, told (selection.reynolds)
    noise_shown: dict | None = None  # where the model would be adequate with the noise that the data show: sigma, known, unit ..
    starts_shown: dict | None = None  # where it would be with starts fitted, not stated: how far these differ, next ..
    model: Any = None
    pictures: Pictures | None = field(default=None, compare=False)


@dataclass(frozen=True, repr=False, kw_only=True)
class Diagnosis(Judgement, Found):
    """The answer of `hlcs.diagnose`; fields as in the result file, plus `model`, the mended model, ready to run.

    `plot` draws four panels: fit, residuals, ranking, the error falling to the noise floor; `save` writes result.json,
    candidates.csv, report.txt, report.html, its pictures and model.toml."""

    kind: str
    title: str
    verdict: str
    next_experiment: NextExperiment | None
    noise: dict = field(default_factory=dict)
    experiment: Any = field(default=None, compare=False)  # the Experiment that was diagnosed
    mended: Any = field(default=None, compare=False)  # the Experiment that it was applied to and saved as

    @property
    def entries(self):
        """What is to be added to [model] effects: name and numbers of each effect, "fill in" for a number that is withheld."""
        return tuple(found_entry(name, self.parameters.get(name, {})) for name in self.effects)

    @property
    def alternatives(self):
        """What could be added in place of `entries`, for each other set of effects that does as well: with its own numbers."""
        sets = [(other["effects"], other["parameters"]) for other in self.sets[1:]]
        known = self.parameters
        return tuple(tuple(found_entry(name, known.get(name, {}), own.get(name)) for name in names) for names, own in sets)

    @property
    def law(self):
        """The learned law, where it can be added: as an effect in a file, of which a command takes one; None where it cannot."""
        others = getattr(self.experiment, "user_effects", ())
        return self.learned if self.learned and self.learned.effect_file and not others else None

    @property
    def additions(self):
        """`entries`, or those of the learned law and of what it stands beside: its own numbers stand in its effect file."""
        return self.law.entries if self.law else self.entries

    @property
    def add(self):
        """What to write and to type next (`data.model_entries.to_add`); None where nothing was found to add."""
        return to_add(self.additions, self.parameters, self.effects, self.mended or self.experiment, self.law, bool(self.mended))

    def apply(self, experiment):
        """Another Experiment, with what was found added to its model; the first is unchanged.

        A number that was withheld stands in it as "fill in", and has to be replaced before it can be compared. The file of a
        learned law is written when it is saved. Where nothing was found it is the same Experiment. Raises InputError."""
        if not hasattr(experiment, "with_effects"):
            raise InputError(f"apply: got {what_is(experiment)}; give an hlcs.Experiment, such as diagnosis.experiment")
        own = self.experiment.user_effects if self.experiment else ()
        if law := self.law:
            return experiment.with_effects(self.additions, (*own, law.kind)).with_effects_text(law.file_name, law.effect_file)
        return experiment.with_effects(self.entries, own) if self.effects else experiment

    def to_json(self):
        """The result of `diagnose --json` as a dictionary of plain numbers and texts."""
        told = ("kind", "title", "verdict", "effects", "parameters", "ambiguous", "sets", "inclusion", "explained", "tolerance")
        names = (*told, "error", "steps", "adequate", "where", "noise", "noise_shown", "starts_shown", "reynolds")
        candidates = [{name: value for name, value in asdict(finding).items() if name != "reason"} for finding in self.candidates]
        others = {"next_experiment": self.next_experiment and asdict(self.next_experiment)}
        others |= {"add": self.add, "learned": self.learned and self.learned.to_json(), "candidates": candidates}
        return plain({"format": 1, **{name: getattr(self, name) for name in (*names, "notes")}, **others})

    def to_dataframe(self, table="candidates"):
        """A table of the diagnosis as a pandas frame.

        "candidates": one row each, best first; "numbers": of the effects, with their intervals; "steps": the error falling;
        "sets": fitted sets of comparable weight; "where": where the model still misses."""
        import pandas as pd

        if table == "candidates":
            names = ("effect", "accepted", "evidence", "fitted", "held_out", "same_as", "why")
            frame = pd.DataFrame([{name: getattr(finding, name) for name in names} for finding in self.candidates], columns=names)
            return frame.assign(same_as=frame["same_as"].map(", ".join))
        found = {name: getattr(self, name) for name in ("candidates", "steps", "sets", "where")}
        found["numbers"] = [{"effect": e, "number": name} | n for e, of in self.parameters.items() for name, n in of.items()]
        return table_of(found, table, {"parameters": "numbers", "effects": "numbers"})


@dataclass(frozen=True, repr=False)
class Plan(Result):
    """The answer of `hlcs plan`: what finds an effect of a stated size with a stated power."""

    effect: str
    at: dict  # number -> value
    power: float  # asked for
    what: str  # "recordings", or "rows" of a table
    noncentrality: float  # of the pilot: the expected fall of chi2
    now: dict  # recordings of the pilot, and their power
    needed: dict  # recordings (None: more than anybody makes), length_s, sigma, unit
    options: tuple[dict, ...]  # the same for other lengths and noise, with the power of as many as now
    look_alikes: tuple[dict, ...]  # effect, cosine, recordings that tell them apart (None: more than anybody makes)
    notes: tuple[str, ...] = ()

    def to_json(self):
        """The result of `plan --json` as a dictionary of plain numbers and texts."""
        return plain({"format": 1, **asdict(self)})

    def to_dataframe(self, table="options"):
        """A table of the plan as a pandas frame: "options", lengths and noise, or "look_alikes"."""
        return table_of({"options": self.options, "look_alikes": self.look_alikes}, table)
