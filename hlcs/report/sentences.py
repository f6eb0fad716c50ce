"""The first sentences of a report: what was found, what it removes, what is left; for a first-year student and an engineer."""

import math

from hlcs.data.notes import OutOfTime, Stopped
from hlcs.data.quantities import unit_of
from hlcs.records import Reason
from hlcs.report.alternatives import alternatives, crossed, crossing_told
from hlcs.report.document import Points
from hlcs.report.doubted import as_it_is, doubt, other_gravity, supposes_air
from hlcs.report.leftover import likeness, turns_missed
from hlcs.report.ranking import ranking
from hlcs.report.words import capital, joined, number, share, size, span, two_digits, value, words

NEAR_NOISE = 1.15  # times the noise up to which an error is called noise without more words
NOTHING_MORE = "Nothing more is missing."
LEFT_OUT = {"trajectory": "recordings", "outcomes": "rows", "layers": "layers"}  # what is held out, by the kind of measurement
STANDS = 1e-6  # speed of a body that stands, to rounding [m/s]
MANY = 8  # numbers of one effect, beyond which a sentence names two of them: the clocks of a class of thirty
SMALL = 0.02  # share of the error below which its fall is told by chi-square instead


def opening(diagnosis):
    """The first sentences of a Diagnosis: list of sentences and Points."""
    told = {
        "complete": _complete,
        "effect": _effect,
        "ambiguous": _ambiguous,
        "unexplained": _unexplained,
        "cannot_judge": _cannot_judge,
    }[diagnosis.verdict](diagnosis)
    stopped = ["Stopped by Ctrl-C before the search ended: what follows holds for the sets of effects that were fitted by then."]
    outside = reynolds_told(diagnosis, holds=False)
    told += [*_not_tried_for_time(diagnosis), *other_gravity(diagnosis), *outside]
    return [*stopped * bool(Stopped.among(diagnosis.notes)), *as_it_is(diagnosis, told), *_tolerance(diagnosis)]


def _not_tried_for_time(diagnosis):
    """That a model which explains the data may not be the only one, where time did not suffice to fit others: sentences."""
    if diagnosis.verdict == "unexplained" or not OutOfTime.among(diagnosis.notes):
        return []
    return ["Other sets of effects might do as well, and were not fitted, for time: see the notes on the data."]


# --- what an effect is called -----------------------------------------------------------------------------------------------


def called(diagnosis, name):
    """An effect in plain words; its name where no candidate tells."""
    return next((entry.called for entry in diagnosis.candidates if entry.effect == name and entry.called), words(name))


def effect_sentence(diagnosis, name):
    """What was found of one effect, with its numbers: "Air resistance is missing (quadratic drag, drag coefficient ..)." """
    numbers = diagnosis.parameters.get(name, {})
    stated = {key: entry for key, entry in numbers.items() if entry.get("stated") is not None and entry["value"] is not None}
    if off := {key: entry for key, entry in stated.items() if not entry["low"] <= entry["stated"] <= entry["high"]} or stated:
        told = joined(f"{words(key)} {value(entry)}, not {entry['stated']:g}" for key, entry in off.items())
        alone = told.removeprefix("coefficient ") if len(off) == 1 else told
        sentence = f"{capital(called(diagnosis, name))} is {'not as stated: ' if alone == told else ''}{alone}."
    elif _finding(diagnosis, name, "reason", None) is Reason.IMPLIED:
        source = "the air that a file means which states no fluid" if supposes_air(diagnosis) else "what the file states"
        sentence = f"{capital(called(diagnosis, name))} follows from {source} ({_numbers(name, numbers)}); "
        sentence += "by itself it would not be proved here."
    elif _finding(diagnosis, name, "lacking", True):
        sentence = f"{capital(called(diagnosis, name))} is missing ({_numbers(name, numbers)})."
    else:
        sentence = f"The data show {called(diagnosis, name)} ({_numbers(name, numbers)})."
    return " ".join([sentence, *_beyond(numbers)])


def _finding(diagnosis, name, what, otherwise):
    """What a Finding says of one effect, by the name of its field; `otherwise` where there is none."""
    return next((getattr(entry, what) for entry in diagnosis.candidates if entry.effect == name), otherwise)


