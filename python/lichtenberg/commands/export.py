"""`lichtenberg export`."""
from .. import messages
from . import argument, frames_argument, overwrite_argument

HELP = "Writes particles, field, observables and tables for ParaView, ASE or a spreadsheet"
FORMATS = (
    "vtk: a folder with .pvd and .vtp of particles, contacts and tree and the last frame's field as .vti; xyz: one "
    "extended XYZ file; csv: a folder with one file per table"
)
ARGUMENTS = [
    argument(
        "RESULT", "result file of a run (.h5), or for csv the folder of an ensemble", required=True, result="exported"
    ),
    argument("--to", FORMATS, required=True, offered=["vtk", "xyz", "csv"]),
    argument("--out", "file or folder to write (default: RESULT with .xyz, -vtk or -csv)"),
    frames_argument("all"),
    overwrite_argument(", including all files of an earlier export"),
]


def act(request):
    from ..export import export

    messages.say(export(request.result, request.to, request.out, request.frames, request.overwrite))
