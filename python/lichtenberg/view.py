"""One HTML page that shows a run: view.html and view.js with the run's arrays in them, so that it needs no network.

Quantities, colour scales, ticks, labels, camera and curves are those of pictures/, as data. Positions are stored in 65535 steps
for each axis, other numbers with 13 binary digits. A frame is stored as the bytewise difference from the frame before, deflated,
in base64. view.js decodes it.
"""
import base64
import html
import json
import re
import zlib
from pathlib import Path

import numpy as np
from matplotlib.colors import AsinhNorm, LogNorm, to_hex
from matplotlib.figure import Figure

from .errors import InputError
from .files import check_output, write_whole
from .ground import electrodes_of, nearest_ground
from .pictures import colours, drawing, packing, series, space
from .pictures.conductors import name_and_potential
from .pictures.frames import check_colour, open_run, read_range
from .result import TO_GROUND, chosen_frames

STEPS = 65535
MANTISSA = 12  # stored binary digits of a value's 23, without the leading one: a relative precision of 1e-4
NO_SET = np.iinfo(np.int32).min  # of a particle in no set


def packed(rows):
    """Returns [T, ...] integers of 2 or 4 bytes as base64 of deflated byte planes; each row is stored as the
    difference from the previous one."""
    rows = np.ascontiguousarray(rows).view(f"u{rows.itemsize}").reshape(len(rows), -1)
    rows = np.diff(rows, axis=0, prepend=np.zeros((1, rows.shape[1]), rows.dtype))
    planes = rows.astype(f"<u{rows.itemsize}").reshape(-1, 1).view(np.uint8).T
    return base64.b64encode(zlib.compress(planes.tobytes(), 6)).decode()


def rounded(values):
    """Returns 32-bit floats with MANTISSA digits, so that their bytes compress, as integers with the same bits."""
    bits = np.asarray(values, np.float32).view(np.uint32).astype(np.uint64)
    drop = 23 - MANTISSA
    return ((bits + (1 << (drop - 1))) >> drop << drop).astype(np.uint32)


def quantized(positions, low, high):
    """Returns [T, N, 3] positions as integer steps of the box from low to high."""
    extent = np.where(high > low, high - low, 1)
    return np.round((positions - low) / extent * STEPS).astype(np.uint16)


