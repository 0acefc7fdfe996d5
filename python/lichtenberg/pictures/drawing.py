"""Functions for all pictures: reading a result, disks and lines, electrodes, a scale bar, saving."""
import json
import os
import re
from dataclasses import dataclass
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.patches import Circle, PathPatch, Polygon, Rectangle
from matplotlib.path import Path as Outline
from matplotlib.transforms import Affine2D, offset_copy

from .. import ground, messages
from ..errors import Failure, InputError
from ..files import check_output, created
from ..result import TO_GROUND, UNCONNECTED, check_result, identity, opened

STEEL, INK, ISOLATED, ELECTRODE = "#e8e8e8", "#1a1a1a", "#ffc20a", "#8c8c8c"
WARNING = "#b00020"
MM = 1e3  # millimetres per metre: all drawings are in millimetres


@dataclass
class Side:
    potential: float
    start: np.ndarray  # its ends, [2] mm
    end: np.ndarray


@dataclass
class Electrode:
    shape: str  # disk, bar or ring
    potential: float
    geometry: dict  # centre and radius, or from, to and width; mm


@dataclass
class Snapshot:
    """One frame. Lengths in mm."""

    title: str
    time: float  # s
    size: np.ndarray  # [2] of the domain
    position: np.ndarray  # [N, 2]
    radius: np.ndarray  # [N]
    contact_gap: float  # nan without contacts
    successor: np.ndarray | None  # [N]
    potential: np.ndarray | None  # [N] V
    sides: list
    electrodes: list

    @property
    def connected(self):
        """[N] True for conductors with a path to the ground."""
        return np.zeros(len(self.radius), bool) if self.successor is None else self.successor != UNCONNECTED


def scene_size(file):
    """Returns the size (m) of the domain, [2] or [3], as the scene states it."""
    domain = file["scene/domain"]
    return np.append(domain["size"][:2], domain["height"][()] if "height" in domain else [])


def size_in(file, frame):
    """Returns the size (m) of the domain, [2] or [3], in a frame: that of the load, if a packing has loads."""
    size = scene_size(file)
    if "observables/size_x" not in file:
        return size
    return np.array([file[f"observables/size_{axis}/value"][frame] for axis in "xyz"[: len(size)]])


def read_sides(domain):
    width, height = domain["size"][:2] * MM
    corners = np.array([[0, 0], [width, 0], [0, height], [width, height]])
    ends = [(0, 2), (1, 3), (0, 1), (2, 3)]  # left, right, bottom, top
    return [
        Side(potential, corners[a], corners[b])
        for (a, b), electrode, potential in zip(ends, domain["side_is_electrode"], domain["side_potential"])
        if electrode
    ]


def read_electrode(group):
    geometry = {name: data[()] * MM for name, data in group.items() if name != "potential"}
    return Electrode(group.attrs["shape"], group["potential"][()], geometry)


def read_file(path, reading):
    """Returns `reading(file)`. Reads again if a run has replaced the file meanwhile, because its segments may no longer
    exist. No lock is taken, so that no run is disturbed. Throws InputError."""
    for _ in range(20):
        before = identity(path)
        try:
            with opened(path) as file:
                result = reading(file)
        except OSError as error:
            raise InputError(f"{path} cannot be read as an HDF5 file ({error})") from None
        if identity(path) == before:
            return result
    raise InputError(f"{path} is replaced by its run faster than it can be read")


def read_json(path):
    """Throws InputError."""
    if not Path(path).is_file():
        raise InputError(f"{path} is no file")
    try:
        return json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{path} cannot be read as JSON ({error})") from None


def frame_index(file, path, frame):
    check_result(file, path)
    count = len(file["particles/conductors/position/time"])
    index = count - 1 if frame is None else frame
    if not 0 <= index < count:
        raise InputError(f"frame {frame} is not in {path}: it has frames 0 to {count - 1}")
    return index, count


def read(path, frame=None):
    """The frame of that index, by default the last. Throws InputError."""

    def reading(file):
        return read_snapshot(file, frame_index(file, path, frame)[0])

    return read_file(path, reading)


def read_snapshot(file, index):
    conductors, scene = file["particles/conductors"], file["scene"]
    return Snapshot(
        title=scene.attrs["title"],
        time=conductors["position/time"][index],
        size=scene["domain/size"][:2] * MM,
        position=conductors["position/value"][index, :, :2] * MM,
        radius=conductors["radius"][()] * MM,
        contact_gap=scene["contact_gap"][()] * MM if "contact_gap" in scene else np.nan,
        successor=conductors["successor/value"][index] if "successor" in conductors else None,
        potential=conductors["potential/value"][index] if "potential" in conductors else None,
        sides=read_sides(scene["domain"]),
        electrodes=[read_electrode(group) for group in scene["electrodes"].values()],
    )


def periodic_axes(particles, count):
    """Returns an array of `count` elements that is true for each periodic axis of the box of a group of particles."""
    kinds = np.resize(particles["box"].attrs.get("boundary", "none"), count)
    return np.array([kind in ("periodic", b"periodic") for kind in kinds])


