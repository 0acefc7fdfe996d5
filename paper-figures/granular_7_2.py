#!/usr/bin/python3
"""Figures G 7.2 and 7.3: fractal dimension and average size of clusters by polarizability."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gases import COLOURS, TIME, courses, draw_mean, in_words, mean, requested

LATE = 200  # t0, from which on G compares


def late(found, name):
    """Mean over the frames from LATE on, of each seed."""
    return np.array([np.nanmean(course.frames[name][course.frames["time"] >= LATE]) for course in found])


def compared(found, name, gases):
    """Ratio to A = 0 of the two others, with half widths over seeds."""
    none = late(found[gases[0].name], name)
    ratios = []
    for a in gas_scenes.POLARIZABILITIES[1:]:
        middle, half = mean((late(found[gases[a].name], name) / none.mean())[:, None])
        ratios.append((float(middle[0]), float(half[0])))
    return ratios


def main():
    asked = requested(__doc__)
    gases = {a: gas_scenes.polarized(asked.full, a) for a in gas_scenes.POLARIZABILITIES}
    found = courses(asked, *gases.values())
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
    for (a, gas), colour in zip(gases.items(), COLOURS):
        draw_mean(axes[0], found[gas.name], "bound_fractal_dimension", colour, f"A = {a:g}", first=60)
        draw_mean(axes[1], found[gas.name], "mean_bound_cluster", colour, f"A = {a:g}", first=9)
    axes[0].axvspan(60, LATE, color="#8c8c8c", alpha=0.12, linewidth=0)
    axes[0].set(xlabel=TIME, ylabel="$D_f$ of bound clusters", ylim=(1.4, 2.8))
    axes[1].set(xscale="log", yscale="log", xlabel=TIME, ylabel=r"$\langle m \rangle$ by mass (grains)")
    for panel, words in zip(axes, ("G 7.2", "G 7.3")):
        panel.set_title(words, fontsize=9)
        panel.legend(frameon=False, fontsize=8)
    save(figure, "granular_7_2")
    dimension = compared(found, "bound_fractal_dimension", gases)
    size = compared(found, "mean_bound_cluster", gases)
    drop = dimension[1][0] + (dimension[1][1] if np.isfinite(dimension[1][1]) else 0)
    save_claims("granular_7_2", [
        claim(f"D_f from t = {LATE} on over that of A = 0, A = .005, .075, clusters of six and more", "G 7.2",
              "none; -2 % without clusters of 5 and less, -8 to -9 % with", ", ".join(map(in_words, dimension)),
              "a drop" if drop < 1 else "no drop seen", "intervals of few seeds and 1500 grains are as wide as the drop"),
        claim(f"<m> from t = {LATE} on over that of A = 0, A = .005, .075", "G 7.3", "grows with A",
              ", ".join(map(in_words, size)), "grows" if size[1][0] - (size[1][1] if np.isfinite(size[1][1]) else 0) > 1
              else "no growth seen", "one run each in the source, too")])


if __name__ == "__main__":
    main()
