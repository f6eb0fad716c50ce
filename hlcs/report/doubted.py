"""A statement of the file that is doubted: starts or a noise with which, were they others, nothing would be missing; in words."""

from typing import NamedTuple

from hlcs.data.experiment_file import Surroundings
from hlcs.data.notes import AsItIs
from hlcs.report.words import capital, joined, number, size, words

KNOWN_BY = {  # what a noise is called, by how it is known
    "stated": "The stated noise",
    "static recording": "The noise of the body at rest",
    "replicates": "The noise that repeats show",
}


AT_THE_EQUATOR, AT_THE_POLES = 9.780, 9.832  # normal gravity at sea level, World Geodetic System 1984 [m/s2]
ON_EARTH = 9.764, 9.834  # on the Huascaran and on the Arctic Ocean [m/s2] (C. Hirt et al., Geophys. Res. Lett. 40 (2013) 4279)
CLOSE = 0.006  # what data leave open [m/s2]


class Doubt(NamedTuple):
    """What is said of a statement that is doubted."""

    told: str  # sentences: what would be otherwise, by how much, what to do
    verdict: str  # what the verdict then means
    left: str  # what the model leaves, in a table
    noise: str  # beside what an effect is not proved


def doubt(result):
    """The Doubt of a Comparison or Diagnosis; None where no statement is doubted."""
    searched = hasattr(result, "effects")  # a Diagnosis, which adds what it found
    mended = searched and bool(result.effects)
    if result.starts_shown:
        return Doubt(
            starts_wrong(result.starts_shown, mended, searched),
            "the starts, as they are stated, do not agree with the data",
            "more, with these starts",
            "noise, with the starts as they are stated,",
        )
    if result.noise_shown:
        return Doubt(
            noise_too_small(result.noise_shown, mended),
            "more is left than the noise, as it was taken to be",
            "more than the noise taken",
            "the noise as it is stated",
        )
    return None


def starts_wrong(shown, mended, searched):
    """That the starts may not be as stated, by how much, and what to do; mended: if effects are added; searched: if any were
    looked for."""
    model, more = _agreeing(mended)
    other = "something is missing that none of the effects tried explains" if searched else "something is missing"
    differ = joined(_differing(name, **each) for name, each in shown["differ"].items())
    return (
        f"Either the starts that the file states are wrong: with starts fitted to the data in their place {model} agrees with "
        f"the data, and {more} need be missing. They differ from those stated by {differ}. So it is where a body was let go a "
        f"little before the first stamp. Or {other}. To know it, {shown['next']}."
    )


def as_it_is(diagnosis, told):
    """Sentences on what was found, and those on a setup, another than stated, with which the model as it is agrees with the data:
    the latter first where nothing explains them otherwise."""
    notes = AsItIs.among(diagnosis.notes)
    if not notes or diagnosis.verdict != "unexplained":
        return [*told, *(f"Or none of this: {note}." for note in notes)]
    first, *others = told
    return [*(f"{capital(note)}." for note in notes), f"If that is not so: {first[0].lower()}{first[1:]}", *others]


def other_gravity(diagnosis):
    """That another gravity than the stated one does what a wrong scale of length or a clock at a wrong rate would do alike:
    sentences; where that is the gravity of some place on Earth, or no set explains the data by plausible numbers."""
    around = _surroundings(diagnosis)
    if around is None:
        return []
    stated, falls = around.gravity, {"length_scale": 1, "time_scale": 2}  # g goes as its power
    alone = {its["effects"][0]: its["parameters"] for its in diagnosis.sets if len(its["effects"]) == 1}
    factors = {name: alone.get(name, {}).get(name, {}).get("factor") for name in falls}
    if None in factors.values():
        return []  # a length is known, nothing falls freely, or each session has a factor of its own
    needed = [stated * factors[name] ** power for name, power in falls.items()]
    on_earth = all(ON_EARTH[0] - CLOSE < each < ON_EARTH[1] + CLOSE for each in needed)
    beyond = {name for name, numbers in diagnosis.parameters.items() if any("beyond" in number for number in numbers.values())}
    doubtful = all(beyond.intersection(its["effects"]) for its in diagnosis.sets)
    if not (on_earth or doubtful) or abs(needed[0] / needed[1] - 1) > CLOSE / AT_THE_EQUATOR:
        return []  # the two need different ones where more than gravity acts
    told = f"A gravity of {needed[0]:.4g} m/s2 in place of {stated:g} does the same"
    if not on_earth:
        return [f"{told}: see to surroundings.gravity in the file, and to the unit of what is measured."]
    return [
        f"{told}: at sea level it is {AT_THE_EQUATOR:.3f} at the equator and {AT_THE_POLES:.3f} at the poles, less on mountains. "
        "State that of your place as surroundings.gravity."
    ]


def supposes_air(diagnosis):
    """Does the file of a Diagnosis state no fluid, and so mean air?"""
    around = _surroundings(diagnosis)
    return around is not None and not around.fluid_stated


def _surroundings(diagnosis):
    """The Surroundings that the file of a Diagnosis states; None where it knows none."""
    around = getattr(getattr(diagnosis.experiment, "file", None), "surroundings", None)
    return around if isinstance(around, Surroundings) else None


def _differing(name, least, most, unit):
    """How far what is stated of starts lies aside of what the data show."""
    least, most = (number(each, unit) for each in (least, most))
    return f"{least} to {most} ({words(name)})" if least != most else f"{most} ({words(name)})"


def _agreeing(mended):
    """Which model agrees with the data once a statement is mended, and what need then be missing."""
    return ("the model with what is told below", "nothing else") if mended else ("the model as it is", "nothing")


def noise_too_small(shown, mended):
    """That the noise may be larger than what was taken for it, by how much, and what to write; mended: if effects are added."""
    known, sigma = (
        f"{joined(size(each, shown['unit']) for each in shown[along].values())} along {joined(shown[along])}"
        if along in shown
        else size(shown[key], shown["unit"])
        for key, along in (("known", "known_along"), ("sigma", "along"))
    )
    whose, unlike = KNOWN_BY.get(shown["source"], "The noise"), "along" in shown and "known_along" not in shown
    wrong = "not be the same along all axes" if unlike else "be too small"
    model, more = _agreeing(mended)
    return (
        f"{whose} may {wrong}: it is {known}, and {shown['seen']} {sigma}, whatever the model. With a noise of {sigma} "
        f"{model} agrees with the data, and {more} need be missing. The line to write: {shown['remedy']}; then run it again."
    )
