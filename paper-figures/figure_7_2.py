#!/usr/bin/python3
"""Figure 7.2: the network graph G of a state (left) and its anti-arborescence A (right).

G: contacts (D 7.1); contacts that are not in A are blue: one per loop, and all without a path to the ground. A: each
conductor's successor on the path to the ground; endpoints (degree 1) are red, branch points (degree above 2) green,
with their fractions.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D

import networks
from networks import drawing
from figures import claim, save, save_claims

ENDPOINT, BRANCH, LEFT_OUT = "#d62728", "#2ca02c", "#1f77b4"


def in_tree(snapshot, contacts):
    """Returns whether each contact joins a conductor and its successor."""
    successor = snapshot.successor
    return np.array([successor[i] == j or (j >= 0 and successor[j] == i) for i, j in contacts], dtype=bool)


def draw_arrows(axes, snapshot):
    for start, end in drawing.tree_edges(snapshot):
        axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>,head_width=0.12,head_length=0.25", "shrinkA": 0,
                                                  "shrinkB": 0, "linewidth": 0.8, "color": drawing.INK}, zorder=4)


def draw_kinds(axes, snapshot, degree):
    kinds = [("endpoint", ENDPOINT, degree == 1), ("branch point", BRANCH, degree > 2)]
    kinds.append(("other", drawing.INK, degree == 2))
    handles = []
    for name, colour, chosen in kinds:
        chosen = chosen & snapshot.connected
        networks.draw_nodes(axes, snapshot, chosen, colour)
        label = f"{name}, {chosen.sum() / max(snapshot.connected.sum(), 1):.3f}"
        handles.append(Line2D([], [], linestyle="", marker="o", markersize=4, color=colour, label=label))
    axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, 0), ncols=3, frameon=False, handletextpad=0)


def claims(degree, contacts):
    """Returns claims of D 7.3.1 on the graph: no node of degree above 4, no loop."""
    largest, loops = int(degree.max()), networks.loops(len(degree), contacts)
    return [claim("largest degree", "D 7.3.1", 4, largest, "agrees" if largest <= 4 else "larger ones exist"),
            claim("contacts that close a loop", "D 7.3.1", 0, loops,
                  "agrees" if loops == 0 else f"{loops} of {len(contacts)} contacts close one")]


def main():
    snapshot, contacts, name = networks.last_state(__doc__.splitlines()[0], "figure_7_2")
    drawing.set_style()
    figure, (graph, tree) = plt.subplots(1, 2, figsize=(9, 4.6), layout="constrained")
    networks.panel(graph, snapshot, f"graph: N = {len(snapshot.radius)}, {len(contacts)} contacts")
    edges, kept = networks.contact_edges(snapshot, contacts), in_tree(snapshot, contacts)
    drawing.draw_edges(graph, snapshot, edges[kept], color=drawing.INK, linewidths=1)
    drawing.draw_edges(graph, snapshot, edges[~kept], color=LEFT_OUT, linewidths=1)
    networks.draw_nodes(graph, snapshot, slice(None), drawing.INK)
    drawing.draw_scale(graph, snapshot)
    networks.panel(tree, snapshot, f"anti-arborescence: M = {snapshot.connected.sum()}")
    draw_arrows(tree, snapshot)
    degree = networks.degrees(snapshot, contacts)
    draw_kinds(tree, snapshot, degree)
    save(figure, name)
    save_claims(name, claims(degree, contacts))


if __name__ == "__main__":
    main()