class Page:
    """Collects the data of the page: numbers in `about`, compressed arrays in `arrays`. `colour`: quantity that the page shows
    first, or None for that of pictures; `own_range`: range of its colours as for `plot`, "LOW,HIGH", or None."""

    def __init__(self, result, frames, colour=None, own_range=None):
        self.result, self.frames = result, list(frames)
        self.run = open_run(result.file, result.path)
        check_colour(self.run, colour)
        self.own_range = read_range(own_range)
        self.colour = colour or self.run.default_colour(result.file, self.frames[-1])
        self.arrays = {}
        loaded = "size_x" in result.observables  # a packing with loads, each in its own domain
        factor, prefix = drawing.prefixed(max(result.size)) if result.size.unit == "m" else (1.0, "")
        self.about = {
            "title": result.title or Path(result.path).name,
            "file": Path(result.path).name,
            "frames": self.frames,
            "captions": [self.run.caption(self.run.read(result.file, k, None)) for k in self.frames],
            "count": result.count,
            "dimension": result.dimension,
            "time": numbers(result.time[self.frames]),
            "lengthFactor": factor,
            "lengthUnit": prefix + drawing.in_symbols(result.size.unit),
            "size": numbers(result.size),
            "sizes": [numbers(result.frame(k).size) for k in self.frames] if loaded else None,
            "periodic": result.periodic,
            "scene": result.scene,
            "provenance": result.provenance,
            "warnings": result.warnings,
            "summary": {name: value if np.isfinite(value) else None for name, value in result.summary.items()},
            "camera": camera_of(self.run),
            "images": not loaded and result.dimension == 2,
            "paleColour": colours.PALE,
            "plainColour": drawing.STEEL,
            "path": f"path to {getattr(self.run, 'all_supplies', 'the ground')}",
            "packing": packing_data(result),
        }
        self.add_positions()
        self.about["columns"] = [self.column(name) for name in self.run.quantities]
        self.about["colour"] = self.colour
        self.add_edges()
        self.about["electrodes"] = [{**shape, "label": name_and_potential(shape)} for shape in electrodes_of(result)]
        self.about["curves"] = list(curves_of(result))

    def add_positions(self):
        positions = np.asarray(self.result["position"][self.frames])
        if not np.isfinite(positions).all():
            raise InputError(f"{self.result.path} has positions that are no numbers")
        box = np.zeros(3)
        box[: self.result.dimension] = self.result.size
        low = np.minimum(0, positions.min(axis=(0, 1), initial=0))
        high = np.maximum(box, positions.max(axis=(0, 1), initial=0))
        self.about["low"], self.about["high"] = numbers(low), numbers(high)
        self.arrays["places"] = packed(quantized(positions, low, high))
        self.arrays["radius"] = packed(rounded(self.result["radius"])[None])

    def column(self, name):
        """Adds the values of a quantity in all frames, or one row if they are constant. Returns its colour scale as data."""
        file = self.result.file
        own_range = self.own_range if name == self.colour else None
        scale = colours.scale_of(self.run.quantities[name], own_range, self.run.range(file, name))
        values = np.array([self.run.values(file, name, k) for k in self.frames], float)
        changes = not np.array_equal(values[1:], values[:-1], equal_nan=True)
        values = values if changes else values[:1]
        sets = scale.norm is None
        self.arrays[f"column {name}"] = packed(np.nan_to_num(values, nan=NO_SET).astype(np.int32) if sets else rounded(values))
        return {"changes": changes, **scale_data(scale)}

    def add_edges(self):
        """Adds contacts and the tree's edges as pairs of particles, and for the edges also points on the ground."""
        known = self.result.frames_with_contacts
        if known:
            none = np.empty((0, 2), np.int32)
            self.add_pairs("contacts", [self.result.read_contacts(k) if k in known else none for k in self.frames])
        if "successor" in self.result.columns:
            self.add_pairs("tree", [self.result.frame(index).tree for index in self.frames])
            self.add_ground_points()

    def add_pairs(self, name, lists):
        self.about[name] = np.cumsum([len(pairs) for pairs in lists]).tolist()  # end index of each frame
        self.arrays[name] = packed(np.concatenate(lists).astype(np.int32).T)

    def add_ground_points(self):
        """Adds the ground points of the tree's edges, in the order of edges, frame by frame."""
        electrodes = electrodes_of(self.result)
        points = []
        for index in self.frames:
            frame = self.result.frame(index)
            last = frame.tree[frame.tree[:, 1] == TO_GROUND, 0]
            ends = np.array(frame["position"])[last]
            axes = slice(self.result.dimension)
            ends[:, axes] = nearest_ground(ends[:, axes], electrodes)
            points.append(ends)
        self.arrays["ground"] = packed(rounded(np.concatenate(points)).reshape(1, -1))

    def html(self):
        here = Path(__file__).parent
        parts = {
            "TITLE": html.escape(self.about["title"]),
            "ABOUT": json.dumps(self.about, allow_nan=False).replace("<", "\\u003c"),
            "ARRAYS": json.dumps(self.arrays),
            "SCRIPT": (here / "view.js").read_text(encoding="utf-8"),
        }
        template = (here / "view.html").read_text(encoding="utf-8")
        return re.sub("@(TITLE|ABOUT|ARRAYS|SCRIPT)@", lambda mark: parts[mark[1]], template)


def numbers(values):
    """Returns a list for JSON with six digits; values that are not finite are null."""
    if np.ndim(values) > 1:
        return [numbers(row) for row in values]
    return [float(f"{value:.6g}") if np.isfinite(value) else None for value in np.asarray(values, float)]


def camera_of(run):
    """Returns the camera of the run's pictures: centre, and the ends of the window around it. In space also axes to the right,
    up and towards the eye, angles and distance of the eye, and the box with its labels."""
    if not run.spatial:
        corner, size = getattr(run, "window", (np.zeros(2), np.array(getattr(run, "box", run.size / drawing.MM))))
        ends = {"low": numbers(-0.52 * size), "high": numbers(0.52 * size)}
        return ends | {"centre": [*numbers(corner + size / 2), 0], "window": [numbers(corner), numbers(corner + size)]}
    corner, size = run.window
    camera = space.Camera(size, run.down)
    edges = space.edge_labels(camera, run.unit)
    labels = [{"at": numbers(corner + middle), "shift": shift, "text": text} for middle, shift, text in edges]
    return {
        "frame": camera.frame.tolist(),
        "turn": space.TURN,
        "rise": space.RISE,
        "distance": camera.distance,
        "centre": numbers(corner + camera.middle),
        "low": numbers(camera.low),
        "high": numbers(camera.high),
        "box": [numbers(corner), numbers(corner + size)],
        "labels": labels,
        "light": space.LIGHT.tolist(),
        "fog": space.FOG,
    }


