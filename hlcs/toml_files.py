"""TOML files that a user writes, read so that every complaint is one line: file, line, key, value, remedy."""

import difflib
import re
import tomllib
from pathlib import Path

import numpy as np

from minibullet.errors import InputError

EXAMPLES = {"measurement.noise": "{ position = 0.002 }", "surroundings.floor": "{ height = 0.0 }",
            "trial.start": "{ velocity = [0.0, 0.0, 0.0] }"}


def nearest(name, known):
    """The known name that somebody who wrote `name` most likely meant: the same word, one that begins with it, a like one."""
    lower = name.strip().lower()
    begins = [word for word in known if lower and word.lower().split("_")[0] == lower.split("_")[0]]
    near = difflib.get_close_matches(lower, begins or list(known), n=1, cutoff=0.0)
    return near[0]


class TomlFile:
    """The text of the file beside its values, so that complaints can name the line.

    path; sections: the keys that each section knows, by the section's dotted name ("" = the top of the file).
    """

    def __init__(self, path, sections):
        self.path, self.sections = Path(path), sections
        try:
            self.text = self.path.read_text(encoding="utf-8-sig")  # editors of some systems put a mark before the text
        except OSError as problem:
            why = problem.strerror or problem
            raise InputError(f"{self.path}: cannot be read ({why}); give the path of a TOML file") from None
        except UnicodeDecodeError:
            raise InputError(f"{self.path}: is not text; give the path of a TOML file") from None
        try:
            self.values = tomllib.loads(self.text)
        except tomllib.TOMLDecodeError as problem:
            raise InputError(f"{self.path}: not valid TOML: {problem}") from None

    def line_of(self, key, section="", index=None):
        """Line number (from 1) where the key stands in its section, by a search of the text; None where not found."""
        lines, current, count = self.text.splitlines(), "", -1
        pattern = re.compile(rf"(^|[\s{{,.\[])[\"']?{re.escape(key)}[\"']?\s*[=\].]")
        fallback = None
        for number, line in enumerate(lines, start=1):
            bare = line.split("#", 1)[0]
            header = re.match(r"\s*\[\[?\s*([^\]]+?)\s*\]\]?\s*$", bare)
            if header and "=" not in bare:
                current = header.group(1)
                count += bare.strip().startswith("[[")
            if pattern.search(bare):
                fallback = fallback or number
                if section.startswith(current) and (current or not section) and (index is None or count == index):
                    return number
        return fallback

    def fail(self, key, what, section="", index=None):
        """Raise the one-line complaint about a key."""
        line = self.line_of(key, section, index)
        where = f"{self.path}" + (f", line {line}" if line else "")
        name = f"{section}.{key}" if section else key
        raise InputError(f"{where}: {name}: {what}")

    def known(self, table, section, index=None):
        """Refuse keys that the section does not know, with the nearest that it does."""
        if not isinstance(table, dict):
            parent, _, name = section.rpartition(".")
            like = f" such as {name} = {EXAMPLES[section]}" if section in EXAMPLES else ""
            self.fail(name, f"must be a table{like}, got {table!r}", parent, index)
        for key in table:
            if key not in self.sections[section]:
                near = nearest(key, self.sections[section])
                self.fail(key, f"unknown key; the nearest known key is '{near}'", section, index)

    def number(self, table, key, section, *, low=None, high=None, above=None, default=None, index=None):
        """A finite number within bounds, or the default where the key is left out."""
        if key not in table:
            return default
        value = table[key]
        if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
            self.fail(key, f"must be a finite number, got {value!r}", section, index)
        if above is not None and not value > above:
            self.fail(key, f"must be greater than {above:g}, got {value:g}", section, index)
        if (low is not None and value < low) or (high is not None and value > high):
            bounds = f"at least {low:g}" if high is None else f"between {low:g} and {high:g}"
            self.fail(key, f"must be {bounds}, got {value:g}; units are SI (m, kg, s, rad)", section, index)
        return float(value)

    def vector(self, table, key, section, length, *, above=None, index=None):
        """`length` finite numbers as a tuple, or None where the key is left out."""
        if key not in table:
            return None
        value = table[key]
        good = isinstance(value, list) and len(value) == length and all(
            isinstance(v, int | float) and not isinstance(v, bool) and np.isfinite(v) for v in value)
        if not good:
            self.fail(key, f"must be {length} finite numbers, got {value!r}", section, index)
        if above is not None and min(value) <= above:
            self.fail(key, f"every component must be greater than {above:g}, got {value!r}", section, index)
        return tuple(float(v) for v in value)

    def words(self, table, key, section, allowed=None, default=None, index=None):
        """A string, perhaps one of a few."""
        if key not in table:
            return default
        value = table[key]
        if not isinstance(value, str):
            self.fail(key, f"must be text, got {value!r}", section, index)
        if allowed and value not in allowed:
            near = difflib.get_close_matches(value, allowed, n=1, cutoff=0.0)
            self.fail(key, f"'{value}' is not one of {', '.join(allowed)}; nearest: '{near[0]}'", section, index)
        return value
