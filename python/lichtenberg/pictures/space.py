"""Spheres in a box seen in perspective. They are painted from far to near into an image, shaded by a light. They are darker in hollows and paler far away. x points to the right, y up as in plane pictures, z towards the eye. The eye is a little to the
right and above. In a scene with gravity the axis along which bodies fall points down. The code needs numpy only and no
display."""
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection

from .drawing import INK, InputError, in_metres

TURN, RISE = np.radians(28), np.radians(18)  # direction of the eye, as angles
DISTANCE = 2.6  # distance of the eye from the middle of the box, relative to its longest edge
LIGHT = np.array([-0.45, 0.65, 0.61], np.float32)  # direction in the picture: right, up, towards the eye
SIDE = (0.3, 0.3, 0.3)
EDGE, FOG = "#4d4d4d", 0.25  # so little that a colour can still be found on its bar
PIXELS = 1000  # of the longer side of an image
MOST_RUNS = 100_000  # rows of pixels that are spread at a time


def view_axes(down=None):
    """[3, 3] The axes of the box that point to the right, up and towards the eye, with their signs. `down`: the direction
    of the fall, of which the axis that is nearest to it counts; None: y points up."""
    if down is None:
        return np.eye(3)
    axis = np.argmax(np.abs(down))
    up, right = np.zeros(3), np.zeros(3)
    up[axis] = -np.sign(down[axis])
    right[1 if axis == 0 else 0] = 1
    return np.array([right, up, np.cross(right, up)])


def down_of(file):
    """The direction of the fall in a result, [3]; None without gravity."""
    return file["scene"].attrs.get("down")


class Camera:
    """Central projection of a box on the plane through its middle. `down`: as in view_axes."""

    def __init__(self, box, down=None):
        self.frame = view_axes(down)
        forward = -np.array([np.sin(TURN) * np.cos(RISE), np.sin(RISE), np.cos(TURN) * np.cos(RISE)]) @ self.frame
        right = np.cross(forward, self.frame[1])
        right /= np.linalg.norm(right)
        self.axes = np.array([right, np.cross(right, forward), forward])
        self.box, self.middle = box, box / 2
        self.distance = DISTANCE * box.max()
        shown = self.project(corners(box))
        margin = 0.065 * np.ptp(shown, axis=0).max()
        self.low, self.high = shown.min(axis=0) - [1.7 * margin, margin], shown.max(axis=0) + margin

    @property
    def size(self):
        """Returns the size of the window that shows the whole box."""
        return self.high - self.low

    def depth(self, points):
        return self.distance + (points - self.middle) @ self.axes[2]

    def scale(self, points):
        """Returns the factors by which lengths at these points appear larger than in the middle."""
        return self.distance / self.depth(points)

    def project(self, points):
        return (points - self.middle) @ self.axes[:2].T * self.scale(points)[..., None]

    def haze(self, depth):
        """Returns the relative depth: 0 at the box's nearest corner, 1 at its farthest."""
        ends = self.depth(corners(self.box))
        return np.clip((depth - ends.min()) / np.ptp(ends), 0, 1)


def corners(box):
    return box * np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)])


def box_edges(box):
    """[12, 2, 3] ends of the edges of the box."""
    ends = corners(box)
    return np.array([[ends[i], ends[i | 1 << k]] for i in range(8) for k in range(3) if not i >> k & 1])


def behind_cut(position, cut, camera=None):
    """Returns [N] whether a point is behind the cut, seen from the eye. `cut`: (axis, position), or None for all."""
    if cut is None:
        return np.ones(len(position), bool)
    axis, level = cut
    away = camera is None or camera.frame[:, axis].sum() > 0  # the eye is on the far side of all three axes of its frame
    return position[:, axis] <= level if away else position[:, axis] >= level


def read_cut(text, box, unit):
    """Parses "z=0.5" to (2, 0.5). Throws InputError."""
    axis, _, level = text.partition("=")
    try:
        level = float(level)
    except ValueError:
        level = np.nan
    if axis not in ("x", "y", "z") or not np.isfinite(level):
        example = f"--cut z={box[2] / 2:g}"
        raise InputError(f"--cut {text} is not valid: it must be an axis and a position on it, as in {example}")
    k = "xyz".index(axis)
    if not 0 < level <= box[k]:
        raise InputError(f"--cut {text} leaves nothing: the box reaches from {axis} = 0 to {box[k]:g} {unit}")
    return k, level


