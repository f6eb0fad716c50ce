"""The house is as docs/architecture.md draws it."""

import re
import sys
from pathlib import Path

import hlcs
from hlcs import mystery

ROOT = Path(__file__).resolve().parent.parent
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
MOST_AT_TOP, MOST_LINES_AT_TOP, MOST_STATIONS = 7, 300, 10  # what one can keep in mind


def test_every_room_on_the_page_exists_and_every_room_is_on_the_page():
    drawn = {
        match for line in PAGE.splitlines() if line.startswith("| `") for match in re.findall(r"`(\w+)/`", line.split("|")[1])
    }
    standing = {path.parent.name for package in ("hlcs", "minibullet") for path in (ROOT / package).glob("*/__init__.py")}
    assert drawn | {"mystery"} == standing


def test_the_top_of_hlcs_is_small():
    lines = {path.name: len(path.read_text(encoding="utf-8").splitlines()) for path in (ROOT / "hlcs").glob("*.py")}
    assert len(lines) <= MOST_AT_TOP and max(lines.values()) <= MOST_LINES_AT_TOP, lines


def test_one_measurement_passes_the_rooms_in_the_order_on_the_page(tmp_path):
    """From file to verdict: the modules that the page lists are first entered in that order, each once, at most ten."""
    stations = re.findall(r"^\d+\. `([\w.]+)`", PAGE, re.MULTILINE)
    entered = {}

    def hook(frame, event, _):
        if event == "call":
            entered.setdefault(frame.f_globals.get("__name__"))

    path = mystery.copy("tower-drop", tmp_path)
    for module in stations:
        __import__(module)  # what is run when a module is loaded is not the measurement on its way
    sys.setprofile(hook)
    try:
        str(hlcs.diagnose(path, candidates=["quadratic_drag"]))
    finally:
        sys.setprofile(None)
    assert stations == [module for module in entered if module in stations]
    assert len(stations) == len(set(stations)) <= MOST_STATIONS
