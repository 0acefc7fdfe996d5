"""Scenes in memory, from files, dictionaries or keyword tables."""
import json
import os
import warnings
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from . import core
from .errors import InputError


def quoted(text):
    """Formats a text as a TOML string."""
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:
        raise InputError(f"the text {text!a} is no valid Unicode") from None
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def toml(value):
    """Formats a Python or numpy value as TOML, a table in one line. Throws InputError for values that TOML cannot hold."""
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if isinstance(value, np.floating):  # a long double, which has no Python type
        value = float(value)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{quoted(key)} = {toml(entry)}" for key, entry in texts(value).items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml(entry) for entry in value) + "]"
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int) and not -(2**63) <= value < 2**63:
        raise InputError(f"the integer {value} is too large for a scene")
    if isinstance(value, (int, float)):
        return repr(value)
    raise InputError(f"a scene cannot hold {type(value).__name__}")


def texts(mapping):
    """Returns the mapping. Throws InputError for a key that is no text."""
    for key in mapping:
        if not isinstance(key, str):
            raise InputError(f"{key!r} is no key of a scene: keys are texts")
    return mapping


def text_of(tables):
    """Returns the text of a scene file with these keys."""
    return "".join(f"{quoted(key)} = {toml(value)}\n" for key, value in texts(tables).items())


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


def settings_of(settings):
    """Returns settings as a list of pairs of texts. `settings`: a dictionary of keys and values, one text "key=value" as
    of --set, or a list of such texts."""
    if settings is None:
        return []
    if isinstance(settings, Mapping):
        return [(key, toml(value)) for key, value in texts(settings).items()]
    words = [settings] if isinstance(settings, str) else settings
    if not isinstance(words, (list, tuple)) or not all(isinstance(word, str) for word in words):
        raise InputError(f'{settings!r} are no settings: give a dictionary, or texts like "field.cells=64"')
    return [core.load().setting_of(word) for word in words]


def text_of_file(path):
    """Returns the text of a scene file."""
    try:
        return Path(path).read_text(encoding="utf-8")
    except FileNotFoundError:
        raise InputError(f"{os.fspath(path)}: there is no such scene file") from None
    except OSError as error:
        raise InputError(f"{os.fspath(path)}: the scene file cannot be read ({error.strerror})") from None
    except UnicodeDecodeError:
        raise InputError(f"{os.fspath(path)}: the scene file is no text in UTF-8") from None


class Scene:
    """A checked scene: a value that later changes of its source do not affect.

    source: path of a scene file, or a dictionary with the keys of a scene file. Arrays are allowed. Without a source the
        keyword arguments are the tables.

    Settings are keys that replace those of the source, as {"mechanics.position_tolerance": 1e-6}.

    compiled: effects of compile_effect(), whose tables the scene has.

    Throws InputError that names file, line and key. Warns about former names of keys."""

    def __init__(self, source=None, settings=None, compiled=(), **tables):
        if source is None and not tables:
            raise InputError("a scene needs a path, a dictionary, or keyword tables")
        if source is not None and tables:
            raise InputError(f"a scene with a source has no keyword tables, as {next(iter(tables))}: put them into the source")
        if source is None or isinstance(source, Mapping):
            text, name = text_of(tables if source is None else source), "scene"
        elif isinstance(source, (str, os.PathLike)):
            text, name = text_of_file(source), os.fspath(source)
        else:
            raise InputError(f"a {type(source).__name__} is no scene: give a path or a dictionary")
        self._read(text, name, settings_of(settings), list_of_effects(compiled))
        for warning in self._core.warnings:
            warnings.warn(warning, stacklevel=2)

    def _read(self, text, name, settings, compiled):
        self._name, self._compiled = name, compiled
        try:
            self._core = core.load().Scene.from_text(text, name, settings, compiled)
        except InputError as error:
            if error.key == "mechanics.integrator" and "must be one of" in str(error):
                raise InputError(f"{error}; integrators that a C++ program adds are unknown to this Python module") from None
            raise
        for effect in compiled:
            if effect.name not in self._core.effects:
                raise InputError(f"{name}: the scene has no table [effects.{effect.name}] for the compiled effect")

    def changed(self, settings):
        """Returns the scene with further settings."""
        scene = Scene.__new__(Scene)
        scene._read(self.text, self._name, settings_of(settings), self._compiled)
        return scene

    def __reduce__(self):
        if self._compiled:
            raise InputError("a scene with compiled effects cannot be pickled: compile them in the other process")
        return from_text, (self.text, self._name)

    @property
    def text(self):
        """Text of the scene with its settings."""
        return self._core.text

    @property
    def title(self):
        return self._core.title

    @property
    def dimension(self):
        return self._core.dimension

    @property
    def is_granular(self):
        """True for a scene of grains, whose units are its reduced ones."""
        return self._core.grains

    def __len__(self):
        """Number of bodies."""
        return self._core.body_count

    def __repr__(self):
        return f"<scene {self.title or 'without title'}: {len(self)} bodies in {self.dimension} dimensions>"


def from_text(text, name):
    scene = Scene.__new__(Scene)
    scene._read(text, name, [], [])
    return scene


def list_of_effects(compiled):
    kind = core.load().CompiledEffect
    effects = [compiled] if isinstance(compiled, kind) else compiled
    if not isinstance(effects, (list, tuple)) or not all(isinstance(effect, kind) for effect in effects):
        raise InputError(f"{compiled!r} is no list of effects of compile_effect()")
    return list(effects)


def scene_of(scene, settings=None):
    """Returns a Scene from a Scene, a path or a dictionary."""
    if isinstance(scene, Scene):
        return scene.changed(settings) if settings else scene
    return Scene(scene, settings)


def check_device(device):
    """Throws InputError unless the device is "", "cpu" or "cuda"."""
    if device not in ("", "cpu", "cuda"):
        raise InputError(f'device = {device!r} is not allowed: it must be "cpu" or "cuda"')
