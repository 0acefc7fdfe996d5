"""Commands of the program in Python: python3 -m lichtenberg view RESULT [--out PAGE] and so on (commands/). The program calls
this file by its path, and further with

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
import warnings

from lichtenberg import commands, messages
from lichtenberg.errors import Failure, InputError


def work_of(name, words):
    """What is to be done, and the file that it reads, if any."""
    if name == "--describe":
        return lambda: print(json.dumps(json.dumps(commands.describe(words)))), None
    if name == "--draw":
        module, function = words[0].split(".")
        return lambda: getattr(importlib.import_module(f"lichtenberg.pictures.{module}"), function)(*words[1:]), words[1]
    module, request = commands.module_of(name), commands.parser_of(name).parse_args(words)
    read = [getattr(request, each["name"].lower()) for each in module.ARGUMENTS if "result" in each]
    return lambda: module.act(request), read[0] if read else None


def show(words, kind, *_, **__):
    """A warning of load() as a sentence, and none of Python's own. The program has said it before."""
    if kind is UserWarning and __package__:
        messages.tell(f"lichtenberg: {messages.printable(str(words))}")


def main(name="", *words):
    messages.open_closed_descriptors()
    warnings.showwarning = show
    read = None
    try:
        work, read = work_of(name, words)
        work()
        return 0
    except (InputError, Failure) as error:
        sentence, status = str(error), 2 if isinstance(error, InputError) else 1
    except Exception as error:  # whatever a damaged file leads to
        if read is None:
            raise
        from lichtenberg.result import damage

        sentence, status = f"{read if isinstance(read, str) else read[0]} is damaged or incomplete ({damage(error)})", 2
    messages.tell(f"lichtenberg: {messages.printable(sentence)}")
    return status


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
