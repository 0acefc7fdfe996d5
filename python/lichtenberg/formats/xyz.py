"""Extended XYZ, for OVITO and ASE: one file with all frames."""
import numpy as np

from ..files import write_whole
from . import columns_of

ENDING, IS_FOLDER = ".xyz", False
# Names of OVITO's manual (XYZ file reader) where they differ; other columns keep their own names
OVITO = {"position": "pos", "velocity": "velo", "image": "map_shift", "dipole": "dipoles"}


def write(result, frames, out):
    """Writes one line per particle; each frame begins with its box, time and units."""
    write_whole(out, (xyz_frame(result.frame(index)) for index in frames))


def xyz_frame(frame):
    result = frame.result
    columns = {"species": np.full(result.count, "X"), "position": np.asarray(frame["position"])}
    columns.update(columns_of(frame))
    columns.pop("species")  # the number of the species in lichtenberg
    columns["color"] = colours(frame)
    kinds = {"f": "R", "i": "I", "U": "S"}
    named = {"species": np.full(result.count, "X"), **{OVITO.get(name, name): values for name, values in columns.items()}}
    properties = ":".join(
        f"{name}:{kinds[values.dtype.kind]}:{values.shape[1] if values.ndim > 1 else 1}" for name, values in named.items()
    )
    head = f'Lattice="{lattice(frame)}" pbc="{" ".join("FT"[axis] for axis in result.periodic)}" Properties={properties}'
    units = f'Time={frame.time:.10g} length_unit="{result.size.unit}" time_unit="{result.time.unit}"'
    blocks = [values.reshape(len(values), -1) for values in named.values()]
    words = [as_words(block) for block in blocks]
    lines = "\n".join(map(" ".join, zip(*(column for block in words for column in block))))
    return f"{result.count}\n{head} {units}\n{lines}\n"


def as_words(block):
    """Returns K lists of N words."""
    if block.dtype.kind == "f":
        return [[f"{value:.10g}" for value in column] for column in block.T.tolist()]
    return [[str(value) for value in column] for column in block.T.tolist()]


def lattice(frame):
    """Returns the box vectors of a frame; the depth of a plane box is the largest particle diameter."""
    lengths = [*np.asarray(frame.size), 2 * float(frame.result["radius"].max(initial=0))][:3]
    return " ".join(f"{lengths[i]:.10g}" if i == j else "0" for i in range(3) for j in range(3))


def colours(frame):
    """[N, 3] red for positive, blue for negative potential (or charge, if there is no potential), on the same scale
    in the whole run; grey if there is neither."""
    result = frame.result
    shown = next((name for name in ("potential", "charge") if name in result.columns), None)
    if shown is None:
        return np.full((result.count, 3), 0.75)
    share = np.clip(np.asarray(frame[shown])[:, None] / result.colour_range(shown)[1], -1, 1)
    white, red, blue = np.ones(3), np.array([0.7, 0.09, 0.17]), np.array([0.13, 0.4, 0.67])
    return np.where(share > 0, white + share * (red - white), white - share * (blue - white))
