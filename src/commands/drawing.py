"""The picture of a conductor scene: potential, conductors, electrodes, the tree; and what all pictures share."""
import json
import os
import sys
from dataclasses import dataclass
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.colors import Normalize
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, PathPatch, Rectangle
from matplotlib.path import Path as Outline
from matplotlib.transforms import Affine2D

TO_GROUND, UNCONNECTED = -1, -2
STEEL, INK, ISOLATED, ELECTRODE = "#e8e8e8", "#1a1a1a", "#ffc20a", "#8c8c8c"
MM = 1e3  # millimetres a metre: all drawings are in millimetres


class InputError(Exception):
    """Input that cannot be used, as one sentence."""


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
    field: np.ndarray | None  # [ny, nx] V, potential at the centres of the cells; of the last frame only
    sides: list
    electrodes: list

    @property
    def connected(self):
        """[N] True for conductors with a path to the ground."""
        return np.zeros(len(self.radius), bool) if self.successor is None else self.successor != UNCONNECTED


def read_sides(domain):
    width, height = domain["size"][()] * MM
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
    """What `reading(file)` returns, which is done again if a run has replaced the file meanwhile: its segments may be
    gone. No lock is taken, so that no run is disturbed. Throws InputError."""
    for _ in range(20):
        before = identity(path)
        try:
            with h5py.File(path, locking=False) as file:
                result = reading(file)
        except OSError as error:
            raise InputError(f"{path} cannot be read as an HDF5 file ({error})") from None
        if identity(path) == before:
            return result
    raise InputError(f"{path} is replaced by its run faster than it can be read")


def identity(path):
    try:
        status = os.stat(path)
    except OSError as error:
        reason = "does not exist" if isinstance(error, FileNotFoundError) else f"cannot be read ({error.strerror})"
        raise InputError(f"{path} {reason}") from None
    return status.st_ino, status.st_mtime_ns


def report(path, work):
    """Does the work and returns the exit status: 2 for a file that cannot be drawn, with one sentence."""
    try:
        work()
        return 0
    except InputError as error:
        sentence = str(error)
    except Exception as error:  # whatever a damaged file, or one that another program has changed, leads to
        sentence = f"{path} cannot be drawn: it is damaged or incomplete ({type(error).__name__}: {error})"
    print(f"lichtenberg: {' '.join(sentence.split())}", file=sys.stderr)
    return 2


def read_json(path):
    """Throws InputError."""
    try:
        return json.loads(Path(path).read_text())
    except (OSError, ValueError) as error:
        raise InputError(f"{path} cannot be read as JSON ({error})") from None


def frame_index(file, path, frame):
    if "particles/conductors/position/time" not in file:
        raise InputError(f"{path} holds no frames: there is nothing to draw")
    count = len(file["particles/conductors/position/time"])
    if count == 0:
        raise InputError(f"{path} holds no frames: there is nothing to draw")
    index = count - 1 if frame is None else frame
    if not 0 <= index < count:
        raise InputError(f"frame {frame} is not in {path}: it has frames 0 to {count - 1}")
    return index, count


def read(path, frame=None):
    """The frame of that index, by default the last. Throws InputError."""

    def reading(file):
        if "lichtenberg_result" not in file.attrs:
            raise InputError(f"{path} was not written by `lichtenberg run`")
        return read_snapshot(file, *frame_index(file, path, frame))

    return read_file(path, reading)


def read_snapshot(file, index, count):
    conductors, scene = file["particles/conductors"], file["scene"]
    field = file.get("VTKHDF/PointData/potential") if index == count - 1 else None
    return Snapshot(
        title=scene.attrs["title"],
        time=conductors["position/time"][index],
        size=scene["domain/size"][:2] * MM,
        position=conductors["position/value"][index, :, :2] * MM,
        radius=conductors["radius"][()] * MM,
        contact_gap=scene["contact_gap"][()] * MM if "contact_gap" in scene else np.nan,
        successor=conductors["successor/value"][index] if "successor" in conductors else None,
        potential=conductors["potential/value"][index] if "potential" in conductors else None,
        field=field[0] if field is not None else None,
        sides=read_sides(scene["domain"]),
        electrodes=[read_electrode(group) for group in scene["electrodes"].values()],
    )


def nearest_on_segment(point, start, end):
    along = end - start
    return start + np.clip(np.dot(point - start, along) / np.dot(along, along), 0, 1) * along


