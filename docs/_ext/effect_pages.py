"""The catalogue of effects as pages, written when the documentation is built: what `hlcs effects` prints, with pictures."""

import io
from pathlib import Path

import matplotlib
from matplotlib.figure import Figure
from standard_experiments import experiment_of, residual

from hlcs.effects import classes
from hlcs.effects.catalogue import FAMILIES
from hlcs.kinds.catalogue import whole_catalogue
from hlcs.report.catalogue import UNSAID, typical_of, unit_words
from hlcs.report.words import number

GREY, BLUE = "#808080", "#2f86c1"  # seen on white and on black
SIZE = (4.4, 2.2)  # of a picture [inch]
LAYERS = "layers"  # the page of what only tests of layers know


def write(folder):
    """Write index, one page an effect and its picture into a folder; names of the files written."""
    catalogue = whole_catalogue()
    pages = {"index.md": index(catalogue), f"{LAYERS}.md": layers_page(catalogue)}
    for facts in catalogue:
        if facts.name in classes():
            pages[f"{facts.name}.md"] = page(facts)
            pages[f"{facts.name}.svg"] = picture(facts.name)
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in pages.items():
        write_changed(folder / name, text)
    return sorted(pages)


def write_changed(path: Path, text):
    """Write a file whose text is another one than before, so that only these pages are built again."""
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8", newline="\n")


def index(catalogue):
    """The page that lists all effects."""
    lines = [
        "# Catalogue of effects",
        "",
        "What a model may lack. `hlcs effects` prints the same list, `hlcs effects NAME` the page of one. Each picture shows",
        "what the effect leaves in a small experiment without noise when the model lacks it: measured - model, against time.",
    ]
    for group, heading in FAMILIES.items():
        members = [facts for facts in catalogue if facts.group == group]
        if not members:
            continue
        lines += ["", f"## {heading}", ""]
        pictured = members[0].name in classes()
        head = ("", "effect", "what it looks like in data") if pictured else ("effect", "what it looks like in data")
        lines += table(head, [index_row(facts, pictured) for facts in members])
    toctree = ["", "```{toctree}", ":hidden:", "", *sorted(facts.name for facts in catalogue if facts.name in classes()), LAYERS]
    return "\n".join([*lines, *toctree, "```", ""])


def index_row(facts, pictured):
    """The row of an effect in the list: its picture where it has one, its name as a link, what it looks like."""
    target = f"{facts.name}.md" if pictured else f"{LAYERS}.md#{facts.name}"
    row = (f"[`{facts.name}`]({target})<br>{facts.called}", facts.looks_like)
    return (f"[![]({facts.name}.svg){{.dark-light .thumbnail}}]({target})", *row) if pictured else row


def page(facts):
    """The page of one effect."""
    experiment = experiment_of(facts.name)
    values = ", ".join(f"{name} = {value:g}" for name, value in experiment.effects[facts.name].items())
    lines = [f"# {facts.name}", "", f"*{facts.called[:1].upper()}{facts.called[1:]}.* {facts.law}", ""]
    lines += [*fence("text", facts.formula), "", *letters(facts), *numbers(facts), *typical(facts)]
    lines += ["## What it looks like in data", "", facts.looks_like, ""]
    lines += [f"```{{figure}} {facts.name}.svg", f":alt: residual that {facts.name} leaves", ":class: dark-light", ""]
    lines += [
        f"Made by `{facts.name}` with {values}, in an experiment where {experiment.told}; the start is known, there is no noise."
    ]
    lines += ["```", "", *confused(facts), *more(facts), "## In Python and in files", ""]
    call = facts.class_name.replace("minibullet.", "mb.")
    first = ", ".join(f"{name}={value:g}" for name, value in experiment.effects[facts.name].items())
    lines += [*fence("python", f"{call}({first})"), ""]
    entry = ", ".join(f"{name} = {value:g}" for name, value in experiment.effects[facts.name].items())
    lines += [*fence("toml", f'[model]\neffects = [{{ name = "{facts.name}", {entry} }}]'), ""]
    return "\n".join(lines)


