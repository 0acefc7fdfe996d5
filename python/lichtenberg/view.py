"""One HTML page that shows a run: view.html and view.js with the run's arrays in them, so that it needs no network.

Positions are stored in 65535 steps for each axis, other numbers with 13 binary digits. A frame is stored as the bytewise
difference from the frame before, deflated, in base64. view.js decodes it.
"""
import base64
import html
import json
import re
import zlib
from pathlib import Path

import numpy as np

from .ground import electrodes_of, nearest_ground
from .ranges import colour_range
from .errors import InputError
from .files import check_output, write_whole
from .result import TO_GROUND, UNCONNECTED, chosen_frames

STEPS = 65535
MANTISSA = 12  # stored binary digits of a value's 23, without the leading one: a relative precision of 1e-4
INTEGERS = {"group", "cluster", "species"}  # numbers that name sets; they are not amounts


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
    """Collects the data of the page: numbers in `about`, compressed arrays in `arrays`."""

    def __init__(self, result, frames):
        self.result, self.frames = result, list(frames)
        self.arrays = {}
        self.about = {
            "title": result.title or Path(result.path).name,
            "file": Path(result.path).name,
            "frames": self.frames,
            "count": result.count,
            "dimension": result.dimension,
            "time": numbers(result.time[self.frames]),
            "timeUnit": "iterations" if "packing" in result.tables else result.time.unit,
            "lengthUnit": result.size.unit,
            "size": numbers(result.size),
            "periodic": result.periodic,
            "down": None if result.down is None else numbers(result.down),
            "scene": result.scene,
            "provenance": result.provenance,
            "warnings": result.warnings,
            "summary": {name: value if np.isfinite(value) else None for name, value in result.summary.items()},
        }
        self.add_positions()
        self.about["columns"] = list(self.columns())
        self.add_edges()
        self.about["electrodes"] = electrodes_of(result)
        self.about["curves"] = list(curves_of(result))

    def add_positions(self):
        positions = np.asarray(self.result["position"][self.frames])
        if not np.isfinite(positions).all():
            raise InputError(f"{self.result.path} has positions that are no numbers")
        self.box = np.zeros(3)
        self.box[: self.result.dimension] = self.result.size
        self.low = np.minimum(0, positions.min(axis=(0, 1), initial=0))
        self.high = np.maximum(self.box, positions.max(axis=(0, 1), initial=0))
        self.about["low"], self.about["high"] = numbers(self.low), numbers(self.high)
        self.arrays["places"] = packed(quantized(positions, self.low, self.high))
        self.arrays["radius"] = packed(rounded(self.result["radius"])[None])

    def columns(self):
        """Yields the quantities that colour particles: name, unit, whether it names sets, and whether it changes."""
        for name in self.result.columns:
            if name in ("position", "image", "successor", "species"):
                continue
            values = self.result[name]
            changes = self.result.changes(name)
            unit, values = values.unit, np.asarray(values if changes else values[None])
            if values.ndim == 3:  # vectors
                name, values = "speed" if name == "velocity" else f"|{name}|", np.linalg.norm(values, axis=2)
            yield self.column(name, unit, values)
        yield from self.columns_of_tree()
        stored = self.result.tables.get("analysis", {})
        for name, values in stored.items():
            if values.shape == (len(self.result), self.result.count):
                yield self.column(name, values.unit, np.asarray(values))

    def columns_of_tree(self):
        if "successor" not in self.result.columns:
            return
        connected = np.asarray(self.result["successor"]) != UNCONNECTED
        yield self.column("connected", "1", connected.astype(np.int32), sets=True)
        joined = np.where(connected.any(axis=0), self.result.time[connected.argmax(axis=0)], np.nan)
        yield self.column("first joined the tree at", self.about["timeUnit"], joined[None])

    def column(self, name, unit, values, sets=None):
        """Adds the values of all frames, or one row if they are constant. Returns the description of the column."""
        sets = name in INTEGERS if sets is None else sets
        low, high = (0, 0) if sets else colour_range(name, values)
        changes = len(values) == len(self.result)
        values = values[self.frames] if changes else values
        self.arrays[f"column {name}"] = packed(values.astype(np.int32) if sets else rounded(values))
        return {"name": name, "unit": unit, "sets": sets, "changes": changes, "low": float(low), "high": float(high)}

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


def curves_of(result):
    """Returns the curves: name, unit, time and values of each."""
    time = numbers(result.time)
    for name, values in result.observables.items():
        columns = values.reshape(len(values), -1).T if values.ndim > 1 else values[None]
        labels = result.terminals.get(name, [])
        for k, column in enumerate(columns):
            label = f", {labels[k]}" if k < len(labels) else f"[{k}]" if len(columns) > 1 else ""
            yield {"name": name + label, "unit": values.unit, "time": time, "values": numbers(column)}
    for table, axis in [("gas", "time"), ("relaxation", "iteration")]:
        series = result.tables.get(table, {})
        for name, values in series.items():
            if name != axis and values.ndim == 1:
                yield {"name": f"{table}: {name}", "unit": values.unit, "time": numbers(series[axis]), "values": numbers(values)}


def write_page(result, out, frames=None, overwrite=False):
    """Writes the page of the frames (given as in "0:100:10") and returns its path. Throws InputError and Failure."""
    check_output(out, overwrite)
    write_whole(out, Page(result, chosen_frames(result, frames)).html())
    return out
