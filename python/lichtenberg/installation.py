"""Path of the program."""
import os
import shutil
from pathlib import Path

from .errors import Failure

RELATIVE_PATHS = [
    "../../../../bin/lichtenberg",  # from share/lichtenberg/python/lichtenberg, as installed
    "../../build/lichtenberg",  # from the source
]


def find_program():
    """LICHTENBERG of the environment, else the program that this package came with, else the one on the PATH."""
    here = Path(__file__).resolve().parent
    candidates = [os.environ.get("LICHTENBERG"), *((here / relative_path).resolve() for relative_path in RELATIVE_PATHS), shutil.which("lichtenberg")]
    for candidate in candidates:
        if candidate and os.access(candidate, os.X_OK):
            return str(candidate)
    raise Failure("the program lichtenberg was not found: put it on the PATH, or its path into LICHTENBERG")
