"""Draws frames of result files: of conductors, of a packing or of a gas of grains.

Colours, their range and the layout are the same for all frames of a run. Several files are drawn side by side, in the
same colours.
"""
import functools
from pathlib import Path

from ..result import listed_frames, warnings_of
from . import drawing
from .colours import draw_bar, scale_of
from .drawing import InputError
from .fields import Fields


def open_run(file, path):
    """Returns the run as an object of its kind. Imports of the other kinds would cost time."""
    drawing.frame_index(file, path, None)
    if "walls" in file["scene"] or "relaxation" in file or "observables/size_x" in file:
        from .packing import Packing as Kind
    elif "gas" not in file and "height" in file["scene/domain"] and "potential" in file["particles/conductors"]:
        from .conductors import ConductorsInSpace as Kind
    elif "gas" in file or "height" in file["scene/domain"]:
        from .gas import Grains as Kind
    else:
        from .conductors import Conductors as Kind
    run = Kind(file, path)
    run.warning = drawing.warning_line(warnings_of(file))
    return run


def read_run(path):
    return drawing.read_file(path, lambda file: open_run(file, path))


def read_range(text):
    """Parses "LOW,HIGH" to two numbers. Returns None for None. Throws InputError."""
    if text is None:
        return None
    try:
        low, high = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"--range {text} is not valid: it must be two numbers, as in --range=-200,200") from None
    if not abs(low) < float("inf") or not abs(high) < float("inf"):
        raise InputError(f"--range {text} is not allowed: both ends must be finite numbers")
    if low >= high:
        raise InputError(f"--range {text} is reversed: the lower end must come first and be less than the other")
    return low, high


def check_colour(run, colour):
    """Throws InputError for a quantity that the result does not have."""
    if colour is None or colour in run.quantities:
        return
    known = ", ".join(run.quantities) or "none"
    if colour == "current" and "strahler" in run.quantities:
        where = "that needs effects.current_injection with equal currents"
        raise InputError(f"{run.path} has no current by conductor: {where}; it has {known}")
    raise InputError(f"{run.path} has no {colour} to colour by: it has {known}")


def common_scale(runs, colour, own_range=None, cmap=None):
    """Returns a common scale for all runs: from the lowest to the highest value of their ranges."""
    for run in runs:
        check_colour(run, colour)
    if colour is None:
        return None
    ranges = [drawing.read_file(run.path, lambda file: run.range(file, colour)) for run in runs]
    found = functools.reduce(lambda one, other: one.joined(other), ranges)
    return scale_of(runs[0].quantities[colour], read_range(own_range), found, cmap)


def default_colour(runs, frames):
    """Returns the quantity that the first run suggests, if all runs have it."""
    run = runs[0]
    colour = drawing.read_file(run.path, lambda file: run.default_colour(file, frames[0]))
    return colour if all(colour in other.quantities for other in runs) else None


def picture_name(request, runs, frame, colour):
    """Returns the name of a picture, which states its contents."""
    stem = Path(runs[0].path).with_suffix("")
    beside = "".join(f"-beside-{Path(run.path).stem}" for run in runs[1:])
    cut = f"-cut-{request.cut.replace('=', '-')}" if request.cut else ""
    return f"{stem}{beside}-frame-{frame}{'-' + colour if colour else ''}{cut}.png"


def picture_names(request, runs, frames, colour):
    if request.out is None:
        return [picture_name(request, runs, words(shown), colour) for shown in frames]
    if len(frames) == 1:
        return [request.out]
    path = Path(request.out)
    return [str(path.with_name(f"{path.stem}-{words(shown)}{path.suffix}")) for shown in frames]


def words(frames):
    """Formats the frame of each run for the file name: "10" if it is the same for all, else "128-13"."""
    return "-".join(str(frame) for frame in (frames if len(set(frames)) > 1 else frames[:1]))


class Pictures:
    """Draws frames in sequence on one sheet; their common parts are drawn once."""

    def __init__(self, runs, scale, colour):
        from .layout import PanelLayout

        drawing.set_style()
        self.runs, self.scale, self.colour = runs, scale, colour
        self.layout = PanelLayout([run.size for run in runs], scale is not None)
        if scale is not None:
            draw_bar(self.layout.figure, self.layout.bar, scale)
        self.heads = []

    def draw(self, frames, fields=None):
        """Draws one frame of each run. Returns the figure."""
        for head in self.heads:
            head.remove()
        self.heads = []
        for k, (run, frame) in enumerate(zip(self.runs, frames)):
            axes = self.layout.panels[k]
            axes.clear()
            field = None if fields is None else fields[k]
            shown = drawing.read_file(run.path, lambda file: run.read(file, frame, self.colour, field))
            run.draw(axes, shown, self.scale)
            self.heads += self.layout.head(k, run.title, run.caption(shown), run.warning)
        return self.layout.figure


def set_cut(runs, cut):
    for run in runs:
        if cut and len(getattr(run, "box", ())) < 3:
            raise InputError(f"--cut is for scenes in space: {run.path} is of a plane")
        if cut:
            from .space import read_cut

            run.cut = read_cut(cut, run.box, run.unit)


def frames_of(request, runs):
    """Returns the frame of each run, for each picture."""
    written = request.frames if request.frame is None else str(request.frame)
    if written is None:
        return [[len(run.times) - 1 for run in runs]]
    for run in runs:
        frames = listed_frames(written, run.path, len(run.times))
    return [[frame] * len(runs) for frame in frames]


def plot_frames(request):
    """Draws the frames of a request of `lichtenberg plot`. Throws InputError and Failure."""
    runs = [read_run(path) for path in request.result]
    frames = frames_of(request, runs)
    set_cut(runs, request.cut)
    colour = request.colour or default_colour(runs, frames[len(frames) // 2])
    scale = common_scale(runs, colour, request.range, request.cmap)
    names = picture_names(request, runs, frames, colour)
    for name in names:
        drawing.check_picture(name, request.overwrite)
    first = Fields(runs[0].path, [indices[0] for indices in frames]) if colour == "potential" else None
    pictures = Pictures(runs, scale, colour)  # in parallel with the program, which computes the fields of the first run
    fields = []
    if first:
        fields = [first.values()]
        fields += [Fields(run.path, own).values() for run, own in list(zip(runs, zip(*frames)))[1:]]
    if any(field is None for field in fields):
        fields = []
    for k, (shown, name) in enumerate(zip(frames, names)):
        drawing.save(pictures.draw(shown, [field[k] for field in fields] or None), name)
        drawing.messages.say(f"{name} shows frame {words(shown)}{' by ' + colour if colour else ''}")


def draw_last(run, colour, picture):
    drawing.save(Pictures([run], common_scale([run], colour), colour).draw([len(run.times) - 1]), picture)


def draw_run(path):
    """Draws the pictures of a run that has just ended; they replace its earlier pictures."""
    stem, run = Path(path).with_suffix(""), read_run(path)
    draw_last(run, default_colour([run], [len(run.times) - 1]), f"{stem}.png")
    if drawing.read_file(path, lambda file: "gas" in file):
        from . import series

        drawing.save(series.draw_runs([series.read(path)], None), f"{stem}-series.png")


def draw_solution(path, out):
    """Draws the solution of `lichtenberg solve`."""
    drawing.check_picture(out, overwrite=True)
    draw_last(read_run(path), "potential", out)
