#!/usr/bin/python3
"""Energy of a contact w(q) = (q - 1) ln q in units of k, with force and curvature, as in the source's first figure."""

import matplotlib.pyplot as plt
import numpy as np

from figures import build_folder, save

CURVES = [  # label, formula, colour
    (r"$w = (q - 1)\,\ln q$", lambda q: (q - 1) * np.log(q), "#0c7bdc"),
    (r"$-w' = 1/q - 1 - \ln q$", lambda q: 1 / q - 1 - np.log(q), "#d55e00"),
    (r"$w'' = (q + 1)/q^2$", lambda q: (q + 1) / q**2, "#1a1a1a"),
]


def main():
    build_folder(__doc__.splitlines()[0])  # no program is run
    inside, outside = np.linspace(0.005, 1, 1000), np.array([1, 1.5])
    figure, axes = plt.subplots(figsize=(5, 3.4), layout="constrained")
    for label, formula, colour in CURVES:
        axes.plot(inside, formula(inside), color=colour, label=label)
        axes.plot(outside, [0, 0], color=colour)
    axes.plot([1], [2], "o", color=CURVES[2][2], markersize=4)
    axes.plot([1], [0], "o", color=CURVES[2][2], markerfacecolor="white", markersize=4)
    axes.set(xlim=(0, 1.5), ylim=(-0.2, 5), xlabel=r"$q = \|\Delta p\| / R$", ylabel=r"in units of $k$")
    axes.legend(frameon=False)
    save(figure, "figure_packing_potential")


if __name__ == "__main__":
    main()
