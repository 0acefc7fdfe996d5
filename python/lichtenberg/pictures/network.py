"""Draws the networks that `lichtenberg network` left in a result file: potential as colour, current as line width. In
space only the backbone, the strongest of its resistors, in perspective and paler where they are far."""
from dataclasses import dataclass

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.colors import Normalize

from . import drawing, space
from .layout import PanelLayout

COLOURS = "viridis"
ISOLATED = "#f2d7d5"  # particles without a path to an electrode
PALE = "#f0f0f0"
MOST_LINES = 4000  # limit in space: more resistors would hide each other


@dataclass
class DrawnNetwork:
    """Lengths in m; three coordinates in space, else two."""

    model: str
    resistor: str
    size: np.ndarray  # [2] or [3] of the domain
    position: np.ndarray  # [N, 2] or [N, 3] of the particles
    radius: np.ndarray  # [N]
    isolated: np.ndarray  # indices of particles
    segments: np.ndarray  # [L, 2, 2] or [L, 2, 3] ends of the resistors
    potential: np.ndarray  # [L] V, mean of both ends
    current: np.ndarray  # [L] A, magnitude
    carries: np.ndarray  # [L]
    resistance: float  # Ohm
    electrodes: list  # [2, 2] ends of each wall that is one, or the number of a particle; in space (name, number)
    highest: float  # V


def walls(file):
    """name -> (point, normal), as the command reads them."""
    if "scene/walls" in file:
        group = file["scene/walls"]
        return {name: (p, n) for name, p, n in zip(group.attrs["names"], group["point"][()], group["normal"][()])}
    width, height = file["scene/domain/size"][:2]
    sides = {
        "left": (np.zeros(3), np.array([1.0, 0, 0])),
        "right": (np.array([width, 0, 0]), np.array([-1.0, 0, 0])),
        "bottom": (np.zeros(3), np.array([0, 1.0, 0])),
        "top": (np.array([0, height, 0]), np.array([0, -1.0, 0])),
    }
    if "height" in file["scene/domain"]:
        depth = file["scene/domain/height"][()]
        sides["front"] = (np.zeros(3), np.array([0, 0, 1.0]))
        sides["back"] = (np.array([0, 0, depth]), np.array([0, 0, -1.0]))
    return sides


def wall_line(point, normal, size):
    """Returns the line of a wall in the picture, long enough to cross the domain; None of a wall parallel to the
    picture."""
    along = np.array([-normal[1], normal[0]])
    if np.hypot(*along) < 1e-12:
        return None
    along = along / np.hypot(*along)
    middle = point + np.dot(size / 2 - point, along) * along
    half = 0.5 * (abs(along[0]) * size[0] + abs(along[1]) * size[1])
    return np.array([middle - half * along, middle + half * along])


def resistor_ends(group, position, radius, electrode_walls):
    """[L, 2, 3] ends of the resistors; one at a wall is the projection of the particle's centre onto it."""
    links, particles = group["links"][()], group["link_particles"][()]
    ends = group["position"][()][links]
    for node, wall in zip(group["electrode"][()], electrode_walls):
        if wall is None:
            continue
        point, normal = wall
        k, end = np.nonzero(links == node)
        centre = position[particles[k, 0]]
        ends[k, end] = centre - ((centre - point) @ normal)[:, None] * normal
    return ends


def read(path, model):
    """Throws drawing.InputError."""

    def reading(file):
        if f"network/{model}" not in file:
            raise drawing.InputError(f"{path} has no {model}-centred network: run `lichtenberg network` first")
        return read_network(file, model)

    return drawing.read_file(path, reading)


def read_network(file, model):
    group = file["network"][model]
    position = file["particles/conductors/position/value"][int(group.attrs["frame"])]
    radius = file["particles/conductors/radius"][()]
    domain = file["scene/domain"]
    spatial = "height" in domain
    size = drawing.size_in(file, int(group.attrs["frame"]))
    moved = np.ones(3)
    moved[: len(size)] = size / drawing.scene_size(file)  # walls move with the sides of a packing with loads
    shown = [0, 1, 2] if spatial else [0, 1]
    names = [name.strip() for name in group.attrs["between"].split(",")]
    found = [walls(file).get(name) for name in names]
    found = [(w[0] * moved, w[1]) if w else None for w in found]
    ends = resistor_ends(group, position, radius, found)
    period = np.where(drawing.periodic_axes(file["particles/conductors"], len(size)), size, np.inf)
    separation = ends[:, 1, : len(size)] - ends[:, 0, : len(size)]  # across a periodic side: to the nearest image
    ends[:, 1, : len(size)] -= np.where(np.isfinite(period), size, 0) * np.round(separation / period)
    potential = group["potential"][()]
    lines = [wall_line(w[0][:2], w[1][:2], size[:2]) if w else int(name) for w, name in zip(found, names)]
    if spatial:
        lines = [(name, None if w else int(name)) for w, name in zip(found, names)]
    return DrawnNetwork(
        model=model,
        resistor=group.attrs["resistor"] + (" 1 Ω (assumed)" if group.attrs.get("assumed", 0) else ""),
        size=size,
        position=position[:, shown],
        radius=radius,
        isolated=group["isolated"][()],
        segments=ends[:, :, shown],
        potential=potential[group["links"][()]].mean(axis=1),
        current=np.abs(group["current"][()]),
        carries=group["link_in_backbone"][()] != 0,
        resistance=group["effective_resistance"][()],
        electrodes=lines,
        highest=potential[group["electrode"][()]].max(),
    )


