#!/usr/bin/python3
"""Figure 7.5: a Euclidean minimum spanning tree of random points, and the degrees of such trees.

The tree has 324 uniform points, as in the source. The other panel shows fractions of nodes by degree (D 7.4) for many
such trees, for trees of 100000 points, and for trees of points with the minimum distance of the source's spheres. They
are compared with the source's values for spanning trees (7.16) and for the experiments (7.10).

Runs `spanning_tree` (seconds).
"""

import json

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection

from ensembles import student_factor
from figures import build_folder, claim, run, save, save_claims

PRINTED = {"D 7.16, spanning trees": [0.253, 0.527, 0.204, 0.016], "D 7.10, experiments": [0.252, 0.511, 0.222, 0.015]}
# Standard errors. Those of 7.16 are its +- 0.3, 0.6, 0.4, 0.1, read as per cent. 7.10 has none; the values are the
# scatter between trees of one network of 324 conductors (validation/topology.cpp).
PRINTED_ERROR = {"D 7.16, spanning trees": [0.003, 0.006, 0.004, 0.001],
                 "D 7.10, experiments": [0.014, 0.026, 0.016, 0.007]}
DEGREES = range(1, 5)


def draw_tree(axes, found):
    point, edges = np.array(found["points"]), np.array(found["edges"])
    degree = np.bincount(edges.ravel(), minlength=len(point))
    axes.add_collection(LineCollection(point[edges], color="black", linewidths=0.8))
    for name, colour, chosen in (("endpoint", "#d62728", degree == 1), ("branch point", "#2ca02c", degree > 2),
                                 ("other", "black", degree == 2)):
        axes.scatter(*point[chosen].T, s=9, color=colour, linewidths=0, zorder=2,
                     label=f"{name}, {chosen.mean():.3f}")
    axes.set_aspect("equal")
    axes.set_xlim(-1.03, 1.03)
    axes.set_ylim(-1.03, 1.03)
    axes.set_xlabel("$x$")
    axes.set_ylabel("$y$")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.1), ncols=3, frameon=False, handletextpad=0)


def half_widths(row):
    """Returns the half widths of the 95 % intervals of the means over its trees."""
    return student_factor(row["trees"] - 1) * np.array(row["error"])


def draw_degrees(axes, found):
    series = [(name, values, 1.96 * np.array(PRINTED_ERROR[name])) for name, values in PRINTED.items()]
    for key, name in (("uniform", f"{found['uniform']['nodes']} uniform points"),
                      ("many", f"{found['many']['nodes']} uniform points"),
                      ("spheres", f"{found['spheres']['nodes']} points that keep the spheres' distance")):
        series.append((name, found[key]["fraction"][1:5], half_widths(found[key])[1:5]))
    colours = ["#7f7f7f", "black", "#aec7e8", "#1f77b4", "#d62728"]
    width = 0.16
    for k, ((name, values, error), colour) in enumerate(zip(series, colours)):
        bars = axes.bar(np.array(DEGREES) + (k - 2) * width, values, width, yerr=error, color=colour,
                        label=name, error_kw={"linewidth": 0.8})
        axes.bar_label(bars, [f"{value:.3f}" for value in values], rotation=90, padding=3, fontsize=6)
    axes.set_xticks(list(DEGREES))
    axes.set_xlabel("degree $j$")
    axes.set_ylabel("fraction of nodes $f_j$")
    axes.set_ylim(0, 0.66)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1), ncols=2, frameon=False, fontsize=8)


def claims(found):
    rows = []
    spheres = "points that keep the spheres' distance"
    for key, what, printed in (("many", "uniform points, many", "D 7.16, spanning trees"),
                               ("spheres", spheres, "D 7.16, spanning trees"),
                               ("spheres", spheres, "D 7.10, experiments")):
        for j in DEGREES:
            rows.append(claim(f"f_{j} of minimum spanning trees: {what}", printed,
                              (PRINTED[printed][j - 1], 1.96 * PRINTED_ERROR[printed][j - 1]),
                              (found[key]["fraction"][j], half_widths(found[key])[j])))
    return rows


def main():
    found = json.loads(run(build_folder(__doc__.splitlines()[0]) / "spanning_tree"))
    figure, (tree, degrees) = plt.subplots(1, 2, figsize=(10, 4.8), layout="constrained")
    draw_tree(tree, found)
    draw_degrees(degrees, found)
    save(figure, "figure_7_5")
    save_claims("figure_7_5", claims(found))
    for name in ("uniform", "many", "spheres"):
        row = found[name]
        print(f"{name:8} N = {row['nodes']:6}: "
              + ", ".join(f"f{j} = {row['fraction'][j]:.4f} +- {row['error'][j]:.4f}" for j in DEGREES))


if __name__ == "__main__":
    main()
