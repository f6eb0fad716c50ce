"""report.html: one well-formed page that opens offline, on a phone too; text of files stays text."""

from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from planted import ALL, COMPLETE, EFFECT, pictures, table

from hlcs.report import glossary
from hlcs.report import page as page_style
from hlcs.report.statistics import facts

VOID = {"meta", "img", "br", "wbr", "link"}


class Page(HTMLParser):
    """What a page is made of; fails where a tag is not closed in its turn."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.words = [], [], []
        self.feed(text)
        assert not self.open, self.open

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes), tuple(self.open)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] != "style":
            self.words.append(data)

    def attributes(self, tag):
        return [attributes for name, attributes, _ in self.tags if name == tag]


def page(diagnosis, folder):
    return (diagnosis.save(folder) / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("verdict", sorted(ALL))
def test_a_page_is_one_file_that_asks_nothing_of_the_net(tmp_path, verdict):
    text = page(ALL[verdict], tmp_path / "out")
    parsed = Page(text)
    assert not parsed.attributes("script") and not parsed.attributes("link") and "@import" not in text and "url(" not in text
    assert all(image["src"].startswith("data:image/png;base64,") and image["alt"] for image in parsed.attributes("img"))
    assert all(link["href"].startswith("#") for link in parsed.attributes("a"))
    assert {"name": "viewport", "content": "width=device-width,initial-scale=1"} in parsed.attributes("meta")
    assert "prefers-color-scheme:dark" in text


def test_the_links_of_a_page_lead_somewhere_and_its_tables_scroll_inside_their_box(tmp_path):
    parsed = Page(page(EFFECT, tmp_path / "out"))
    anchors = {attributes["id"] for _, attributes, _ in parsed.tags if "id" in attributes}
    assert {link["href"][1:] for link in parsed.attributes("a")} <= anchors
    inside = [where for tag, _, where in parsed.tags if tag == "table"]
    scrolled = [attributes for tag, attributes, _ in parsed.tags if tag == "div" and attributes.get("class") == "scroll"]
    assert inside and all(where[-1] == "div" for where in inside) and len(scrolled) == len(inside)


def test_only_the_cells_of_tables_keep_to_one_line_so_that_a_phone_never_scrolls_sideways():
    """Wide things are tables and pre, which scroll inside their own box; a row of links goes on in the next line."""
    rules = [rule.partition("{") for rule in page_style.STYLE.split("}")]
    unbroken = {name for names, _, told in rules if "white-space:nowrap" in told for name in names.strip().split(",")}
    assert unbroken <= {"th", "td"}
    assert any(names.strip() == "nav" and "flex-wrap:wrap" in told for names, _, told in rules)


def test_the_page_says_what_the_terminal_says_and_explains_its_words(tmp_path):
    words = " ".join(" ".join(Page(page(EFFECT, tmp_path / "out")).words).split())
    assert "Air resistance is missing (quadratic drag, drag coefficient 0.4965 ± 0.0010)." in words
    assert glossary.GLOSSARY["chi-square per degree of freedom"] in words and glossary.GLOSSARY["held out"] in words


def test_a_title_and_a_note_that_a_browser_would_obey_are_only_text(tmp_path):
    bad = "<script>alert(1)</script>"
    found = replace(EFFECT, title=bad, notes=(bad,))
    assert bad not in page(found, tmp_path / "out") and bad not in found._repr_html_()
    Page(found._repr_html_())


def test_what_was_found_is_marked_and_the_mark_is_explained_as_it_looks():
    """A star in a terminal, a shaded row in a page."""
    words, printed = " ".join(Page(EFFECT._repr_html_()).words), EFFECT.summary()
    assert "Shaded: found." in words and "* found." not in words
    assert "* found." in printed and "Shaded" not in printed and "* quadratic_drag" in printed
    assert "found." not in COMPLETE.summary()  # nothing is marked there


def test_every_picture_is_a_file_of_its_own_and_stands_in_the_page(tmp_path):
    left = np.random.default_rng(1).standard_normal(50) * 0.003
    found = replace(EFFECT, pictures=pictures(table(left + np.linspace(0, 0.3, 50)), table(left)))
    text = page(found, tmp_path / "out")
    files = {path.stem for path in (tmp_path / "out").glob("*.png")}
    assert {"fit", "error", "ranking", "residuals_time", "residuals_height", "residuals_speed", "residuals_by_recording"} <= files
    assert text.count("data:image/png") == len(files - {"diagnosis"})


def test_cards_and_the_picture_of_the_fit_say_of_which_data_they_are(tmp_path):
    """The error of a card is one of data left out, where there are any; the curve of the picture was fitted to what it shows."""
    assert [what for what, _ in facts(EFFECT)][:2] == [f"error {when}, on recordings left out" for when in ("before", "after")]
    fitted = replace(EFFECT, error=EFFECT.error | {"held_out": None})
    assert [what for what, _ in facts(fitted)][:2] == ["error before, on the fitted data", "error after, on the fitted data"]
    left = np.random.default_rng(1).standard_normal(50) * 0.003
    found = replace(EFFECT, pictures=pictures(table(left + np.linspace(0, 0.3, 50)), table(left)))
    assert "The numbers were fitted to all that was measured, this as well." in page(found, tmp_path / "out")


def test_the_glossary_of_the_documentation_is_the_one_of_the_pages():
    docs = Path(__file__).resolve().parents[3] / "docs"
    assert (docs / "glossary.md").read_text(encoding="utf-8") == glossary.as_markdown()


def test_a_name_breaks_behind_an_underscore_and_lines_to_copy_wrap_unbroken(tmp_path):
    """<wbr> stands in tables, whose columns are narrow; not in what is copied, where a mark would be a mistake in a file."""
    text = page(EFFECT, tmp_path / "out")
    assert "quadratic_<wbr>drag</td>" in text
    copied = [part.split("</pre>")[0] for part in text.split("<pre>")[1:]]
    assert copied and not any("<wbr>" in part for part in copied) and "quadratic_drag" in "".join(copied)
    assert "pre{white-space:pre-wrap;overflow-wrap:anywhere" in page_style.STYLE


def test_a_table_that_ends_in_sentences_is_a_list_on_a_phone_whose_cells_say_what_they_are(tmp_path):
    """Five columns beside each other are wider than a phone, and the bar to scroll them is far below."""
    parsed = Page(page(EFFECT, tmp_path / "out"))
    heads = [cell["data-head"] for cell in parsed.attributes("td") if "data-head" in cell]
    assert heads[:4] == ["evidence", "fitted", "held out", "why"]
    phone = page_style.STYLE.split("@media (max-width:40rem)")[1]
    assert ".wordy thead{display:none}" in phone and "content:attr(data-head)" in phone
