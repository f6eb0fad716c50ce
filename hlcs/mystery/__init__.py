"""Data sets with something missing from their model, to find with `compare` and `diagnose`; answers stay sealed until `reveal`.

Each set is a folder as a user would write it: experiment.toml and CSV files. No data come from the engine: the packaged sets are
made by `tests/blind/remake_mysteries.py`, new ones by `make`, each by an integration of its own; layers are those of heaps that
pybullet made. Where a function takes a name, the folder of a set that `make` wrote does as well.
"""

import json
import tomllib
from pathlib import Path

from hlcs.files.folders import result_folder, write_bytes, write_text
from hlcs.mystery.seal import SEALED, opened
from minibullet.errors import InputError, if_alike

FOLDER = Path(__file__).resolve().parent / "data"


def rooms():
    """{room: names of its sets, from easy to hard}."""
    order = json.loads((FOLDER / "order.json").read_text(encoding="utf-8"))
    return {room: tuple(sets) for room, sets in order.items()}


def names():
    """Names of all packaged sets, room by room, in each from easy to hard."""
    return tuple(name for sets in rooms().values() for name in sets)


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
    file = _folder(name) / SEALED
    try:
        return opened(file.read_bytes())
    except (OSError, ValueError) as problem:
        raise InputError(
            f"{file}: is no sealed answer ({problem}); take it from the folder that `hlcs mystery make` wrote"
        ) from None


def reveal(name):
    """What was hidden, in words."""
    return answer(name)["text"]


def make(effect, strength, seed, out):
    """Write a new data set with a hidden effect and its sealed answer into the new folder `out`; the path of experiment.toml.

    effect: one of `hlcs.mystery.making.OFFERS` or, for a table of layers, of `hlcs.mystery.layers.OFFERS`; strength: how much it
    changes the recordings, or the means of the layers, in standard deviations of their noise, 0 = nothing is hidden; seed: a
    whole number. InputError for an effect or a strength that cannot be had.
    """
    from hlcs.mystery.making import made  # it needs SciPy's integrators, which take a while to load

    with result_folder(out) as partial:
        for file, text in made(effect, strength, seed).items():
            write_text(partial / file, text)
    return Path(out) / "experiment.toml"


def experiment(name):
    """Path of the experiment file of a set, to be read where it stands."""
    return _folder(name) / "experiment.toml"


def _folder(name):
    """Folder of a set; what is neither a name nor a folder with a sealed answer is refused with the nearest name."""
    known = names()
    if name in known:
        return FOLDER / name
    if (Path(name) / SEALED).is_file():
        return Path(name)
    raise InputError(f"mystery '{name}': unknown, and no folder with {SEALED}{if_alike(name, known)} (all: {', '.join(known)})")
