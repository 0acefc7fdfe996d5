"""What holds a potential in a plane scene - sides, disks, bars, rings - and where the way to it ends."""
import numpy as np

from .result import text_of


def electrodes_of(result):
    """As dictionaries, lengths in metres: shape, name, potential, and `ends` of a side, else the shape's own geometry."""
    scene = result.file["scene"]
    if result.dimension == 3:
        return []
    width, height = result.size
    ends = [(0, 0, 0, height), (width, 0, width, height), (0, 0, width, 0), (0, height, width, height)]
    shapes = []
    domain = scene["domain"]
    for k in np.flatnonzero(domain["side_is_electrode"]):
        name, potential = f"{text_of(domain.attrs['sides'][k])} side", float(domain["side_potential"][k])
        shapes.append({"shape": "side", "name": name, "potential": potential, "ends": [float(end) for end in ends[k]]})
    for group in scene.get("electrodes", {}).values():
        geometry = {name: data[()].tolist() for name, data in group.items()}
        shapes.append({"shape": group.attrs["shape"], "name": group.attrs["name"], **geometry})
    return shapes


def nearest_on_segments(points, start, end):
    along = end - start
    share = np.clip((points - start) @ along / (along @ along), 0, 1)
    return start + share[:, None] * along


def towards(start, points, length):
    """From the start that far in the direction of the points."""
    offset = points - start
    distance = np.maximum(np.linalg.norm(offset, axis=1), 1e-300)  # any direction from the start itself
    return start + length * offset / distance[:, None]


def nearest_on(shape, points):
    """[K, 2] on the surface of one, nearest to points [K, 2]."""
    if shape["shape"] == "side":
        ends = np.array(shape["ends"])
        return nearest_on_segments(points, ends[:2], ends[2:])
    if shape["shape"] == "bar":
        axis = nearest_on_segments(points, np.array(shape["from"]), np.array(shape["to"]))
        return towards(axis, points, shape["width"] / 2)
    return towards(np.array([shape["centre"]]), points, shape["radius"])


def nearest_ground(points, electrodes):
    """[K, 2] on the nearest of all surfaces, or the points [K, 2] themselves where there is none."""
    if not electrodes or len(points) == 0:
        return points
    candidates = np.array([nearest_on(shape, points) for shape in electrodes])
    nearest = np.argmin(np.linalg.norm(candidates - points, axis=2), axis=0)
    return candidates[nearest, np.arange(len(points))]
