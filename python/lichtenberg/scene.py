"""Scenes in memory, from files, dictionaries or keyword tables."""
import json
import os
import warnings

import numpy as np

from . import core
from .errors import InputError


def toml(value):
    """Formats a Python or numpy value as TOML, a table in one line. Throws InputError for values that TOML cannot hold."""
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


def text_of(tables):
    """Returns the text of a scene file with these keys."""
    return "".join(f"{json.dumps(str(key))} = {toml(value)}\n" for key, value in tables.items())


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
    """Returns settings as a list of pairs of texts. `settings`: a dictionary of keys and values, one text "key=value", or
    a list of such texts."""
    if settings is None:
        return []
    if isinstance(settings, dict):
        return [(key, toml(value)) for key, value in settings.items()]
    words = [settings] if isinstance(settings, str) else list(settings)
    for word in words:
        if not isinstance(word, str) or "=" not in word:
            raise InputError(f'{word!r} is no setting: give a dictionary, or texts like "field.cells=64"')
    return [tuple(part.strip() for part in word.split("=", 1)) for word in words]


class Scene:
    """A checked scene.

    source: path of a scene file, or a dictionary with the keys of a scene file. Arrays are allowed. Without a source the
        keyword arguments are the tables.

    Settings are keys that replace those of the source, as {"mechanics.position_tolerance": 1e-6}.

    effects: effects of compile_effect(), whose tables the scene may have.

    Throws InputError that names file, line and key. Warns about former names of keys."""

    def __init__(self, source=None, settings=None, effects=(), **tables):
        if isinstance(effects, dict):  # the table of that name
            tables, effects = {**tables, "effects": effects}, ()
        if (source is None) == (not tables):
            raise InputError("a scene needs a path, a dictionary, or keyword tables, and only one of them")
        self._source, self._settings = tables if source is None else source, settings_of(settings)
        self._effects = list(effects)
        self._core = self._read(self._settings)
        for text in self._core.warnings:
            warnings.warn(text, stacklevel=2)

    def _read(self, settings):
        if isinstance(self._source, dict):
            return core.load().Scene.from_text(text_of(self._source), "scene", settings, self._effects)
        if not isinstance(self._source, (str, os.PathLike)):
            raise InputError(f"a {type(self._source).__name__} is no scene: give a path or a dictionary")
        return core.load().Scene.from_file(os.fspath(self._source), settings, self._effects)

    def changed(self, settings):
        """Returns the scene with further settings."""
        return Scene(self._source, [f"{key}={value}" for key, value in self._settings + settings_of(settings)], self._effects)

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
        return self._core.bodies

    def __repr__(self):
        return f"<scene {self.title or 'without title'}: {len(self)} bodies in {self.dimension} dimensions>"


def scene_of(scene, settings=None):
    """Returns a Scene from a Scene, a path or a dictionary."""
    if isinstance(scene, Scene):
        return scene.changed(settings) if settings else scene
    return Scene(scene, settings)
