"""Pictures of spheres in space, and of a gas of grains in the plane: coloured by charge, cluster, force or speed."""
import numpy as np
from matplotlib.collections import EllipseCollection
from matplotlib.colors import to_rgba

from . import drawing, space
from .colours import Quantity, Range, draw_legend, quantities_in, read_column, run_range

EDGE = "#4d4d4d"
FEW = 100  # largest number of spheres for which only a part of a large box is shown
SAMPLE = 5_000_000  # maximum number of values for the range of a run; above it, frames are omitted at regular intervals


class Grains:
    """A run of grains of a gas, in units of its scales, or of spheres in space, in metres."""

    def __init__(self, file, path):
        scene, particles = file["scene"], file["particles/conductors"]
        self.path = path
        self.title = scene.attrs["title"]
        self.times = particles["position/time"][()]
        self.radius = particles["radius"][()]
        self.unit = "d0" if "reference" in file else "m"
        domain = scene["domain"]
        self.spatial = "height" in domain
        self.box = np.append(domain["size"][:2], domain["height"][()] if self.spatial else [])
        self.periodic = drawing.periodic_axes(particles, len(self.box))
        self.quantities = quantities_in(file, self.all_quantities())
        self.cut = None
        self.down = space.down_of(file)
        self.window = np.zeros(len(self.box)), self.box  # lower corner and size of the shown part
        if self.spatial and len(self.radius) <= FEW:
            self.window = self.window_of_few(particles["position/value"][()])
        if not self.periodic.all() and self.window[1] is self.box:
            self.window = self.window_of_cloud(particles["position/value"])

    def window_of_few(self, position):
        """Returns a cube around all positions of the run if it is small compared with the box, else the box."""
        low, high = position.min(axis=(0, 1)) - self.radius.max(), position.max(axis=(0, 1)) + self.radius.max()
        edge = 1.2 * (high - low).max()
        if 2 * edge > self.box.min():
            return self.window
        return (low + high - edge) / 2, np.full(3, edge)

    def window_of_cloud(self, position):
        """Returns the box, enlarged along axes that are not periodic so that it contains the first and the last frame."""
        axes, reach = len(self.box), self.radius.max()
        ends = np.concatenate([position[k][:, :axes] for k in (0, -1) if len(position)] or [np.zeros((1, axes)) + reach])
        low = np.where(self.periodic, 0, np.minimum(0, ends.min(axis=0) - reach))
        high = np.where(self.periodic, self.box, np.maximum(self.box, ends.max(axis=0) + reach))
        return (low, high - low) if (ends < 0).any() or (ends > self.box).any() else self.window

    def all_quantities(self):
        charge, force, speed = ("q₀", "m₀ v₀²/d₀", "v₀") if self.unit == "d0" else ("{}C", "{}N", "{}m/s")
        return [
            Quantity("charge", f"charge ({charge})", "signed", "charge"),
            Quantity("cluster", "grains in contact", "category", "cluster", "in contact with none"),
            Quantity("force", f"force ({force})", "decades", "force", "without a force"),
            Quantity("speed", f"speed ({speed})", "decades", "velocity", "at rest"),
        ]

    @property
    def size(self):
        """Returns the size of the panel in any unit."""
        return space.Camera(self.window[1], self.down).size if self.spatial else self.window[1]

    def column(self, file, name, index):
        return read_column(file, self.quantities[name], index)

    def values(self, file, name, index):
        column = self.column(file, name, index)
        if name != "cluster":
            return column
        _, inverse, size = np.unique(column, return_inverse=True, return_counts=True)
        return np.where(size[inverse] > 1, column, np.nan)

    def range(self, file, name):
        step = max(1, -(-len(self.times) * len(self.radius) // SAMPLE))
        chosen = np.arange(len(self.times))[::-1][::step][::-1]  # including the last frame
        quantity = self.quantities[name]
        found = run_range(quantity, np.concatenate([self.column(file, name, k) for k in chosen]))
        if quantity.kind == "signed" and found.low < 0 < found.high:
            reach = max(-found.low, found.high)
            return Range(-reach, reach, found.typical, found.least, found.largest)
        return found

    def default_colour(self, file, index):
        """Returns charge, unless all grains have the same charge."""
        if "charge" in self.quantities and np.ptp(self.column(file, "charge", index)) > 0:
            return "charge"
        return next((name for name in ("cluster", "speed", "charge") if name in self.quantities), None)

    def read(self, file, index, name, field=None):
        particles = file["particles/conductors"]
        clusters = particles["cluster/value"][index] if "cluster" in particles else None
        values = self.values(file, name, index) if name else None
        return self.times[index], particles["position/value"][index], values, clusters

    def caption(self, shown):
        time, _, _, cluster = shown
        words = f"t = {time:.4g} {'t₀' if self.unit == 'd0' else 's'}, N = {len(self.radius)}"
        if cluster is not None:
            _, size = np.unique(cluster, return_counts=True)
            words += f", {len(size)} cluster{'s' * (len(size) != 1)}, the largest of {size.max()}"
        if (self.window[1] < self.box).any():
            words += ", a part of the box"
        return words + self.words_of_cut()

    def words_of_cut(self):
        return f", cut at {'xyz'[self.cut[0]]} = {self.cut[1]:g} {self.unit.replace('0', '₀')}" if self.cut else ""

    def faces(self, shown, scale):
        return scale.colours(shown[2]) if scale else np.tile(to_rgba(drawing.STEEL), (len(self.radius), 1))

    def draw(self, axes, shown, scale):
        position = shown[1]
        if self.spatial:
            faces = self.faces(shown, scale)
            space.draw(axes, position, self.radius, faces, self.window, self.unit, self.cut, down=self.down)
        else:
            self.draw_in_the_plane(axes, position, self.faces(shown, scale))
        draw_legend(axes, scale.legend(shown[2]) if scale else [])

    def draw_in_the_plane(self, axes, position, faces):
        low, size = self.window
        axes.set(xlim=(low[0], low[0] + size[0]), ylim=(low[1], low[1] + size[1]), aspect="equal", xticks=[], yticks=[])
        for spine in axes.spines.values():
            spine.set_linewidth(0.6)
        period = np.where(self.periodic, self.box, np.inf)[:2]
        grain, centre = drawing.with_images(position[:, :2], self.radius, period)
        diameter = 2 * self.radius[grain]
        width = np.clip(0.04 * diameter * drawing.points_a_unit(axes), 0.05, 0.6)
        offsets = {"units": "xy", "offsets": centre, "offset_transform": axes.transData}
        style = {"facecolor": faces[grain], "edgecolor": EDGE, "linewidths": width, "zorder": 2}
        axes.add_collection(EllipseCollection(diameter, diameter, np.zeros_like(diameter), **offsets, **style))
        drawing.draw_length(axes, size[0], lambda length: f"{length:g} d₀")
