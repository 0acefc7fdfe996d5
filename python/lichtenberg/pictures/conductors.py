"""Pictures of conductors: colours, electrodes, the tree, and in a plane the field."""
import re
import tomllib

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from .. import ground
from ..result import field_of, text_of
from . import drawing, space
from .colours import Quantity, Range, bar_norm, draw_legend, quantities_in, read_column, run_range
from .drawing import INK, MM, UNCONNECTED, prefixed

QUANTITIES = [
    Quantity("potential", "potential ({}V)", "signed", "potential"),
    Quantity("charge", "charge ({}C)", "signed", "charge"),
    Quantity("force", "electric force ({}N)", "decades", "force", "without a force"),
    Quantity("cluster", "conductors in contact", "category", "group", "in contact with none"),
    Quantity("current", "current carried to the ground ({}A)", "decades", "successor", "not connected"),
    Quantity("strahler", "order of the branch (Strahler number)", "order", "successor", "not connected"),
    Quantity("connection_time", "in the tree since ({}s)", "amount", "successor", "not connected"),
    Quantity("speed", "speed ({}m/s)", "decades", "velocity", "at rest"),
]
ALL_ZERO = 1e-3  # of the run's largest potential: colours look white below it


class Conductors:
    """A run of conductors. Lengths of drawings in mm."""

    spatial = False

    def __init__(self, file, path):
        scene, particles = file["scene"], file["particles/conductors"]
        self.path = path
        self.title = scene.attrs["title"]
        self.times = particles["position/time"][()]
        self.size = scene["domain/size"][:2] * MM
        self.radius = particles["radius"][()] * MM
        self.scene = tomllib.loads(text_of(scene["text"][()]))
        self.terminals = terminal_potentials(file)
        self.quantities = quantities_in(file, QUANTITIES)
        self.highest_supply = np.abs(self.terminals).max(initial=0)
        self.reach = self.highest_supply  # V, largest magnitude in the run
        if "potential" in particles:
            self.reach = max(self.reach, np.abs(particles["potential/value"][()]).max(initial=0))
        effects = self.scene.get("effects", {})
        source = effects.get("current_injection") or effects.get("current_source", {})  # its name in earlier versions
        self.fed = source.get("current", 0)
        self.since = None  # connection_times, once they are needed
        if not self.fed:
            self.quantities.pop("current", None)

    @property
    def all_supplies(self):
        """Returns the name of any electrode: the ground if all are at 0 V."""
        return "the ground" if not np.any(self.terminals) else "an electrode"

    def column(self, file, name, index=slice(None)):
        return read_column(file, self.quantities[name], index)

    def values(self, file, name, index):
        """Returns [N] values of a quantity in a frame; nan where it is undefined."""
        column = self.column(file, name, index)
        if name == "cluster":
            numbers, inverse, size = np.unique(column, return_inverse=True, return_counts=True)
            return np.where(size[inverse] > 1, (numbers + 1)[inverse], np.nan)
        if name == "current":
            return self.fed * carried(column)
        if name == "strahler":
            return strahler_numbers(column)
        if name == "connection_time":
            return self.connection_times(file)[index]
        return column

    def connection_times(self, file):
        """Returns the times (s) since which the conductors have had an uninterrupted path to the ground, [T, N]; nan
        without a path."""
        if self.since is None:
            connected = self.column(file, "connection_time") != UNCONNECTED
            broken = np.maximum.accumulate(np.where(connected, -1, np.arange(len(connected))[:, None]))
            self.since = np.where(connected, np.append(self.times, np.nan)[broken + 1], np.nan)
        return self.since

    def range(self, file, name):
        """Returns the range of a quantity in the whole run."""
        quantity = self.quantities[name]
        if name == "potential":
            return run_range(quantity, self.column(file, name).ravel(), self.terminals)
        if name == "connection_time":
            return Range(0, self.times[-1])
        # The range usually ends at the complete tree, but a tree that broke had larger values before.
        if name in ("current", "strahler"):
            frames = np.unique(np.linspace(0, len(self.times) - 1, 25).astype(int))
            return run_range(quantity, np.concatenate([self.values(file, name, k) for k in frames]))
        return run_range(quantity, self.column(file, name).ravel())

    def default_colour(self, file, index):
        """Returns potential if it differs from 0 visibly; else a quantity of the tree."""
        if "potential" not in self.quantities:
            return next(iter(self.quantities), None)
        instead = [name for name in ("current", "strahler") if name in self.quantities]
        grown = instead and (self.column(file, instead[0], index) != UNCONNECTED).any()
        return instead[0] if grown and self.is_dark(self.column(file, "potential", index)) else "potential"

    def read(self, file, index, name, field=None):
        """Returns the data of a frame that a picture shows. `field`: [ny, nx] V, if it has been solved."""
        snapshot = drawing.read_snapshot(file, index)
        values = self.values(file, name, index) if name else None
        if name == "potential" and field is None and index == len(self.times) - 1:
            field = field_of(file)
        return snapshot, values, field if name == "potential" else None

    def caption(self, shown):
        snapshot = shown[0]
        words = f"t = {snapshot.time:.4g} s, N = {len(snapshot.radius)}"
        if len(snapshot.radius) == 0:
            return words
        if snapshot.successor is not None and (len(self.terminals) > 0 or snapshot.connected.any()):
            words += f", {100 * snapshot.connected.mean():.3g} % connected to {self.all_supplies}"
        if self.is_dark(snapshot.potential):
            words += ", all at 0 V"
        return words

    def is_dark(self, potential):
        """Returns true if all potentials are so near to 0 V that their colours look white."""
        return potential is not None and max(np.abs(potential).max(initial=0), self.highest_supply) <= ALL_ZERO * self.reach

    def draw(self, axes, shown, scale):
        snapshot, values, field = shown
        drawing.set_frame(axes, snapshot)
        if field is not None:
            extent = (0, snapshot.size[0], 0, snapshot.size[1])
            # A separate norm per image: removed images leave their callbacks in a shared norm.
            style = {"cmap": scale.cmap, "norm": bar_norm(scale, 1), "interpolation": "bilinear", "aspect": "auto"}
            axes.imshow(field, origin="lower", extent=extent, **style)
        faces = scale.colours(values) if scale else np.tile(to_rgba(drawing.STEEL), (len(snapshot.radius), 1))
        drawing.draw_disks(axes, snapshot, slice(None), facecolor=faces)
        drawing.draw_electrodes(axes, snapshot)
        edges = drawing.tree_edges(snapshot)
        drawing.draw_edges(axes, snapshot, edges, color=INK)
        drawing.draw_scale(axes, snapshot)
        marks = scale.legend(values) if scale else []
        if len(edges) > 0:
            marks.append(Line2D([], [], color=INK, linewidth=1.5, label=f"path to {self.all_supplies}"))
        draw_legend(axes, marks)


