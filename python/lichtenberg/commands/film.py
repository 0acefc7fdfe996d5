"""`lichtenberg film`."""
import os
import shutil

from ..errors import InputError
from . import argument, frames_argument
from .plot import FRAME_ARGUMENTS, replace_old_colour

HELP = "Makes an mp4 of a run, on all cores, in one colour scale and layout; needs ffmpeg"
ARGUMENTS = [
    argument("RESULT", "result file of a run (.h5)", required=True, result="drawn"),
    frames_argument("all"),
    argument("--rate", "frames per second", "float", positive=True, default=15),
    argument("--out", "film to write (default: RESULT.mp4, with a --colour RESULT-COLOUR.mp4)"),
    argument("--quiet", "show no progress", "flag"),
    *FRAME_ARGUMENTS,
]
LEAST, MOST = 0.1, 1000  # frame rates that players support (frames per second)


def act(request):
    from ..files import check_output

    replace_old_colour(request)
    if request.out is None:
        request.out = os.path.splitext(request.result)[0] + (f"-{request.colour}" if request.colour else "") + ".mp4"
    if not LEAST <= request.rate <= MOST:
        raise InputError(f"--rate {request.rate:g} is not allowed: it must be from {LEAST:g} to {MOST:g} frames a second")
    if not request.out.endswith(".mp4"):
        raise InputError(f"--out {request.out}: films are written as .mp4, and their names end so")
    check_output(request.out, request.overwrite)
    if not shutil.which("ffmpeg"):
        raise InputError("there is no ffmpeg, which makes films of pictures: install Debian's package ffmpeg")
    from ..pictures import film

    film.make(request)
