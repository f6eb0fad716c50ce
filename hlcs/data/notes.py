"""Notes that a report does more with than print: what such a note is stands in its class, its words are for reading only."""


class Note(str):
    """A note of a kind of its own, in all else a text as the other notes are."""

    @classmethod
    def among(cls, notes):
        """Those of some notes that are of this kind."""
        return [note for note in notes if isinstance(note, cls)]


class Stopped(Note):
    """Ctrl-C ended the search before all sets of effects were fitted."""


class OutOfTime(Note):
    """Sets of effects that might do as well were not fitted, to keep within the limit of time."""


class AsItIs(Note):
    """The model as it is agrees with the data if the setup was another than stated, as no effect of the library says."""
