from collections.abc import Callable, Iterator, Mapping
from os import PathLike
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .result import Frame as Frame, Result as Result

Settings = Mapping[str, Any] | list[str] | tuple[str, ...] | str | None

class InputError(Exception):
    file: str | None
    line: int | None
    key: str | None

class Failure(Exception): ...

class Array(np.ndarray):
    unit: str
    def __new__(cls, values: ArrayLike, unit: str) -> Array: ...

class CompiledEffect:
    @property
    def name(self) -> str: ...
    @property
    def description(self) -> str: ...

class Scene:
    def __init__(self, source: str | PathLike[str] | Mapping[str, Any] | None = None, settings: Settings = None,
                 compiled: CompiledEffect | list[CompiledEffect] | tuple[CompiledEffect, ...] = (), **tables: Any) -> None: ...
    def changed(self, settings: Settings) -> Scene: ...
    @property
    def text(self) -> str: ...
    @property
    def title(self) -> str: ...
    @property
    def dimension(self) -> int: ...
    @property
    def is_granular(self) -> bool: ...
    def __len__(self) -> int: ...

AnyScene = Scene | str | PathLike[str] | Mapping[str, Any]

class Answer(SimpleNamespace):
    position: Array
    radius: Array
    potential: Array
    charge: Array
    force: Array
    energy: float
    units: dict[str, str]

class State:
    time: float
    position: np.ndarray
    momentum: np.ndarray
    mass: np.ndarray
    radius: np.ndarray
    charge: np.ndarray | None

class RunFrame:
    time: float
    time_unit: str
    @property
    def columns(self) -> list[str]: ...
    def __getitem__(self, name: str) -> Array | float: ...
    def __getattr__(self, name: str) -> Any: ...

Force = Callable[[State], ArrayLike | tuple[ArrayLike, float]]

class Contacts:
    time: float
    pair: np.ndarray
    impact_speed: np.ndarray
    direction: np.ndarray
    charge: np.ndarray
    radius: np.ndarray
    mass: np.ndarray

ChargeExchange = Callable[[Contacts], ArrayLike]

class Run:
    scene: Scene
    def __init__(self, scene: AnyScene, settings: Settings = None, *, out: str | PathLike[str] | None = None,
                 record: bool = True, overwrite: bool = False, device: str = "") -> None: ...
    def add_force(self, function: Force) -> Force: ...
    def add_charge_exchange(self, function: ChargeExchange, unit: float = 1e-3) -> ChargeExchange: ...
    def frames(self, every: float | None = None) -> Iterator[RunFrame]: ...
    def finish(self, progress: bool = False) -> Run: ...
    def save(self, path: str | PathLike[str], overwrite: bool = False) -> str: ...
    def plot(self, **options: Any) -> Any: ...
    def view(self, out: str | PathLike[str], **options: Any) -> Any: ...
    @property
    def result(self) -> Result: ...
    @property
    def time(self) -> float: ...
    @property
    def finished(self) -> bool: ...
    @property
    def summary(self) -> dict[str, tuple[float, str]]: ...
    @property
    def warnings(self) -> list[str]: ...

class Coagulation:
    time: np.ndarray
    size: np.ndarray
    number: np.ndarray
    width: np.ndarray
    error: float
    lost: float

def coagulate(kernel: Callable[[float, float], float], times: ArrayLike, *, tolerance: float = 1e-4,
              largest: float = 1e6, stiff: bool = False) -> Coagulation: ...
def compile_effect(source: str | PathLike[str], compiler: str | None = None) -> CompiledEffect: ...
def conductors(position: ArrayLike, **columns: ArrayLike) -> list[dict[str, Any]]: ...
def load(path: str | PathLike[str]) -> Result: ...
def run(scene: AnyScene, out: str | PathLike[str], settings: Settings = None, *, overwrite: bool = False,
        device: str = "") -> Result: ...
def solve(scene: AnyScene, settings: Settings = None, *, capacitance: bool = False, potential_field: bool = False,
          device: str = "") -> Answer: ...
