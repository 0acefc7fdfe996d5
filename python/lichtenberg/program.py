"""Calls of the program, which is a process of its own."""
import subprocess
import tempfile
from pathlib import Path

from .errors import Failure, InputError
from .installation import find_program


def call(*arguments):
    """Returns the output of the program. Throws InputError and Failure with the program's error message."""
    ended = subprocess.run([find_program(), *arguments], capture_output=True, text=True, check=False)
    if ended.returncode == 0:
        return ended.stdout
    sentence = ended.stderr.strip().splitlines()[-1] if ended.stderr.strip() else f"ended with {ended.returncode}"
    raise (InputError if ended.returncode == 2 else Failure)(sentence.removeprefix("lichtenberg: "))


def options_of(settings):
    """Formats options: colour="charge" as --colour=charge, overwrite=True as --overwrite, range=(-1, 1) as --range=-1,1."""
    words = []
    for name, value in settings.items():
        option = "--" + name.replace("_", "-")
        if value is True:
            words.append(option)
        elif isinstance(value, tuple):
            words.append(f"{option}={','.join(map(str, value))}")
        elif value is not None and value is not False:
            words.append(f"{option}={value}")
    return words


class Picture:
    """A picture that Jupyter displays; `save` writes it to a file."""

    def __init__(self, data):
        self.data = data

    def _repr_png_(self):
        return self.data

    def save(self, path):
        Path(path).write_bytes(self.data)


def plot(path, frame, options):
    """Returns the picture that `lichtenberg plot` draws. Throws InputError for the option out: save the picture instead."""
    if "out" in options:
        raise InputError("plot() returns a picture: call its save() in place of the option out")
    with tempfile.TemporaryDirectory(prefix="lichtenberg-") as folder:
        picture = Path(folder) / "picture.png"
        words = options_of({"frame": frame, "out": picture, **options})
        call("plot", path, *words)
        return Picture(picture.read_bytes())
