"""Runs a command of commands/, as in python3 -m lichtenberg view RESULT [--out PAGE]. The program calls this file by its path.
Two options are for the program alone:

    --describe [NAME ...]           prints the table of commands: JSON in quotes, as C++ and JSON have a text
    --draw MODULE.FUNCTION WORD ... calls a function of pictures/ with these words
"""
import os
import sys

if not __package__:  # called by its path: no other folder's modules come before the package
    here = os.path.dirname(os.path.abspath(__file__))
    sys.path.insert(0, here)
    import interrupted  # before all else

    sys.path = [os.path.dirname(here)] + [path for path in sys.path if path != here]

import importlib
import json
import traceback
import warnings
from pathlib import Path

from lichtenberg import commands, messages
from lichtenberg.errors import Failure, InputError


def work_of(name, words):
    """Returns a function that does the work, and the result file or files that it reads; None without one."""
    if name in ("", "-h", "--help"):
        return lambda: messages.put(commands.listed()), None
    if name == "--describe":
        return lambda: print(json.dumps(json.dumps(commands.describe(words)))), None
    if name == "--draw":
        module, function = words[0].split(".")
        return lambda: getattr(importlib.import_module(f"lichtenberg.pictures.{module}"), function)(*words[1:]), words[1]
    module, request = commands.module_of(name), commands.parse(name, words)
    read = [getattr(request, each["name"].lower()) for each in module.ARGUMENTS if "result" in each]
    return lambda: module.act(request), read[0] if read else None


def show(words, kind, *_, **__):
    """Prints a warning of load() in one line, unless the program has printed it before. Python's own warnings are not shown."""
    if kind is UserWarning and __package__:
        messages.write_error(f"lichtenberg: {messages.printable(str(words))}")


def may_be_damage(error):
    """Whether a damaged file may have caused an exception: one of the kinds that this can be, raised where the package, h5py or
    numpy work with its contents. A module from outside gets an InputError for damage (lichtenberg.load)."""
    if isinstance(error, ModuleNotFoundError):  # of h5py, for example, which the next line imports
        return False
    from lichtenberg.result import DAMAGE

    at = Path(traceback.extract_tb(error.__traceback__)[-1].filename)
    package = Path(__file__).resolve().parent
    if at == package / "__main__.py" or not (package in at.parents or {"h5py", "numpy"} & set(at.parts)):
        return False
    if isinstance(error, AttributeError):
        return type(error.obj).__module__.split(".")[0] in ("h5py", "numpy")
    return isinstance(error, DAMAGE) and not isinstance(error, (MemoryError, RecursionError, NotImplementedError))


def defect(error):
    """Returns the error message for an exception that no input file causes, with the line of the code."""
    frames = [each for each in traceback.extract_tb(error.__traceback__) if not each.filename.startswith("<")]
    where = f"{frames[-1].filename}, line {frames[-1].lineno}"
    if isinstance(error, SyntaxError):
        where = f"{error.filename}, line {error.lineno}"
    if isinstance(error, MemoryError):
        return "this machine has too little memory for that"
    if isinstance(error, ModuleNotFoundError) and not (error.name or "lichtenberg.").startswith("lichtenberg."):
        return f"there is no Python package {error.name}, which {where} imports: install it"
    return f"{type(error).__name__} in {where} ({error}): this is an error of the program or of a module added to it"


def main(name="", *words):
    messages.open_closed_descriptors()
    warnings.showwarning = show
    read = None
    try:
        work, read = work_of(name, words)
        work()
        return 0
    except (InputError, Failure) as error:
        message, status = str(error), 2 if isinstance(error, InputError) else 1
    except Exception as error:
        if read is None or not may_be_damage(error):
            message, status = defect(error), 1
        else:
            from lichtenberg.result import damage

            message, status = f"{read if isinstance(read, str) else read[0]} is damaged or incomplete ({damage(error)})", 2
    messages.write_error(f"lichtenberg: {messages.printable(message)}")
    return status


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
