"""How a Diagnosis is shown: printed, in a notebook, drawn, written into a folder."""

import json
import shlex
from dataclasses import replace
from pathlib import Path

from hlcs.data.effects_of_model import OF_EFFECTS
from hlcs.data.model_entries import FILL_IN, MODEL
from hlcs.data.notes import AsItIs, Stopped
from hlcs.files import folders
from hlcs.files.documents import toml_value
from hlcs.files.spreadsheets import csv_text
from hlcs.records import Reason
from hlcs.report import page, statistics
from hlcs.report.diagnosis_figures import diagnosis_panels, pictures
from hlcs.report.document import Lines, Points, Section, Table, as_text
from hlcs.report.doubted import doubt
from hlcs.report.learned import numbers_of
from hlcs.report.leftover import camera_swings
from hlcs.report.notes import note_parts
from hlcs.report.ranking import LITTLE, left_by_base, ranking
from hlcs.report.sentences import error_of, opening, place, reynolds_told
from hlcs.report.words import capital, interval, joined, size, value, words

NOT_PROVED = {
    "ambiguous": "{what} can be added, and {is_} not proved: others do as well.",
    "unexplained": "{what} can be added, and {is_} not proved: {it_helps}, and more than {noise} remains.",
    "learned": "{what} can be added, and {is_} not proved: what is read off these data, other data must show.",
}
OWN_UNITS = {  # of effects, that are no units of every day
    "L": "L: edge of the cube that has the volume of the body.",
    "weights": "weights: of the body, the lighter one of two.",
    "Dn": "Dn: nominal diameter.",
}
AS_LITTLE = 1.02  # times what was found leaves, up to which a candidate is said to leave as little
SOME_WEIGHT = 0.01  # of all fitted sets, from which a set with a candidate counts as one that might have been found
MOST_INSTEAD = 4  # sets that do as well, of which the lines to write are told
MOST_ROWS = 12  # of the ranking, before the details
OTHERS = {  # why not the others, where one sentence does for all of them
    Reason.OTHER_FORM: "much the same as a part of what was found; more is left, or it is less probable beforehand",
    Reason.EXPLAINED_TOO: "a part is explained, not as well as by what was found (what is left with each stands above, or among "
    "the details)",
    Reason.NOT_SEEN: "not seen: what is explained is less than chance explains with as many numbers more",
    Reason.SUSPECTED: "the misfit would fall, but not enough on data that the numbers were not fitted to",
    Reason.INVISIBLE: "cannot be seen in these data: nothing here depends on it, or unknown starts or what is in the model take "
    "it up",
    Reason.NO_DRAG: Reason.NO_DRAG.value,
    Reason.ON_FEWER_RECORDINGS: "tried on fewer recordings, to keep within the limit of time, and not kept",
}


def text(diagnosis, details=False):
    """The printed report of a Diagnosis; details: with the statistics."""
    known = [*sections(diagnosis), *(statistics.sections(diagnosis) if details else [])]
    more = () if details else (Section("", ("The statistics behind this: --details, or summary(details=True).",)),)
    return as_text(headline(diagnosis), [*known, *more])


def line(diagnosis):
    """Title, verdict, effects and the error in a line."""
    error, unit = error_of(diagnosis), diagnosis.error.get("unit") or ""
    told = f": {joined(diagnosis.effects)}" if diagnosis.effects else ""
    if error:
        fall = f"error {size(error['before'], unit)}"
        fall += f" -> {size(error['after'], unit)}" if diagnosis.effects else ""
        told += f"; {fall}, noise {size(error['noise'], unit)}"
    return headline(diagnosis) + told


def headline(diagnosis):
    """Title, kind and verdict in a line; of a search that was stopped that it was."""
    stopped = " (stopped by Ctrl-C before the search ended)" * bool(Stopped.among(diagnosis.notes))
    return f"{diagnosis.title} ({diagnosis.kind}): {diagnosis.verdict}{stopped}"