class ConductorsInSpace(Conductors):
    """Pictures of spheres in perspective, in metres: without the field; electrodes are dark."""

    unit, spatial = "m", True
    ELECTRODE = (0.3, 0.3, 0.3, 1)

    def __init__(self, file, path):
        super().__init__(file, path)
        self.box = file["scene/domain/size"][()]
        self.down = space.down_of(file)
        self.window = np.zeros(3), self.box
        self.size = space.Camera(self.box, self.down).size
        self.radius = file["particles/conductors/radius"][()]
        self.electrodes = ground.electrodes_in(file["scene"])
        fixed = [shape for shape in self.electrodes if shape["shape"] == "sphere"]
        self.fixed_position = np.array([shape["centre"] for shape in fixed]).reshape(-1, 3)
        self.fixed_radius = np.array([shape["radius"] for shape in fixed])
        self.cut = None

    def read(self, file, index, name, field=None):
        snapshot, values, _ = super().read(file, index, name)
        return snapshot, values, file["particles/conductors/position/value"][index]

    def caption(self, shown):
        cut = f", cut at {'xyz'[self.cut[0]]} = {self.cut[1]:g} m" if self.cut else ""
        return super().caption(shown) + cut

    def draw(self, axes, shown, scale):
        snapshot, values, position = shown
        faces = scale.colours(values) if scale else np.tile(to_rgba(drawing.STEEL), (len(position), 1))
        all_positions = np.concatenate([position, self.fixed_position])
        radius = np.concatenate([self.radius, self.fixed_radius])
        faces = np.concatenate([faces, np.tile(self.ELECTRODE, (len(self.fixed_position), 1))])
        sides = [np.array([shape["low"], shape["high"]]) for shape in self.electrodes if shape["shape"] == "face"]
        space.draw(axes, all_positions, radius, faces, self.window, self.unit, self.cut, sides, self.down)
        marks = scale.legend(values) if scale else []
        if self.electrodes:
            marks.append(Patch(color=self.ELECTRODE, label=", ".join(map(name_and_potential, without_parts(self.electrodes)))))
        if snapshot.connected.any() and not self.cut:
            self.draw_paths(axes, position, snapshot.successor)
            marks.append(Line2D([], [], color=INK, linewidth=1.0, label=f"path to {self.all_supplies}"))
        draw_legend(axes, marks)

    def draw_paths(self, axes, position, successor):
        """Draws the tree's edges from centre to centre, and its last edges to the nearest electrode."""
        start = np.flatnonzero(successor != UNCONNECTED)
        end = position[np.maximum(successor[start], 0)]
        last = successor[start] < 0
        end[last] = ground.nearest_ground(position[start[last]], self.electrodes)
        lines = space.Camera(self.box, self.down).project(np.stack([position[start], end], axis=1))
        axes.add_collection(LineCollection(lines, colors=INK, linewidths=1.0, zorder=4))