def _numbers(name, numbers):
    """The name of an effect and its numbers; what only says that it is there is no number, nor is what the data do not show."""
    known = {key: entry for key, entry in numbers.items() if key != "switch" and "left_out" not in entry}
    told = [f"{words(key)} {value(entry)}" for key, entry in known.items()]
    more = [f"and {len(told) - 2} more, listed below"] if len(told) > MANY else []
    return ", ".join([words(name), *(told[:2] if more else told), *more])


def _beyond(numbers):
    """A sentence for each number that is beyond what is usual."""
    return [
        f"The {words(key)} of {entry['beyond']}: check the inputs that it rests on"
        + (f" ({entry['rests_on']})." if entry.get("rests_on") else ".")
        for key, entry in numbers.items()
        if "beyond" in entry
    ]


def reynolds_told(diagnosis, holds):
    """Sentences on the Reynolds numbers of the laws of drag that hold there, or of those that do not or are not known to."""
    told = {name: each["told"] for name, each in diagnosis.reynolds.items() if bool(each["holds"] or each.get("area")) == holds}
    return [f"{capital(words(name))}: {sentence[:1].lower()}{sentence[1:]}" for name, sentence in told.items()]


# --- what it removes, what is left ------------------------------------------------------------------------------------------


def error_of(diagnosis):
    """The error that counts: on recordings that the numbers were not fitted to, where there are any."""
    return diagnosis.error.get("held_out") or diagnosis.error.get("fitted")


def removal(diagnosis, subject):
    """How far the error falls, in a sentence; subject: what makes it fall."""
    error, unit = error_of(diagnosis), diagnosis.error.get("unit", "")
    if not error:  # a kind of measurement may have none
        return ""
    before, after = error["before"], _afters(diagnosis, "held_out" if diagnosis.error.get("held_out") else "fitted")
    plural = subject.endswith("they")
    whose = "their" if plural else "its"
    left_out = LEFT_OUT.get(diagnosis.kind, "data")
    where = f", on {left_out} that {whose} numbers were not fitted to" if diagnosis.error.get("held_out") else ""
    if no_fall := _no_fall(diagnosis, error):
        return f"{no_fall}."
    part = span([share(max(1 - each / before, 0.0)) for each in (max(after), min(after))])
    sizes = span([size(each, unit) for each in (min(after), max(after))])
    return f"{subject} remove{'' if plural else 's'} {part} of the error: {size(before, unit)} before, {sizes} after{where}."


def _afters(diagnosis, which):
    """The errors that are left, "fitted" or "held_out": of each set that does as well, or of the first where that is all that is
    known."""
    first = [diagnosis.error[which]["after"]]
    if diagnosis.verdict != "ambiguous":
        return first
    rows = {frozenset(row["effects"]): row["error"] for row in ranking(diagnosis)}
    told = [entry["held_out"] if which == "held_out" else rows.get(frozenset(entry["effects"])) for entry in diagnosis.sets]
    return first if None in told else first + told[1:]


def _no_fall(diagnosis, error):
    """That an error stays or rises, and what falls in its place, as the begin of a sentence; "" of an error that falls."""
    before, after, unit = error["before"], error["after"], diagnosis.error.get("unit", "")
    if before and 1 - after / before >= SMALL:
        return ""
    stays = f"stays near {size(after, unit)}"
    if before and after / before - 1 >= SMALL:
        stays = f"does not fall ({size(before, unit)} before, {size(after, unit)} after)"
    chi2 = diagnosis.adequate.get("chi2_per_freedom") or {}
    fall = f", from {chi2['before']:.3g} to {chi2['after']:.3g} times what noise leaves" if chi2.get("after") else ""
    return f"The {_measure(diagnosis)} {stays}; what falls is the square of the misfit{fall}"


def _measure(diagnosis):
    """The error in words."""
    return "mean relative error" if diagnosis.error.get("measure") == "mean relative error" else "error (root mean square)"


