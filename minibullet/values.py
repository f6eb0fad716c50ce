"""What the values that users write have in common: a short line with units, a table in a notebook, no unknown argument."""

from dataclasses import MISSING, fields
from html import escape
from inspect import CO_VARKEYWORDS

from minibullet.errors import InputError, if_alike, listed, shown_value

LONGEST = 60  # letters of a field that is neither a number nor a word


class Named:
    """A class whose constructor refuses an argument that it does not have, and names the nearest that it has."""

    def __new__(cls, *given, **named):
        code = getattr(cls.__init__, "__code__", None)
        if named and code is not None and not code.co_flags & CO_VARKEYWORDS:
            known = code.co_varnames[1 : code.co_argcount + code.co_kwonlyargcount]
            for name in named:
                if name not in known:
                    takes = if_alike(name, known) or f"; it takes {listed(known) or 'none'}"
                    raise InputError(f"{cls.__name__} has no argument {shown_value(name)}{takes}")
        return super().__new__(cls)


class Value(Named):
    """A frozen dataclass that shows the fields that it does not have by default, each with its unit; in a notebook as a table.

    The unit of a field stands in `_units` or, of a number of an effect, in what is known of it; `_told`: fields that are always
    shown, as those numbers are.
    """

    _units = {}
    _told = ()

    def __init_subclass__(cls, **more):
        super().__init_subclass__(**more)
        cls.__repr__ = cls.__repr__  # a dataclass writes its own only for a class that has none

    def _fields_told(self):
        """(name, value as text, unit) of every field that is shown."""
        rows = []
        for field in fields(self):
            value, number = getattr(self, field.name), field.metadata.get("parameter")
            always = field.name in self._told or number is not None or field.default is MISSING
            if value is None or not field.repr or not always and _equal(value, field.default):
                continue
            unit = number.unit if number is not None else self._units.get(field.name, "")
            rows.append((field.name, _text(value), "" if unit in ("-", "1") else unit))
        return rows

    def __repr__(self):
        told = (f"{name}={value} {unit}".strip() for name, value, unit in self._fields_told())
        return f"{type(self).__name__}({', '.join(told)})"

    def _repr_html_(self):
        return table(type(self).__name__, ("field", "value", "unit"), self._fields_told())


def _equal(value, default):
    try:
        return bool(value == default)
    except ValueError:  # an array is neither equal nor unequal to one number
        return False


def _text(value):
    return f"{value:.6g}" if isinstance(value, float) else shown_value(value, LONGEST)


def table(title, head, rows):
    """A title and a table as HTML, for a notebook; head: names of the columns; rows: of texts, which may hold any letters."""
    names = "".join(f"<th>{escape(name)}</th>" for name in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<p>{escape(title)}</p><table><thead><tr>{names}</tr></thead><tbody>{body}</tbody></table>"
