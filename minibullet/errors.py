"""What can go wrong, in two classes: the input is at fault, or it is not; and how messages quote what they were given."""

import difflib
from math import isfinite
from numbers import Real

LIKE = 0.5  # likeness of two names, 0 to 1, below which the one tells nothing of the other
MOST_TOLD = 14  # names that a message lists
LONGEST_NAME = 100  # letters of a name that is looked for in a text, or among known names


class InputError(ValueError):
    """The user's input cannot be used; the message names element, value, rule and remedy in one line."""


class InputWarning(UserWarning):
    """The user's input can be used but is hardly what was meant; the message names element, value, and what is usual."""


class RunError(RuntimeError):
    """Work could not be finished through no fault of the input: a full disk, a killed worker, a lost scheduler.

    The message says in one line what happened, what is kept and what to do; `result`, where it is not None, is the text of
    what could be kept nowhere else, to be printed.
    """

    def __init__(self, message, result=None):
        super().__init__(message)
        self.result = result


def is_number(value):
    """Whether this is a finite real number that double precision holds; True and False are none."""
    try:
        return isinstance(value, Real) and not isinstance(value, bool) and isfinite(value)
    except OverflowError:  # a whole number of 400 digits
        return False


def shown(text, most=60):
    """What a message quotes of a file: so many characters at most, those that a terminal would obey or hide as escapes."""
    text = str(text)
    head = "".join(one if one.isprintable() else one.encode("unicode_escape").decode() for one in text[:most])
    return head + ".." * (len(text) > most)


def shown_value(value, most=80):
    """A value as messages show it: as Python writes it, on one line, cut where it is long."""
    try:
        return shown(repr(value), most)
    except ValueError:  # a whole number of more than 4300 digits
        return "a number of thousands of digits"


def how_many(count, noun):
    """A number of things: "1 row", "2 rows"."""
    return f"{count} {noun}{'s' * (count != 1)}"


def nearest(name, known, least=0.0):
    """The known name that somebody who wrote `name` most likely meant: the same word, one that begins with it, a like one.

    least: how alike it has to be, from 0 to 1; None where no name is.
    """
    lower, words = str(name)[:LONGEST_NAME].strip().lower(), {word.lower(): word for word in known}
    begins = [word for word in words if lower and word.split("_")[0] == lower.split("_")[0]]
    near = difflib.get_close_matches(lower, begins or list(words), n=1, cutoff=least)
    return words[near[0]] if near else None


def one_of(name, known, words="it must be one of"):
    """The end of a message on a name that is none of the known ones: what it may be, and which word was most likely meant."""
    return f"{words} {', '.join(known)}{if_alike(name, known) if isinstance(name, str) else ''}"


def known_one(name, known, told="the nearest known key is"):
    """The end of a message on a name that is not known: the nearest that is, or all of them where none is like it."""
    if near := nearest(name, known, LIKE):
        return f"{told} '{near}'"
    return f"known are {listed(known)}"


def listed(known):
    """Names as messages list them, the first of many."""
    known = list(known)
    return ", ".join(known[:MOST_TOLD]) + ", .." * (len(known) > MOST_TOLD)


def if_alike(name, known):
    """The end of a message where other words than the known ones may be right too: what was meant, if one of them is alike."""
    near = nearest(name, known, LIKE)
    return f"; did you mean '{near}'?" if near else ""
