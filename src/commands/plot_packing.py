"""The picture of a packing: particles, the forces between them as lines, rattlers; `plot.py` calls it.

In three dimensions the particles are seen from the front, those behind first and darker.
"""
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.lines import Line2D

import drawing

FORCE, RATTLER, BEHIND = "#0c7bdc", drawing.ISOLATED, "#7a7a7a"


def is_packing(path):
    return drawing.read_file(path, lambda file: "walls" in file["scene"])


class DrawnPacking:
    """A frame. Lengths in mm, in the plane of the picture."""

    def __init__(self, file, frame):
        particles = file["particles/conductors"]
        times = particles["position/time"]
        index = len(times) - 1 if frame is None else frame
        last = index == len(times) - 1
        self.title = file["scene"].attrs["title"]
        self.iteration = int(times[index])
        self.spatial = "height" in file["scene/domain"]
        position = particles["position/value"][index] * drawing.MM
        self.position = position[:, :2]
        self.depth = position[:, 2] if self.spatial else np.zeros(len(position))
        self.radius = particles["radius"][()] * drawing.MM
        self.size = file["scene/domain/size"][:2] * drawing.MM
        self.energy = file["observables/energy/value"][index]
        walls = file["scene/walls"]
        self.wall_point, self.wall_normal = walls["point"][()][:, :2] * drawing.MM, walls["normal"][()][:, :2]
        self.contacts = file["packing/contacts"][()] if last and "packing" in file else None
        self.force = file["packing/force"][()] if self.contacts is not None else None
        count = len(self.radius)
        self.rattler = file["packing/rattler"][()] == 1 if self.contacts is not None else np.zeros(count, bool)

    def foot(self, i, wall):
        """The point of a wall nearest to a particle."""
        normal = self.wall_normal[wall]
        return self.position[i] - np.dot(self.position[i] - self.wall_point[wall], normal) * normal

    def force_lines(self):
        """[E, 2, 2] from centre to centre, or to the wall."""
        n = len(self.radius)
        return np.array([[self.position[i], self.position[j] if j < n else self.foot(i, j - n)] for i, j in self.contacts])


def draw_particles(axes, packing):
    order = np.argsort(-packing.depth) if packing.spatial else np.arange(len(packing.radius))
    face = np.array([RATTLER if rattler else drawing.STEEL for rattler in packing.rattler], dtype=object)
    if packing.spatial:
        near = np.clip(1 - packing.depth / max(packing.depth.max(), 1e-300), 0, 1)
        low, high = (np.array(plt.matplotlib.colors.to_rgb(c)) for c in (BEHIND, drawing.STEEL))
        face = low + near[:, None] * (high - low)
        face[packing.rattler] = plt.matplotlib.colors.to_rgb(RATTLER)
    diameter = 2 * packing.radius[order]
    style = {"facecolor": list(face[order]), "edgecolor": drawing.INK, "zorder": 2}
    style["linewidth"] = drawing.line_width(axes, packing, 0.1, 0.8)
    # Where particles overlap, both rims show.
    style["alpha"] = 1 if packing.spatial else 0.75
    place = {"units": "xy", "offsets": packing.position[order], "offset_transform": axes.transData}
    axes.add_collection(EllipseCollection(diameter, diameter, np.zeros_like(diameter), **place, **style))


def draw_forces(axes, packing):
    """A line as wide as its force is strong, against the mean."""
    if packing.contacts is None or packing.spatial or len(packing.contacts) == 0:
        return
    mean_width = drawing.line_width(axes, packing, 0.15, 2)
    width = mean_width * packing.force / packing.force.mean()
    axes.add_collection(LineCollection(packing.force_lines(), linewidths=width, colors=FORCE, capstyle="round", zorder=3))


def draw_walls(axes, packing):
    for point, normal in zip(packing.wall_point, packing.wall_normal):
        if np.hypot(*normal) > 1e-9:  # else it is seen from the front
            axes.axline(point, point + np.array([-normal[1], normal[0]]), color=drawing.INK, linewidth=1, zorder=1)


def draw_legend(axes, packing):
    handles = []
    if packing.contacts is not None and not packing.spatial:
        handles.append(Line2D([], [], color=FORCE, linewidth=2, label="force"))
    if packing.rattler.any():
        style = {"linestyle": "", "marker": "o", "markersize": 6, "markeredgecolor": drawing.INK, "markeredgewidth": 0.6}
        handles.append(Line2D([], [], markerfacecolor=RATTLER, label="rattler", **style))
    if handles:
        where = {"loc": "upper right", "bbox_to_anchor": (1, 0), "ncols": 2, "borderaxespad": 0.5, "handletextpad": 0.4}
        axes.legend(handles=handles, frameon=False, **where)


def caption(packing):
    return f"iteration {packing.iteration}, N = {len(packing.radius)}, U = {packing.energy:.4g} J"


def draw_panel(axes, packing):
    drawing.set_frame(axes, packing)
    draw_walls(axes, packing)
    draw_particles(axes, packing)
    draw_forces(axes, packing)


def draw(path, frame):
    """The whole picture, as a figure; the frame exists."""
    packing = drawing.read_file(path, lambda file: DrawnPacking(file, frame))
    drawing.set_style()
    figure, axes = plt.subplots(figsize=(6, 0.9 + 5 * packing.size[1] / packing.size[0]), layout="constrained")
    draw_panel(axes, packing)
    drawing.draw_scale(axes, packing)
    draw_legend(axes, packing)
    axes.set_title(f"{packing.title}\n{caption(packing)}" if packing.title else caption(packing))
    return figure
