"""The error for an instrument that does not do what it should."""


class InstrumentError(Exception):
    """The instrument, or the link to it, failed: told in one line that says what was asked.

    The command prints the line and ends with exit status 1.
    """