def nearest_on_electrode(point, electrode):
    """The point of its surface that is nearest to a point outside; for a bar, of its axis."""
    if electrode.shape == "bar":
        return nearest_on_segment(point, electrode.geometry["from"], electrode.geometry["to"])
    offset = point - electrode.geometry["centre"]
    return electrode.geometry["centre"] + electrode.geometry["radius"] * offset / np.hypot(*offset)


def nearest_ground(point, snapshot):
    candidates = [nearest_on_segment(point, side.start, side.end) for side in snapshot.sides]
    candidates += [nearest_on_electrode(point, electrode) for electrode in snapshot.electrodes]
    return min(candidates, key=lambda candidate: np.hypot(*(candidate - point)))


def tree_edges(snapshot):
    """[M, 2, 2] from each connected conductor to its successor."""
    ends = []
    for i in np.flatnonzero(snapshot.connected):
        j = snapshot.successor[i]
        end = nearest_ground(snapshot.position[i], snapshot) if j == TO_GROUND else snapshot.position[j]
        ends.append([snapshot.position[i], end])
    return np.array(ends)


def line_width(axes, snapshot, radii, points):
    """A width of so many radii, but at most so many points."""
    axes.figure.canvas.draw()  # decides how large a millimetre is
    (left, _), (right, _) = axes.transData.transform([(0, 0), (1, 0)])
    points_a_millimetre = (right - left) * 72 / axes.figure.dpi
    return min(radii * np.median(snapshot.radius) * points_a_millimetre, points)


def potential_colours(values):
    """White is 0 V, with a colour for each sign, equally strong at equal potentials; None if all is at 0 V."""
    low, high = min(values.min(), 0), max(values.max(), 0)
    reach = max(high, -low)
    if reach == 0:
        return None
    if min(high, -low) > 1e-3 * reach:
        return {"cmap": "RdBu_r", "norm": Normalize(-reach, reach)}
    return {"cmap": "Blues" if high > -low else "Reds_r", "norm": Normalize(low, high)}


def draw_colour_bar(axes, colours, values):
    bar = axes.figure.colorbar(ScalarMappable(**colours), cax=axes.inset_axes([1.03, 0, 0.03, 1]))
    bar.ax.set_ylim(min(values.min(), 0), max(values.max(), 0))
    bar.set_label("potential (V)")
    bar.outline.set_linewidth(0.6)


def draw_field(axes, snapshot, colours):
    extent = (0, snapshot.size[0], 0, snapshot.size[1])
    axes.imshow(snapshot.field, origin="lower", extent=extent, interpolation="bilinear", **colours)


def draw_disks(axes, snapshot, chosen, **style):
    diameter = 2 * snapshot.radius[chosen]
    place = {"units": "xy", "offsets": snapshot.position[chosen], "offset_transform": axes.transData}
    style = {"edgecolor": INK, "linewidth": line_width(axes, snapshot, 0.1, 0.8), "zorder": 3, **style}
    axes.add_collection(EllipseCollection(diameter, diameter, np.zeros_like(diameter), **place, **style))


def draw_conductors(axes, snapshot):
    """Connected ones as steel, the others in a colour that no potential has."""
    draw_disks(axes, snapshot, snapshot.connected, facecolor=STEEL)
    draw_disks(axes, snapshot, ~snapshot.connected, facecolor=ISOLATED)


def draw_potential(axes, snapshot):
    """The field behind the conductors; where the file has none for the frame, the conductors' own potentials."""
    values = snapshot.field if snapshot.field is not None else snapshot.potential
    colours = potential_colours(values) if values is not None else None
    if snapshot.field is not None or colours is None:
        draw_conductors(axes, snapshot)
        draw_legend(axes, snapshot)
    else:
        everyone = np.ones(len(snapshot.radius), bool)
        draw_disks(axes, snapshot, everyone, array=snapshot.potential, **colours)
    if colours is not None:
        draw_colour_bar(axes, colours, values)
        if snapshot.field is not None:
            draw_field(axes, snapshot, colours)


def draw_edges(axes, snapshot, edges, **style):
    if len(edges) > 0:
        style = {"linewidths": line_width(axes, snapshot, 0.3, 2.5), "capstyle": "round", "zorder": 4, **style}
        axes.add_collection(LineCollection(edges, **style))


