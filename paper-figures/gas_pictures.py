"""Pictures of grains in their box, for the figures that are snapshots."""

import h5py
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection, LineCollection

# rotation and elevation of the camera, and its distance from the box's middle in edges
TURN, RISE, DISTANCE = np.radians(28), np.radians(18), 2.6
LONE = (0.6, 0.6, 0.6, 0.25)


class Grains:
    """Frame of a result nearest to a time after the warm-up, with the clusters of grains in contact."""

    def __init__(self, path, warm, time):
        with h5py.File(path) as file:
            particles = file["particles/conductors"]
            times = particles["position/time"][()] - warm
            index = int(np.abs(times - time).argmin())
            self.time = times[index]
            self.box = particles["box/edges"][()]
            self.radius = particles["radius"][()]
            self.position = particles["position/value"][index]
            self.velocity = particles["velocity/value"][index]
            self.cluster = particles["cluster/value"][index]
            self.charge = particles["charge/value"][index] if "charge" in particles else np.zeros(len(self.radius))
            ends = file["network/contacts_end"][()]
            self.contacts = file["network/contacts_of_all_frames"][ends[index - 1] if index else 0 : ends[index]]

    def in_clusters_of(self, least):
        """Returns for each grain [N] whether its cluster has at least `least` grains."""
        _, inverse, size = np.unique(self.cluster, return_inverse=True, return_counts=True)
        return size[inverse] >= least


def project(box, points):
    """Returns (positions in the picture, depth, scale) in perspective."""
    forward = np.array([np.sin(TURN) * np.cos(RISE), np.cos(TURN) * np.cos(RISE), -np.sin(RISE)])
    right = np.cross(forward, [0, 0, 1.0]) / np.cos(RISE)
    depth = DISTANCE * box.max() + (points - box / 2) @ forward
    scale = DISTANCE * box.max() / depth
    return (points - box / 2) @ np.array([right, np.cross(right, forward)]).T * scale[:, None], depth, scale


def draw(axes, grains, least, title):
    """Draws each cluster of at least `least` grains in a colour, paler if distant; the other grains in grey."""
    corners = grains.box * np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)])
    at, depth_of_corners, _ = project(grains.box, corners)
    edges = [at[[i, i | 1 << k]] for i in range(8) for k in range(3) if not i >> k & 1]
    axes.add_collection(LineCollection(edges, colors="#b0b0b0", linewidths=0.4, zorder=1))
    axes.set(xlim=(at[:, 0].min(), at[:, 0].max()), ylim=(at[:, 1].min(), at[:, 1].max()), aspect="equal")
    axes.axis("off")
    axes.set_title(title, fontsize=7)
    points, depth, scale = project(grains.box, grains.position)
    order = np.argsort(-depth)
    colours = colours_of(grains.cluster)[order]
    alone = ~grains.in_clusters_of(least)[order]
    colours[alone] = LONE
    far = 0.75 * (depth - depth_of_corners.min())[order] / np.ptp(depth_of_corners)
    colours[:, :3] += far[:, None] * (1 - colours[:, :3])
    diameter = (2 * grains.radius * scale)[order]
    axes.add_collection(EllipseCollection(diameter, diameter, np.zeros_like(diameter), units="xy", offsets=points[order],
                                          offset_transform=axes.transData, facecolor=colours, edgecolor="none", zorder=2))


def colours_of(cluster):
    """Returns a colour per grain [N, 4] by the size rank of its cluster."""
    numbers, inverse, size = np.unique(cluster, return_inverse=True, return_counts=True)
    rank = np.empty(len(numbers), int)
    rank[np.argsort(-size, kind="stable")] = np.arange(len(numbers))
    palette = [colour for k, colour in enumerate(plt.get_cmap("tab20").colors) if k // 2 != 7]
    return np.column_stack([np.array(palette[::2] + palette[1::2])[rank % 18], np.ones(len(rank))])[inverse]