def _noise(diagnosis):
    """What an adequate model leaves is noise, in a sentence: on the data themselves, on which it is judged."""
    error, unit = diagnosis.error.get("fitted") or error_of(diagnosis), diagnosis.error.get("unit", "")
    if not error:
        return "What is left is noise."
    left = left_by_adequate(diagnosis, error["after"], error["noise"], unit)
    if not foretold_worse(diagnosis):
        return f"What is left {left}."
    many = LEFT_OUT.get(diagnosis.kind, "data")
    after = _afters(diagnosis, "fitted")
    sizes = span([size(each, unit) for each in (min(after), max(after))])
    return (
        f"On the {many} themselves {sizes} are left, which {left}. That the error is larger on {many} that "
        f"were left out says that these are foretold from the others with less certainty: more or other {many} tell the numbers "
        "better."
    )


def foretold_worse(diagnosis):
    """Is the error on data that the numbers were not fitted to larger than on the fitted ones by more than noise allows?"""
    fitted, held_out = diagnosis.error.get("fitted"), diagnosis.error.get("held_out")
    if not fitted or not held_out:
        return False
    return held_out["after"] > NEAR_NOISE * max(fitted["after"], fitted["noise"])


def left_by_adequate(result, after, noise, unit):
    """What an adequate model leaves, as the end of a sentence; result: Comparison or Diagnosis; after, noise: in their unit."""
    told, kind = size(noise, unit), result.kind
    if scatter := result.noise.get("between_settings"):
        cannot = "if they cannot, something is missing (measurement.input_sd says how far off inputs may be)"
        return f"is your noise ({told}) if settings can be {size(scatter, unit)} off, more than repeats show; {cannot}"
    if after <= NEAR_NOISE * noise:
        return f"is your noise ({told})"
    if kind == "layers":
        return f"is no more than the noise ({told}) and what campaigns and engines differ by make together"
    return f"cannot be told from your noise ({told})"


def beyond_noise(diagnosis):
    """The part of the error after, in its unit, that the noise does not account for; None where the noise is as large.

    Of the fitted data where others are foretold worse: what numbers that are known badly miss there is no missing effect.
    """
    error = diagnosis.error["fitted"] if foretold_worse(diagnosis) else error_of(diagnosis)
    excess = error["after"] ** 2 - error["noise"] ** 2
    return math.sqrt(excess) if excess > 0 else None


def looks(diagnosis):
    """What is left looks like, and where it is largest: sentences."""
    told = []
    if diagnosis.learned is not None:
        beside = {entry["name"] for entry in diagnosis.learned.beside}
        rest = beside.issuperset(diagnosis.effects) or not diagnosis.learned.fit
        said = "What is left follows a law of its own" if rest else "In place of what was found one law explains more"
        told.append(f"{said}: {diagnosis.learned.text}.")
    elif diagnosis.pictures:
        shown = diagnosis.pictures
        told.append(f"What is left: {likeness(shown.after, shown.channels, shown.units, shown.trials)}.")
    if diagnosis.where:
        what = "It is" if diagnosis.learned is None else "Without that law what is left is"
        told.append(f"{what} largest in {place(diagnosis.where[0], diagnosis.error.get('unit', ''))}.")
    return told


def place(row, unit):
    """A row of `where` as words, with its size."""
    channel = f", {row['channel']}" if row.get("channel") and row.get("time") is not None else ""
    phase = f", {row['phase']}" if row.get("phase") not in (None, "table", "flight") else ""
    told = f"{row['trial']}{channel}{phase}: {size(row['rms'], unit_of(row.get('channel'), unit))}"
    told += f", {two_digits(abs(row['sigma']))} times the noise"
    if (time := row.get("time")) is not None:
        height = [] if row["height"] is None else [f"{row['height']:.3g} m high"]
        speed = [] if row["speed"] is None else [f"{row['speed'] if row['speed'] > STANDS else 0.0:.3g} m/s"]
        told += f" (most at {', '.join([f'{time:.3g} s', *height, *speed])})"
    return told


# --- one opening for each verdict -------------------------------------------------------------------------------------------


def _complete(diagnosis):
    error, unit = error_of(diagnosis), diagnosis.error.get("unit", "")
    told = ["Nothing is missing at the precision of these data."]
    if error and error["noise"]:
        told.append(f"The model misses by {size(error['after'], unit)}. {_noise(diagnosis)}")
    if any(entry.visible_from for entry in diagnosis.candidates):
        told.append("An effect that is too small for these data may still be there; how large it would have to be is told below.")
    return [" ".join(told)]


