"""The two kinds of errors, in a module without imports that take time."""
import re


class InputError(Exception):
    """Invalid input. The text is one error message. `file`, `line` and `key` name the place in a scene, where the message
    does; otherwise they are None."""

    PLACE = re.compile(r"(?:(?P<file>[^\n]*?\.toml|scene)(?::(?P<line>\d+))?: )?"
                       r"(?:key )?(?P<key>[a-z_]+(?:\[\d+\])?(?:\.[a-z_0-9]+)+\b(?!:))?")

    def __init__(self, message=""):
        super().__init__(message)
        found = self.PLACE.match(str(message))
        self.file, self.key = found["file"], found["key"]
        self.line = int(found["line"]) if found["line"] else None


class Failure(Exception):
    """Work that did not succeed. The text is one error message."""
