"""One page for each public name of minibullet and hlcs, written when the documentation is built.

What a page says stands in the code: signature and docstring, the comments beside fields, the facts of an effect's numbers. Its
example is a file of docs/reference/examples, in the form of doctest, which the tests run.
"""

import dataclasses
import importlib
import inspect
import re
from pathlib import Path
from typing import NamedTuple

from effect_pages import fence, table, write_changed

from hlcs.effects.catalogue import number_facts
from minibullet.effects.contract import Effect, name_of, parameters

EXAMPLES = Path(__file__).resolve().parents[1] / "reference" / "examples"
MODULES = ("minibullet", "hlcs")
RETURNED = {
    "Comparison": "hlcs.records",
    "Diagnosis": "hlcs.records",
}  # classes that functions return, beside the names of __all__
SHOWN = 120  # letters of a default
OUTSIDE = r"(?![^()]*\))"  # in a pattern: no bracket is open here
GROUPS = {  # headings of the list, and the names under them that no rule puts there
    "World and settings": ("World", "Settings", "Journal", "Bodies", "Contacts", "ContactLaw", "solve_contacts", "rotations"),
    "Shapes": ("Box", "Capsule", "Compound", "ConvexPiece", "Cylinder", "Sphere", "mesh_file"),
    "Effects": (),
    "Placement": ("PlacementTest", "PlacementResult", "Grid", "RPG", "TPG", "Cube", "Cubipod"),
    "Measured layers": ("laboratory", "paper_numerical", "reproduce"),
    "Experiments": ("Experiment", "import_measurements", "compare", "Comparison", "diagnose", "Diagnosis", "predict", "reveal"),
    "Errors and warnings": ("EffectError", "InputError", "InputWarning", "SceneWarning"),
}


class Argument(NamedTuple):
    """One argument of a function, or one field of a record."""

    name: str
    default: str  # as Python writes it, "" where it must be given
    about: str
    unit: str  # "" where it has none


def public_names():
    """{full name: object} of all names that the two packages offer, and of what they return; a name of both stands once."""
    found = {}
    for module in MODULES:
        package = importlib.import_module(module)
        for name in package.__all__:
            value = getattr(package, name)
            if not any(value is other for other in found.values()):
                found[f"{module}.{name}"] = value
    return found | {f"{home}.{name}": getattr(importlib.import_module(home), name) for name, home in RETURNED.items()}


# ---- what the code says of arguments ----------------------------------------------------------------------------------------


def arguments(value):
    """The Arguments of a class or function, of a method without self."""
    try:
        signature = inspect.signature(value)
    except (TypeError, ValueError):
        return []
    named = [given for given in signature.parameters.values() if given.name not in ("self", "cls")]
    told = described(value, [given.name for given in named])
    return [Argument(given.name, default_of(value, given), *told.get(given.name, ("", ""))) for given in named]


def default_of(value, given):
    """The default of a parameter of a signature as Python writes it; "" where it must be given."""
    if given.default is inspect.Parameter.empty:
        return "" if given.kind.name not in ("VAR_POSITIONAL", "VAR_KEYWORD") else "none"
    default = given.default
    if isinstance(default, type):
        return default.__name__
    if repr(default).startswith("<"):  # the factory of a dataclass
        field = next((field for field in dataclasses.fields(value) if field.name == given.name), None)
        return repr(field.default_factory()) if field is not None else "none"
    text = f"{default:.6g}" if isinstance(default, float) else repr(default)
    return text if len(text) <= SHOWN else f"{type(default).__name__}(..)"


def described(value, names):
    """{name: (about, unit)}: from the facts of an effect's numbers, the comments beside fields, the clauses of the docstring."""
    told = clauses(inspect.getdoc(value) or "", names)
    if inspect.isclass(value):
        told |= {name: split_unit(comment) for name, comment in field_comments(value).items() if name in names}
        if dataclasses.is_dataclass(value):
            facts = [number_facts(known) for known in parameters(value).values()]
            told |= {known.name: (known.about, "-" if known.unit == "1" else known.unit) for known in facts}
    return told


def field_comments(record):
    """{field: comment} of the comments that stand beside the fields of a class and of its bases in the code."""
    found = {}
    for kind in reversed(record.__mro__):
        if kind.__module__.split(".")[0] in MODULES:
            source = inspect.getsource(kind)
            found |= dict(re.findall(r"^    (\w+)\s*:[^#\n]*#\s*(.+?)\s*$", source, re.MULTILINE))
    return found


