"""The paper's figures from runs: all there, none empty, their entries beside the paper's numbers, marked units the right ones."""

import io
import json
import re

import numpy as np
import pytest

from hlcs import Cubipod
from hlcs.paper import drawings, figure_list, index_page, reproduce_files
from hlcs.paper.reproduce import Plan
from hlcs.placement import figures

SMALL = {"rows": 2, "columns": 2, "layers": 2}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """(folder, documents, texts) of the figures and both tables, on four units and one."""
    folder, plan = tmp_path_factory.mktemp("paper"), Plan(SMALL | {"friction": 0.36, "margin": 0.0}, repeats=1, workers=1)
    made = {name: reproduce_files.run(name, plan, folder) for name in ("table2", "table3", "figures")}
    return folder, {name: one[0] for name, one in made.items()}, {name: one[1] for name, one in made.items()}


def test_every_figure_is_drawn_and_accounted_for(made):
    """Figs. 1 to 14 stand in the list once each; every file it names is there and holds a picture that is not blank."""
    import matplotlib.image

    folder, documents, _ = made
    drawn = [figure_list.Entry(**one) for one in documents["figures"]["drawings"]]
    entries = figure_list.in_order([*figure_list.NOT_REDRAWN, *drawn, *figure_list.plotted_entries(documents)])
    assert [entry.figure for entry in entries] == [f"Fig. {n}" for n in range(1, 15)] + ["Videos"]
    assert all(entry.ours and entry.paper for entry in entries)
    for name in (entry.file for entry in entries if entry.file.endswith(".png")):
        image = matplotlib.image.imread(folder / name)
        assert np.ptp(image[..., :3]) > 0.5 and min(image.shape[:2]) > 200, name


def test_the_falling_layer_is_a_film_and_a_page_with_a_slider(made):
    from PIL import Image

    folder, _, _ = made
    film = Image.open(io.BytesIO((folder / "falling_layer.gif").read_bytes()))
    page = (folder / "falling_layer.html").read_text(encoding="utf-8")
    frames = len(json.loads(re.search(r"const scene = (\{.*\});", page)[1])["motion"]["times"])
    assert 2 <= film.n_frames <= frames and 'type="range"' in page and "http" not in page.replace("http://www.w3.org", "")


def test_the_index_page_shows_every_table_and_figure_and_asks_for_nothing(made):
    """Every picture and link of the page is a file of the folder or a place on the page."""
    folder, documents, texts = made
    texts = texts | {"table1": "the text of Table 1", "blind": "of blind reference"}
    text = index_page.page(documents, texts, 60.0)
    for target in re.findall(r'(?:src|href)="([^"#]+)"', text):
        assert (folder / target).is_file() or target == "sensitivity.png"
    for place in re.findall(r'href="#([^"]+)"', text):
        assert f'id="{place}"' in text
    assert "Made in 1.0 minutes" in text and "laboratory" in text and "http" not in text


def test_lost_and_misplaced_units_are_the_ones_that_are_marked(small_result):
    marks = drawings.marked(small_result)
    far = np.concatenate([np.hypot(*miss.T) > 0.5 for miss in small_result.misses])
    assert len(marks) == 9 + 4 and (marks >= far).all()
    assert sum(row[3] == drawings.MARKED for row in drawings.marked_rows(small_result)) == int(marks.sum())


def test_the_unit_is_drawn_with_its_three_lengths():
    words = {text.get_text() for text in drawings.unit(Cubipod()).axes[0].texts}
    assert {"L", "1.5 L", "0.25 L", "0.5 L"} <= words


def test_a_view_has_the_scale_of_the_structure(small_result):
    """The first layer of three rows: its units reach half a unit's width, at most 0.702 Dn, beyond their centres."""
    ax = figures.view_axes(figures.canvas(4, 3)[1][0], figures.unit_rows(small_result), "front", 1.0681647, width=200)
    reach = np.abs(np.concatenate(small_result.poses)[:, 0]).max() / 1.0681647
    low, high = ax.images[0].get_extent()[:2]
    assert reach + 0.5 < 0.94 * 0.5 * (high - low) + 0.02 < reach + 0.702 + 0.1
