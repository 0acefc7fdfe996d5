"""Calls of the program, which is a process of its own."""
import subprocess
import tempfile
from pathlib import Path

from .errors import Failure, InputError
from .installation import find_program
from .result import load
from .scene import text_of, toml


def call(*arguments):
    """Returns the output of the program. Throws InputError and Failure with the program's error message."""
    ended = subprocess.run([find_program(), *arguments], capture_output=True, text=True, check=False)
    if ended.returncode == 0:
        return ended.stdout
    sentence = ended.stderr.strip().splitlines()[-1] if ended.stderr.strip() else f"ended with {ended.returncode}"
    raise (InputError if ended.returncode == 2 else Failure)(sentence.removeprefix("lichtenberg: "))


def options_of(settings):
    """Formats options: accuracy=1e-3 as --accuracy=1e-3, capacitance=True as --capacitance, range=(-1, 1) as
    --range=-1,1, and set={"field.cells": 64, ...} or set=["field.cells=64", ...] as --set=field.cells=64 and so on."""
    words = []
    for name, value in settings.items():
        option = "--" + name.replace("_", "-")
        if value is True:
            words.append(option)
        elif isinstance(value, dict):
            words += [f"{option}={key}={toml(entry)}" for key, entry in value.items()]
        elif isinstance(value, tuple):
            words.append(f"{option}={','.join(map(str, value))}")
        elif isinstance(value, list):
            words += [f"{option}={entry}" for entry in value]
        elif value is not None and value is not False:
            words.append(f"{option}={value}")
    return words


class SceneFile:
    """Path of a scene, for use with `with`. The scene is a path, or a dictionary with the keys of a scene file. A dictionary is
    written to a temporary file."""

    def __init__(self, scene):
        self.scene, self.folder = scene, None

    def __enter__(self):
        if not isinstance(self.scene, dict):
            return str(self.scene)
        self.folder = tempfile.TemporaryDirectory(prefix="lichtenberg-")
        path = Path(self.folder.name) / "scene.toml"
        path.write_text(text_of(self.scene), encoding="utf-8")
        return str(path)

    def __exit__(self, *_):
        if self.folder:
            self.folder.cleanup()


def run(scene, out, **options):
    """Runs a scene, a path or a dictionary with the keys of a scene file, as `lichtenberg run --out` does, in a process of
    its own. Returns its Result."""
    with SceneFile(scene) as path:
        call("run", path, "--out", str(out), "--quiet", *options_of(options))
    return load(out)


class Picture:
    """A picture that Jupyter displays; `save` writes it to a file."""

    def __init__(self, data):
        self.data = data

    def _repr_png_(self):
        return self.data

    def save(self, path):
        Path(path).write_bytes(self.data)


def plot(path, frame, options):
    with tempfile.TemporaryDirectory(prefix="lichtenberg-") as folder:
        picture = Path(folder) / "picture.png"
        words = options_of({"frame": frame, "out": picture, **options})
        call("plot", path, *words)
        return Picture(picture.read_bytes())