def bar_patch(axes, geometry, **style):
    start, width = geometry["from"], geometry["width"]
    along = geometry["to"] - start
    turned = Affine2D().rotate(np.arctan2(along[1], along[0])).translate(*start)
    return Rectangle((0, -width / 2), np.hypot(*along), width, transform=turned + axes.transData, **style)


def ring_patch(geometry, size, **style):
    """All of the domain outside of the circle, which runs clockwise to be a hole."""
    box = Outline([(0, 0), (size[0], 0), size, (0, size[1]), (0, 0)], closed=True)
    angle = np.linspace(0, -2 * np.pi, 361)
    circle = geometry["centre"] + geometry["radius"] * np.column_stack([np.cos(angle), np.sin(angle)])
    return PathPatch(Outline.make_compound_path(box, Outline(circle, closed=True)), **style)


def electrode_patch(axes, electrode, size, **style):
    if electrode.shape == "disk":
        return Circle(electrode.geometry["centre"], electrode.geometry["radius"], **style)
    if electrode.shape == "bar":
        return bar_patch(axes, electrode.geometry, **style)
    return ring_patch(electrode.geometry, size, **style)


def draw_electrodes(axes, snapshot):
    for electrode in snapshot.electrodes:
        style = {"facecolor": ELECTRODE, "edgecolor": INK, "linewidth": 0.6, "zorder": 2}
        axes.add_patch(electrode_patch(axes, electrode, snapshot.size, **style))
    for side in snapshot.sides:
        style = {"color": ELECTRODE, "linewidth": 4, "solid_capstyle": "butt", "clip_on": False, "zorder": 5}
        axes.plot(*np.array([side.start, side.end]).T, **style)


def draw_scale(axes, snapshot):
    """A bar below the domain, a round length of about a fifth of its width."""
    aim = 0.2 * snapshot.size[0]
    decade = 10.0 ** np.floor(np.log10(aim))
    length = max(m * decade for m in (1, 2, 5) if m * decade <= aim)
    y = -0.025 * snapshot.size[1]
    axes.plot([0, length], [y, y], color=INK, linewidth=1.5, solid_capstyle="butt", clip_on=False)
    axes.text(length / 2, 1.5 * y, f"{length:g} mm", ha="center", va="top")


def draw_legend(axes, snapshot):
    """What the two colours of conductors mean, below the domain, where both occur."""
    if snapshot.connected.all() or not snapshot.connected.any():
        return
    style = {"linestyle": "", "marker": "o", "markersize": 6, "markeredgecolor": INK, "markeredgewidth": 0.6}
    handles = [
        Line2D([], [], markerfacecolor=colour, label=label, **style)
        for colour, label in [(STEEL, "connected to the ground"), (ISOLATED, "not connected")]
    ]
    where = {"loc": "upper right", "bbox_to_anchor": (1, 0), "ncols": 2, "borderaxespad": 0.5, "handletextpad": 0}
    axes.legend(handles=handles, frameon=False, **where)


def set_frame(axes, snapshot):
    axes.set(xlim=(0, snapshot.size[0]), ylim=(0, snapshot.size[1]), aspect="equal", xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set_linewidth(0.6)


def caption(snapshot):
    parts = [f"t = {snapshot.time:.4g} s", f"N = {len(snapshot.radius)}"]
    if snapshot.successor is not None:
        parts.append(f"{100 * snapshot.connected.mean():.3g} % connected")
    return ", ".join(parts)


def set_style():
    plt.rcParams.update({"font.size": 9, "axes.titlesize": 10, "savefig.dpi": 200, "figure.dpi": 200})


def draw(snapshot):
    """The whole picture, as a figure."""
    set_style()
    aspect = snapshot.size[1] / snapshot.size[0]
    figure, axes = plt.subplots(figsize=(6, 0.9 + 5 * aspect), layout="constrained")
    set_frame(axes, snapshot)
    draw_potential(axes, snapshot)
    draw_electrodes(axes, snapshot)
    draw_edges(axes, snapshot, tree_edges(snapshot), color=INK)
    draw_scale(axes, snapshot)
    axes.set_title(f"{snapshot.title}\n{caption(snapshot)}" if snapshot.title else caption(snapshot))
    return figure


def save(figure, path):
    """Whole or not at all. Throws InputError."""
    partial = f"{path}.partial"
    try:
        figure.savefig(partial, format=Path(path).suffix[1:] or "png")
        os.replace(partial, path)
    except (OSError, ValueError) as error:
        raise InputError(f"{path} cannot be written ({error})") from None
