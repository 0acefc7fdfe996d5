#!/usr/bin/python3
"""Figures G 7.2 and 7.3: fractal dimension and average size of clusters by polarizability."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gases import COLOURS, TIME, all_in_words, differ, gas_runs, draw_mean, mean, parse_arguments

LATE = 200  # t0; G compares later times


def late(found, name):
    """Returns the mean of each seed over the frames from LATE on."""
    return np.array([np.nanmean(gas_run.frames[name][gas_run.frames["time"] >= LATE]) for gas_run in found])


def compared(found, name, gases):
    """Returns the ratios to A = 0 of the two others, with half widths over seeds of both."""
    (none,), (off,) = mean(late(found[gases[0].name], name)[:, None])
    ratios = []
    for a in gas_scenes.POLARIZABILITIES[1:]:
        (middle,), (half,) = mean(late(found[gases[a].name], name)[:, None])
        ratios.append((float(middle / none), float(np.hypot(half, off * middle / none) / none)))
    return ratios


def main():
    arguments = parse_arguments(__doc__)
    gases = {a: gas_scenes.polarized(arguments.full, a) for a in gas_scenes.POLARIZABILITIES}
    found = gas_runs(arguments, *gases.values())
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
    save_claims("granular_7_2", [
        claim(f"D_f from t = {LATE} on over that of A = 0, A = .005, .075, clusters of six and more", "G 7.2",
              "none; -2 % without clusters of 5 and less, -8 to -9 % with", all_in_words(dimension), verdict(dimension[1]),
              "as wide as the drop itself are the intervals of few seeds and 1500 grains"),
        claim(f"<m> from t = {LATE} on over that of A = 0, A = .005, .075", "G 7.3", "grows with A",
              all_in_words(size), verdict(size[1]), "one run each in the source")])


def verdict(ratio):
    """Returns whether the ratio is below or above 1 by more than its interval."""
    return "undecided" if not differ(ratio, (1, 0)) else "falls" if ratio[0] < 1 else "grows"


if __name__ == "__main__":
    main()