def nearest_at(centre, radius, depth, shape):
    """[h, w] index of the sphere that is visible at each pixel, -1 for none. Lengths in pixels, from the lower left."""
    height, width = shape
    image = np.full(height * width, -1, np.int32)
    order = np.argsort(-depth, kind="stable")
    rows = np.maximum(np.ceil(2 * radius[order]).astype(int), 1) + 1
    starts = np.searchsorted(np.cumsum(rows), np.arange(0, rows.sum() + MOST_RUNS, MOST_RUNS))
    for first, last in zip(starts, np.append(starts[1:], len(order))):
        paint(image, order[first:last], rows[first:last], centre, radius, shape)
    return image.reshape(shape)


def paint(image, spheres, rows, centre, radius, shape):
    """Paints disks row by row; where they overlap, the last one is visible."""
    height, width = shape
    sphere = np.repeat(spheres.astype(np.int32), rows)
    row = np.arange(len(sphere)) - np.repeat(np.cumsum(rows) - rows, rows)
    y = np.floor(centre[sphere, 1] - radius[sphere]).astype(np.int32) + row
    above = y + 0.5 - centre[sphere, 1]
    half = np.sqrt(np.maximum(radius[sphere] ** 2 - above**2, 0))
    left = np.ceil(centre[sphere, 0] - half - 0.5).astype(np.int32).clip(0, width)
    right = np.floor(centre[sphere, 0] + half - 0.5).astype(np.int32).clip(-1, width - 1)
    length = np.where((np.abs(above) <= radius[sphere]) & (y >= 0) & (y < height), right - left + 1, 0).clip(0)
    ends = np.cumsum(length)
    first = (y * width + left - (ends - length)).astype(np.int32)
    pixel = np.arange(ends[-1] if len(ends) else 0, dtype=np.int32) + np.repeat(first, length)
    image[pixel] = np.repeat(sphere, length)


def blurred(values, reach):
    """Returns the mean over a square of 2 reach + 1 pixels around each pixel."""
    for axis in range(2):
        padded = np.concatenate([np.repeat(values.take([0], axis), reach + 1, axis), values], axis)
        padded = np.concatenate([padded, np.repeat(values.take([-1], axis), reach, axis)], axis)
        total = np.cumsum(padded, axis, np.float64)
        n = values.shape[axis]
        after, before = np.arange(2 * reach + 1, 2 * reach + 1 + n), np.arange(n)
        values = (total.take(after, axis) - total.take(before, axis)) / (2 * reach + 1)
    return values


