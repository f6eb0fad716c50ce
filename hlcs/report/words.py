"""Words and numbers of printed reports, in the manner of a fit report."""


def number(value, unit="", digits=3):
    """A number for reading, a dash where there is none."""
    if value is None:
        return "-"
    return f"{value:.{digits}g}" + (f" {unit}" if unit and unit != "1" else "")


def where_lines(rows, unit):
    keys = [key for key in rows[0] if key not in ("rms", "sigma", "phase" if "layer" in rows[0] else "")]
    rms = "rms" if unit in ("", "1") else f"rms {unit}"
    head = "  " + " ".join(f"{key:>{_width(key)}s}" for key in keys) + f" {rms:>12s} {'in sigma':>9s}"
    cells = ["  " + " ".join(f"{_cell(row[key]):>{_width(key)}s}" for key in keys) for row in rows]
    return [head] + [text + f" {row['rms']:12.4g} {row['sigma']:9.2f}" for text, row in zip(cells, rows, strict=True)]


def _cell(value):
    return f"{value:.4g}" if isinstance(value, float) else str(value)[-24:]


def _width(key):
    return 24 if key == "trial" else 9


def note_lines(notes):
    if not notes:
        return []
    more = [f"  .. and {len(notes) - 12} more (all in the JSON result)"] if len(notes) > 12 else []
    return ["", "Notes on the data", *(f"  {note}" for note in notes[:12]), *more]
