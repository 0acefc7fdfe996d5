"""Electrodes in a scene of conductors (sides, disks, bars, rings, polygons; in space faces and spheres), and the nearest points on
them."""
import numpy as np

from .result import text_of


def electrodes_of(result):
    """Returns the electrodes as dictionaries with shape, name and potential, lengths in metres. A side has `ends`, a
    face in space the corners `low` and `high`, any other shape its own geometry."""
    return electrodes_in(result.file["scene"])


def electrodes_in(scene):
    """Returns the electrodes of a result's group /scene."""
    shapes = []
    domain = scene["domain"]
    for k in np.flatnonzero(domain["side_is_electrode"]):
        name, potential = f"{text_of(domain.attrs['sides'][k])} side", float(domain["side_potential"][k])
        shapes.append({"name": name, "potential": potential, **side(domain["size"][()], k)})
    for group in scene.get("electrodes", {}).values():
        geometry = {name: data[()].tolist() for name, data in group.items()}
        shapes.append({"shape": group.attrs["shape"], "name": group.attrs["name"], **geometry})
    return shapes


def side(size, k):
    """Returns the geometry of the k-th side of a box: left, right, bottom, top, and so on along the axes."""
    low, high = np.zeros(len(size)), np.array(size, float)
    (high if k % 2 == 0 else low)[k // 2] = (low if k % 2 == 0 else high)[k // 2]
    if len(size) == 2:
        return {"shape": "side", "ends": [*low.tolist(), *high.tolist()]}
    return {"shape": "face", "low": low.tolist(), "high": high.tolist()}


def nearest_on_segments(points, start, end):
    along = end - start
    share = np.clip((points - start) @ along / (along @ along), 0, 1)
    return start + share[:, None] * along


def nearest_on_polygon(points, corners):
    """Returns the points on the edges of a polygon that are nearest to `points`, a thousand of these at a time."""
    start, along = corners, np.roll(corners, -1, axis=0) - corners
    nearest = np.empty_like(points)
    for first in range(0, len(points), 1000):
        some = points[first : first + 1000, None]
        share = np.clip(((some - start) * along).sum(axis=2) / (along**2).sum(axis=1), 0, 1)
        on_edges = start + share[..., None] * along
        best = np.argmin(((on_edges - some) ** 2).sum(axis=2), axis=1)
        nearest[first : first + 1000] = on_edges[np.arange(len(some)), best]
    return nearest


def towards(start, points, length):
    """Returns the points at this distance from `start` in the direction of `points`."""
    offset = points - start
    distance = np.maximum(np.linalg.norm(offset, axis=1), 1e-300)  # any direction if a point coincides with start
    return start + length * offset / distance[:, None]


def nearest_on(shape, points):
    """Returns the points [K, D] on the surface of a shape that are nearest to `points` [K, D]."""
    if shape["shape"] == "face":
        return np.clip(points, shape["low"], shape["high"])
    if shape["shape"] == "side":
        ends = np.array(shape["ends"])
        return nearest_on_segments(points, ends[:2], ends[2:])
    if shape["shape"].endswith("polygon"):
        return nearest_on_polygon(np.asarray(points, float), np.array(shape["points"]))
    if shape["shape"] == "bar":
        axis = nearest_on_segments(points, np.array(shape["from"]), np.array(shape["to"]))
        return towards(axis, points, shape["width"] / 2)
    return towards(np.array([shape["centre"]]), points, shape["radius"])


def nearest_ground(points, electrodes):
    """Returns the points [K, D] of all surfaces that are nearest to `points`; without electrodes, `points`
    themselves."""
    if not electrodes or len(points) == 0:
        return points
    candidates = np.array([nearest_on(shape, points) for shape in electrodes])
    nearest = np.argmin(np.linalg.norm(candidates - points, axis=2), axis=0)
    return candidates[nearest, np.arange(len(points))]
