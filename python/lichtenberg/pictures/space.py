"""Spheres in a box seen in perspective. They are painted from far to near into an image, shaded by a light. They are darker in hollows and paler far away. x points to the right, y up as in plane pictures, z towards the eye. The eye is a little to the
right and above. In a scene with gravity the axis along which bodies fall points down. The code needs numpy only and no
display."""
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection

from .drawing import INK, InputError, in_metres

TURN, RISE = np.radians(28), np.radians(18)  # of the eye about the box
DISTANCE = 2.6  # of the eye from the middle of the box, in its longest edges
LIGHT = np.array([-0.45, 0.65, 0.61], np.float32)  # in the picture: to the right, up, towards the eye
SIDE = (0.3, 0.3, 0.3)
EDGE, FOG = "#4d4d4d", 0.25  # so little that a colour can still be found on its bar
PIXELS = 1000  # of the longer side of an image
MOST_RUNS = 100_000  # rows of pixels that are spread at a time


def frame_of(down=None):
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


class Eye:
    """Central projection of a box on the plane through its middle. `down`: as in frame_of."""

    def __init__(self, box, down=None):
        self.frame = frame_of(down)
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
        """0 at the box's nearest corner, 1 at its farthest."""
        ends = self.depth(corners(self.box))
        return np.clip((depth - ends.min()) / np.ptp(ends), 0, 1)


def corners(box):
    return box * np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)])


def box_edges(box):
    """[12, 2, 3]"""
    ends = corners(box)
    return np.array([[ends[i], ends[i | 1 << k]] for i in range(8) for k in range(3) if not i >> k & 1])


def kept(position, cut, eye=None):
    """Returns [N] whether a point is behind the cut, seen from the eye. `cut`: (axis, position), or None for all."""
    if cut is None:
        return np.ones(len(position), bool)
    axis, place = cut
    away = eye is None or eye.frame[:, axis].sum() > 0  # the eye is on the far side of all three axes of its frame
    return position[:, axis] <= place if away else position[:, axis] >= place


def read_cut(text, box, unit):
    """ "z=0.5" as (2, 0.5). Throws InputError."""
    axis, _, place = text.partition("=")
    try:
        place = float(place)
    except ValueError:
        place = np.nan
    if axis not in ("x", "y", "z") or not np.isfinite(place):
        example = f"--cut z={box[2] / 2:g}"
        raise InputError(f"--cut {text} is not understood: an axis and a place on it are wanted, as in {example}")
    k = "xyz".index(axis)
    if not 0 < place <= box[k]:
        raise InputError(f"--cut {text} leaves nothing: the box reaches from {axis} = 0 to {box[k]:g} {unit}")
    return k, place


def nearest_at(centre, radius, depth, shape):
    """[h, w] index of the sphere that each pixel shows, -1 for none. In pixels, from the lower left."""
    height, width = shape
    image = np.full(height * width, -1, np.int32)
    order = np.argsort(-depth, kind="stable")
    rows = np.maximum(np.ceil(2 * radius[order]).astype(int), 1) + 1
    starts = np.searchsorted(np.cumsum(rows), np.arange(0, rows.sum() + MOST_RUNS, MOST_RUNS))
    for first, last in zip(starts, np.append(starts[1:], len(order))):
        paint(image, order[first:last], rows[first:last], centre, radius, shape)
    return image.reshape(shape)


def paint(image, spheres, rows, centre, radius, shape):
    """Disks row by row; where they cover each other, the last stays."""
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
    """Means over squares of 2 reach + 1 pixels."""
    for axis in range(2):
        padded = np.concatenate([np.repeat(values.take([0], axis), reach + 1, axis), values], axis)
        padded = np.concatenate([padded, np.repeat(values.take([-1], axis), reach, axis)], axis)
        total = np.cumsum(padded, axis, np.float64)
        n = values.shape[axis]
        after, before = np.arange(2 * reach + 1, 2 * reach + 1 + n), np.arange(n)
        values = (total.take(after, axis) - total.take(before, axis)) / (2 * reach + 1)
    return values


def shaded(image, centre, radius, depth, length, faces, haze):
    """[h, w, 4] colours of an image of indices. `radius` in pixels, `depth` and `length` (the spheres' radii) in the box's
    unit."""
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
    """Means of two by two pixels, for smooth rims; colours count by how much of them there is."""
    weighted = colours.copy()
    weighted[..., :3] *= colours[..., 3:]
    small = (weighted[::2, ::2] + weighted[1::2, ::2] + weighted[::2, 1::2] + weighted[1::2, 1::2]) / 4
    small[..., :3] /= np.maximum(small[..., 3:], 1e-9)
    return small


