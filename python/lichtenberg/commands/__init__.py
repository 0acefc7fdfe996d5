"""Commands in Python that start programs or draw. Each is a module named like its command, with _ for -. It defines:

    HELP        Description of the command in one line.
    ARGUMENTS   List of argument(...).
    act(request)
                Runs the command. The values of the arguments are attributes of `request`. May raise InputError and Failure.

The program reads this table (src/commands/python.cpp), parses the words as for its own commands, prints their help and
passes them on. An external command is such a module in a folder that LICHTENBERG_COMMANDS names.
"""
import argparse
import contextlib
import importlib
import math
import os
import pkgutil
import re
import sys

from ..errors import Failure, InputError

__path__ += [folder for folder in os.environ.get("LICHTENBERG_COMMANDS", "").split(":") if folder]
FIRST = ["plot", "film", "view", "export"]  # as they are listed, before the others
KINDS = {"flag": bool, "int": int, "ints": int, "float": float, "text": str, "texts": str}
NUMBERS, LISTS = ["int", "ints", "float"], ["ints", "texts"]
# Kinds of argument that each rule is for, and the type of its value
RULES = {
    "default": (["int", "float", "text"], (int, float, str)),
    "required": ([kind for kind in KINDS if kind != "flag"], bool),
    "positive": (NUMBERS, bool),
    "comma_separated": (LISTS, bool),
    "repeated": (LISTS, bool),
    "allowed": (["text", "texts"], list),
    "offered": (["text", "texts"], list),
    "excluded": (list(KINDS), str),
    "value_optional": (["text"], bool),
    "result": (["text", "texts"], str),
}


def argument(name, help, kind="text", **rules):
    """Returns the description of an argument of a command. Throws InputError if it is not valid.

    `name`: "--out", or "FILE" of a positional argument. `kind`: flag, int, float, text; ints and texts are lists. `rules`:
    default, required, positive, comma_separated, repeated, allowed, offered, excluded and value_optional.
    They are those of ArgumentRule in src/commands/commands.hpp. The rule result is for a positional argument that names
    result files. Its value is a verb ("drawn") for the error message by which the program refuses a damaged file."""
    if kind not in KINDS:
        raise InputError(f"argument {name}: there is no kind {kind}; it is one of {', '.join(KINDS)}")
    if not isinstance(name, str) or not name.strip("-") or not isinstance(help, str):
        raise InputError(f"argument {name}: its name and its help must be texts")
    for rule, value in rules.items():
        check_rule(name, kind, rule, value)
    return {"name": name, "help": help, "kind": kind, **rules}


def check_rule(name, kind, rule, value):
    """Throws InputError for a rule that does not exist, has another type or is not for this kind of argument."""
    if rule not in RULES:
        raise InputError(f"argument {name}: there is no rule {rule}; the rules are {', '.join(RULES)}")
    kinds, types = RULES[rule]
    if kind not in kinds:
        raise InputError(f"argument {name}: the rule {rule} is for {', '.join(kinds)}, not for the kind {kind}")
    if not isinstance(value, types) or (types is list and not all(isinstance(each, str) for each in value)):
        wanted = {bool: "true or false", list: "a list of texts", str: "a text"}.get(types, "a value of the argument's kind")
        raise InputError(f"argument {name}: the rule {rule} must be {wanted}")
    if rule == "result" and name.startswith("-"):
        raise InputError(f"argument {name}: only a positional argument names the result file that a command reads")
    if rule in ("comma_separated", "excluded") and not name.startswith("-"):
        raise InputError(f"argument {name}: the rule {rule} is for options only")


def overwrite_argument(more=""):
    return argument("--overwrite", f"replace files that exist{more}", "flag")


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
    """Returns the table that the program reads: descriptions of the commands of these names, or of all. Words that modules print
    go to standard error."""
    with contextlib.redirect_stdout(sys.stderr):
        return [description_of(name) for name in chosen or names()]


def listed():
    """Returns a line of help for each of the package's commands."""
    return "".join(f"{name:<16}{module_of(name).HELP}\n" for name in names())