def draw_particles(axes, network):
    diameter = 2 * network.radius
    colours = np.full(len(diameter), PALE, dtype="U7")
    colours[network.isolated] = ISOLATED
    placement = {"units": "xy", "offsets": network.position, "offset_transform": axes.transData}
    style = {"facecolor": colours, "edgecolor": "#b0b0b0", "linewidth": 0.3, "zorder": 1}
    axes.add_collection(EllipseCollection(diameter, diameter, np.zeros_like(diameter), **placement, **style))


def draw_resistors(axes, network, colours, widest=4.0):
    """The line width is proportional to the current: the largest current has the widest line, a resistor without a
    current a hairline."""
    dead = network.segments[~network.carries]
    axes.add_collection(LineCollection(dead, colors="#909090", linewidths=0.3, zorder=2))
    order = np.argsort(network.current[network.carries])  # the largest currents on top
    segments = network.segments[network.carries][order]
    current = network.current[network.carries][order]
    width = 0.3 + (widest - 0.3) * current / current.max() if len(current) else []
    axes.add_collection(
        LineCollection(
            segments,
            array=network.potential[network.carries][order],
            linewidths=width,
            capstyle="round",
            zorder=3,
            **colours,
        )
    )


def draw_electrodes(axes, network, clip):
    """Draws walls as bars and particles as rings. `clip`: walls on the frame are cut at it."""
    for electrode in network.electrodes:
        if isinstance(electrode, int):
            centre = network.position[electrode]
            axes.add_patch(plt.Circle(centre, network.radius[electrode], fill=False, linewidth=2, zorder=4))
        elif electrode is not None:
            axes.plot(*electrode.T, color=drawing.INK, linewidth=4, solid_capstyle="butt", clip_on=clip, zorder=4)


def draw_backbone(axes, network, colours):
    """The strongest resistors, from far to near; returns which share of the largest current the weakest has."""
    camera = space.Camera(network.size)
    space.set_window(axes, camera)
    space.draw_box(axes, camera, "m")
    current = np.where(network.carries, network.current, 0)
    strongest = np.argsort(-current, kind="stable")[: min(MOST_LINES, np.count_nonzero(current > 0))]
    middle = network.segments[strongest].mean(axis=1)
    strongest = strongest[np.argsort(-camera.depth(middle))]
    if len(strongest) == 0:
        return 0
    middle = network.segments[strongest].mean(axis=1)
    faces = ScalarMappable(**colours).to_rgba(network.potential[strongest])
    haze = 0.8 * camera.haze(camera.depth(middle))[:, None]
    faces[:, :3] += haze * (1 - faces[:, :3])
    share = current[strongest] / current.max()
    widest = min(4.0, 0.5 * np.median(network.radius) * drawing.points_a_unit(axes))
    width = np.maximum(widest * share, 0.2) * camera.scale(middle)
    style = {"linewidths": width, "colors": faces, "capstyle": "round", "zorder": 2}
    axes.add_collection(LineCollection(camera.project(network.segments[strongest]), **style))
    return share.min()


def panel_in_space(axes, network, colours):
    weakest = draw_backbone(axes, network, colours)
    electrodes = " to ".join(name if number is None else f"particle {name}" for name, number in network.electrodes)
    words = f"backbone from {electrodes}"
    if weakest > 0:
        words += f", currents from {100 * weakest:.2g} % of the largest"
    axes.text(0.5, 0, words, transform=axes.transAxes, ha="center", va="bottom", fontsize=8)


def panel(axes, network, window=None):
    """Draws a network. `window`: the shown part, [[left, right], [bottom, top]]; by default the domain."""
    colours = {"cmap": COLOURS, "norm": Normalize(0, network.highest)}
    resistance = f"R = {network.resistance:.6g} Ω" if np.isfinite(network.resistance) else "no path"
    axes.set_title(f"{network.model}-centred, {network.resistor}: {resistance}")
    if len(network.size) == 3:
        panel_in_space(axes, network, colours)
        return colours
    (left, right), (bottom, top) = window if window is not None else [(0, network.size[0]), (0, network.size[1])]
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xticks=[], yticks=[])
    draw_particles(axes, network)
    # Lines as wide as particles would hide a packing of many, and the widest may lie outside of a window.
    axes.figure.canvas.draw()
    points = 72 / axes.figure.dpi * np.diff(axes.transData.transform([(0, 0), (np.median(network.radius), 0)])[:, 0])[0]
    draw_resistors(axes, network, colours, widest=max(0.4, min(4.0 if window is None else 12.0, 0.5 * points)))
    draw_electrodes(axes, network, clip=window is not None)
    if window is None:
        drawing.draw_length(axes, network.size[0], drawing.in_metres)
    return colours


def draw(networks, warnings=()):
    """One panel a network, as a figure; below them why the packing may be unsafe to use."""
    drawing.set_style()
    spatial = len(networks[0].size) == 3
    layout = PanelLayout([space.Camera(n.size).size if spatial else n.size for n in networks], with_bar=True)
    for axes, network in zip(layout.panels, networks):
        colours = panel(axes, network)
    bar = layout.figure.colorbar(ScalarMappable(**colours), cax=layout.figure.add_axes(layout.bar))
    bar.set_label("potential (V)")
    bar.outline.set_linewidth(0.6)
    style = {"fontsize": 8, "color": drawing.WARNING, "ha": "center", "va": "bottom", "parse_math": False}
    layout.figure.text(0.5, 0.02 / layout.height, drawing.warning_line(warnings), **style)
    return layout.figure


def draw_file(path, out, models, *warnings):
    """`models`: particle, contact or both, with a comma; `warnings`: why the packing may be unsafe to use."""
    drawing.save(draw([read(path, model) for model in models.split(",")], warnings), out)
