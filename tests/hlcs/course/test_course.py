"""The lessons as notebooks: their cells, the format of the file, what is copied and what is left alone."""

import importlib.util
import json
import re

import pytest

from hlcs import course
from hlcs.course import lesson_text, notebooks
from minibullet.errors import InputError

LESSON = """---
file_format: mystnb
---

# 1. A title

Words and {doc}`theory <../theory/certificates>`, {doc}`the next <02_next>`.

```{code-cell} ipython3
a = 1
```

## Exercise 1: more

```{code-cell} ipython3
:tags: [hide-cell]

assert a + 1 == 2
```

The end.
"""


def test_a_lesson_comes_apart_into_its_cells_in_order():
    found = lesson_text.cells(LESSON)
    assert [cell.is_code for cell in found] == [False, True, False, True, False]
    assert [cell.text for cell in found if cell.is_code] == ["a = 1", "assert a + 1 == 2"]
    assert [cell.is_solution for cell in found] == [False, False, False, True, False]
    assert lesson_text.title(LESSON) == "1. A title" and found[0].text.startswith("# 1. A title")


def test_a_notebook_has_an_empty_cell_before_a_closed_solution_and_links_that_it_can_follow():
    document = json.loads(notebooks.write(LESSON, ("02_next",)))
    text, code, _, yours, solution, _ = document["cells"]
    assert "theory (page *theory/certificates* of the documentation), [the next](02_next.ipynb)" in text["source"]
    assert code["source"] == "a = 1" and "jupyter" not in code["metadata"]
    assert yours["source"].startswith("# your answer")
    assert solution["metadata"]["jupyter"] == {"source_hidden": True, "outputs_hidden": True}


@pytest.mark.parametrize("markup", ["{doc}`02_next`", "{py:class}`World`", "```{figure} x.png\n```", ":::{note}\n:::"])
def test_markup_that_a_notebook_cannot_show_is_refused(markup):
    with pytest.raises(ValueError, match="means nothing in a notebook"):
        notebooks.write(f"# 1. A title\n\nWords\n\n{markup}\n", ("02_next",))


def test_every_notebook_keeps_to_the_format():
    """nbformat 4.5: every cell has an id of its own, and what its type asks for; its schema, where nbformat is installed."""
    for name in course.names():
        document = json.loads(course.notebook(name))
        assert (document["nbformat"], document["nbformat_minor"]) == (4, 5)
        ids = [cell["id"] for cell in document["cells"]]
        assert len(set(ids)) == len(ids) and all(re.fullmatch(r"[\w-]{1,64}", one) for one in ids)
        for cell in document["cells"]:
            code = {"execution_count", "outputs"} if cell["cell_type"] == "code" else set()
            assert set(cell) == {"id", "cell_type", "metadata", "source"} | code and cell["source"]
        if importlib.util.find_spec("nbformat"):
            import nbformat

            nbformat.validate(nbformat.reads(course.notebook(name), as_version=4))


def test_every_link_of_a_notebook_leads_to_one_that_is_copied(tmp_path):
    copied = {path.name for path in course.copy(tmp_path)}
    linked = {link for path in tmp_path.glob("*.ipynb") for link in re.findall(r"\]\(([\w.]+)\)", path.read_text("utf-8"))}
    assert len(copied) == 9 and linked and linked <= copied


def test_a_copy_holds_the_data_that_lessons_read(tmp_path):
    course.copy(tmp_path)
    for path in tmp_path.glob("*.ipynb"):
        read = re.findall(r'read_csv\(\\"([\w.]+)\\"', path.read_text("utf-8"))
        assert all((tmp_path / name).is_file() for name in read)
    made_by = (tmp_path / "stack_in_pybullet.csv").read_text("utf-8").splitlines()[0]
    assert "pybullet" in made_by and (tmp_path / re.search(r"made by (\S+)", made_by)[1]).is_file()


def test_a_copy_that_was_worked_in_is_left_alone(tmp_path):
    first = course.copy(tmp_path / "course")[0]
    assert course.copy(tmp_path / "course")[0] == first  # once more over an untouched one
    first.write_text("my own work", encoding="utf-8")
    with pytest.raises(InputError, match="not as this program wrote it"):
        course.copy(tmp_path / "course")
    assert first.read_text(encoding="utf-8") == "my own work"


def test_an_unknown_lesson_is_refused_by_name():
    with pytest.raises(InputError, match="'10_more': unknown; the lessons are 01_first_drop"):
        course.notebook("10_more")


def test_without_its_folder_of_lessons_the_course_says_so(monkeypatch, tmp_path):
    monkeypatch.setattr(course, "PACKED", tmp_path)
    monkeypatch.setattr(course, "CHECKOUT", tmp_path)
    with pytest.raises(InputError, match="install hlcs again"):
        course.copy(tmp_path / "out")