def sections(diagnosis):
    """The report in plain words: what was found, its numbers, what remains, why not the others, how to go on."""
    found = [
        Section("", tuple(opening(diagnosis)), "opening"),
        Section("The numbers", _numbers(diagnosis), "numbers"),
        Section("The law that was learned", numbers_of(diagnosis.learned) if diagnosis.learned else (), "law"),
        Section("What remains", statistics.ranking_parts(diagnosis, MOST_ROWS), "ranking"),
        Section("Why not the others", _others(diagnosis), "others"),
        Section("The smallest effects that these data would have shown", _visible(diagnosis), "visible"),
        Section("Where the model still misses", _where(diagnosis), "where"),
        Section("How to go on", _next(diagnosis), "next"),
        Section("Notes on the data", note_parts([note for note in diagnosis.notes if not isinstance(note, AsItIs)]), "notes"),
    ]
    return [section for section in found if section.parts]


# --- the parts --------------------------------------------------------------------------------------------------------------


def _numbers(diagnosis):
    """The numbers of every effect of the sets that do as well."""
    rows, why = [], []
    for effect, numbers in diagnosis.parameters.items():
        for name, entry in numbers.items():
            if name == "switch":
                continue
            if "left_out" in entry:
                why.append(f"{effect} {name} is not told: {entry['why']}.")
                continue
            unit = "" if entry["unit"] in ("1", "-") else entry["unit"]
            here = value({**entry, "unit": "1"})
            rows.append((effect, name, here, "" if entry["value"] is None else interval(entry), unit))
            if entry["value"] is None:
                why.append(f"{effect} {name} withheld: {entry['why']}")
    if not rows:
        return ()
    why += reynolds_told(diagnosis, holds=True)
    units = {row[-1] for row in rows}
    note = " ".join(told for unit, told in OWN_UNITS.items() if unit in units)
    return (Table(("effect", "number", "value", "90 % interval", "unit"), tuple(rows), texts=2, note=note), *why)


def _others(diagnosis):
    """Why the other candidates were not taken, those of one reason together."""
    together, alone, untried = {}, [], {}
    start = left_by_base(ranking(diagnosis))
    for finding in diagnosis.candidates:
        if finding.accepted or finding.reason in (Reason.NOT_TOLD_APART, Reason.NOT_JUDGED):
            continue
        if finding.reason is Reason.NOT_TRIED:
            untried.setdefault(finding.why.removeprefix(Reason.NOT_TRIED(why="").why), []).append(finding.effect)
        elif finding.reason in OTHERS:
            together.setdefault(_what(diagnosis, finding, start), []).append(finding.effect)
        else:
            alone.append(f"{finding.effect}: {finding.why}")
    told = [f"{', '.join(names)}: {why}." for why, names in together.items()]
    told += [f"not tried, {why}: {', '.join(names)}" for why, names in sorted(untried.items())]
    return (Points((*alone, *told)),) if alone or told else ()


def _what(diagnosis, finding, start):
    """What is said of a candidate and of all others like it; start: what the model as it is leaves."""
    if finding.reason not in (Reason.EXPLAINED_TOO, Reason.SUSPECTED):
        return OTHERS[finding.reason]
    part = 1 - finding.remains["chi2_per_freedom"] / start if finding.remains and start else 1.0
    if part < LITTLE:
        return f"less than {100 * LITTLE:.0f} % of the misfit is explained"
    if finding.reason is Reason.SUSPECTED and (not diagnosis.effects or _as_little(diagnosis, finding)):
        return OTHERS[Reason.SUSPECTED]
    if not diagnosis.effects:
        return "a part is explained, and more than noise is left (how much stands above)"
    return _as_good(diagnosis, finding) or OTHERS[Reason.EXPLAINED_TOO]


def _as_little(diagnosis, finding):
    """Does a candidate leave as little as what was found?"""
    named = [set(entry["effects"]) for entry in diagnosis.sets] or [set(diagnosis.effects)]
    found = max((row["chi2_per_freedom"] for row in ranking(diagnosis) if set(row["effects"]) in named), default=None)
    return bool(found and finding.remains and finding.remains["chi2_per_freedom"] <= AS_LITTLE * found)


