"""Base class of errors that users can correct."""


class SetcmasError(Exception):
    """Wrong user input: the message has the value, what it must be, and what to do next.

    Commands print the message on one line and exit with status 2.
    """
