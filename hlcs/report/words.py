"""Numbers, shares and names as a reader sees them: with units, to the digits that mean something."""

import math

DASH = "-"
AS_IT_IS = "the model as it is agrees with these data, and nothing else need be missing"
TINY = 1e-3  # below which a number with many decimals is told with a power of ten
SMALLER = {"m": ("mm", 1e3), "s": ("ms", 1e3)}  # unit that is used below one


def number(value, unit="", digits=3):
    """A number for reading, a dash where there is none."""
    if value is None:
        return DASH
    text = f"{value:.0f}" if digits == 3 and 1e3 <= abs(value) < 1e6 else f"{value:.{digits}g}"
    return text + (f" {unit}" if unit and unit != "1" else "")


def size(value, unit):
    """An error with its unit, three digits: millimetres below a metre, milliseconds below a second, per cent of a pure number."""
    if value is None:
        return DASH
    if unit == "1":
        return f"{number(100 * value)} %"
    smaller, factor = SMALLER.get(unit, (unit, 1.0))
    if abs(value) < 1.0:
        return f"{number(factor * value)} {smaller}"
    return f"{number(value)} {unit}".rstrip()


def span(ends):
    """Two sizes or shares as one, or from one to the other: "3 mm", "13.2 to 14.5 mm", "900 mm to 1.2 m"."""
    (low, unit), (high, other) = (end.rsplit(" ", 1) if " " in end else (end, "") for end in ends)
    if ends[0] == ends[1]:
        return ends[0]
    return f"{low} to {ends[1]}" if unit == other else f"{ends[0]} to {ends[1]}"


def two_digits(value):
    """A number to two digits without a power of ten, where it is no larger than a million."""
    return f"{float(f'{value:.2g}'):g}"


def share(part):
    """A share in per cent, never rounded up to all of it: "98 %", "99.7 %", "more than 99.9 %"."""
    if part >= 0.9995:
        return "more than 99.9 %"
    return f"{math.floor(1000 * part) / 10:.1f} %" if part > 0.99 else f"{math.floor(100 * part + 1e-9):d} %"


def chance(p, draws=None):
    """A probability; one that is the least that its draws of pure noise can show is told as such."""
    if p is None:
        return "unknown"
    if draws and p <= 1.5 / (draws + 1):
        return f"{1 / (draws + 1):.2g} at most (none of {draws} draws of noise alone was as large)"
    return f"{p:.2g}"


def value(entry):
    """A number of an effect with its 90 % interval and unit, to the digits that the interval leaves."""
    if entry["value"] is None:
        return "withheld"
    unit = "" if entry["unit"] in ("1", "-") else f" {entry['unit']}"
    low, here, high = (entry[key] for key in ("low", "value", "high"))
    half = (high - low) / 2
    if not (math.isfinite(half) and half > 0):
        return f"{here:.6g}{unit}"
    digits = _decimals(half)
    tens = _power(max(map(abs, (low, here, high))), digits)
    low, here, high, half = (_rounded(number / 10.0**tens, digits + tens) for number in (low, here, high, half))
    power = f"e{tens:+03d}" * bool(tens)
    if "mirrored" in entry:  # its other sign would do as well
        other = _rounded(entry["mirrored"] / 10.0**tens, digits + tens)
        return f"{here}{power} or {other}{power} ({low}{power} to {high}{power}){unit}"
    if abs((entry["high"] - entry["value"]) - (entry["high"] - entry["low"]) / 2) > 0.1 * (entry["high"] - entry["low"]):
        return f"{here}{power} ({low}{power} to {high}{power}){unit}"
    return (f"({here} +- {half}){power}" if power else f"{here} +- {half}") + unit


def _power(largest, digits):
    """The power of ten that is taken out of a number and its interval: of what is tiny or huge; 0 for what is read easily."""
    return math.floor(math.log10(largest)) if largest and (digits > 6 and largest < TINY or largest >= 1e6) else 0


def interval(entry):
    """The two ends of an interval, to the digits that it leaves."""
    low, high = entry["low"], entry["high"]
    if low is None or not (math.isfinite(high - low) and high > low):
        return DASH
    digits = _decimals((high - low) / 2)
    tens = _power(max(abs(low), abs(high)), digits)
    low, high = (_rounded(number / 10.0**tens, digits + tens) for number in (low, high))
    power = f"e{tens:+03d}" * bool(tens)
    return f"{low}{power} to {high}{power}"


def _decimals(half):
    """Decimals at which the half width of an interval has two digits."""
    return 1 - math.floor(math.log10(half * (1 + 1e-9)))  # 0.00099999.. is 0.001


def _rounded(number, digits):
    """A number to so many decimals."""
    return f"{round(number, digits) + 0.0:.{max(digits, 0)}f}"  # zero has no sign


def words(name):
    """The name of an effect or a number as words."""
    return name.replace("_", " ")


def joined(items, last="and"):
    """ "a", "a and b", "a, b and c"; last: the word before the last one."""
    items = list(items)
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} {last} {items[-1]}" if items else ""


def change_told(comparison):
    """What was done to the model of a Comparison: "magnus added and quadratic drag corrected"."""
    added = [words(name) for name in comparison.added if name not in comparison.replaced]
    parts = [f"{joined(names)} {done}" for names, done in ((added, "added"), (map(words, comparison.replaced), "corrected"))]
    return joined([part for part, names in zip(parts, (added, comparison.replaced), strict=True) if names])


def capital(sentence):
    """A sentence with its first letter large."""
    return sentence[:1].upper() + sentence[1:]


def note_lines(notes):
    """Notes below a printed report."""
    if not notes:
        return []
    more = [f"  .. and {len(notes) - 12} more (all in the JSON result)"] if len(notes) > 12 else []
    return ["", "Notes on the data", *(f"  {note}" for note in notes[:12]), *more]
