"""`lichtenberg view`."""
import os

from .. import messages
from . import argument, frames_argument, overwrite_argument
from .plot import COLOUR, RANGE, replace_old_colour

HELP = "Writes one HTML page that shows a run in a browser without a network: particles over time, curves"
ARGUMENTS = [
    argument("RESULT", "result file of a run (.h5)", required=True, result="shown"),
    argument("--out", "page to write (default: RESULT with .html)"),
    frames_argument("all"),
    COLOUR,
    RANGE,
    overwrite_argument(),
]


def act(request):
    from ..files import default_output
    from ..result import load
    from ..view import write_page

    replace_old_colour(request)
    with load(request.result) as result:
        out = request.out or default_output(request.result, ".html")
        write_page(result, out, request.frames, request.overwrite, request.colour, request.range)
    messages.say(f"{out}: {os.path.getsize(out) / 1e6:.3g} MB, open it in a browser")
