"""Scenes, field solves and runs of lichtenberg in Python, and its results as numpy arrays with units. The package's README.md
has examples."""
import importlib

_homes = {
    "coagulation": ["coagulate"],
    "compiled": ["compile_effect"],
    "errors": ["Failure", "InputError"],
    "array": ["Array"],
    "result": ["Frame", "Result", "load"],
    "running": ["Run", "run"],
    "scene": ["Scene", "conductors"],
    "solving": ["solve"],
}
__all__ = sorted(name for names in _homes.values() for name in names)


def __getattr__(name):
    """Imports a module at its first use: numpy and HDF5 take a quarter of a second, which not every command needs."""
    for home, names in _homes.items():
        if name in names or name == home:
            module = importlib.import_module(f".{home}", __name__)
            return module if name == home else getattr(module, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__():
    return __all__
