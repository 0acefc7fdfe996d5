"""Functions for the figures of networks: the run, its contacts, panels of conductors and edges."""

import sys

import h5py
import numpy as np

from figures import SOURCE, kept_run, name_for, request

sys.path.insert(0, str(SOURCE / "python"))
from lichtenberg.pictures import drawing  # used by `lichtenberg plot`


def last_state(description, name):
    """Returns the last frame of the result file on the command line, its contacts [E, 2] as indices (-1: the ground), and
    the name of the figure NAME. The default is scenes/dendrite.toml, which is run once."""
    arguments = request(description, ("--result", "result file of `lichtenberg run` to show in place of dendrite's"))
    path = arguments.result or kept_run(arguments.program, SOURCE / "scenes" / "dendrite.toml", arguments.results / "dendrite.h5")
    try:
        snapshot = drawing.read(path)
    except drawing.InputError as error:
        sys.exit(str(error))
    with h5py.File(path) as file:
        if "network/contacts" not in file or snapshot.successor is None:
            sys.exit(f"{path} holds no network of electrical contacts: this figure needs a run of a scene with "
                     "[effects.contact_discharge]")
        return snapshot, file["network/contacts"][()], name_for(name, arguments.result)


def degrees(snapshot, contacts):
    """Returns the number of contacts of each conductor, including the ground (D 7.2)."""
    return np.bincount(contacts[contacts >= 0], minlength=len(snapshot.radius))


def loops(count, contacts):
    """Returns the number of contacts among COUNT conductors beyond those of a forest; each closes a loop. The ground is
    one node."""
    towards = list(range(count + 1))  # next node on each node's path to its tree's root; the last, -1, is the ground

    def root(node):
        while towards[node] != node:
            towards[node] = node = towards[towards[node]]
        return node

    closed = 0
    for i, j in contacts:
        a, b = root(i), root(j if j >= 0 else count)
        closed += a == b
        towards[a] = b
    return int(closed)


def contact_edges(snapshot, contacts):
    """Returns lines [E, 2, 2] from centre to centre, or to the nearest point of the ground; mm."""
    ends = []
    for i, j in contacts:
        start = snapshot.position[i]
        ends.append([start, drawing.nearest_ground(start, snapshot) if j == drawing.TO_GROUND else snapshot.position[j]])
    return np.array(ends).reshape(-1, 2, 2)


def panel(axes, snapshot, title):
    drawing.set_frame(axes, snapshot)
    drawing.draw_electrodes(axes, snapshot)
    axes.set_title(title)


def draw_nodes(axes, snapshot, chosen, colour):
    """Draws conductors as dots."""
    axes.scatter(*snapshot.position[chosen].T, s=9, color=colour, linewidths=0, zorder=5)
