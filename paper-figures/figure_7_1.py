#!/usr/bin/python3
"""Figure 7.1: the stationary state of 324 conductors, and its network of electrical contacts.

The source has a photograph of the experiment instead of the network.
"""

import matplotlib.pyplot as plt

import networks
from networks import drawing
from figures import claim, save, save_claims


def main():
    snapshot, contacts, name = networks.last_state(__doc__.splitlines()[0], "figure_7_1")
    drawing.set_style()
    figure, (state, graph) = plt.subplots(1, 2, figsize=(9, 4.6), layout="constrained")
    networks.panel(state, snapshot, drawing.caption(snapshot))
    drawing.draw_conductors(state, snapshot)
    drawing.draw_scale(state, snapshot)
    networks.panel(graph, snapshot, f"{len(contacts)} contacts")
    drawing.draw_edges(graph, snapshot, networks.contact_edges(snapshot, contacts), color=drawing.INK, linewidths=1)
    networks.draw_nodes(graph, snapshot, slice(None), drawing.INK)
    save(figure, name)
    connected, all_conductors = int(snapshot.connected.sum()), len(snapshot.radius)
    save_claims(name, [claim("conductors connected to the ground in the stationary state", "D 7.1",
                                     all_conductors, connected,
                                     "agrees" if connected == all_conductors else "some are left over")])


if __name__ == "__main__":
    main()
