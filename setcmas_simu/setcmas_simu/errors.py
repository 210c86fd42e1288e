"""Base of every error that a user can mend."""


class SetcmasError(Exception):
    """A mistake in what the user gave: the message says what, the value, and what it must be.

    Commands print the message on one line and exit with status 2.
    """
