"""TOML files that a user writes, read so that every complaint is one line: file, line, key, value, remedy.

The same values may be given in Python, where no file is: complaints then name the key and no line.

Nothing in the text can make the reader slow, or fail in another way: it is bounded in size and depth before it is parsed.
"""

import copy
import os
import re
import tomllib
import warnings
from pathlib import Path

from hlcs.files import limits
from hlcs.files.limits import LARGEST
from hlcs.files.other_words import in_place_of
from minibullet.errors import LONGEST_NAME, InputError, InputWarning, if_alike, is_number, known_one, nearest, shown, shown_value
from minibullet.files.reading import read_text

EXAMPLES = {
    "measurement.noise": "{ position = 0.002 }",
    "measurement.input_sd": "{ height_m = 0.01 }",
    "surroundings.floor": "{ height = 0.0 }",
    "trial.start": "{ velocity = [0.0, 0.0, 0.0] }",
}
MOST_BYTES = 2_000_000  # ten thousand recordings with starts of their own; read in 2 s
MOST_DEPTH = 16  # of tables and lists in each other; files of ours have 4
ALIKE = 0.75  # likeness of two keys, 0 to 1, from which one is taken for the other misspelt
REMEDIES = {  # what stands in a line that is no TOML -> what is to be written in its place
    r"=[^\"'#]*(?<![\w.])[+-]?(\.\d|\d+\.(?!\d))": "a number has digits on both sides of its point, 0.1 or 1.0",
    r"=[^\"']*\d,\d+\s*(#|}|$)": "decimals have a point, 0.5",
    r"=\s*(?i:yes|no|on|off|true|false)\s*(#|$)": "write true or false, in small letters",
    r"=\s*[+-]?\d[\d.]*(e[+-]?\d+)?\s*[a-df-zµ%°]": "numbers stand without units: kg, m, s, rad, or as the name of the key says",
    r"(?<!:)//": "a remark begins with #",
    r"^[^\"']*\"[^\"]*$": "a text ends with the quote that it begins with",
    r"\\": "between folders write /, also on Windows",
    r"^[\w. -]+:": 'write key = value, and texts between quotes, such as kind = "trajectory"',
    r"=\s*(?!true|false|inf|nan)[^\s\d\"'\[{.+-]": 'texts stand between quotes, such as shape = "sphere"',
    r"^\[": "a table stands once; [[trial]] begins one of several",
}
TABLES = (".csv", ".tsv", ".txt")
# A name of more parts than that: reading takes time as the square of their number.
_PART = r"""(?:[A-Za-z0-9_-]++|"[^"\n]*+"|'[^'\n]*+')"""
DOTTED = re.compile(rf"(?<![A-Za-z0-9_-])(?:{_PART}[ \t]*+\.[ \t]*+){{{MOST_DEPTH}}}")
CONTROLS = re.compile("[\x00-\x1f\x7f-\x9f]")


