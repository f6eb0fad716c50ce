"""The one exception that tells a user that the input is at fault."""


class InputError(ValueError):
    """The user's input cannot be used; the message names element, value, rule and remedy in one line."""
