"""What a case is made of, and how it is written to disk as a user would write it (experiment.toml and CSV files)."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

START_KEYS = ("position", "orientation", "velocity", "angular_velocity")


@dataclass(frozen=True)
class Trial:
    """One recording to be made. All vectors in the world frame, SI; `times` as the recorder stamps them, from the release
    at 0."""

    group: str
    start: dict  # true start: position (3,), orientation (4,) w x y z, velocity (3,), angular_velocity (3,)
    known: tuple[str, ...]  # what of the start the experimenter states; the rest has to be fitted
    times: np.ndarray  # (n,) s
    overrides: dict = field(default_factory=dict)  # per-trial [body] and [surroundings] keys, nominal
    own: dict = field(default_factory=dict)  # what an outside effect does in this trial only: phase, time of the gust, ...
    tangents: tuple = ()  # unit vectors in which an unknown start may be shifted; () = all three axes


@dataclass(frozen=True)
class Setup:
    """An experiment before anything is hidden: what the user writes, and how nature moves the body."""

    family: str
    title: str
    shape: dict  # [body] without mass: shape and its size
    inputs: dict  # numbers nature needs: mass, radius, volume, gravity, friction, ...; nominal
    surroundings: dict  # [surroundings] as written
    model: tuple[dict, ...]  # [model] effects already in the model under test
    trials: tuple[Trial, ...]
    columns: tuple[str, ...]  # subset of x_m y_m z_m, and "q" for the four of the quaternion
    simulate: object  # function (trial, inputs, effects, start, times, step) -> position (n,3), orientation (n,4) or None
    rivals: tuple[str, ...]  # library effects that act in this family
    errors: tuple[str, ...] = ("mass", "size", "tilt_x", "tilt_y")  # nominal inputs that may be slightly wrong
    holds: object = None  # function (trial, inputs, effects, times) -> is `simulate` true at all times; None = always

    def base(self):
        """Effects of the model under test as {name: parameters}."""
        return {entry["name"]: {k: v for k, v in entry.items() if k != "name"} for entry in self.model}

    def trimmed(self, keep):
        """The same experiment with fewer trials."""
        return replace(self, trials=tuple(self.trials[i] for i in keep))


def value_text(value):
    """A Python value as TOML text."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {value_text(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, list | tuple | np.ndarray):
        return "[" + ", ".join(value_text(entry) for entry in value) + "]"
    if isinstance(value, int | np.integer):
        return str(int(value))
    return repr(float(f"{float(value):.8g}") + 0.0)  # + 0.0 makes -0.0 a plain zero


def toml_text(tables):
    """TOML text of {section: {key: value}}; section "" comes first, a list of dicts becomes [[section]]."""
    lines = [f"{key} = {value_text(value)}" for key, value in tables.get("", {}).items()]
    for section, entries in tables.items():
        for entry in entries if isinstance(entries, list) else [entries]:
            if section and entry:
                lines += ["", f"[[{section}]]" if isinstance(entries, list) else f"[{section}]"]
                lines += [f"{key} = {value_text(value)}" for key, value in entry.items()]
    return "\n".join(lines) + "\n"


def csv_text(columns, rows, digits=6):
    """CSV text; rows (n, len(columns)) of numbers or strings, NaN = blank."""

    def cell(value):
        if isinstance(value, str | int | np.integer):
            return str(value)
        return "" if np.isnan(value) else f"{value:.{digits}f}"

    return "\n".join([",".join(columns)] + [",".join(cell(value) for value in row) for row in rows]) + "\n"


def write_case(folder, files):
    """Write {name: text} into the folder."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
