"""The catalogue of effects as text: one effect, or all of them. Records are those of `hlcs.effects.catalogue`."""

from hlcs.report.document import Lines, Points, Section, Table, as_text
from hlcs.report.words import number

UNSAID = "no value holds for many bodies; the range is what is plausible"


def one(facts):
    """The printed page of one effect."""
    parts = [facts.law, *([Lines((facts.formula,))] if facts.formula else [])]
    found = [
        Section("", tuple(parts)),
        Section("Letters", _letters(facts)),
        Section("Numbers", _numbers(facts)),
        Section("Typical values", _typical(facts)),
        Section("What it looks like in data", (facts.looks_like,) if facts.looks_like else ()),
        Section("Easily confused with", (", ".join(facts.confused_with),) if facts.confused_with else ()),
        Section("More", tuple(facts.details.split("\n\n")) if facts.details else ()),
        Section("In Python and in files", _use(facts)),
    ]
    return as_text(f"{facts.name}: {facts.called}", [section for section in found if section.parts])


def all_of(catalogue, headings):
    """The printed list of all effects, those of one group together; headings: {group: heading}."""
    sections = []
    for group, heading in headings.items():
        rows = tuple((facts.name, facts.called, _short_numbers(facts)) for facts in catalogue if facts.group == group)
        if rows:
            sections.append(Section(heading, (Table(("effect", "in plain words", "numbers"), rows, texts=3),)))
    sections.append(Section("", ("One of them: hlcs effects NAME.",)))
    return as_text(f"{len(catalogue)} effects that a model may lack", sections)


def unit_words(unit):
    """A unit in a table, a dash for a pure number."""
    return "-" if unit == "1" else unit


def typical_of(facts):
    """Rows (number, value with unit, of what, source) of all typical values of an effect."""
    return tuple(
        (known.name, number(value, known.unit), what, known.source) for known in facts.numbers for value, what in known.typical
    )


def _letters(facts):
    return (Table(("letter", "meaning [unit]"), facts.symbols, texts=2, wordy=True),) if facts.symbols else ()


def _numbers(facts):
    """Numbers to be found, and those that the experiment file gives."""
    rows = tuple(
        (
            known.name,
            known.symbol,
            unit_words(known.unit),
            number(known.default),
            known.range or "given",
            number(known.null),
            known.about,
        )
        for known in facts.numbers
    )
    head = ("number", "letter", "unit", "default", "plausible", "absent at", "what")
    if not any(known.about for known in facts.numbers):  # the name of the effect says it
        head, rows = head[:-1], tuple(row[:-1] for row in rows)
    return (Table(head, rows, texts=len(head), wordy=True),) if rows else ()


def _typical(facts):
    """Values that were measured, with their sources; that there are none is said."""
    rows = [f"{name} = {value}: {what}" + (f"; {source}" if source else "") for name, value, what, source in typical_of(facts)]
    if not rows and any(not known.given for known in facts.numbers):
        sources = [f"{known.name}: {known.source}" for known in facts.numbers if known.source]
        rows = sources or [UNSAID]
    return (Points(tuple(rows)),) if rows else ()


def _use(facts):
    """How it is written in Python and under [model]."""
    if not facts.class_name:
        return ()
    first = next((known for known in facts.numbers if not known.given), facts.numbers[0])
    value = first.typical[0][0] if first.typical else first.high if first.null == first.default and first.high else first.default
    call = f"{facts.class_name.replace('minibullet.', 'mb.')}({first.name}={value:g})"
    return (Lines((call, f'effects = [{{ name = "{facts.name}", {first.name} = {value:g} }}]')),)


def _short_numbers(facts):
    """Names and units of the numbers to be found."""
    named = [known.name + ("" if known.unit == "1" else f" [{known.unit}]") for known in facts.numbers if not known.given]
    return ", ".join(named[:3]) + (", .." if len(named) > 3 else "")
