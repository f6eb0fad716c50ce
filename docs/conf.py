"""Sphinx settings. Build with `sphinx-build -W docs docs/_build`: every warning is an error, every notebook is executed."""

import dataclasses
import inspect
import re
import sys
import tomllib
from pathlib import Path

from docutils import nodes
from latex2mathml.converter import convert

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "docs" / "_ext")]

from hlcs import course  # noqa: E402  # of this checkout

project = "hlcs"
author = "the hlcs developers"
copyright = "the hlcs developers, BSD 3-Clause"
release = version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.viewcode",
    "numpydoc",
    "myst_nb",
    "effect_pages",
    "api_pages",
]
exclude_patterns = ["_build", "_ext", ".jupyter_cache", "jupyter_execute", "**.ipynb_checkpoints"]
templates_path = ["_templates"]
default_role = "literal"

html_math_renderer = "mathml"  # formulas are in the page itself: it reads the same without a network
html_theme = "pydata_sphinx_theme"
html_title = "hlcs"
html_theme_options = {
    "show_prev_next": False,
    "navigation_with_keys": False,
    # headings at the side; not of the how-to pages and the effects, whose printed reports and tables need the room
    "secondary_sidebar_items": dict.fromkeys(("*", "theory/*", "reference/api/*", "api/**"), ["page-toc"]) | {"index": []},
}
html_show_sourcelink = False
html_sidebars = {"*": []}  # pages without pages below them need no navigation at their side
html_static_path = ["_static"]
html_css_files = ["wide.css"]
html_context = {"default_mode": "auto"}  # light or dark as the reader's system has it

myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "attrs_inline", "colon_fence"]
myst_heading_anchors = 3
nb_execution_mode = "cache"
nb_execution_raise_on_error = True
nb_execution_timeout = 600
nb_merge_streams = True  # what one cell prints is one block
nb_code_prompt_show, nb_code_prompt_hide = "Show the solution", "Hide the solution"  # only solutions of exercises are hidden

autosummary_generate = True
autodoc_member_order = "bysource"
autodoc_typehints = "none"
numpydoc_show_class_members = False


MARKUP = re.compile(r"([|*\\]|(?<=\w)_(?!\w))")


def fields_of(record):
    """Lines that describe the fields of a record by the comments, or the metadata, that stand beside them in the code."""
    try:
        source = inspect.getsource(record)
    except (OSError, TypeError):
        return []
    comments = dict(re.findall(r"^    (\w+)\s*:[^#\n]*#\s*(.+?)\s*$", source, re.MULTILINE))
    for field in dataclasses.fields(record) if dataclasses.is_dataclass(record) else ():
        if "parameter" in field.metadata and field.name not in comments:
            known = field.metadata["parameter"]
            parts = [f"[{known.unit}]"]
            parts += [f"{known.low:g} to {known.high:g}"] if None not in (known.low, known.high) else []
            parts += [f"no effect at {known.null:g}"] if known.null is not None else []
            comments[field.name] = ", ".join(parts + [known.source] * bool(known.source))
    named = [name for name in getattr(record, "__annotations__", {}) if name in comments]
    return ["", *(f"- ``{name}``: {comments[name]}" for name in named), ""] if named else []


def skip_alias(app, what, name, obj, skip, options):
    """The fields of a named tuple are described with the class."""
    return True if type(obj).__name__ == "_tuplegetter" else skip


def plain_docstring(app, what, name, obj, options, lines):
    """Let docstrings be plain text: formulas such as |r_T| or x* mean themselves, deeper indented lines are kept as they are."""
    result, literal = [], False
    if what == "class":
        lines += fields_of(obj)
    for line in lines:
        indented = line.startswith((" ", "\t"))
        bullet = line.lstrip().startswith(("- ", "* "))
        if indented and not literal and not bullet and (not result or not result[-1].lstrip().startswith("- ")):
            result += ["", "::", ""]
            literal = True
        elif line.strip() and not indented:
            if literal:
                result.append("")
            literal = False
        if not literal:
            # escape what reStructuredText would read as markup, outside of `names` in backticks
            parts = re.split(r"(``.+?``|`.+?`)", line)
            line = "".join(part if index % 2 else MARKUP.sub(r"\\\1", part) for index, part in enumerate(parts))
            line = re.sub(r"^(\s*)\\\* ", r"\1* ", line)
        result.append(line)
    lines[:] = result


def lesson_of(docname):
    """The name of the lesson that a page of the course is, else None."""
    room, _, name = docname.rpartition("/")
    return name if room == "course" and name in course.names() else None


def link_notebook(app, docname, source):
    """A link to the notebook of a lesson, under its title."""
    if name := lesson_of(docname):
        link = f'<a href="{name}.ipynb" download>Download this lesson as a notebook</a> (all: `hlcs course copy --out DIR`)'
        source[0] = re.sub(r"^(# .+)$", rf"\1\n\n{link}", source[0], count=1, flags=re.MULTILINE)


def write_notebooks(app, exception):
    """The notebooks that the pages of the course link to, beside them."""
    if exception is None and app.builder.format == "html":
        course.copy(Path(app.outdir) / "course")


def formula(display):
    """What writes a formula as MathML, which browsers draw themselves."""

    def visit(translator, node):
        written = convert(node.astext(), display=display)
        translator.body.append(written if display == "inline" else f'<div class="formula">{written}</div>')
        raise nodes.SkipNode

    return visit, None


def setup(app):
    app.add_html_math_renderer("mathml", formula("inline"), formula("block"))
    app.connect("autodoc-process-docstring", plain_docstring, priority=400)
    app.connect("autodoc-skip-member", skip_alias)
    app.connect("source-read", link_notebook)
    app.connect("build-finished", write_notebooks)
