"""Tables as CSV text that a spreadsheet only shows: no cell of it is a formula there."""

STARTS = ("=", "+", "-", "@", "\t", "\r")  # what spreadsheets take for the beginning of a formula


def csv_text(frame):
    """The CSV text of a DataFrame without its index; a word that would be a formula gets an apostrophe before it."""
    words = {name: frame[name].map(_shown) for name in frame if frame[name].dtype.kind not in "biuf"}
    return frame.assign(**words).rename(columns=_shown).to_csv(index=False)


def _shown(cell):
    """The cell; with an apostrophe where it is text that begins a formula. A number, written as text or not, is itself."""
    if not isinstance(cell, str) or not cell.startswith(STARTS):
        return cell
    try:
        float(cell)
    except ValueError:
        return "'" + cell
    return cell
