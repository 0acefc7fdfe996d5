"""What the figures of networks share: the run that they show, its contacts, panels of conductors and edges."""

import argparse
import sys
from pathlib import Path

import h5py
import numpy as np

from figures import OUTPUT, SOURCE, run

sys.path.insert(0, str(SOURCE / "src" / "commands"))
import plot  # noqa: E402  the pictures of `lichtenberg plot`


def result_file(description):
    """The result file that the command line names; by default scenes/dendrite.toml is run, once."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--build", type=Path, default=SOURCE / "build", help="folder of the built programs")
    parser.add_argument("--result", type=Path, help="result file of `lichtenberg run` to show in place of dendrite's")
    request = parser.parse_args()
    if request.result is not None:
        return request.result
    result = OUTPUT / "dendrite.h5"
    if not result.exists():
        OUTPUT.mkdir(exist_ok=True)
        run(request.build.resolve() / "lichtenberg", "run", SOURCE / "scenes" / "dendrite.toml", "--out", result)
    return result


def last_state(description):
    """The last frame of that file, and its contacts: [E, 2] indices, -1 the ground."""
    path = result_file(description)
    try:
        snapshot = plot.read(path)
    except plot.InputError as error:
        sys.exit(str(error))
    with h5py.File(path) as file:
        return snapshot, file["network/contacts"][()]


def degrees(snapshot, contacts):
    """Number of contacts of each conductor, the ground among them (D 7.2)."""
    return np.bincount(contacts[contacts >= 0], minlength=len(snapshot.radius))


def contact_edges(snapshot, contacts):
    """[E, 2, 2] from centre to centre, or to the nearest point of the ground; mm."""
    ends = []
    for i, j in contacts:
        start = snapshot.position[i]
        ends.append([start, plot.nearest_ground(start, snapshot) if j == plot.TO_GROUND else snapshot.position[j]])
    return np.array(ends)


def panel(axes, snapshot, title):
    plot.set_frame(axes, snapshot)
    plot.draw_electrodes(axes, snapshot)
    axes.set_title(title)


def draw_nodes(axes, snapshot, chosen, colour):
    """Conductors as dots."""
    axes.scatter(*snapshot.position[chosen].T, s=9, color=colour, linewidths=0, zorder=5)
