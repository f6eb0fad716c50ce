"""What can go wrong, in two classes: the input is at fault, or it is not."""


class InputError(ValueError):
    """The user's input cannot be used; the message names element, value, rule and remedy in one line."""


class RunError(RuntimeError):
    """Work could not be finished through no fault of the input: a full disk, a killed worker, a lost scheduler.

    The message says in one line what happened, what is kept and what to do; `result`, where it is not None, is the text of
    what could be kept nowhere else, to be printed.
    """

    def __init__(self, message, result=None):
        super().__init__(message)
        self.result = result