def clauses(text, names):
    """{name: (about, unit)} of what a docstring says: clauses that begin with names of arguments, "side, radius: of .. [m]"."""
    found, known = {}, "|".join(map(re.escape, names))
    ends = rf"(?:(?<=[^.\d])[;.]\s+|[;.]\s*$|\n\n|: (?=(?:{known})\b)){OUTSIDE}"
    for clause in re.split(ends if names else r"\n\n", text):
        begun, rest = names_before(" ".join(clause.split()), names)
        about, unit = split_unit(rest)
        found |= {name: (about or name.replace("_", " "), own or unit) for name, own in begun if name not in found}
    return found


def names_before(clause, names):
    """([(name, unit that stands right behind it)], the rest) of the names with which a clause begins, with commas between."""
    found, more = [], True
    while more and (match := re.match(r"(\w+)(?: \[([^\]]*)\])?(, |: ?| |$)", clause)) and match[1] in names:
        found.append((match[1], match[2] or ""))
        clause, more = clause[match.end() :], match[3] == ", "
    return found, clause


def split_unit(text):
    """A description without its unit, and the unit that stands in brackets in it, "" where none does."""
    units = re.findall(r"\[([^\[\]]*)\]", text)
    return re.sub(r"\s*\[[^\[\]]*\]", "", text, count=1).strip(" ,;") if units else text.rstrip(".,; "), units[0] if units else ""


# ---- pages ---------------------------------------------------------------------------------------------------------------


def write(folder):
    """Write the list and one page a name into a folder; names of the files written."""
    known = public_names()
    pages = {f"{name}.md": page(name, value) for name, value in known.items()} | {"index.md": index(known)}
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in pages.items():
        write_changed(folder / name, text)
    return sorted(pages)


def index(known):
    """The page that lists all public names by what they are for."""
    lines = [
        "# Functions and classes",
        "",
        "Every public name of `minibullet` (the physics) and `hlcs` (the laboratory); tests run the example of each.",
        "",
    ]
    for heading in GROUPS:
        rows = [(f"[`{name}`]({name}.md)", first_sentence(value)) for name, value in known.items() if group_of(name) == heading]
        lines += [f"## {heading}", "", *table(("name", "what it is"), rows)]
    return "\n".join([*lines, "```{toctree}", ":hidden:", "", *known, "```", ""])


def group_of(name):
    """The heading that a name stands under: what no heading names belongs to effects."""
    short = name.rsplit(".", 1)[-1]
    return next((heading for heading, members in GROUPS.items() if short in members), "Effects")


def first_sentence(value):
    """The first sentence of a docstring, as Markdown."""
    return plain(
        re.split(r"(?<=[a-z0-9)\]])[.:](?:\s|$)", " ".join((inspect.getdoc(value) or "").split("\n\n")[0].split()))[0] + "."
    )


def page(name, value):
    """The page of one public name."""
    short = name.rsplit(".", 1)[-1]
    lines = [f"# {name}", ""]
    if inspect.ismodule(value):
        return "\n".join([*lines, *prose(value), *functions_of(value), *example(name)])
    callable_value = value if callable(value) else type(value)
    if callable(value):
        lines += [*fence("python", signature_of(short, value)), ""]
    else:
        lines += [
            f"A value of [`hlcs.{type(value).__name__}`](hlcs.{type(value).__name__}.md).",
            "",
            *fence("python", repr(value)),
            "",
        ]
    lines += [*prose(value), *catalogue_link(value), *argument_table(callable_value, "Arguments"), *example(name)]
    if inspect.isclass(value):
        lines += [*properties_of(value), *methods_of(value)]
    return "\n".join(lines)


def signature_of(name, value):
    """A call with its arguments, one a line where they are many."""
    try:
        given = [str(one.replace(annotation=inspect.Parameter.empty)) for one in inspect.signature(value).parameters.values()]
    except (TypeError, ValueError):
        return f"{name}(..)"
    given = (
        [
            f"{argument.name}={argument.default}" if argument.default not in ("", "none") else argument.name
            for argument in arguments(value)
        ]
        if given
        else []
    )
    flat = f"{name}({', '.join(given)})"
    return flat if len(flat) <= 90 else f"{name}(\n" + "".join(f"    {one},\n" for one in given) + ")"


