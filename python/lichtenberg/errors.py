"""The two kinds of errors, in a module without imports that take time."""


class InputError(Exception):
    """Invalid input. The text is one error message."""


class Failure(Exception):
    """Work that did not succeed. The text is one error message."""
