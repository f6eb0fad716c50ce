"""The course: nine lessons, from a first drop to five layers of Cubipods, as notebooks to be copied and worked in.

The lessons are text, one source for the pages of the documentation and for the notebooks: `docs/course` in a checkout, which is
packed into the installed package as `hlcs/course/lessons`.
"""

from pathlib import Path

from hlcs.course import lesson_text, notebooks
from hlcs.files import folders
from minibullet.errors import InputError, one_of

PACKED = Path(__file__).resolve().parent / "lessons"
CHECKOUT = Path(__file__).resolve().parents[2] / "docs" / "course"
LESSONS, DATA = "[0-9]*.md", ("*.csv", "*.py")  # of that folder, what is a lesson and what lessons read; other pages stay there


def names():
    """Names of all lessons in their order."""
    return tuple(path.stem for path in sorted(folder().glob(LESSONS)))


def title(name):
    """The title of a lesson; InputError for a name that none has."""
    return lesson_text.title(_text(name))


def notebook(name):
    """A lesson as the text of a Jupyter notebook (.ipynb, format 4.5); InputError for a name that none has."""
    return notebooks.write(_text(name), names())


def copy(out):
    """Write all lessons as notebooks, and the data that they read, into the folder `out` (made if need be); their paths in order.

    All or none. A lesson that was copied before is replaced where nobody has changed it; where somebody has, or another file of
    its name stands there, nothing is touched: InputError, which says where the new copy is.
    """
    data = {path.name: path.read_bytes() for pattern in DATA for path in sorted(folder().glob(pattern))}
    lessons = {f"{name}.ipynb": notebook(name).encode("utf-8") for name in names()}
    target = folders.save_files(out, lessons | data)
    return [target / name for name in lessons]


def folder():
    """The folder of the lessons' text: of the installed package, or of the checkout."""
    found = next((place for place in (PACKED, CHECKOUT) if any(place.glob(LESSONS))), None)
    if found is None:
        raise InputError(f"course: no lessons in '{PACKED}' or '{CHECKOUT}'; install hlcs again")
    return found


def _text(name):
    if name not in names():
        raise InputError(f"lesson '{name}': unknown; {one_of(name, names(), 'the lessons are')}")
    return (folder() / f"{name}.md").read_text(encoding="utf-8")