def shaded(image, centre, radius, depth, length, faces, haze):
    """[h, w, 4] colours of an image of indices. `radius` in pixels; `depth` and `length` (the spheres' radii) in the
    unit of the box."""
    colours = np.zeros((*image.shape, 4), np.float32)
    given = (centre, radius, depth, length, faces, haze)
    centre, radius, depth, length, faces, haze = (values.astype(np.float32) for values in given)
    y, x = np.nonzero(image >= 0)
    if len(x) == 0:
        return colours
    sphere = image[y, x]
    right = (x + np.float32(0.5) - centre[sphere, 0]) / radius[sphere]
    up = (y + np.float32(0.5) - centre[sphere, 1]) / radius[sphere]
    towards = np.sqrt(np.clip(1 - right**2 - up**2, 0, 1))
    lit = np.clip(right * LIGHT[0] + up * LIGHT[1] + towards * LIGHT[2], 0, 1)
    surface = depth[sphere] - length[sphere] * towards
    depths = np.full(image.shape, surface.max())
    depths[y, x] = surface
    # A pixel is dark if its surroundings are nearer (Luft, Colditz & Deussen 2006): hollows and whatever is behind. Every
    # other pixel is enough for that.
    around = blurred(depths[::2, ::2], max(int(0.6 * np.median(radius)), 1)).astype(np.float32)
    hollow = np.clip((surface - around[y // 2, x // 2]) / (4 * np.median(length)), 0, 1)
    strength = (0.42 + 0.62 * lit) * (1 - 0.5 * hollow) * (0.55 + 0.45 * np.clip(towards / 0.4, 0, 1))
    gleam = 0.25 * lit**24
    faded = FOG * haze[sphere]
    for channel in range(3):
        own = np.clip(faces[sphere, channel] * strength + gleam, 0, 1)
        colours[y, x, channel] = own + faded * (1 - own)
    colours[y, x, 3] = 1
    return colours


def halved(colours):
    """Returns means of two by two pixels, for smooth outlines; colours are weighted by their opacity."""
    weighted = colours.copy()
    weighted[..., :3] *= colours[..., 3:]
    small = (weighted[::2, ::2] + weighted[1::2, ::2] + weighted[::2, 1::2] + weighted[1::2, 1::2]) / 4
    small[..., :3] /= np.maximum(small[..., 3:], 1e-9)
    return small


def rendered(camera, position, radius, faces, pixels=PIXELS):
    """[h, w, 4] image of the spheres seen from the eye."""
    fine = 2 * pixels / camera.size.max()  # pixels per unit of length
    shape = tuple(2 * np.ceil(camera.size[::-1] * fine / 2).astype(int))
    depth = camera.depth(position)
    seen = depth > 0.05 * camera.distance  # spheres behind the eye or very close to it are omitted
    position, radius, faces, depth = position[seen], radius[seen], faces[seen], depth[seen]
    centre = (camera.project(position) - camera.low) * fine
    shown = np.maximum(radius * camera.scale(position) * fine, 0.8)
    image = nearest_at(centre, shown, depth, shape)
    return halved(shaded(image, centre, shown, depth, radius, faces, camera.haze(depth)))


def edge_labels(camera, unit):
    """Returns for three edges of the box the middle [3], the direction in which its label is beside it and the label:
    axis and length."""
    for along, (start, shift) in enumerate([((0, 0, 1), (0, -1)), ((0, 0, 1), (-1, 0)), ((1, 0, 0), (1, -1))]):
        k = np.argmax(np.abs(camera.frame[along]))
        signs = np.array(start) @ camera.frame + (np.ones(3) - start) @ -camera.frame  # sign along each axis: 1 for its far end, -1 for 0
        middle = np.where(signs > 0, camera.box, 0)
        middle[k] = camera.box[k] / 2
        length = in_metres(camera.box[k]) if unit == "m" else f"{camera.box[k]:.4g} d₀"
        yield middle, shift, f"{'xyz'[k]}  {length}"


def draw_box(axes, camera, unit):
    """Draws the edges of the box, three with their length: those that end at the farthest corner behind the spheres,
    the others in front of them."""
    edges = box_edges(camera.box)
    ends = corners(camera.box)
    farthest = ends[np.argmax(camera.depth(ends))]
    behind = (edges == farthest).all(axis=2).any(axis=1)
    for chosen, order in [(behind, 1), (~behind, 3)]:
        axes.add_collection(LineCollection(camera.project(edges[chosen]), colors=EDGE, linewidths=0.6, zorder=order))
    middle = camera.project(camera.middle[None])[0]
    for point, shift, label in edge_labels(camera, unit):
        x, y = camera.project(point[None])[0]
        away = np.sign(x - middle[0]) if shift[0] else 0
        aside = {"textcoords": "offset points", "xytext": (7 * away, 7 * shift[1])}
        aside |= {"ha": {1: "left", -1: "right", 0: "center"}[int(away)], "va": "top" if shift[1] else "center"}
        axes.annotate(label, (x, y), fontsize=8, color=INK, **aside)


def draw_sides(axes, camera, sides):
    """Tinted, [2, 3] low and high corner each: those that end at the farthest corner behind the spheres, the others before them."""
    ends = corners(camera.box)
    farthest = ends[np.argmax(camera.depth(ends))]
    for low, high in sides:
        across = np.flatnonzero(high > low)
        face = np.tile(low, (4, 1))
        for k, chosen in zip(across, ([0, 1, 1, 0], [0, 0, 1, 1])):
            face[:, k] = np.where(chosen, high[k], low[k])
        behind = (face == farthest).all(axis=1).any()
        axes.add_collection(PolyCollection([camera.project(face)], facecolors=[(*SIDE, 0.22)], zorder=1 if behind else 3))


def set_window(axes, camera):
    axes.set(xlim=(camera.low[0], camera.high[0]), ylim=(camera.low[1], camera.high[1]), aspect="equal")
    axes.axis("off")


def draw(axes, position, radius, faces, window, unit, cut=None, sides=(), down=None):
    """Draws spheres, [N, 3] and [N] in a unit of length, with colours [N, 4]. `window`: lower corner and size of the shown
    part; `sides`: those of the box that are electrodes, by their corners [2, 3]; `down`: as in view_axes."""
    corner, size = window
    camera = Camera(size, down)
    set_window(axes, camera)
    left = behind_cut(position, cut, camera)
    image = rendered(camera, position[left] - corner, radius[left], faces[left])
    extent = (camera.low[0], camera.high[0], camera.low[1], camera.high[1])
    axes.imshow(image, origin="lower", extent=extent, interpolation="bilinear", aspect="auto", zorder=2)
    draw_sides(axes, camera, sides)
    draw_box(axes, camera, unit)
