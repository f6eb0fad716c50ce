"""Numbers in tables: a dash where there is none."""

from math import isfinite


def or_dash(value, form):
    """A number in a form, "-" where there is none."""
    return format(value, form) if value is not None and isfinite(value) else "-"


def percent(value, form=".2f"):
    """A share as a percentage, "-" where there is none."""
    return or_dash(100 * value if value is not None else None, form)


def chance(probability):
    """A probability as a percentage, never 100 nor 0: no finite number of runs shows either."""
    return ">99.9" if probability > 0.9995 else "<0.1" if probability < 0.0005 else percent(probability, ".1f")
