"""Commands in Python that start programs or draw. Each is a module named like its command, with _ for -. A module has

    HELP        what the command does, in one line
    ARGUMENTS   a list of argument(...)
    act(request)
                does it, with the arguments' values as attributes; it may raise InputError and Failure

The program reads the words from this table (src/commands/python.cpp), as it does for commands of its own, prints their help,
and passes them on. A command from outside is such a module in a folder that LICHTENBERG_COMMANDS names.
"""
import argparse
import importlib
import os
import pkgutil
import re

from ..errors import InputError

__path__ += [folder for folder in os.environ.get("LICHTENBERG_COMMANDS", "").split(":") if folder]
FIRST = ["plot", "film", "view", "export"]  # as they are listed, before the others
KINDS = {"flag": bool, "int": int, "ints": int, "float": float, "text": str, "texts": str}
RULES = ["default", "required", "positive", "comma_separated", "repeated", "allowed", "offered", "excluded", "value_optional",
         "value_follows", "result"]


def argument(name, help, kind="text", **rules):
    """`name`: "--out", or "FILE" of a positional argument. `kind`: flag, int, float, text; ints and texts are lists. `rules`:
    default; required, positive, comma_separated, repeated, allowed, offered, excluded, value_optional, value_follows as in
    ArgumentRule of src/commands/commands.hpp; result of a positional argument that names result files: a verb for the
    message about a damaged one ("drawn"), which the program refuses. Throws InputError."""
    unknown = [rule for rule in rules if rule not in RULES]
    if kind not in KINDS:
        raise InputError(f"argument {name}: there is no kind {kind}; it is one of {', '.join(KINDS)}")
    if unknown:
        raise InputError(f"argument {name}: there is no rule {unknown[0]}; the rules are {', '.join(RULES)}")
    if "result" in rules and name.startswith("-"):
        raise InputError(f"argument {name}: only a positional argument names the result file that a command reads")
    return {"name": name, "help": help, "kind": kind, **rules}


def frames_argument(otherwise):
    words = "frames and ranges FIRST:LAST:STEP, with LAST among them, as in 0,5,10:20,30:90:10 or ::10"
    return argument("--frames", f"{words} (default: {otherwise})")


def names():
    """Returns the names of the package's commands. Modules in folders of LICHTENBERG_COMMANDS are left out."""
    found = {module.name.replace("_", "-") for module in pkgutil.iter_modules(__path__[:1])}
    return sorted(found, key=lambda name: (FIRST.index(name) if name in FIRST else len(FIRST), name))


def module_of(name):
    module = f"{__name__}.{name.replace('-', '_')}"
    try:
        if not re.fullmatch("[a-z]+(-[a-z]+)*", name):
            raise ModuleNotFoundError(name=module)
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name != module:
            raise
        raise InputError(f"there is no command `{name}` in Python: it is one of {', '.join(names())}") from None


def describe(chosen):
    """Returns the table that the program reads: descriptions of the commands of these names, or of all."""
    return [description_of(name) for name in chosen or names()]


def description_of(name):
    """Throws InputError for a module that is no command."""
    try:
        module = module_of(name)
    except InputError as error:
        raise InputError(f"{name.replace('-', '_')}.py: {error}") from None
    missing = [each for each in ("HELP", "ARGUMENTS", "act") if not hasattr(module, each)]
    if missing:
        raise InputError(f"{module.__file__} is no command: it has no {missing[0]} (it needs HELP, ARGUMENTS and act)")
    if not isinstance(module.HELP, str) or not all(isinstance(each, dict) and "kind" in each for each in module.ARGUMENTS):
        raise InputError(f"{module.__file__} is no command: HELP is a text and ARGUMENTS a list of argument(...)")
    return {"name": name, "help": module.HELP, "arguments": module.ARGUMENTS}


class Parser(argparse.ArgumentParser):
    def error(self, message):
        raise InputError(message)


def value_reader(rules):
    """Returns the function that argparse calls with a word: it returns the argument's value, or a list of values of a
    comma-separated one."""

    def value_of(word):
        if word == "":
            raise argparse.ArgumentTypeError("the value is empty")
        value = KINDS[rules["kind"]](word)
        if rules.get("positive") and not value > 0:
            raise argparse.ArgumentTypeError(f"{word} is not allowed: it must be a number above 0")
        if rules.get("allowed") and word not in rules["allowed"]:
            raise argparse.ArgumentTypeError(f"{word} is not allowed: it is one of {', '.join(rules['allowed'])}")
        return value

    def values_of(word):
        return [value_of(each) for each in word.split(",")]

    read = values_of if rules.get("comma_separated") else value_of
    read.__name__ = rules["kind"].rstrip("s")  # argparse's message names it: "invalid int value"
    return read


def parser_of(name):
    """Returns the argparse parser of a command, and its module."""
    module = module_of(name)
    parser = Parser(prog=f"lichtenberg {name}", description=module.HELP, allow_abbrev=False)
    for each in module.ARGUMENTS:
        several, place = each["kind"] in ("ints", "texts"), not each["name"].startswith("-")
        options = {"help": each["help"].replace("%", "%%")}
        if each["kind"] == "flag":
            options["action"] = "store_true"
        else:
            options |= {"type": value_reader(each), "default": each.get("default", [] if several else None)}
            if several:
                listed = "extend" if each.get("comma_separated") else "append"
                options |= {"nargs": "+" if each.get("required") else "*"} if place else {"action": listed}
            elif place and not each.get("required"):
                options["nargs"] = "?"
            if each.get("value_optional"):
                options |= {"nargs": "?", "const": "true"}
            if not place:
                options["required"] = each.get("required", False)
        parser.add_argument(each["name"].lower() if place else each["name"], **options)
    return parser, module


def parse(name, words):
    """Returns the values of a command's arguments as attributes. `words` were read by the program, or come from a command line
    of Python's own. Throws InputError."""
    parser, module = parser_of(name)
    request = parser.parse_args(words)
    for each in module.ARGUMENTS:
        given = [option for option in (each["name"], each.get("excluded")) if option and any(
            word == option or word.startswith(option + "=") for word in words)]
        if len(given) == 2:
            raise InputError(f"{given[0]} excludes {given[1]}")
    return request