def layers_page(catalogue):
    """The page of all effects that only tests of layers know."""
    lines = [
        "# Effects of layer tests alone",
        "",
        "Ranges are those of the default placement test; they follow what a file says.",
        "",
    ]
    for facts in (facts for facts in catalogue if facts.name not in classes()):
        lines += [f"({facts.name})=", f"## {facts.name}", "", facts.law + " " + facts.looks_like, ""]
        lines += [*numbers(facts, heading=False), *confused(facts, heading=False), facts.details, ""]
    return "\n".join(lines)


def fence(language, text):
    """A block of code."""
    return [f"```{language}", text, "```"]


def cell(text):
    """A text in a cell of a table."""
    return str(text).replace("|", "\\|")


def table(head, rows):
    """A table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return ["| " + " | ".join(map(cell, line)) + " |" for line in lines] + [""]


def letters(facts):
    """The letters of the formula."""
    rows = [(f"`{letter}`", meaning) for letter, meaning in facts.symbols]
    return table(("letter", "meaning [unit]"), rows) if rows else []


def numbers(facts, heading=True):
    """The numbers, with units, defaults and ranges."""
    rows = [
        (
            f"`{known.name}`" + (f" (`{known.symbol}`)" if known.symbol != known.name else ""),
            known.about,
            unit_words(known.unit),
            number(known.default),
            known.range or "given by the file",
            number(known.null),
        )
        for known in facts.numbers
    ]
    head = ("number", "what", "unit", "default", "plausible", "absent at")
    if not any(known.about for known in facts.numbers):  # the name of the effect says it
        head, rows = (head[0], *head[2:]), [(row[0], *row[2:]) for row in rows]
    return [*(["## Numbers", ""] if heading else []), *table(head, rows)] if rows else []


def typical(facts):
    """Values that were measured, with their sources."""
    rows = [(f"`{name}`", value, what, source) for name, value, what, source in typical_of(facts)]
    if rows:
        return ["## Typical values", "", *table(("number", "value", "of", "source"), rows)]
    sources = [f"`{known.name}`: {known.source}." for known in facts.numbers if known.source]
    return ["## Typical values", "", *(sources or [UNSAID.capitalize() + "."]), ""]


def confused(facts, heading=True):
    """What it is confused with, as links."""
    if not facts.confused_with:
        return []
    links = ", ".join(f"[`{name}`]({name}.md)" if name in classes() else f"`{name}`" for name in facts.confused_with)
    if not heading:
        return [f"Easily confused with {links}.", ""]
    after = (
        "What tells them apart in your data, or which experiment would, is what {doc}`/howto/when_it_says_ambiguous` is about."
    )
    return ["## Easily confused with", "", f"{links}.", "", after, ""]


def more(facts):
    """What else there is to know; formulas in it are text."""
    escaped = [
        part.replace("*", "\\*").replace("_", "\\_").replace("^", "\\^").replace("|", "\\|").replace("``", "`")
        for part in facts.details.split("\n\n")
    ]
    return ["## More", "", "\n\n".join(escaped), ""] if facts.details else []


def picture(name):
    """The residual of an effect as SVG, without a background, the same bytes every time."""
    times, values, what = residual(name)
    with matplotlib.rc_context({"svg.hashsalt": name, "font.size": 9, "svg.fonttype": "none", "font.family": "sans-serif"}):
        figure = Figure(figsize=SIZE, layout="constrained")
        ax = figure.add_subplot()
        ax.axhline(0.0, color=GREY, lw=0.75)
        ax.plot(times, values, color=BLUE, lw=1.8)
        ax.set_xlabel("time [s]", color=GREY)
        ax.set_title(what, loc="left", fontsize=9, color=GREY)
        ax.tick_params(colors=GREY)
        ax.spines[["top", "right"]].set_visible(False)
        ax.spines[["left", "bottom"]].set_color(GREY)
        ax.locator_params(nbins=5)
        stream = io.StringIO()
        figure.savefig(stream, format="svg", transparent=True, metadata={"Date": None})
    return stream.getvalue()


def setup(app):
    """Write the pages before Sphinx looks for them."""
    write(Path(app.srcdir) / "reference" / "effects")
    return {"parallel_read_safe": True}
