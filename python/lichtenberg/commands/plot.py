"""`lichtenberg plot`."""
import os

from ..errors import InputError
from ..messages import write_error
from . import argument, frames_argument, overwrite_argument

COLOUR = argument(
    "--colour",
    "quantity of the colours; conductors: potential, charge, force, cluster (of those in contact), "
    "current (to the ground), strahler (order of the branch), connection_time (time of connection to the tree), "
    "speed; gases: charge, cluster, force, speed; packings: force; any other column of particles by its name (default: potential or charge, "
    "unless all is 0 or the same)",
    offered=["potential", "charge", "force", "cluster", "current", "strahler", "connection_time", "speed"],
)
RANGE = argument(
    "--range",
    "LOW,HIGH: range of the colours, in the file's units without prefix, as in --range=-200,200 (default: that of the "
    "whole run, all frames together)",
)
# Arguments that plot and film share for pictures of frames.
FRAME_ARGUMENTS = [
    COLOUR,
    RANGE,
    argument("--cmap", "colour map by matplotlib's name, as viridis"),
    argument("--cut", "AXIS=POSITION: in space, show only the part behind this plane, as in --cut z=0.005"),
    overwrite_argument(),
]
HELP = (
    "Draws frames of results as PNG, PDF or SVG, or with --series time series of runs. The default name of a picture states "
    "its contents, and existing files are not replaced without --overwrite"
)
ARGUMENTS = [
    argument(
        "RESULT",
        "result file of a run (.h5); several are drawn side by side in the same colours; with --series in the same "
        "axes, and the folder of an ensemble (or a table in it, as ensemble-2.json), whose means are drawn without "
        "--series",
        "texts",
        required=True,
        result="drawn",
    ),
    argument("--frame", "index of the frame, from 0 (default: the last)", "int"),
    frames_argument("the last"),
    argument(
        "--out",
        "picture to write, its format by its ending: .png, .pdf or .svg; of several frames each name gets its index "
        "(default: RESULT-frame-N-COLOUR.png, RESULT-series.png)",
    ),
    argument("--series", "draw time series of the runs instead of a frame", "flag"),
    argument("--observables", "names of time series, as in energy,connected; an unknown name prints the list of those present"),
    *FRAME_ARGUMENTS,
]

OLD_COLOURS = {"order": "strahler", "joined": "connection_time"}  # names of earlier versions, which still work


def replace_old_colour(request):
    """Replaces a value of --colour that had another name in earlier versions, and prints a warning."""
    if request.colour in OLD_COLOURS:
        name = OLD_COLOURS[request.colour]
        write_error(f"lichtenberg: --colour {request.colour} is an old name: it is called {name} now")
        request.colour = name


def is_ensemble(path):
    """Returns true if a path is an ensemble's folder or its table."""
    return os.path.isdir(path) or path.endswith(".json")


def check(request, ensembles):
    if request.frames and request.frame is not None:
        raise InputError("--frame and --frames say the same: give one of them")
    if request.observables and not request.series and not ensembles:
        raise InputError("--observables is for curves over time: it needs --series")
    draws_frames = request.frame is not None or any(getattr(request, name) for name in ("frames", "colour", "range", "cmap", "cut"))
    if draws_frames and (request.series or ensembles):
        raise InputError("--frame, --frames, --colour, --range, --cmap and --cut are for pictures of frames, not for curves")
    if ensembles and len(request.result) > 1:
        raise InputError(f"the ensemble {ensembles[0]} is drawn alone: draw the other files by a command of their own")


def act(request):
    replace_old_colour(request)
    ensembles = [path for path in request.result if is_ensemble(path)]
    check(request, ensembles)
    if request.series or ensembles:
        from ..pictures import series

        return series.draw(request, bool(ensembles))
    from ..pictures import frames

    return frames.plot_frames(request)
