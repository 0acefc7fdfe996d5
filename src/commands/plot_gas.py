"""The pictures of a gas of grains: where they are, and its course over time; `plot.py` calls it.

Grains in space are seen in perspective, painted from far to near and paler where they are far. Colour is charge or, if
all have the same or it is asked for, the cluster that they are in.
"""
import tomllib
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.colors import Normalize, to_rgba
from matplotlib.ticker import LogLocator, MaxNLocator

import drawing

LONE, EDGE, FOG = "#dcdcdc", "#4d4d4d", "#ffffff"
THEORY = "#d95f02"
TURN, RISE = np.radians(28), np.radians(18)  # of the eye about the box
DISTANCE = 2.6  # of the eye from the middle of the box, in its longest edges


def is_gas(path):
    return drawing.read_file(path, lambda file: "lichtenberg_result" in file.attrs and "gas" in file)


class DrawnGas:
    """A frame, in units of the scene's scales, and the series of the run."""

    def __init__(self, file, path, frame):
        index, _ = drawing.frame_index(file, path, frame)
        particles = file["particles/conductors"]
        times = particles["position/time"]
        self.title = file["scene"].attrs["title"]
        self.time = times[index]
        self.spatial = "height" in file["scene/domain"]
        self.box = particles["box/edges"][()]
        self.position = particles["position/value"][index]
        self.radius = particles["radius"][()]
        self.charge = particles["charge/value"][index] if "charge" in particles else np.zeros(len(self.radius))
        self.cluster = particles["cluster/value"][index]
        self.series = {name: data[()] for name, data in file["gas"].items()}
        scene = tomllib.loads(text_of(file["scene/text"]))
        self.warm_up = sum(stage.get("duration", 0) for stage in scene.get("stage", []) if stage.get("elastic", True))


def text_of(dataset):
    text = dataset[()]
    return text.decode() if isinstance(text, bytes) else str(text)


class Eye:
    """Central projection of a box on the plane through its middle, whose axis z points up."""

    def __init__(self, box):
        forward = np.array([np.sin(TURN) * np.cos(RISE), np.cos(TURN) * np.cos(RISE), -np.sin(RISE)])
        right = np.cross(forward, [0, 0, 1.0])
        right /= np.linalg.norm(right)
        self.axes = np.array([right, np.cross(right, forward), forward])
        self.middle = box / 2
        self.distance = DISTANCE * box.max()

    def depth(self, points):
        return self.distance + (points - self.middle) @ self.axes[2]

    def scale(self, points):
        """By what lengths there are shown larger than in the middle."""
        return self.distance / self.depth(points)

    def project(self, points):
        return (points - self.middle) @ self.axes[:2].T * self.scale(points)[..., None]


def corners(box):
    return box * np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)])


def box_edges(box):
    """[12, 2, 3]"""
    all_corners = corners(box)
    return np.array([[all_corners[i], all_corners[i | 1 << k]] for i in range(8) for k in range(3) if not i >> k & 1])


def draw_box(axes, gas, eye):
    """Edges that end at the farthest corner are behind the grains, the others before them."""
    edges = box_edges(gas.box)
    farthest = corners(gas.box)[np.argmax(eye.depth(corners(gas.box)))]
    behind = (edges == farthest).all(axis=2).any(axis=1)
    for chosen, order in [(behind, 1), (~behind, 3)]:
        axes.add_collection(LineCollection(eye.project(edges[chosen]), colors=EDGE, linewidths=0.5, zorder=order))


def charge_colours(charge):
    """White is 0, with the same range for both signs; None if all charges are the same, none among them."""
    if np.ptp(charge) == 0:
        return None
    reach = np.quantile(np.abs(charge), 0.995)
    reach = reach if reach > 0 else np.abs(charge).max()
    return {"cmap": "RdBu_r", "norm": Normalize(-reach, reach)}


