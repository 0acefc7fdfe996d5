"""The commands `lichtenberg view` and `lichtenberg export`: python3 -m lichtenberg view RESULT [--out PAGE] and so on."""
import argparse
import os
import sys
import warnings

from . import messages
from . import view as page
from .export import export
from .result import Failure, InputError, damage, default_output, load, printable


def parser():
    commands = argparse.ArgumentParser(prog="lichtenberg", description=__doc__)
    kinds = commands.add_subparsers(dest="command", required=True)
    for name in ("view", "export"):
        command = kinds.add_parser(name)
        command.add_argument("file")
        command.add_argument("--out", "--output")
        command.add_argument("--frames", "--frame")
        command.add_argument("--overwrite", action="store_true")
        if name == "export":
            command.add_argument("--to", required=True)
    return commands


def view(request):
    with load(request.file) as result:
        out = request.out or default_output(request.file, ".html")
        page.write_page(result, out, request.frames, request.overwrite)
    messages.say(f"{out}: {os.path.getsize(out) / 1e6:.3g} MB, open it in a browser")


def act(request):
    if request.command == "view":
        return view(request)
    return messages.say(export(request.file, request.to, request.out, request.frames, request.overwrite))


def show(words, kind, *_, **__):
    """A warning of load() as a sentence, and none of Python's own."""
    if kind is UserWarning:
        messages.tell(f"lichtenberg: {printable(str(words))}")


def main():
    messages.open_closed_descriptors()
    warnings.showwarning = show
    request = parser().parse_args()
    try:
        act(request)
        return 0
    except (InputError, Failure) as error:
        sentence, status = str(error), 2 if isinstance(error, InputError) else 1
    except Exception as error:  # whatever a damaged file leads to
        sentence, status = f"{request.file} is damaged or incomplete ({damage(error)})", 2
    messages.tell(f"lichtenberg: {printable(sentence)}")
    return status


if __name__ == "__main__":
    sys.exit(main())
