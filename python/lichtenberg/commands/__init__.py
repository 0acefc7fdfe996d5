"""Commands that only drive and draw: one module each, named like its command with _ for -. A module has

    HELP        what the command does, in one line
    ARGUMENTS   a list of argument(...)
    act(request)
                does it, with the arguments' values as attributes; may raise InputError and Failure

The program reads the words from this table (src/commands/python.cpp), as it does for commands of its own, prints their help,
and passes them on. A command from outside is such a module in a folder that LICHTENBERG_COMMANDS names.
"""
import argparse
import importlib
import os
import pkgutil

from ..errors import InputError

__path__ += [folder for folder in os.environ.get("LICHTENBERG_COMMANDS", "").split(":") if folder]
FIRST = ["plot", "film", "view", "export"]  # as they are listed, before the others
KINDS = {"int": int, "ints": int, "float": float}


def argument(name, help, kind="text", **rules):
    """`name`: "--out", or "FILE" of one that is told by its place. `kind`: flag, int, float, text; ints and texts are several.
    `rules`: default; and required, positive, comma_separated, repeated, allowed, offered, excluded, value_optional, value_follows as of ArgumentRule in
    src/commands/commands.hpp; `result`: a result file, and what is done with it ("drawn"): a damaged one is refused before."""
    return {"name": name, "help": help, "kind": kind, **rules}


def frames_argument(otherwise):
    words = "frames and ranges FIRST:LAST:STEP, with LAST among them, as in 0,5,10:20,30:90:10 or ::10"
    return argument("--frames", f"{words} (default: {otherwise})")


def names():
    """Of all commands, without those that only a folder outside has."""
    found = {module.name.replace("_", "-") for module in pkgutil.iter_modules(__path__[:1])}
    return sorted(found, key=lambda name: (FIRST.index(name) if name in FIRST else len(FIRST), name))


def module_of(name):
    module = f"{__name__}.{name.replace('-', '_')}"
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name != module:
            raise
        raise InputError(f"there is no command `{name}` in Python: it is one of {', '.join(names())}") from None


def describe(chosen):
    """The table that the program reads, of these names or of all."""
    modules = {name: module_of(name) for name in chosen or names()}
    return [{"name": name, "help": module.HELP, "arguments": module.ARGUMENTS} for name, module in modules.items()]


class Parser(argparse.ArgumentParser):
    def error(self, message):
        raise InputError(message)


def parser_of(name):
    """For words that the program has read, or that come from a command line of Python's own."""
    module = module_of(name)
    parser = Parser(prog=f"lichtenberg {name}", description=module.HELP, allow_abbrev=False)
    for each in module.ARGUMENTS:
        several, place = each["kind"] in ("ints", "texts"), not each["name"].startswith("-")
        options = {"help": each["help"].replace("%", "%%")}
        if each["kind"] == "flag":
            options["action"] = "store_true"
        else:
            options |= {"type": KINDS.get(each["kind"], str), "default": each.get("default", [] if several else None)}
            if several:
                options |= {"nargs": "+" if each.get("required") else "*"} if place else {"action": "append"}
            elif place and not each.get("required"):
                options["nargs"] = "?"
            if each.get("value_optional"):
                options |= {"nargs": "?", "const": "true"}
            if not place:
                options["required"] = each.get("required", False)
        parser.add_argument(each["name"].lower() if place else each["name"], **options)
    return parser
