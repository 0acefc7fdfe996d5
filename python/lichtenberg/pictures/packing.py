"""Pictures of packings: particles, the forces between them as lines, rattlers; in space spheres."""
import numpy as np
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D

from . import drawing, space
from .colours import Quantity, disk_mark, draw_legend, quantities_in, read_column, run_range

FORCE, RATTLER = "#0c7bdc", drawing.ISOLATED


class DrawnPacking:
    """A frame. Lengths in mm, in the plane of the picture."""

    def __init__(self, file, frame):
        particles = file["particles/conductors"]
        times = particles["position/time"]
        index = len(times) - 1 if frame is None else frame
        last = index == len(times) - 1
        self.title = file["scene"].attrs["title"]
        self.instant = f"{'load' if 'observables/size_x' in file else 'iteration'} {int(times[index])}"
        self.spatial = "height" in file["scene/domain"]
        self.position_3d = particles["position/value"][index]  # [N, 3] m
        self.position = self.position_3d[:, :2] * drawing.MM
        self.radius = particles["radius"][()] * drawing.MM
        size = drawing.size_in(file, index)
        self.size = size[:2] * drawing.MM
        self.period = np.where(drawing.periodic_axes(particles, len(size)), size, np.inf)
        self.period = self.period[:2] * drawing.MM
        self.energy = file["observables/energy/value"][index]
        walls = file["scene/walls"] if "walls" in file["scene"] else dict.fromkeys(["point", "normal"], np.empty((0, 3)))
        self.wall_point, self.wall_normal = walls["point"][()][:, :2] * drawing.MM, walls["normal"][()][:, :2]
        self.wall_point = self.wall_point * (size / drawing.scene_size(file))[:2]  # walls move with the sides
        self.contacts = file["packing/contacts"][()] if last and "packing" in file else None
        self.force = file["packing/force"][()] if self.contacts is not None else None
        count = len(self.radius)
        self.rattler = file["packing/rattler"][()] == 1 if self.contacts is not None else np.zeros(count, bool)

    def foot(self, i, wall):
        """Returns the point of a wall that is nearest to a particle."""
        normal = self.wall_normal[wall]
        return self.position[i] - np.dot(self.position[i] - self.wall_point[wall], normal) * normal

    def force_lines(self):
        """[E, 2, 2] lines from centre to centre or to the wall; across a periodic side to the nearest image."""
        n = len(self.radius)
        ends = np.array([[self.position[i], self.position[j] if j < n else self.foot(i, j - n)] for i, j in self.contacts])
        separation = ends[:, 1] - ends[:, 0]
        ends[:, 1] -= np.where(np.isfinite(self.period), self.period, 0) * np.round(separation / self.period)
        return ends

    def lines_with_images(self):
        """Returns the lines of force_lines() and the indices of their contacts. A line across a periodic side appears
        twice, from each of its particles."""
        lines, contact = self.force_lines(), np.arange(len(self.contacts))
        n = len(self.radius)
        partner = np.array([self.position[j] if j < n else line[1] for (_, j), line in zip(self.contacts, lines)])
        shift = partner - lines[:, 1]
        across = np.flatnonzero(np.abs(shift).max(axis=1) > 0.5 * np.min(self.period))
        return np.concatenate([lines, lines[across] + shift[across, None]]), np.concatenate([contact, across])

    def pressing(self):
        """[N] sum of the magnitudes (N) of the forces on each particle; nan of rattlers, and where no forces are
        stored."""
        if self.contacts is None:
            return np.full(len(self.radius), np.nan)
        ends = self.contacts.ravel()
        on = ends < len(self.radius)
        total = np.bincount(ends[on], np.repeat(self.force, 2)[on], minlength=len(self.radius))
        return np.where(total > 0, total, np.nan)


