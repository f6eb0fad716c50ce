"""What tells a user that the input is at fault, or may be."""


class InputError(ValueError):
    """The user's input cannot be used; the message names element, value, rule and remedy in one line."""


class InputWarning(UserWarning):
    """The user's input can be used but is hardly what was meant; the message names element, value, and what is usual."""