def description_of(name):
    """Throws InputError for a module that is no command."""
    try:
        module = module_of(name)
    except InputError as error:
        raise InputError(f"{name.replace('-', '_')}.py: {error}") from None
    except SystemExit:
        raise Failure(f"{name.replace('-', '_')}.py is no command: it ends Python when it is imported") from None
    missing = [each for each in ("HELP", "ARGUMENTS", "act") if not hasattr(module, each)]
    if missing:
        raise InputError(f"{module.__file__} is no command: it has no {missing[0]} (it needs HELP, ARGUMENTS and act)")
    if not isinstance(module.HELP, str) or not all(isinstance(each, dict) and "kind" in each for each in module.ARGUMENTS):
        raise InputError(f"{module.__file__} is no command: HELP is a text and ARGUMENTS a list of argument(...)")
    try:
        parser_of(module)
    except (argparse.ArgumentError, ValueError) as error:
        raise InputError(f"{module.__file__} is no command: {error}") from None
    return {"name": name, "help": module.HELP, "arguments": module.ARGUMENTS}


class Parser(argparse.ArgumentParser):
    def error(self, message):
        raise InputError(message)


class Once(argparse.Action):
    """Stores the value of an option that may be given once."""

    def __call__(self, parser, request, value, option=None):
        given = request.__dict__.setdefault("options_given", set())
        if option in given:
            parser.error(f"{option} is given twice, and once is allowed")
        given.add(option)
        setattr(request, self.dest, value)


def value_reader(rules):
    """Returns the function that argparse calls with a word: it returns the argument's value, or a list of values of a
    comma-separated one."""

    def value_of(word):
        if word == "":
            raise argparse.ArgumentTypeError("the value is empty")
        value = KINDS[rules["kind"]](word)
        if rules.get("positive") and not 0 < value < math.inf:
            raise argparse.ArgumentTypeError(f"{word} is not allowed: it must be a finite number above 0")
        if rules.get("allowed") and word not in rules["allowed"]:
            raise argparse.ArgumentTypeError(f"{word} is not allowed: it is one of {', '.join(rules['allowed'])}")
        return value

    def values_of(word):
        return [value_of(each) for each in word.split(",")]

    read = values_of if rules.get("comma_separated") else value_of
    read.__name__ = rules["kind"].rstrip("s")  # argparse's message names it: "invalid int value"
    return read


def parser_of(module):
    """Returns the argparse parser of a command's module. Throws ValueError for an argument that excludes one that is not before
    it, and argparse.ArgumentError for a repeated name."""
    parser = Parser(prog="lichtenberg", description=module.HELP, allow_abbrev=False)
    groups = {}
    for each in module.ARGUMENTS:
        several, positional = each["kind"] in LISTS, not each["name"].startswith("-")
        options = {"help": each["help"].replace("%", "%%")}
        if each["kind"] == "flag":
            options["action"] = "store_true"
        else:
            options |= {"type": value_reader(each), "default": each.get("default", [] if several else None)}
            if several:
                listed = "extend" if each.get("comma_separated") else "append"
                options |= {"nargs": "+" if each.get("required") else "*"} if positional else {"action": listed}
            elif positional and not each.get("required"):
                options["nargs"] = "?"
            if each.get("value_optional"):
                options |= {"nargs": "?", "const": "true"}
            if not positional:
                options["required"] = each.get("required", False)
                options.setdefault("action", Once)
        excluded = each.get("excluded")
        if excluded and excluded not in groups:
            raise ValueError(f"argument {each['name']}: there is no option {excluded} before it that it could exclude")
        group = groups[excluded] if excluded else parser
        excluding = [other for other in module.ARGUMENTS if other.get("excluded") == each["name"]]
        if excluding:
            group = groups[each["name"]] = parser.add_mutually_exclusive_group()
        group.add_argument(each["name"].lower() if positional else each["name"], **options)
    return parser


def parse(name, words):
    """Returns the values of a command's arguments as attributes. `words` were read by the program, or come from a command line
    of Python's own. Throws InputError."""
    return parser_of(module_of(name)).parse_args(words)