def _as_good(diagnosis, finding):
    """What is said of a candidate that leaves as little as what was found, alone or beside others; "" where it leaves more."""
    if _as_little(diagnosis, finding):
        foreseen = "is foreseen to be" if finding.remains["foreseen"] else "is"
        of_found = [entry.remains["numbers"] for entry in diagnosis.candidates if entry.accepted and "numbers" in entry.remains]
        more = of_found and finding.remains.get("numbers", 0) > max(of_found)
        needed = "more numbers are needed" if more else "less usual numbers are needed"
        return f"what is left {foreseen} as little as with what was found, but {needed}"
    after = (diagnosis.error.get("fitted") or {}).get("after")
    beside = diagnosis.inclusion.get(finding.effect, 0.0) >= SOME_WEIGHT
    if beside and after and finding.fitted is not None and finding.fitted <= AS_LITTLE * after:
        return (
            "beside others, as little is left as with what was found; such a set is less probable, or holds less well on data "
            "that its numbers were not fitted to"
        )
    return ""


def _visible(diagnosis):
    """The smallest effects that would have been found, where nothing was."""
    found = [entry for entry in diagnosis.candidates if entry.visible_from and not entry.accepted]
    if diagnosis.verdict != "complete" or not found:
        return ()
    rows = tuple((entry.effect, entry.called, entry.visible_from) for entry in found)
    return (Table(("effect", "in plain words", "seen nine times in ten from"), rows, texts=3),)


def _where(diagnosis, most=5):
    """Where the model still misses, if it does."""
    if diagnosis.verdict != "unexplained" or doubt(diagnosis) or not diagnosis.where:
        return ()
    return (Points(tuple(place(row, diagnosis.error.get("unit", "")) for row in diagnosis.where[:most])),)


def _next(diagnosis):
    """The next experiment; what to write, what to type."""
    parts = []
    if diagnosis.next_experiment is not None and diagnosis.verdict != "cannot_judge":
        parts.append(f"Next experiment: {diagnosis.next_experiment.text}.")
    swings = diagnosis.verdict == "unexplained" and diagnosis.pictures
    if swings and (often := camera_swings(diagnosis.pictures.after, diagnosis.pictures.channels)):
        parts.append(
            f"What swings {often:.2g} times a second may be the camera: keep a mark that stands still in the view. If the mark "
            "swings as well, the camera shakes; if it does not, it is the motion."
        )
    return (*parts, *_add(diagnosis))


def _add(diagnosis):
    """The line for [model], the file to put it in, the command to type next."""
    add, experiment = diagnosis.add, diagnosis.experiment
    if add is None:
        return ()
    parts = [_not_proved(diagnosis)] if diagnosis.verdict in NOT_PROVED else []
    if diagnosis.mended:
        parts += [f"Written into [model] of {add['file']}:", Lines((add["toml"],))]
    elif add["file"]:
        parts.append(f"To add it, write in {add['file']}, under [model]:")
        comments = [f"# {name} is left out: {why}" for name, why in add["left_out"].items()]
        parts.append(Lines((*comments, *_model_lines(diagnosis.apply(experiment)))))
    else:
        parts += ["To add it:", Lines((add["toml"],))]
    if diagnosis.verdict == "ambiguous":
        parts += _instead(diagnosis)
    parts += [f'Fill in first: {name} ("{FILL_IN}" stands for it): {why}.' for name, why in add["fill_in"].items()]
    if add["effect_file"]:
        parts.append(_law_file(diagnosis, add))
    parts += ["Then see the error before and after:", Lines((add["next"],))]
    if add["effect_file"] and add["file"] and not diagnosis.mended and diagnosis.law.folder is not None:
        model = str(Path(diagnosis.law.folder) / MODEL)
        line = shlex.join(["hlcs", "compare", model, "--effects", diagnosis.law.place("")])
        parts += [f"{model} is {add['file']} with it added; it needs the file of the law as well:", Lines((line,))]
    if add["file"] and not diagnosis.mended:
        parts.append('Or let it be written: --apply NEW.toml; in Python diagnosis.apply(experiment).save("NEW.toml").')
    return tuple(parts)


