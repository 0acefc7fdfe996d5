"""The two kinds of errors, in a module without imports that take time."""
import re


class InputError(Exception):
    """Invalid input. The text is one error message. `file`, `line` and `key` name the place in a scene, where the message
    does; otherwise they are None."""

    KEY = r"(?P<key>[a-z_]+(?:\[\d+\])?(?:\.[a-z_0-9]+)*)"
    POSITION = re.compile(rf"(?P<file>[^\n]*?\.toml|scene)(?::(?P<line>\d+)(?::\d+)?)?: (?:{KEY} (?:=|is missing))?")
    SETTING = re.compile(rf"key {KEY}:")

    def __init__(self, message=""):
        super().__init__(message)
        match = (self.POSITION.match(str(message)) or self.SETTING.match(str(message)) or re.match("", "")).groupdict()
        self.file, self.key = match.get("file"), match.get("key")
        self.line = int(match["line"]) if match.get("line") else None


class Failure(Exception):
    """Work that did not succeed. The text is one error message."""