def with_images(centre, radius, period):
    """Returns indices and positions of disks. Disks that a periodic side cuts appear again as images. `period`: [2] lengths of
    the domain along periodic axes, infinite along others."""
    disk = np.arange(len(radius))
    for axis in np.flatnonzero(np.isfinite(period)):
        length = period[axis]
        over = [(centre[:, axis] < radius[disk], length), (centre[:, axis] > length - radius[disk], -length)]
        shift = np.eye(2)[axis]
        centre = np.vstack([centre] + [centre[cut] + by * shift for cut, by in over])
        disk = np.concatenate([disk] + [disk[cut] for cut, _ in over])
    return disk, centre


def nearest_ground(point, snapshot):
    """Returns the nearest point (mm) on a side or an electrode, where a conductor's path to the ground ends."""
    return nearest_grounds(np.asarray(point)[None], snapshot)[0]


def nearest_grounds(points, snapshot):
    sides = [{"shape": "side", "ends": [*side.start, *side.end]} for side in snapshot.sides]
    return ground.nearest_ground(points, sides + [{"shape": e.shape, **e.geometry} for e in snapshot.electrodes])


def tree_edges(snapshot):
    """[M, 2, 2] from each connected conductor to its successor."""
    start = np.flatnonzero(snapshot.connected)
    successor = snapshot.successor[start] if len(start) else start
    end = snapshot.position[np.maximum(successor, 0)]
    end[successor == TO_GROUND] = nearest_grounds(snapshot.position[start[successor == TO_GROUND]], snapshot)
    return np.stack([snapshot.position[start], end], axis=1)


def line_width(axes, snapshot, radii, points):
    """Returns a line width (points) of `radii` radii, at most `points`."""
    if len(snapshot.radius) == 0:
        return points
    return min(radii * np.median(snapshot.radius) * points_a_unit(axes), points)


def points_a_unit(axes):
    """Returns the drawn size (points) of a unit of length."""
    if axes.figure.get_layout_engine() is None:
        axes.apply_aspect()
    else:
        axes.figure.canvas.draw()  # the layout is computed here
    (left, _), (right, _) = axes.transData.transform([(0, 0), (1, 0)])
    return (right - left) * 72 / axes.figure.dpi


def draw_disks(axes, snapshot, chosen, **style):
    diameter = 2 * snapshot.radius[chosen]
    placement = {"units": "xy", "offsets": snapshot.position[chosen], "offset_transform": axes.transData}
    style = {"edgecolor": INK, "linewidth": line_width(axes, snapshot, 0.1, 0.8), "zorder": 3, **style}
    axes.add_collection(EllipseCollection(diameter, diameter, np.zeros_like(diameter), **placement, **style))


def draw_conductors(axes, snapshot):
    """Draws connected conductors in a steel colour, the others in a colour that is not on the potential scale."""
    draw_disks(axes, snapshot, snapshot.connected, facecolor=STEEL)
    draw_disks(axes, snapshot, ~snapshot.connected, facecolor=ISOLATED)


def draw_edges(axes, snapshot, edges, **style):
    if len(edges) > 0:
        style = {"linewidths": line_width(axes, snapshot, 0.3, 2.5), "capstyle": "round", "zorder": 4, **style}
        axes.add_collection(LineCollection(edges, **style))


def bar_patch(axes, geometry, **style):
    start, width = geometry["from"], geometry["width"]
    along = geometry["to"] - start
    turned = Affine2D().rotate(np.arctan2(along[1], along[0])).translate(*start)
    return Rectangle((0, -width / 2), np.hypot(*along), width, transform=turned + axes.transData, **style)


def outside_patch(curve, size, **style):
    """Returns the domain outside of a closed curve [K, 2] as a patch. The curve runs clockwise to be a hole, and its last
    point is the first."""
    box = Outline([(0, 0), (size[0], 0), size, (0, size[1]), (0, 0)], closed=True)
    return PathPatch(Outline.make_compound_path(box, Outline(curve, closed=True)), **style)


def ring_patch(geometry, size, **style):
    """Returns the domain outside of the circle as a patch."""
    angle = np.linspace(0, -2 * np.pi, 361)
    circle = geometry["centre"] + geometry["radius"] * np.column_stack([np.cos(angle), np.sin(angle)])
    return outside_patch(circle, size, **style)


def electrode_patch(axes, electrode, size, **style):
    if electrode.shape == "disk":
        return Circle(electrode.geometry["centre"], electrode.geometry["radius"], **style)
    if electrode.shape == "bar":
        return bar_patch(axes, electrode.geometry, **style)
    if electrode.shape == "polygon":
        return Polygon(electrode.geometry["points"], **style)
    if electrode.shape == "hollow polygon":  # its points run clockwise
        points = electrode.geometry["points"]
        return outside_patch(np.vstack([points, points[:1]]), size, **style)
    return ring_patch(electrode.geometry, size, **style)


