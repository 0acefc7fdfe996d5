#!/usr/bin/python3
"""Draws frames of result files: of conductors, of a packing or of a gas of grains.

    plot.py FILE ... [--frames 0,5,10] [--colour NAME] [--range LOW,HIGH] [--cmap NAME] [--cut z=0.01] [--out PICTURE]
                     [--fields FILE] [--overwrite] [--quiet]
    plot.py FILE --of-run                       what a run leaves: FILE.png, and of a gas FILE-series.png too

Colours, their range and the layout are the same for all frames of a run. Several files are drawn beside each other, in
the same colours.

Exit status 2 and one sentence for input that cannot be used.
"""
import interrupted  # before all else

import argparse
import functools
import sys
from pathlib import Path

import drawing
from colours import draw_bar, scale_of
from drawing import InputError
from lichtenberg.result import warnings_of


def open_run(file, path):
    """What there is to draw, by kind. Imports of other kinds cost time."""
    drawing.frame_index(file, path, None)
    if "walls" in file["scene"]:
        from plot_packing import Packing as Kind
    elif "gas" not in file and "height" in file["scene/domain"] and "potential" in file["particles/conductors"]:
        from plot_conductors import ConductorsInSpace as Kind
    elif "gas" in file or "height" in file["scene/domain"]:
        from plot_gas import Grains as Kind
    else:
        from plot_conductors import Conductors as Kind
    run = Kind(file, path)
    run.warning = drawing.warning_line(warnings_of(file))
    return run


def read_run(path):
    return drawing.read_file(path, lambda file: open_run(file, path))


def read_range(text):
    """ "LOW,HIGH" as numbers; None for None. Throws InputError."""
    if text is None:
        return None
    try:
        low, high = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"--range {text} is not understood: two numbers are wanted, as in --range=-200,200") from None
    if not abs(low) < float("inf") or not abs(high) < float("inf"):
        raise InputError(f"--range {text} is not allowed: both ends must be finite numbers")
    if low >= high:
        raise InputError(f"--range {text} is the wrong way round: the lower end comes first, and is less than the other")
    return low, high


def check_colour(run, colour):
    """Throws InputError for a quantity that the result does not have."""
    if colour is None or colour in run.quantities:
        return
    known = ", ".join(run.quantities) or "none"
    if colour == "current" and "order" in run.quantities:
        where = "that is known where effects.current_source feeds all alike"
        raise InputError(f"{run.path} has no current by conductor: {where}; it has {known}")
    raise InputError(f"{run.path} has no {colour} to colour by: it has {known}")


def common_scale(runs, colour, request):
    """One scale for all runs: from the lowest to the highest of their ranges."""
    for run in runs:
        check_colour(run, colour)
    if colour is None:
        return None
    ranges = [drawing.read_file(run.path, lambda file: run.range(file, colour)) for run in runs]
    found = functools.reduce(lambda one, other: one.joined(other), ranges)
    return scale_of(runs[0].quantities[colour], read_range(request.range), found, request.cmap)


def default_colour(runs, frames):
    """That which the first run suggests, if all have it."""
    run = runs[0]
    colour = drawing.read_file(run.path, lambda file: run.default_colour(file, frames[0]))
    return colour if all(colour in other.quantities for other in runs) else None


def picture_name(request, runs, frame, colour):
    """Says what it shows."""
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
    """ "10" of all runs, or "128-13"."""
    return "-".join(str(frame) for frame in (frames if len(set(frames)) > 1 else frames[:1]))


