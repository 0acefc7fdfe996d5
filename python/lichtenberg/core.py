"""The compiled module lichtenberg._core: next to this package if it is installed, else in the build folder of the source."""
import contextlib
import importlib.util
import os
import signal
import sys
import threading
from importlib.machinery import PathFinder
from pathlib import Path

from .errors import Failure

NAME = "lichtenberg._core"
LOADING = threading.Lock()


def find():
    """Returns the import specification of the module for this Python; None if there is none."""
    here = Path(__file__).resolve().parent
    folders = [here, here / "../../build"]
    if program := os.environ.get("LICHTENBERG"):
        folders.insert(0, Path(program).resolve().parent)
    found = PathFinder.find_spec("_core", [str(folder) for folder in folders])
    return found and importlib.util.spec_from_file_location(NAME, found.origin)


@contextlib.contextmanager
def delayed_interrupt():
    """Delays Ctrl-C to the end of the block: a module whose initialization was interrupted cannot be loaded again."""
    handler, noted = signal.getsignal(signal.SIGINT), []
    if threading.current_thread() is not threading.main_thread() or not callable(handler):
        yield  # no handler of Python's is called in this thread
        return
    signal.signal(signal.SIGINT, lambda *_: noted.append(True))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        if noted:
            signal.raise_signal(signal.SIGINT)


def load():
    """Returns the module. Throws Failure if there is none for this Python."""
    with LOADING:
        if NAME in sys.modules:
            return sys.modules[NAME]
        found = find()
        if found is None:
            raise Failure("the module lichtenberg._core was not found for this Python: build it with "
                          "`ninja -C build python_module` (Debian packages pybind11-dev and python3-dev)")
        with delayed_interrupt():
            try:
                module = importlib.util.module_from_spec(found)
                found.loader.exec_module(module)
            except ImportError as error:
                raise Failure(f"{found.origin} cannot be loaded by this Python ({error})") from None
            sys.modules[NAME] = module
        return module
