#!/usr/bin/python3
"""Figure G 5.8: average size of clusters, mean mass^(1/D_f), and the largest cluster against time."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gases import COLOURS, TIME, all_in_words, gas_runs, draw_band, mean, mean_of_seeds, plain_ticks, parse_arguments


def sizes(gas_run, name):
    """Returns (times, <m>^(1/D_f)) where a dimension exists."""
    with np.errstate(invalid="ignore"):
        return gas_run.frames["time"], gas_run.frames[name] ** (1 / gas_run.frames["bound_fractal_dimension"])


def main():
    arguments = parse_arguments(__doc__)
    gases = [gas_scenes.fractal(arguments.full, strength=strength) for strength in (0.4, 1, 5)]
    found = gas_runs(arguments, *gases)
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
    growth = []
    for gas, colour, strength in zip(gases, COLOURS, (0.4, 1, 5)):
        for panel, name in zip(axes, ("mean_bound_cluster", "largest_bound_cluster")):
            time = sizes(found[gas.name][0], name)[0]
            middle, half = mean([sizes(gas_run, name)[1] for gas_run in found[gas.name]])
            shown = np.isfinite(half) & (time > 15)  # at least two seeds
            panel.plot(time[shown], middle[shown], color=colour, linewidth=1.2, label=f"K = {strength:g}")
            draw_band(panel, time[shown], middle[shown], half[shown], colour)
        ratios = []
        for gas_run in found[gas.name]:
            _, size = sizes(gas_run, "largest_bound_cluster")
            size = size[np.isfinite(size)]
            ratios.append(size[-1])
        growth.append(mean_of_seeds(ratios))
    plain_ticks(*axes)
    for panel, words in zip(axes, (r"$S = \langle m \rangle^{1/D_f}$ ($d_0$)", "the same of the largest ($d_0$)")):
        panel.set(xscale="log", yscale="log", xlabel=TIME, ylabel=words)
        panel.legend(frameon=False, fontsize=8)
    save(figure, "granular_5_8")
    save_claims("granular_5_8", [
        claim(f"largest cluster at t = {gases[0].until:g}, in grains across (K = .4, 1, 5)", "G 5.8",
              "one order of magnitude in 1e4 (2 mm to 7 cm: 15)", all_in_words(growth),
              "agrees, sooner" if growth[-1][0] > 7 else "differs",
              "it ends where one cluster has much of the box: a few hundred units at the K Q^2 that chapter 5's onsets need")])


if __name__ == "__main__":
    main()