def _effect(diagnosis):
    found = {name: effect_sentence(diagnosis, name) for name in diagnosis.effects}
    implied = [found[name] for name in found if _finding(diagnosis, name, "reason", None) is Reason.IMPLIED]
    own = [sentence for sentence in found.values() if sentence not in implied] or implied
    lead = f"{_count(len(own))} things are missing or wrong, what the data need most first:"
    told = own if len(own) == 1 else [lead, Points(tuple(own))]
    told = [*told, *(sentence for sentence in implied if own is not implied)]
    told.append(f"{removal(diagnosis, 'It' if len(found) == 1 else 'Together they')} {_noise(diagnosis)}".strip())
    return [*told, *_turns(diagnosis), *_not_sure(diagnosis)]


def _turns(diagnosis):
    """What is missed of rotations, which stand in no error of a length."""
    turns, noise = turns_missed(diagnosis.pictures), diagnosis.noise.get("orientation")
    if not turns or not noise:
        return []
    before, after, noise = (number(each, "rad") for each in (*turns, noise))
    way = f"goes from {before} to {after}" if before != after else f"stays at {after}"
    return [f"That is the error of the positions; that of the rotations {way} (noise {noise})."]


def _count(things):
    return {2: "Two", 3: "Three", 4: "Four"}.get(things, str(things))


def _not_sure(diagnosis):
    """Effects without which another set does nearly as well."""
    smaller = [set(entry["effects"]) for entry in diagnosis.sets[1:] if set(entry["effects"]) < set(diagnosis.effects)]
    doubtful = [name for name in diagnosis.effects if any(name not in members for members in smaller)]
    return [f"Less sure is {words(name)}: the data are described nearly as well without it." for name in doubtful]


def _ambiguous(diagnosis):
    choices, common = alternatives(diagnosis)
    told = [effect_sentence(diagnosis, name) for name in common]
    which, others = ("Beside that, each" if common else "Each"), "the others" if len(choices) > 2 else "the other"
    told.append(f"{which} of these explains the data as well as {others}, and these data cannot tell which it is:")
    together = crossed(choices)
    if len(together) < len(choices) and any(len(choice) > 1 for choice in choices):
        names = dict.fromkeys(name for choice in choices for name in choice)
        told += [Points(tuple(crossing_told(those) if those else NOTHING_MORE for those in together)), "What each of them says:"]
        told.append(Points(tuple(effect_sentence(diagnosis, name) for name in names)))
    else:
        said = (" ".join(effect_sentence(diagnosis, name) for name in choice) or NOTHING_MORE for choice in choices)
        told.append(Points(tuple(said)))
    count = len(_afters(diagnosis, "held_out" if diagnosis.error.get("held_out") else "fitted"))
    subject = ("Each of them" if count == len(choices) else "The first of them") + ", with what stands above," * bool(common)
    return [*told, f"{removal(diagnosis, subject)} {_noise(diagnosis)}".strip(), *_turns(diagnosis)]


def _unexplained(diagnosis):
    error, unit = error_of(diagnosis), diagnosis.error.get("unit", "")
    told = []
    if doubted := doubt(diagnosis):  # what the file states decides before any effect does
        mends = "It" if len(diagnosis.effects) == 1 else "Together they"
        return [doubted.told, *([_helps(diagnosis), removal(diagnosis, mends)] if diagnosis.effects else [])]
    if not error:
        return [f"The model fails, and {_nothing(diagnosis)} explains all of it."]
    if diagnosis.effects:
        told += [_helps(diagnosis), _left_unexplained(diagnosis), *_turns(diagnosis)]
    else:
        told.append(
            f"Something is missing that {_nothing(diagnosis)} explains. The model misses by "
            f"{size(error['before'], unit)}, and the noise is {size(error['noise'], unit)}."
        )
        told += _absorbing(diagnosis) or _nearest(diagnosis)
    told.append(" ".join(looks(diagnosis)))
    return told


def _nothing(diagnosis):
    """What it is that does not explain: what was tried, or where a search was stopped what it had come to."""
    return "nothing that was fitted by then" if Stopped.among(diagnosis.notes) else "none of the effects tried"


