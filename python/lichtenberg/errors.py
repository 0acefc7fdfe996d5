"""The two kinds of errors, apart from all that takes time to import."""


class InputError(Exception):
    """Input that cannot be used. The text is one error message."""


class Failure(Exception):
    """Work that could not be done. The text is one error message."""