def draw_electrodes(axes, snapshot):
    for electrode in snapshot.electrodes:
        style = {"facecolor": ELECTRODE, "edgecolor": INK, "linewidth": 0.6, "zorder": 4.5}  # the lines end at the electrodes
        axes.add_patch(electrode_patch(axes, electrode, snapshot.size, **style))
    for side in snapshot.sides:
        style = {"color": ELECTRODE, "linewidth": 4, "solid_capstyle": "butt", "clip_on": False, "zorder": 5}
        axes.plot(*np.array([side.start, side.end]).T, **style)


def draw_scale(axes, snapshot):
    draw_length(axes, snapshot.size[0], lambda length: in_metres(length / MM))


def draw_length(axes, width, words):
    """A bar below the panel, a round length of about a fifth of its width, with words(length) next to it."""
    aim = 0.2 * width
    decade = 10.0 ** np.floor(np.log10(aim))
    length = max(m * decade for m in (1, 2, 5) if m * decade <= aim)
    below = offset_copy(axes.get_xaxis_transform(), fig=axes.figure, y=-10, units="points")
    style = {"color": INK, "linewidth": 1.5, "solid_capstyle": "butt", "clip_on": False}
    axes.plot([0, length], [0, 0], transform=below, **style)
    beside = offset_copy(below, fig=axes.figure, x=4, units="points")
    axes.text(length, 0, words(length), transform=beside, ha="left", va="center", fontsize=8)


def in_metres(length):
    """Formats a length with an SI prefix: 5 mm, 200 µm."""
    factor, prefix = prefixed(length)
    return f"{length * factor:.4g} {prefix}m"


def prefixed(largest):
    """Returns a factor that scales numbers up to this one to 1 ... 1000, and the matching SI prefix of the unit."""
    prefixes = "qryzafpnµm kMGTPEZYRQ"
    if not (largest > 0 and np.isfinite(largest)):
        return 1.0, ""
    power = int(np.clip(np.floor(np.log10(largest * (1 + 1e-9)) / 3), -10, 10))
    return 10.0 ** (-3 * power), prefixes[power + 10].strip()


SUPERSCRIPTS = str.maketrans("-\N{MINUS SIGN}0123456789", "⁻⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def in_symbols(unit):
    """Formats units such as m0 v0^2 and m s-1 with subscripts and superscripts."""
    indexed = re.sub("([a-z])_?0", r"\1₀", unit)
    return re.sub(r"(?<=[a-zA-Z₀])\^?(-?\d+)", lambda power: power[1].translate(SUPERSCRIPTS), indexed)


def with_unit(label, unit):
    return label if unit == "1" else f"{label} ({in_symbols(unit)})"


def axis_data(axis):
    """Returns label, ends, ticks and kind of an axis of matplotlib as plain data, for view.js."""

    def plain(text):
        words = re.sub(r"\$|\\mathdefault", "", text).replace(r"\times", "×")
        return re.sub(r"\^\{(.*?)\}", lambda power: power[1].translate(SUPERSCRIPTS), words).strip("{}")

    low, high = sorted(axis.get_view_interval())
    values = [float(value) for value in axis.get_majorticklocs() if low <= value <= high]
    formatter = axis.get_major_formatter()
    ticks = [[value, plain(text)] for value, text in zip(values, formatter.format_ticks(values))]
    words = {"label": axis.get_label_text(), "offset": plain(formatter.get_offset())}
    return {**words, "low": float(low), "high": float(high), "ticks": ticks, "log": axis.get_scale() == "log"}


def set_frame(axes, snapshot):
    axes.set(xlim=(0, snapshot.size[0]), ylim=(0, snapshot.size[1]), aspect="equal", xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set_linewidth(0.6)


def caption(snapshot):
    parts = [f"t = {snapshot.time:.4g} s", f"N = {len(snapshot.radius)}"]
    if snapshot.successor is not None:
        parts.append(f"{100 * snapshot.connected.mean():.3g} % connected")
    return ", ".join(parts)


def warning_line(warnings):
    """Returns the warnings of a result in one line; empty without warnings."""
    return "WARNING: " + "; ".join(words.split(": ")[0] for words in warnings) if warnings else ""


def set_style():
    plt.rcParams.update({"font.size": 9, "axes.titlesize": 10, "savefig.dpi": 200, "figure.dpi": 200})
    plt.rcParams["svg.fonttype"] = "none"  # text is stored as text, not as outlines


FORMATS = ("png", "pdf", "svg")


def check_picture(path, overwrite):
    """Throws InputError, before any work, for a picture that could not be written or would replace another."""
    path = Path(path)
    if path.suffix[1:] not in FORMATS:
        raise InputError(f"{path} is no picture that can be drawn: its name must end in .png, .pdf or .svg")
    check_output(path, overwrite)


def save(figure, path):
    """Writes a picture completely or not at all. Throws Failure."""
    partial = f"{path}.partial-{os.getpid()}"
    try:
        with open(created(partial), "wb") as file:
            figure.savefig(file, format=Path(path).suffix[1:] or "png")
        os.replace(partial, path)
    except (OSError, ValueError) as error:
        raise Failure(f"{path} cannot be written ({getattr(error, 'strerror', None) or error})") from None
    finally:
        Path(partial).unlink(missing_ok=True)