def scale_data(scale):
    """Returns a colour scale as data, in the file's units; `bar` is the axis of its colour bar."""
    factor, label = scale.factor_and_label
    quantity = scale.quantity
    data = {"name": quantity.name, "label": label, "kind": quantity.kind, "pale": quantity.pale, "factor": factor}
    if scale.norm is None:
        return data
    norm = scale.norm
    return data | {
        "low": float(scale.low),
        "high": float(scale.high),
        "ends": [float(norm.vmin), float(norm.vmax)],
        "norm": "asinh" if isinstance(norm, AsinhNorm) else "log" if isinstance(norm, LogNorm) else "linear",
        "width": float(getattr(norm, "linear_width", 1)),
        "beyond": scale.beyond,
        "table": "".join(to_hex(colour)[1:] for colour in scale.cmap(np.arange(256))),
        "bar": drawing.axis_data(colours.draw_bar(Figure(figsize=(1, 4)), [0.4, 0.06, 0.2, 0.88], scale)),
    }


def packing_data(result):
    """Returns the rattlers of a packing at rest and, in the plane, its forces as lines, as in pictures of its last frame."""
    if "packing" not in result.file:
        return None
    shown = packing.DrawnPacking(result.file, None)
    data = {"frame": len(result) - 1, "rattlers": np.flatnonzero(shown.rattler).tolist(), "rattlerColour": packing.RATTLER, "lines": []}
    if len(shown.contacts) == 0 or shown.spatial:
        return data
    lines, contact = shown.lines_with_images()
    lines = np.pad(lines / drawing.MM, [(0, 0), (0, 0), (0, 1)])
    mean = {"widths": numbers(shown.force[contact] / shown.force.mean()), "colour": packing.FORCE, "label": packing.force_label(shown)}
    return data | mean | {"lines": numbers(lines.ravel())}


def curves_of(result):
    """Returns the panels of `plot --series`, then one for each other time series that varies: curves and axes, also with both
    axes logarithmic."""
    run = series.series_in(result.file, result.path)
    panels = [panel for panel in run.panels if all(name in run.columns for name, _ in panel.columns)]
    shown = {name for panel in panels for name, _ in [*panel.columns, panel.theory]}
    others = [name for name in sorted(run.columns) if name not in shown and series.varies(run, name)]
    drawing.set_style()
    for panel in panels + [series.plain_panel(name, run) for name in others]:
        axes = Figure(figsize=(3.6, 1.5)).add_axes([0.15, 0.2, 0.8, 0.75])
        series.draw_panel(axes, panel, [run], [0])
        data = {"start": run.start, "curves": [curve_data(line) for line in axes.lines], "axes": axes_data(axes)}
        if any(((line.get_xdata() > 0) & (line.get_ydata() > 0)).any() for line in axes.lines):
            axes.set(xscale="log", yscale="log")
            data["logarithmic"] = axes_data(axes)
        yield data


def axes_data(axes):
    return [drawing.axis_data(axes.xaxis), drawing.axis_data(axes.yaxis)]


def curve_data(line):
    label = "" if line.get_label().startswith("_") else line.get_label()
    style = {"label": label, "colour": to_hex(line.get_color()), "dashed": line.get_linestyle() != "-"}
    return style | {"x": numbers(line.get_xdata()), "y": numbers(line.get_ydata())}


def write_page(result, out, frames=None, overwrite=False, colour=None, own_range=None):
    """Writes the page of the frames (given as in "0:100:10") and returns its path. `colour`, `own_range`: as for Page. Throws
    InputError and Failure."""
    check_output(out, overwrite)
    write_whole(out, Page(result, chosen_frames(result, frames), colour, own_range).html())
    return out
