"""The two kinds of errors, apart from all that takes time to import."""


class InputError(Exception):
    """Input that cannot be used; its text is one sentence."""


class Failure(Exception):
    """Work that could not be done; its text is one sentence."""
