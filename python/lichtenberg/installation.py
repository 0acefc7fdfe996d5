"""Path of the program."""
import os
import shutil
import sys
from pathlib import Path

from .errors import Failure

HERE = Path(__file__).resolve().parent
IN_WHEEL = HERE / "bin/lichtenberg"
PATHS = [
    IN_WHEEL,
    HERE / "../../../../bin/lichtenberg",  # from share/lichtenberg/python/lichtenberg, as installed
    HERE / "../../build/lichtenberg",  # from the source
]


def own_program():
    """Returns the program that this package came with; None if there is none. The program of a wheel then calls this Python,
    because h5py may be installed for this one only."""
    for path in PATHS:
        if os.access(path, os.X_OK):
            if path == IN_WHEEL:
                os.environ.setdefault("LICHTENBERG_PYTHON", sys.executable)
            return str(path.resolve())
    return None


def find_program():
    """LICHTENBERG of the environment, else the program that this package came with, else the one on the PATH."""
    named = os.environ.get("LICHTENBERG")
    program = named if named and os.access(named, os.X_OK) else own_program() or shutil.which("lichtenberg")
    if program:
        return program
    raise Failure("the program lichtenberg was not found: put it on the PATH, or its path into LICHTENBERG")


def start():
    """Replaces this process by the program. pip makes a command of this function."""
    program = own_program()
    if not program:
        sys.exit("lichtenberg: the program was not found next to the Python package: install the package again")
    os.execv(program, ["lichtenberg", *sys.argv[1:]])