class Pictures:
    """Draws frame after frame on one sheet: what all have in common stays."""

    def __init__(self, runs, scale, colour):
        from sheet import Sheet

        drawing.set_style()
        self.runs, self.scale, self.colour = runs, scale, colour
        self.sheet = Sheet([run.size for run in runs], scale is not None)
        if scale is not None:
            draw_bar(self.sheet.figure, self.sheet.bar, scale)
        self.heads = []

    def draw(self, frames, fields=None):
        """A frame of each run; returns the figure."""
        for head in self.heads:
            head.remove()
        self.heads = []
        for k, (run, frame) in enumerate(zip(self.runs, frames)):
            axes = self.sheet.panels[k]
            axes.clear()
            field = None if fields is None else fields[k]
            shown = drawing.read_file(run.path, lambda file: run.read(file, frame, self.colour, field))
            run.draw(axes, shown, self.scale)
            self.heads += self.sheet.head(k, run.title, run.caption(shown), run.warning)
        return self.sheet.figure


def read_fields(path):
    """[frames, ny, nx] V that `lichtenberg plot` has solved (frame_fields.hpp); None for no path."""
    import numpy as np

    if path is None:
        return None
    nx, ny = np.fromfile(path, np.int32, 2)
    return np.memmap(path, np.float32, "r", offset=8).reshape(-1, ny, nx)


def set_cut(runs, cut):
    for run in runs:
        if cut and len(getattr(run, "box", ())) < 3:
            raise InputError(f"--cut is for scenes in space: {run.path} is of a plane")
        if cut:
            from plot_space import read_cut

            run.cut = read_cut(cut, run.box, run.unit)


def plot_frames(request):
    runs = [read_run(path) for path in request.files]
    frames = [[len(run.times) - 1 for run in runs]]  # of each run, picture by picture
    if request.frames:
        frames = [[int(k)] * len(runs) for k in request.frames.split(",")]
    for run in runs:
        for shown in frames:
            drawing.read_file(run.path, lambda file: drawing.frame_index(file, run.path, shown[runs.index(run)]))
    set_cut(runs, request.cut)
    colour = request.colour or default_colour(runs, frames[len(frames) // 2])
    scale = common_scale(runs, colour, request)
    names = picture_names(request, runs, frames, colour)
    for name in names:
        drawing.check_picture(name, request.overwrite)
    fields = [read_fields(path) for path in request.fields.split(",")] if request.fields else None
    pictures = Pictures(runs, scale, colour)
    for k, (shown, name) in enumerate(zip(frames, names)):
        drawing.save(pictures.draw(shown, fields and [field[k] for field in fields]), name)
        if not request.quiet:
            drawing.messages.say(f"{name} shows frame {words(shown)}{' by ' + colour if colour else ''}")


def plot_end(request):
    """The pictures of a run that has just ended, which replaces those that it left before."""
    stem = Path(request.files[0]).with_suffix("")
    run = read_run(request.files[0])
    last = [len(run.times) - 1]
    colour = default_colour([run], last)
    drawing.save(Pictures([run], common_scale([run], colour, request), colour).draw(last), f"{stem}.png")
    if drawing.read_file(run.path, lambda file: "gas" in file):
        import plot_series

        drawing.save(plot_series.draw_runs([plot_series.read(run.path)], None), f"{stem}-series.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="+", help="result files of runs (.h5)")
    parser.add_argument("--frames", help="indices, from 0, separated by commas (default: the last)")
    parser.add_argument("--colour", "--color", help="what particles are coloured by")
    parser.add_argument("--range", help="LOW,HIGH: of the colours (default: that of the whole run)")
    parser.add_argument("--cmap", help="matplotlib's name of a colour map")
    parser.add_argument("--cut", help="AXIS=PLACE: of a scene in space what lies behind, seen from the eye")
    parser.add_argument("--fields", help="potentials of the frames")
    parser.add_argument("--of-run", action="store_true", help="draw what a run leaves")
    parser.add_argument("--out", help="picture to write, .png, .pdf or .svg")
    parser.add_argument("--overwrite", action="store_true", help="replace pictures that exist")
    parser.add_argument("--quiet", action="store_true", help="do not say what has been drawn")
    request = parser.parse_args()
    return drawing.report(request.files[0], lambda: (plot_end if request.of_run else plot_frames)(request))


if __name__ == "__main__":
    sys.exit(main())
