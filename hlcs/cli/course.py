"""`hlcs course`: the lessons as notebooks."""

import click

import hlcs.course as lessons
from hlcs.cli.options import example, json_option, path_option, publish, quiet_option


@click.group()
def course():
    """Nine lessons: from a first drop to a hidden effect and five layers of Cubipods."""


@course.command("copy")
@path_option("--out", metavar="DIR", default="course", show_default=True, help="folder for the notebooks")
@json_option
@quiet_option
@example("hlcs course copy --out course")
def course_copy(out, json_file, quiet):
    """All lessons as notebooks (.ipynb) with their data, for work without a network.

    A copy that you have worked in is not overwritten. Notebooks need the extra: python -m pip install -e '.[notebook]' in the
    folder of the project, and a program that shows them, such as JupyterLab or VS Code.
    """
    files = lessons.copy(out)
    titles = {file.name: lessons.title(file.stem) for file in files}
    text = "\n".join(f"{name:34} {title}" for name, title in titles.items())
    publish({"format": 1, "folder": str(files[0].parent), "lessons": titles}, text, json_file, out, quiet)
