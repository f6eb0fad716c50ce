"""The page of the format tells every key and every column that the readers know, and messages as the program says them."""

import ast
import re
from pathlib import Path

import pytest

from hlcs.data.experiment_file import SECTIONS
from hlcs.data.quantities import INPUTS, OUTCOMES
from hlcs.data.recordings import ACCELERATIONS, COLUMNS, PIXELS

ROOT = Path(__file__).resolve().parent.parent
PAGE = (ROOT / "docs" / "bring_your_own_measurements.md").read_text(encoding="utf-8")
FROM = ("hlcs/data", "hlcs/files", "hlcs/kinds", "hlcs/importing", "hlcs/effects", "minibullet")  # where messages come from
GAP = "\0"  # in the place of what a message fills in


def rows_of(title):
    """The names in the first cells of the tables of a section of the page."""
    section = PAGE.split(f"\n## {title}\n")[1].split("\n## ")[0]
    return [name for row in re.findall(r"^\| (`[^|]+) \|", section, re.MULTILINE) for name in re.findall(r"`([^`]+)`", row)]


def test_every_key_of_an_experiment_file_stands_on_the_page_and_no_other():
    """The keys of [body] and [surroundings] may stand in a [[trial]] too, which the page says once."""
    everywhere = {*SECTIONS["body"], *SECTIONS["surroundings"]}
    own = SECTIONS | {"trial": [key for key in SECTIONS["trial"] if key not in everywhere], "measurement.input_sd": []}
    known = {f"{section}.{key}".lstrip(".") for section, keys in own.items() for key in keys}
    sections = {name for name in known if name in SECTIONS} | {"placement"}  # whose keys are those of `hlcs place`
    assert known - sections == set(rows_of("7. Every key")) - sections


def test_every_column_stands_on_the_page_and_no_other():
    assert set(rows_of("8. Every column")) == {*COLUMNS, *PIXELS, *ACCELERATIONS, *INPUTS, *OUTCOMES, "group"}


def said_by_the_program():
    """All texts of the rooms that speak to users, with a gap where something is filled in."""
    texts = []
    for room in FROM:
        for path in sorted((ROOT / room).rglob("*.py")):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.JoinedStr):
                    texts.append("".join(part.value if isinstance(part, ast.Constant) else GAP for part in node.values))
                elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                    texts.append(node.value)
    return texts


MESSAGES = re.findall(r"^\| `([^`]+)` \|", PAGE.split("\n## 6. What is refused, and why\n")[1].split("\n## ")[0], re.MULTILINE)
SAID = said_by_the_program()


@pytest.mark.parametrize("message", MESSAGES)
def test_a_message_on_the_page_is_one_of_the_program(message):
    """Its words between numbers, names, quotes and stops: the longest run, and every one of four or more, stands so in a text of
    the program, but for a first or last word that joins two texts."""
    filled = re.compile(r"'[^']*'|\"[^\"]*\"|\S*[\d_]\S*|\S+\.\S+|\S*\.\.|[:;,()]( |$)| \(")
    texts = {run.strip() for text in SAID for run in filled.sub(GAP, text).split(GAP)}
    runs = sorted((run.strip() for run in filled.sub(GAP, message).split(GAP)), key=lambda run: -len(run.split()))
    strange = []
    for place, run in enumerate(runs):
        words = run.split()
        if place == 0 or len(words) >= 4:
            parts = (words, words[1:], words[:-1]) if len(words) >= 4 else (words,)
            if not any(" ".join(part) in text for part in parts for text in texts):
                strange.append(run)
    assert not strange