def without_arguments(text, names):
    """A paragraph of a docstring without the clauses that describe arguments, which stand in their table."""
    if not names:
        return text
    lead = rf".*?: (?=(?:{'|'.join(map(re.escape, names))})\b)"
    pieces = re.split(rf"((?<=[^.\d])[;.](?:\s+|$){OUTSIDE})", " ".join(text.split()))
    kept = [
        words + mark
        for words, mark in zip(pieces[::2], [*pieces[1::2], ""], strict=True)
        if not names_before(words, names)[0] and not re.match(lead, words)
    ]
    return "".join(kept).strip()


def prose(value):
    """The docstring as paragraphs, indented lines as code."""
    lines, names = [], [one.name for one in arguments(value)] if callable(value) else []
    for part in re.split(r"\n\n+", inspect.getdoc(value) or ""):
        part = part if part.startswith("    ") else without_arguments(part, names)
        if not part:
            continue
        code = part.startswith("    ") or part.startswith(("world = ", "import "))
        lines += [*fence("python", inspect.cleandoc(part)), ""] if code else [plain(" ".join(part.split())), ""]
    return lines


def plain(text):
    """Text of a docstring as Markdown: what stands in backticks is code, all other letters mean themselves."""
    parts = re.split(r"(``.+?``|`.+?`)", text)
    return "".join(
        part.replace("``", "`") if index % 2 else re.sub(r"([\\*_^|<>\[\]$~{}])", r"\\\1", part)
        for index, part in enumerate(parts)
    )


def catalogue_link(value):
    """Where the catalogue tells more of an effect."""
    if inspect.isclass(value) and parameters_of(value):
        return (
            [f"Formula, typical values and picture: {{doc}}`../effects/{name_of(value)}`.", ""]
            if value.__name__ != "Gravity"
            else []
        )
    return []


def parameters_of(kind):
    """The numbers of an effect class, {} of any other."""
    return parameters(kind) if dataclasses.is_dataclass(kind) else {}


def argument_table(value, heading, level=2):
    """The table of arguments, with unit and default."""
    rows = [
        (f"`{one.name}`", plain(one.about), one.unit or "", f"`{one.default}`" if one.default else "must be given")
        for one in arguments(value)
        if one.about
    ]
    return [f"{'#' * level} {heading}", "", *table(("argument", "what", "unit", "default"), rows)] if rows else []


def example(name):
    """The example of a name, as it is run by the tests."""
    path = EXAMPLES / f"{name}.txt"
    return ["## Example", "", *fence("pycon", path.read_text(encoding="utf-8").strip()), ""] if path.is_file() else []


def members_of(kind):
    """{name: member} of the public methods and properties that a class has from the project, its bases' first."""
    found = {}
    for base in reversed(kind.__mro__):
        if base.__module__.split(".")[0] in MODULES:
            found |= {name: member for name, member in vars(base).items() if not name.startswith("_")}
    fields = {field.name for field in dataclasses.fields(kind)} if dataclasses.is_dataclass(kind) else set()
    fields |= set(getattr(kind, "_fields", ()))
    fields |= set(dir(Effect)) if kind is not Effect and issubclass(kind, Effect) else set()  # they stand on its own page
    return {name: member for name, member in found.items() if name not in fields}


def properties_of(kind):
    """The table of what can be read of a value of a class."""
    rows = [
        (f"`{name}`", plain(" ".join((inspect.getdoc(member) or "").split())))
        for name, member in members_of(kind).items()
        if isinstance(member, property) or type(member).__name__ == "cached_property"
    ]
    rows = [row for row in rows if row[1]]
    return ["## Attributes", "", *table(("name", "what"), rows)] if rows else []


def methods_of(kind):
    """The public methods that say what they do, each with its arguments."""
    lines = []
    for name, member in members_of(kind).items():
        function = getattr(kind, name) if isinstance(member, classmethod | staticmethod) else member
        if inspect.isroutine(function) and inspect.getdoc(function):
            lines += [f"### {name}", "", *fence("python", signature_of(f".{name}", function)), "", *prose(function)]
            lines += argument_table(function, "Arguments", 4)
    return ["## Methods", "", *lines] if lines else []


def functions_of(module):
    """The public functions of a module."""
    names = [name for name, member in vars(module).items() if inspect.isroutine(member) and member.__module__ == module.__name__]
    names = getattr(module, "__all__", [name for name in names if not name.startswith("_")])
    rows = [(f"`{name}`", first_sentence(getattr(module, name))) for name in names]
    return table(("name", "what it does"), rows)


def setup(app):
    """Write the pages before Sphinx looks for them."""
    write(Path(app.srcdir) / "reference" / "api")
    return {"parallel_read_safe": True}