class Packing:
    """A packing during its relaxation; contacts and forces exist for the last frame."""

    def __init__(self, file, path):
        particles, domain = file["particles/conductors"], file["scene/domain"]
        self.path = path
        self.title = file["scene"].attrs["title"]
        self.times = particles["position/time"][()]
        self.spatial = "height" in domain
        self.box = np.append(domain["size"][:2], domain["height"][()] if self.spatial else [])
        self.unit, self.down = "m", None
        self.window = np.zeros(len(self.box)), self.box
        self.quantities = quantities_in(file, [])
        if "packing" in file:
            self.quantities["force"] = Quantity("force", "sum of contact forces ({}N)", "decades", "", "without a force")
        self.cut = None

    @property
    def size(self):
        return space.Camera(self.box).size if self.spatial else self.box

    def values(self, file, name, index):
        return read_column(file, self.quantities[name], index) if name != "force" else DrawnPacking(file, index).pressing()

    def range(self, file, name):
        last = self.values(file, name, None if name == "force" else slice(None))
        return run_range(self.quantities[name], last.ravel())

    def default_colour(self, file, index):
        """In the plane the forces are shown as lines, in space as colours."""
        last = index == len(self.times) - 1
        return "force" if self.spatial and last and "force" in self.quantities else None

    def read(self, file, index, name, field=None):
        if name == "force" and index != len(self.times) - 1:
            last = len(self.times) - 1
            raise drawing.InputError(f"{self.path} has contact forces of its last frame only, {last}, not of {index}")
        packing = DrawnPacking(file, index)
        return packing, self.values(file, name, index) if name else None

    def caption(self, shown):
        packing = shown[0]
        words = f"{packing.instant}, N = {len(packing.radius)}, U = {packing.energy:.4g} J"
        return words + (f", cut at {'xyz'[self.cut[0]]} = {drawing.in_metres(self.cut[1])}" if self.cut else "")

    def draw(self, axes, shown, scale):
        packing, values = shown
        faces = scale.colours(values) if scale else np.tile(to_rgba(drawing.STEEL), (len(packing.radius), 1))
        faces[packing.rattler] = to_rgba(RATTLER)
        if packing.spatial:
            space.draw(axes, packing.position_3d, packing.radius / drawing.MM, faces, self.window, "m", self.cut)
        else:
            draw_panel(axes, packing, faces, lines=scale is None)
            drawing.draw_scale(axes, packing)
        handles = [force_mark(axes, packing)] if self.has_lines(packing, scale) else []
        handles += scale.legend(values[~packing.rattler]) if scale else []
        if packing.rattler.any():
            handles.append(disk_mark(RATTLER, "rattler"))
        draw_legend(axes, handles)

    def has_lines(self, packing, scale):
        return scale is None and not packing.spatial and packing.contacts is not None and len(packing.contacts) > 0


def draw_particles(axes, packing, faces, alpha):
    disk, centre = drawing.with_images(packing.position, packing.radius, packing.period)
    diameter = 2 * packing.radius[disk]
    style = {"facecolor": faces[disk], "edgecolor": drawing.INK, "zorder": 2}
    style["linewidth"] = drawing.line_width(axes, packing, 0.1, 0.8)
    style["alpha"] = alpha
    placement = {"units": "xy", "offsets": centre, "offset_transform": axes.transData}
    axes.add_collection(EllipseCollection(diameter, diameter, np.zeros_like(diameter), **placement, **style))


def mean_width(axes, packing):
    """Returns the width of the line of a mean force."""
    return drawing.line_width(axes, packing, 0.15, 2)


def force_label(packing):
    factor, prefix = drawing.prefixed(packing.force.mean())
    return f"force, this wide: {factor * packing.force.mean():.2g} {prefix}N"


def force_mark(axes, packing):
    """Returns the line of the legend for a mean force."""
    return Line2D([], [], color=FORCE, linewidth=mean_width(axes, packing), label=force_label(packing))


def draw_forces(axes, packing):
    """Draws forces as lines with a width proportional to the force, relative to the mean."""
    if packing.contacts is None or len(packing.contacts) == 0:
        return
    lines, contact = packing.lines_with_images()
    width = mean_width(axes, packing) * packing.force[contact] / packing.force.mean()
    axes.add_collection(LineCollection(lines, linewidths=width, colors=FORCE, capstyle="round", zorder=3))


def draw_walls(axes, packing):
    for point, normal in zip(packing.wall_point, packing.wall_normal):
        if np.hypot(*normal) > 1e-9:  # otherwise the wall is parallel to the picture
            axes.axline(point, point + np.array([-normal[1], normal[0]]), color=drawing.INK, linewidth=1, zorder=1)


def draw_panel(axes, packing, faces=None, lines=True):
    """Draws a packing of disks."""
    if faces is None:
        faces = np.array([to_rgba(RATTLER if rattler else drawing.STEEL) for rattler in packing.rattler])
    drawing.set_frame(axes, packing)
    draw_walls(axes, packing)
    draw_particles(axes, packing, faces, 0.75 if lines else 1)  # both outlines of overlapping particles are visible
    if lines:
        draw_forces(axes, packing)
