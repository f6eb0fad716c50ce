"""The one exception that tells a user that the input is at fault, what counts as a number, and how a value is shown."""

from math import isfinite
from numbers import Real


class InputError(ValueError):
    """The user's input cannot be used; the message names element, value, rule and remedy in one line."""


def is_number(value):
    """Whether this is a finite real number that double precision holds; True and False are none."""
    try:
        return isinstance(value, Real) and not isinstance(value, bool) and isfinite(value)
    except OverflowError:  # a whole number of 400 digits
        return False


def shown(value, most=80):
    """A value as messages show it: on one line, cut where it is long."""
    try:
        text = repr(value)
    except ValueError:  # a whole number of more than 4300 digits
        text = "a number of thousands of digits"
    return text if len(text) <= most else f"{text[:most]}..."