def _law_file(diagnosis, add):
    """Where the law and the numbers of the learned effect stand."""
    name = diagnosis.additions[-1]["name"]
    if diagnosis.mended:
        where = f"{add['effect_file']}, beside {add['file']}"
    elif diagnosis.law.folder is None:
        where = f"{add['effect_file']}, which --plots DIR, or --apply NEW.toml, writes"
    else:
        where = diagnosis.law.place("")
    return f"{name} is what was learned: its law and its numbers stand in {where}."


def _model_lines(experiment):
    """The lines of [model] that name the effects of an Experiment and which of them were added."""
    model = experiment.file.source.values["model"]
    return [f"{key} = {toml_value(model[key])}" for key in OF_EFFECTS if key in model]


def _instead(diagnosis):
    """What could be written in place of what was found, as it is written there, for each other set that does as well."""
    parts, experiment = [], diagnosis.experiment
    instead = "Or instead, in place of effects, added and replaced there:" if diagnosis.mended else "Or instead of these lines:"
    for number, entries in enumerate(diagnosis.alternatives):
        left = len(diagnosis.alternatives) - number
        if number >= MOST_INSTEAD and left > 1:
            parts.append(f"Or, in the same way, what one of {left} more sets that are told above holds.")
            break
        if not entries:
            parts.append("Or nothing need be added.")
        elif diagnosis.add["file"]:
            parts += [instead, Lines(tuple(_model_lines(experiment.with_effects(entries))))]
        else:
            parts += ["Or instead:", Lines((", ".join(map(toml_value, entries)),))]
    return parts


def _not_proved(diagnosis):
    """That what is to be added is no certain thing, by its name."""
    names = [entry["name"] for entry in diagnosis.additions]
    one = len(names) == 1
    is_, helps = ("is", "it helps") if one else ("are", "they help")
    doubted = doubt(diagnosis)
    noise = doubted.noise if doubted else "noise"
    what, said = capital(joined(map(words, names))), NOT_PROVED["learned" if diagnosis.law else diagnosis.verdict]
    return said.format(what=what, is_=is_, it_helps=helps, noise=noise)


# --- as a page, a picture, files --------------------------------------------------------------------------------------------


def html(diagnosis):
    """A diagnosis in a notebook, with its figure."""
    picture = page.png(plot(diagnosis)) if diagnosis.pictures else None
    return page.fragment(headline(diagnosis), sections(diagnosis), statistics.sections(diagnosis), picture)


def plot(diagnosis, ax=None):
    """Four panels: fit, what is left, what remains with each candidate, the error falling to the noise; returns the four Axes."""
    return diagnosis_panels(diagnosis, ax)


def save(diagnosis, folder):
    """Write result.json, candidates.csv, report.txt, report.html, model.toml and its data and, where they are drawn, pictures."""
    if diagnosis.learned is not None:
        diagnosis = replace(diagnosis, learned=diagnosis.learned.in_folder(folder))
    drawn = {name: (page.png(axes), caption) for name, (axes, caption) in pictures(diagnosis).items()}
    found = {
        "candidates.csv": csv_text(diagnosis.to_dataframe().to_dict("list")).encode(),
        "report.txt": (text(diagnosis, details=True) + "\n").encode(),
        "report.html": report_page(diagnosis, drawn).encode(),
    }
    if diagnosis.pictures:
        found["diagnosis.png"] = page.png(plot(diagnosis))
    found |= {f"{name}.png": picture for name, (picture, _) in drawn.items()}
    if diagnosis.learned is not None and diagnosis.learned.effect_file:
        found[diagnosis.learned.file_name] = diagnosis.learned.effect_file.encode()
    if diagnosis.experiment is not None:
        found |= diagnosis.apply(diagnosis.experiment).files(folder, (*found, "result.json"))
    found["result.json"] = json.dumps(diagnosis.to_json(), indent=1).encode()  # last: where it stands, the others stand too
    return folders.save_files(folder, found)


def report_page(diagnosis, drawn):
    """report.html, one page that opens offline; drawn: {name: (PNG bytes, caption)}."""
    facts = statistics.facts(diagnosis)
    return page.whole(diagnosis.title, diagnosis.verdict, facts, sections(diagnosis), statistics.sections(diagnosis), drawn)
