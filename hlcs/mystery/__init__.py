"""Data sets with something missing from their model, to find with `compare` and `diagnose`; answers stay sealed until `reveal`.

Each set is a folder as a user would write it: experiment.toml, the recordings, and rest.csv for the noise. The data come from
closed forms and a Runge-Kutta integration that share no code with the engine; `tests/blind/remake_mysteries.py` makes them again.
"""

import base64
import difflib
import json
import tomllib
from pathlib import Path

from hlcs.files.folders import write_bytes
from minibullet.errors import InputError

FOLDER = Path(__file__).resolve().parent / "data"
SEALED = "answer.sealed"  # base64 of JSON: not a secret, only out of sight


def names():
    """Names of all sets, from easy to hard."""
    order = json.loads((FOLDER / "order.json").read_text(encoding="utf-8"))
    return tuple(order)


def title(name):
    """One line on what was done and recorded; nothing about what is hidden."""
    return tomllib.loads((_folder(name) / "experiment.toml").read_text(encoding="utf-8"))["title"]


def copy(name, out):
    """Copy experiment.toml and its CSV files into the folder `out` (made if need be); the path of the experiment file.

    Files of the same name and other content are not overwritten: InputError.
    """
    source, out = _folder(name), Path(out)
    files = [file for file in sorted(source.iterdir()) if file.suffix in (".toml", ".csv")]
    if out.exists() and not out.is_dir():
        raise InputError(f"{out}: is a file; give a folder for the data set '{name}'")
    for file in files:
        target = out / file.name
        if target.exists() and target.read_bytes() != file.read_bytes():
            raise InputError(f"{target}: exists with other content; give an empty folder for the data set '{name}'")
    for file in files:
        write_bytes(out / file.name, file.read_bytes())
    return out / "experiment.toml"


def answer(name):
    """The sealed answer as a dictionary: effects, parameters (as an ideal fit of the library's law gives them), look-alikes."""
    return json.loads(base64.b64decode((_folder(name) / SEALED).read_bytes()))


def reveal(name):
    """What was hidden, in words."""
    return answer(name)["text"]


def _folder(name):
    """Folder of a set; unknown names are refused with the nearest one."""
    known = names()
    if name not in known:
        near = difflib.get_close_matches(str(name), known, n=1, cutoff=0.0)
        raise InputError(f"mystery '{name}': unknown; the nearest name is '{near[0]}' (all: {', '.join(known)})")
    return FOLDER / name