def rendered(eye, position, radius, faces, pixels=PIXELS):
    """[h, w, 4] the spheres as the eye sees them."""
    fine = 2 * pixels / eye.size.max()  # pixels a unit of length
    shape = tuple(2 * np.ceil(eye.size[::-1] * fine / 2).astype(int))
    depth = eye.depth(position)
    seen = depth > 0.05 * eye.distance  # those behind the eye or before its nose are not
    position, radius, faces, depth = position[seen], radius[seen], faces[seen], depth[seen]
    centre = (eye.project(position) - eye.low) * fine
    shown = np.maximum(radius * eye.scale(position) * fine, 0.8)
    image = nearest_at(centre, shown, depth, shape)
    return halved(shaded(image, centre, shown, depth, radius, faces, eye.haze(depth)))


def draw_box(axes, eye, unit):
    """Edges that end at the farthest corner are behind the spheres, the others before them; three have their length."""
    edges = box_edges(eye.box)
    ends = corners(eye.box)
    farthest = ends[np.argmax(eye.depth(ends))]
    behind = (edges == farthest).all(axis=2).any(axis=1)
    for chosen, order in [(behind, 1), (~behind, 3)]:
        axes.add_collection(LineCollection(eye.project(edges[chosen]), colors=EDGE, linewidths=0.6, zorder=order))
    middle = eye.project(eye.middle[None])[0]
    for along, (start, shift) in enumerate([((0, 0, 1), (0, -1)), ((0, 0, 1), (-1, 0)), ((1, 0, 0), (1, -1))]):
        k = np.argmax(np.abs(eye.frame[along]))
        signs = np.array(start) @ eye.frame + (np.ones(3) - start) @ -eye.frame  # 1: the far end of an axis, -1: 0
        place = np.where(signs > 0, eye.box, 0)
        place[k] = eye.box[k] / 2
        x, y = eye.project(place[None])[0]
        length = in_metres(eye.box[k]) if unit == "m" else f"{eye.box[k]:.4g} ${unit[0]}_0$"
        away = np.sign(x - middle[0]) if shift[0] else 0
        aside = {"textcoords": "offset points", "xytext": (7 * away, 7 * shift[1])}
        aside |= {"ha": {1: "left", -1: "right", 0: "center"}[int(away)], "va": "top" if shift[1] else "center"}
        axes.annotate(f"${'xyz'[k]}$  {length}", (x, y), fontsize=8, color=INK, **aside)


def draw_sides(axes, eye, sides):
    """Tinted, [2, 3] low and high corner each: those that end at the farthest corner behind the spheres, the others before them."""
    ends = corners(eye.box)
    farthest = ends[np.argmax(eye.depth(ends))]
    for low, high in sides:
        across = np.flatnonzero(high > low)
        face = np.tile(low, (4, 1))
        for k, chosen in zip(across, ([0, 1, 1, 0], [0, 0, 1, 1])):
            face[:, k] = np.where(chosen, high[k], low[k])
        behind = (face == farthest).all(axis=1).any()
        axes.add_collection(PolyCollection([eye.project(face)], facecolors=[(*SIDE, 0.22)], zorder=1 if behind else 3))


def set_window(axes, eye):
    axes.set(xlim=(eye.low[0], eye.high[0]), ylim=(eye.low[1], eye.high[1]), aspect="equal")
    axes.axis("off")


def draw(axes, position, radius, faces, window, unit, cut=None, sides=(), down=None):
    """Draws spheres, [N, 3] and [N] in a unit of length, with colours [N, 4]. `window`: lower corner and size of the shown
    part; `sides`: those of the box that are electrodes, by their corners [2, 3]; `down`: as in frame_of."""
    corner, size = window
    eye = Eye(size, down)
    set_window(axes, eye)
    left = kept(position, cut, eye)
    image = rendered(eye, position[left] - corner, radius[left], faces[left])
    extent = (eye.low[0], eye.high[0], eye.low[1], eye.high[1])
    axes.imshow(image, origin="lower", extent=extent, interpolation="bilinear", aspect="auto", zorder=2)
    draw_sides(axes, eye, sides)
    draw_box(axes, eye, unit)
