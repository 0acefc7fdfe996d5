"""Calls of the program from Python, which return numpy arrays. The program is a process of its own, with --json."""
import json
import subprocess
import tempfile
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from .errors import Failure, InputError
from .installation import find_program
from .result import load


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


def toml(value):
    """Formats a Python or numpy value as TOML, a table in one line."""
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(str(key))} = {toml(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml(entry) for entry in value) + "]"
    if isinstance(value, (bool, str)):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, (int, float)):
        return repr(value)
    raise InputError(f"a scene cannot hold {type(value).__name__}")


def conductors(position, **columns):
    """Returns arrays as a scene's list of conductors: position [N, 2] or [N, 3], and radius, charge and so on, [N]
    or one value for all."""
    position = np.asarray(position)
    if position.ndim != 2 or position.shape[1] not in (2, 3):
        raise InputError(f"positions of conductors are [N, 2] or [N, 3], and these have the shape {list(position.shape)}")
    for name, values in columns.items():
        if np.shape(values) not in ((), (len(position),)):
            raise InputError(f"{name} has the shape {list(np.shape(values))}: one number, or one of each of {len(position)}")
    spread = {name: np.broadcast_to(values, len(position)) for name, values in columns.items()}
    return [{"position": position[i], **{name: values[i] for name, values in spread.items()}} for i in range(len(position))]


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
        path.write_text("".join(f"{key} = {toml(value)}\n" for key, value in self.scene.items()), encoding="utf-8")
        return str(path)

    def __exit__(self, *_):
        if self.folder:
            self.folder.cleanup()


def solve(scene, **options):
    """Solves the field of a scene once, as `lichtenberg solve` does, whose options these are (capacitance=True and so
    on). The scene is a path, or a dictionary with the keys of a scene file, arrays allowed.

    Returns an object with the arrays potential, charge, radius, group [N], force, position [N, 2] or [N, 3], in SI units. It
    has all other entries of `solve --json` by their names there. With capacitance=True it has capacitance.matrix, whose rows
    `group` counts, and capacitance.groups, their names. Charged grains have no group, and dipole [N, 3] if they are polarized; their units
    are the scene's reduced ones, by name in units.
    Throws InputError and Failure."""
    with SceneFile(scene) as path:
        answer = json.loads(call("solve", path, "--json", *options_of(options)))
    rows = answer.pop("conductors")
    names = rows[0] if rows else ("position", "radius", "group", "potential", "charge", "force")
    columns = {name: np.array([row[name] for row in rows]) for name in names}
    if "capacitance" in answer:
        capacitance = {**answer["capacitance"], "matrix": np.array(answer["capacitance"]["matrix"])}
        answer["capacitance"] = SimpleNamespace(**capacitance)
    return SimpleNamespace(**answer, **columns)


def run(scene, out, **options):
    """Runs a scene (given as for `solve`) like `lichtenberg run --out` and returns its Result."""
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