def without_parts(electrodes):
    """Returns the electrodes with one in place of the numbered spheres of a torus, under the torus's name."""
    torus, most = re.compile(r"^(.*) \d+$"), 8
    stems = [found[1] if (found := torus.match(each["name"])) else None for each in electrodes]
    shown = {}
    for stem, each in zip(stems, electrodes):
        name = stem if stem is not None and stems.count(stem) > most else each["name"]
        shown.setdefault(name, {**each, "name": name})
    return list(shown.values())


def name_and_potential(electrode):
    factor, prefix = prefixed(abs(electrode["potential"]))
    return f"{electrode['name']} {electrode['potential'] * factor:.4g} {prefix}V"


def terminal_potentials(file):
    """Returns the potentials (V) of the sources of electrodes and sides."""
    domain = file["scene/domain"]
    sides = zip(domain["side_is_electrode"], domain["side_potential"]) if "side_potential" in domain else []
    known = [potential for electrode, potential in sides if electrode]
    known += [group["potential"][()] for group in file["scene/electrodes"].values()]
    return np.array(known, float)


def in_order(successor):
    """Returns the conductors with a path, each before its successor. In a damaged file with a cycle, conductors of
    the cycle are omitted."""
    connected = successor != UNCONNECTED
    waiting = np.bincount(successor[successor >= 0], minlength=len(successor))
    ready = list(np.flatnonzero(connected & (waiting == 0)))
    for i in ready:
        j = successor[i]
        if j >= 0:
            waiting[j] -= 1
            if waiting[j] == 0:
                ready.append(j)
    return ready


def carried(successor):
    """[N] number of conductors whose current passes through each one, including its own; nan of those without a
    path."""
    count = np.where(successor != UNCONNECTED, 1.0, np.nan)
    for i in in_order(successor):
        if successor[i] >= 0:
            count[successor[i]] += count[i]
    return count


def strahler_numbers(successor):
    """[N] as src/analysis/strahler.hpp defines them; nan of those without a path."""
    order = np.where(successor != UNCONNECTED, 1.0, np.nan)
    highest, twice = np.zeros(len(successor)), np.zeros(len(successor), bool)
    for i in in_order(successor):
        if highest[i] > 0:
            order[i] = highest[i] + twice[i]
        j = successor[i]
        if j >= 0:
            twice[j] = order[i] == highest[j] or (twice[j] and order[i] < highest[j])
            highest[j] = max(highest[j], order[i])
    return order
