"""The compiled module lichtenberg._core: next to this package if it is installed, else in the build folder of the source."""
import importlib.util
import os
import sys
from pathlib import Path

from .errors import Failure


def find_module():
    """Returns the path of the module; None if there is none."""
    here = Path(__file__).resolve().parent
    folders = [here, here / "../../build"]
    if program := os.environ.get("LICHTENBERG"):
        folders.insert(0, Path(program).resolve().parent)
    for folder in folders:
        for path in sorted(folder.glob("_core.*.so")):
            return path
    return None


def load():
    name = "lichtenberg._core"
    if name in sys.modules:
        return sys.modules[name]
    path = find_module()
    if path is None:
        raise Failure("the module lichtenberg._core was not found: install the package, or build it with "
                      "`ninja -C build python_module` (Debian package pybind11-dev)")
    spec = importlib.util.spec_from_file_location(name, path)
    try:
        module = importlib.util.module_from_spec(spec)
    except ImportError as error:
        raise Failure(f"{path} cannot be loaded by this Python ({error})") from None
    spec.loader.exec_module(module)
    sys.modules[name] = module
    return module