def cluster_faces(cluster):
    """[N, 4] a colour a cluster, by rank of its size, eighteen in turn; lone grains do not hide them."""
    numbers, inverse, size = np.unique(cluster, return_inverse=True, return_counts=True)
    rank = np.empty(len(numbers), int)
    rank[np.argsort(-size, kind="stable")] = np.arange(len(numbers))
    pairs = [c for k, c in enumerate(plt.get_cmap("tab20").colors) if k // 2 != 7]  # a strong and a pale one, no grey
    faces = np.column_stack([np.array(pairs[::2] + pairs[1::2])[rank % 18], np.ones(len(rank))])
    faces[size == 1] = to_rgba(LONE, 0.25)
    return faces[inverse]


def faces_of(gas, colours):
    if colours is None:
        return cluster_faces(gas.cluster)
    return ScalarMappable(**colours).to_rgba(gas.charge)


def edges_of(faces):
    """[N, 4] as transparent as the faces."""
    edges = np.tile(to_rgba(EDGE), (len(faces), 1))
    edges[:, 3] = faces[:, 3]
    return edges


def in_fog(colours, share):
    """Colours, [N, 4], mixed with so much of the fog's."""
    mixed = colours + share[:, None] * (np.array(to_rgba(FOG)) - colours)
    return np.column_stack([mixed[:, :3], colours[:, 3]])


def draw_discs(axes, centre, diameter, face, edge):
    width = np.clip(72 / axes.figure.dpi * 0.04 * diameter * pixels_a_unit(axes), 0.05, 0.6)
    place = {"units": "xy", "offsets": centre, "offset_transform": axes.transData}
    style = {"facecolor": face, "edgecolor": edge, "linewidths": width, "zorder": 2}
    axes.add_collection(EllipseCollection(diameter, diameter, np.zeros_like(diameter), **place, **style))


def pixels_a_unit(axes):
    axes.figure.canvas.draw()  # decides how large a unit is
    (left, _), (right, _) = axes.transData.transform([(0, 0), (1, 0)])
    return right - left


def draw_in_space(axes, gas, colours):
    eye = Eye(gas.box)
    shown = eye.project(corners(gas.box))
    margin = 0.02 * np.ptp(shown, axis=0)
    (left, bottom), (right, top) = shown.min(axis=0) - margin, shown.max(axis=0) + margin
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
    axes.axis("off")
    draw_box(axes, gas, eye)
    depth = eye.depth(gas.position)
    order = np.argsort(-depth)
    fog = 0.75 * (depth - depth.min())[order] / np.ptp(eye.depth(corners(gas.box)))  # none before the nearest
    face = faces_of(gas, colours)[order]
    diameter = 2 * gas.radius * eye.scale(gas.position)
    draw_discs(axes, eye.project(gas.position)[order], diameter[order], in_fog(face, fog), in_fog(edges_of(face), fog))


def with_images(gas):
    """Indices and places of grains of a plane gas, with those again that a side cuts."""
    grain, place = np.arange(len(gas.radius)), gas.position[:, :2]
    for axis in range(2):
        length = gas.box[axis]
        over = [(place[:, axis] < gas.radius[grain], length), (place[:, axis] > length - gas.radius[grain], -length)]
        shift = np.eye(2)[axis]
        place = np.vstack([place] + [place[cut] + by * shift for cut, by in over])
        grain = np.concatenate([grain] + [grain[cut] for cut, _ in over])
    return grain, place


def draw_in_the_plane(axes, gas, colours):
    axes.set(xlim=(0, gas.box[0]), ylim=(0, gas.box[1]), aspect="equal", xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set_linewidth(0.6)
    grain, place = with_images(gas)
    face = faces_of(gas, colours)[grain]
    draw_discs(axes, place, 2 * gas.radius[grain], face, edges_of(face))


def draw_colour_bar(axes, colours, charge):
    reach = colours["norm"].vmax
    beyond = "both" if np.abs(charge).max() > reach else "neither"
    mappable = ScalarMappable(**colours)
    bar = axes.figure.colorbar(mappable, ax=axes, shrink=0.7, aspect=28, pad=0.04, extend=beyond)
    bar.locator = MaxNLocator(5, symmetric=True)
    bar.update_ticks()
    bar.set_label("charge ($q_0$)")
    bar.outline.set_linewidth(0.6)


def caption(gas):
    numbers, size = np.unique(gas.cluster, return_counts=True)
    parts = [f"t = {gas.time:.4g} $t_0$", f"N = {len(gas.radius)}"]
    clusters = "cluster" if len(numbers) == 1 else "clusters"
    parts.append(f"{len(numbers)} {clusters}, the largest of {size.max()}")
    return ", ".join(parts)


def draw_grains(gas, by_cluster):
    drawing.set_style()
    height = 6 if gas.spatial else 0.9 + 5 * gas.box[1] / gas.box[0]
    figure, axes = plt.subplots(figsize=(6.6, height), layout="constrained")
    colours = None if by_cluster else charge_colours(gas.charge)
    (draw_in_space if gas.spatial else draw_in_the_plane)(axes, gas, colours)
    if colours is not None:
        draw_colour_bar(axes, colours, gas.charge)
    axes.set_title(f"{gas.title}\n{caption(gas)}" if gas.title else caption(gas))
    return figure


def draw_points(axes, time, values, label, marker, colour):
    shown = np.isfinite(values) & (values > 0)
    if not shown.any():
        return
    axes.plot(time[shown], values[shown], marker, color=colour, markersize=2.5, label=label, markeredgewidth=0)


def draw_theory(axes, time, values, label):
    axes.plot(time, values, color=THEORY, linewidth=1, label=label, zorder=1)


def panels_of(series):
    """Each: label of its axis, points (column, label, marker, colour), theory's line (column, label)."""
    panels = [
        (
            "temperature ($m_0 v_0^2$)",
            [("temperature", "with the flow", "o", "#9ecae1"), ("local_temperature", "relative to it", "o", "#08519c")],
            ("haff_temperature", "homogeneous and neutral, restitution of the contacts"),
        )
    ]
    if np.ptp(series["mean_square_charge"]) > 0:
        line = ("expected_square_charge", "homogeneous, two at a time")
        panels.append((r"$\langle q^2 \rangle$ ($q_0^2$)", [("mean_square_charge", "grains", "o", "#08519c")], line))
    clusters = [("mean_aggregate", "grains in contact: mean of two and more", "o", "#08519c")]
    clusters.append(("density_cluster_size", "dense cells: S", "s", "#9ecae1"))
    panels.append(("size of clusters", clusters, ("", "")))
    return panels


def set_scale(axes):
    """Logarithmic where the points span more than a factor of three: else its ticks have no round numbers."""
    shown = np.concatenate([line.get_ydata() for line in axes.lines if len(line.get_ydata()) > 2] or [[1]])
    if shown.max() <= 3 * shown.min():
        return axes.yaxis.set_major_locator(MaxNLocator(5))
    axes.set_yscale("log")
    if shown.max() < 30 * shown.min():  # too few powers of ten to go by
        axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_formatter("")
    return None


def draw_series(gas, marked):
    """Over the time after the warm-up, if the run went on so far, on logarithmic scales where they reach far; a line at
    the frame's time if that is marked."""
    drawing.set_style()
    warm_up = gas.warm_up if gas.series["time"].max() > gas.warm_up else 0
    time = gas.series["time"] - warm_up
    after = time > 0
    panels = panels_of(gas.series)
    size = (6, 0.8 + 2.4 * len(panels))
    figure, all_axes = plt.subplots(len(panels), 1, figsize=size, sharex=True, layout="constrained")
    for axes, (label, points, (line, line_label)) in zip(all_axes, panels):
        for name, point_label, marker, colour in points:
            draw_points(axes, time[after], gas.series[name][after], point_label, marker, colour)
        if line in gas.series:
            draw_theory(axes, time[after], gas.series[line][after], line_label)
        if marked and gas.time > warm_up:
            axes.axvline(gas.time - warm_up, color=EDGE, linewidth=0.6, linestyle=":")
        axes.set(xscale="log", ylabel=label)
        set_scale(axes)
        axes.legend(frameon=False, fontsize=7)
    all_axes[-1].set_xlabel((f"time after the warm-up of {warm_up:g}" if warm_up > 0 else "time") + " ($t_0$)")
    all_axes[0].set_title(gas.title)
    return figure


def series_path(picture):
    picture = Path(picture)
    return picture.with_name(f"{picture.stem}-series{picture.suffix}")


def draw(path, frame, picture, colour=None):
    """Writes both pictures. Throws drawing.InputError."""
    gas = drawing.read_file(path, lambda file: DrawnGas(file, path, frame))
    drawing.save(draw_grains(gas, colour == "cluster"), picture)
    drawing.save(draw_series(gas, frame is not None), series_path(picture))