def _helps(diagnosis):
    """What explains a part, with its share and its numbers."""
    names = diagnosis.effects
    what = capital(joined(called(diagnosis, name) for name in names))
    verb = "explains" if len(names) == 1 else "explain"
    numbers = "; ".join(_numbers(name, diagnosis.parameters.get(name, {})) for name in names)
    part = f" {share(diagnosis.explained)} of" if diagnosis.explained is not None else " a part of"
    instead = "".join(
        f" In place of {words(members[0])} {joined(map(words, members[1:]), 'or')} would do as well."
        for members in diagnosis.ambiguous
    )
    beyond = [sentence for name in names for sentence in _beyond(diagnosis.parameters.get(name, {}))]
    sentence = f"{what} {verb}{part} the misfit beyond the noise ({numbers})."
    return " ".join([sentence, *beyond]) + instead


def _left_unexplained(diagnosis):
    """The error that is left, and that nothing explains it."""
    error, unit, left = error_of(diagnosis), diagnosis.error.get("unit", ""), beyond_noise(diagnosis)
    worse, many, where = foretold_worse(diagnosis), LEFT_OUT.get(diagnosis.kind, "data"), ""
    told = diagnosis.error["fitted"] if worse else error
    fall = f"he error falls from {size(told['before'], unit)} to {size(told['after'], unit)}"
    if no_fall := _no_fall(diagnosis, told):
        fall = no_fall[1:]
    if worse:
        where = f", on {many} that the numbers were not fitted to {size(error['after'], unit)} are left"
    fall = f"{f'On the {many} themselves t' if worse else 'T'}{fall}{where}; the noise is {size(error['noise'], unit)}. "
    if left is None:
        what = "That is no more than the noise, but it has a pattern that noise has not, and"
        return f"{fall}{what} {_nothing(diagnosis)} explains it."
    return fall + f"Beyond the noise {size(left, unit)} are left that {_nothing(diagnosis)} explains."


def _absorbing(diagnosis):
    """What takes a part away on data that it was not fitted to, where that is too little to be named."""
    if not diagnosis.absorbing:
        return []
    what = joined(called(diagnosis, name) for name in diagnosis.absorbing)
    numbers = "; ".join(_numbers(name, its) for name, its in diagnosis.absorbing.items())
    many = LEFT_OUT.get(diagnosis.kind, "data")
    return [
        f"{capital(what)} would take less than half of it away, on {many} that no number was fitted to as well ({numbers}): "
        "too little to be told from what absorbs the work of something else."
    ]


def _nearest(diagnosis):
    """The candidate that leaves least, where it leaves much less than the model as it is."""
    start = (diagnosis.adequate.get("chi2_per_freedom") or {}).get("before")
    fitted = [entry for entry in diagnosis.candidates if entry.remains and not entry.remains["foreseen"]]
    best = min(fitted, key=lambda entry: entry.remains["chi2_per_freedom"], default=None)
    if not start or best is None or best.remains["chi2_per_freedom"] > 0.8 * start:
        return []
    part, name = 1 - best.remains["chi2_per_freedom"] / start, words(best.effect)
    what = name if best.called in ("", name) else f"{best.called} ({name})"
    told = f"Nearest comes {what}, which would take away {share(part)} of the square of the misfit"
    if best.reason is Reason.SUSPECTED:
        left_out = LEFT_OUT.get(diagnosis.kind, "data")
        return [f"{told}, but the error does not fall as it should on {left_out} that its numbers were not fitted to."]
    return [f"{told}; {best.why.partition(': ')[2] or best.why}."]


def _cannot_judge(diagnosis):
    advice = diagnosis.next_experiment.text if diagnosis.next_experiment else ""
    told = ["The noise of the measurement is unknown, so nobody can say whether the model misses anything."]
    return [*told, *([f"To know it: {advice}."] if advice else [])]


def _tolerance(diagnosis):
    if not diagnosis.tolerance:
        return []
    unit, met = diagnosis.tolerance["unit"], "met" if diagnosis.tolerance["met"] else "not met"
    left, wanted = (size(diagnosis.tolerance[name], unit) for name in ("left", "value"))
    return [f"Your tolerance of {wanted} is {met}: {left} are left beyond the noise."]