class TomlFile:
    """The text of the file beside its values, so that complaints can name the line.

    path; sections: the keys that each section knows, by the section's dotted name ("" = the top of the file); allow_outside:
    whether it may name files outside its own folder.
    """

    def __init__(self, path, sections, allow_outside=False):
        self.path, self.sections, self.allow_outside = Path(path), sections, allow_outside
        self.text = read_text(self.path, str(self.path), MOST_BYTES, "split the file up")
        self.tables, self._told = {}, set()
        if DOTTED.search(self.text):
            raise InputError(f"{self.path}: a name of more than {MOST_DEPTH} parts with points between them; {self._deep()}")
        try:
            self.values = tomllib.loads(self.text)
        except tomllib.TOMLDecodeError as problem:
            table = self.path.suffix.lower() in TABLES
            hint = "; a table is no experiment file: write one that names it, or let `hlcs import` write it" if table else ""
            raise InputError(f"{self.path}: not valid TOML: {shown(problem, 200)}{self._at_fault(str(problem))}{hint}") from None
        except RecursionError:
            raise InputError(f"{self.path}: not valid TOML: {self._deep()}") from None
        except ValueError:  # Python's own bound of the digits of a whole number
            raise InputError(f"{self.path}: not valid TOML: a whole number of thousands of digits; TOML has 64 bits") from None
        self._check_values()

    @classmethod
    def of_values(cls, name, values, sections, tables):
        """The same for values that stand in no file.

        name: what messages call it; values: as TOML would give them; tables: {name: CsvText} of what they name as files.
        """
        file = cls.__new__(cls)
        file.path, file.sections, file.allow_outside = Path(name), sections, True
        file.values, file.text, file.tables, file._told = values, "", tables, set()
        file._check_values()
        return file

    def with_values(self, values):
        """The same file with other values; lines are still those of its text."""
        changed = copy.copy(self)
        changed.values = values
        return changed

    def _at_fault(self, problem):
        """The line that a complaint of the parser is about, and what is to be written there in its place."""
        found = re.search(r"at line (\d+)", problem)
        lines = self.text.split("\n")
        line = lines[int(found[1]) - 1].strip() if found else ""
        if "overwrite a value" in problem and "=" in line:
            key = line.split("=")[0].strip()
            alike = (number for number in range(int(found[1]) - 1, 0, -1) if lines[number - 1].split("=")[0].strip() == key)
            before = next((f", first in line {number}" for number in alike), "")
            return f": '{shown(line, 80)}'; {shown(key)} stands twice{before}: keep one of the two"
        remedy = next((remedy for pattern, remedy in REMEDIES.items() if re.search(pattern, line)), "")
        return (f": '{shown(line, 80)}'" if line else "") + (f"; {remedy}" if remedy else "")

    def _deep(self):
        return f"tables and lists stand in each other at most {MOST_DEPTH} deep: write what is meant without so many"

    def _check_values(self):
        """Refuse what TOML does not grant: whole numbers beyond 64 bits; and nesting that nothing here can mean."""
        waiting = [("", self.values, 0)]
        while waiting:
            name, value, depth = waiting.pop()
            if depth > MOST_DEPTH:
                raise InputError(f"{self.path}: {shown(name)}: {self._deep()}")
            if isinstance(value, dict):
                waiting += [(key, entry, depth + 1) for key, entry in value.items()]
            elif isinstance(value, list):
                waiting += [(name, entry, depth + 1) for entry in value]
            elif isinstance(value, int) and not -(2**63) <= value < 2**63:
                line = self.line_of(name)
                where = f"{self.path}" + (f", line {line}" if line else "")
                raise InputError(
                    f"{where}: {shown(name)}: a whole number of {value.bit_length()} bits; TOML has 64: write a "
                    "smaller one, or one with a point"
                )

    def line_of(self, key, section="", index=None):
        """Line number (from 1) where the key stands in its section, by a search of the text; None where not found."""
        if len(key) > LONGEST_NAME:
            return None
        current, count, fallback = "", -1, None
        pattern = re.compile(rf"(^|[\s{{,.\[])[\"']?{re.escape(key)}[\"']?\s*[=\].]")
        for number, line in enumerate(self.text.split("\n"), start=1):
            bare = line.split("#", 1)[0].strip()
            if bare.startswith("[") and bare.endswith("]") and "=" not in bare:
                current = bare.strip("[]").strip()
                count += bare.startswith("[[")
            if key in bare and pattern.search(bare):
                fallback = fallback or number
                if section.startswith(current) and (current or not section) and (index is None or count == index):
                    return number
        return fallback

    def fail(self, key, what, section="", index=None):
        """Raise the one-line complaint about a key."""
        raise InputError(self._at(key, what, section, index))

    def warn(self, key, what, section="", index=None):
        """Tell of a value that is hardly meant, of each key once."""
        if (key, what) not in self._told:
            self._told.add((key, what))
            warnings.warn(self._at(key, what, section, index), InputWarning, stacklevel=2)

    def _at(self, key, what, section, index):
        line = self.line_of(key, section, index)
        where = f"{self.path}" + (f", line {line}" if line else "")
        name = f"{section}.{key}" if section else key
        return f"{where}: {shown(name)}: {what}"

    def title(self):
        """The title on one line, the file's name where there is none."""
        return " ".join(self.words(self.values, "title", "", default=shown(self.path.stem, 200)).split())[:200]

    def file_of(self, name, key, section, index=None):
        """The path of a file that this one names: a regular file, and under this file's folder if not allowed otherwise;
        the table of that name where it was given in Python."""
        if name in self.tables:
            return self.tables[name]
        if CONTROLS.search(name):
            self.fail(key, f"'{shown(name)}' is no name of a file: it holds a control character", section, index)
        path = self.path.parent / name
        inside = Path(os.path.realpath(path)).is_relative_to(os.path.realpath(self.path.parent))
        if not inside and not self.allow_outside:
            self.fail(
                key,
                f"'{shown(name)}' lies outside the folder of this file; put it there, or allow it with "
                "--allow-outside (in Python: allow_outside=True)",
                section,
                index,
            )
        if os.path.isdir(path):
            self.fail(key, f"'{shown(name)}' is a folder; name a file in it", section, index)
        if not os.path.isfile(path):
            slash = "; between folders write /, also on Windows" if "\\" in name else ""
            self.fail(key, f"file '{shown(name)}' is not there (looked for {shown(path, 200)}){slash}", section, index)
        return path

    def known(self, table, section, index=None):
        """Refuse keys that the section does not know, with the nearest that it does."""
        if not isinstance(table, dict):
            parent, _, name = section.rpartition(".")
            like = f" such as {name} = {EXAMPLES[section]}" if section in EXAMPLES else ""
            self.fail(name, f"must be a table{like}, got {shown_value(table)}", parent, index)
        for key in table:
            if key not in self.sections[section]:
                self.fail(key, self._unknown(key, section), section, index)

    def _unknown(self, key, section):
        """What is said of an unknown key: what to write in its place, where it belongs, or the nearest key that the section
        knows."""
        if told := in_place_of(key):
            return f"unknown key; {told}"
        if not nearest(key, self.sections[section], ALIKE):
            for other, keys in self.sections.items():
                if other and (near := nearest(key, keys, ALIKE)):
                    return f"unknown key here; '{near}' stands under [{other}]"
        return f"unknown key; {known_one(key, self.sections[section])}"

    def number(self, table, key, section, *, low=-LARGEST, high=LARGEST, above=None, index=None):
        """A finite number within bounds, None where the key is left out."""
        if key not in table:
            return None
        value = table[key]
        if not is_number(value):
            self.fail(key, f"must be a finite number, got {shown_value(value)}", section, index)
        if above is not None and not value > above:
            self.fail(key, f"must be greater than {above:g}, got {value:g}", section, index)
        if not low <= value <= high:
            lowest = f"between {low:g} and" if above is None or value < low else f"greater than {above:g} and at most"
            self.fail(key, f"must be {lowest} {high:g}, got {value:g}; units are SI (m, kg, s, rad)", section, index)
        if said := limits.unlikely(key, value):
            self.warn(key, said, section, index)
        return float(value)

    def flag(self, table, key, section):
        """true or false; false where the key is left out."""
        value = table.get(key, False)
        if not isinstance(value, bool):
            self.fail(key, f"must be true or false, got {shown_value(value)}", section)
        return value

    def vector(self, table, key, section, length, *, low=-LARGEST, high=LARGEST, index=None):
        """`length` finite numbers within bounds as a tuple, or None where the key is left out."""
        if key not in table:
            return None
        value = table[key]
        if not (isinstance(value, list) and len(value) == length and all(map(is_number, value))):
            self.fail(key, f"must be {length} finite numbers, got {shown_value(value)}", section, index)
        if not low <= min(value) <= max(value) <= high:
            bounds = f"between {low:g} and {high:g}"
            self.fail(key, f"every component must be {bounds}, got {shown_value(value)}; units are SI", section, index)
        return tuple(float(v) for v in value)

    def words(self, table, key, section, allowed=None, default=None, index=None):
        """A string, perhaps one of a few."""
        if key not in table:
            return default
        value = table[key]
        if not isinstance(value, str):
            self.fail(key, f"must be text, got {shown_value(value)}", section, index)
        if allowed and value not in allowed:
            self.fail(key, f"'{shown(value)}' is not one of {', '.join(allowed)}{if_alike(value, allowed)}", section, index)
        return value
