"""Sphinx settings. Build with `sphinx-build -W docs docs/_build`: every warning is an error, every notebook is executed."""

import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

project = "hlcs"
author = "the hlcs developers"
copyright = "the hlcs developers, BSD 3-Clause"
release = version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx.ext.viewcode",
    "numpydoc",
    "myst_nb",
]
exclude_patterns = ["_build", "jupyter_execute", "**.ipynb_checkpoints"]
templates_path = ["_templates"]
default_role = "literal"

html_theme = "pydata_sphinx_theme"
html_title = "hlcs"
html_theme_options = {"show_prev_next": False, "navigation_with_keys": False}
html_show_sourcelink = False

myst_enable_extensions = ["dollarmath", "amsmath", "deflist"]
myst_heading_anchors = 3
nb_execution_mode = "cache"
nb_execution_raise_on_error = True
nb_execution_timeout = 600

autosummary_generate = True
autodoc_member_order = "bysource"
autodoc_typehints = "none"
numpydoc_show_class_members = False


def plain_docstring(app, what, name, obj, options, lines):
    """Let docstrings be plain text: formulas such as |r_T| or x* mean themselves, deeper indented lines are kept as they are."""
    result, literal = [], False
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
            line = "".join(part if index % 2 else re.sub(r"([|*\\]|(?<=\w)_(?!\w))", r"\\\1", part) for index, part in enumerate(parts))
            line = re.sub(r"^(\s*)\\\* ", r"\1* ", line)
        result.append(line)
    lines[:] = result


def setup(app):
    app.connect("autodoc-process-docstring", plain_docstring, priority=400)
