#!/usr/bin/python3
"""Figure G 5.6: distribution of the charges of grains, and a Gaussian."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gases import COLOURS, INK, gas_runs, number, mean_of_seeds, parse_arguments


def main():
    arguments = parse_arguments(__doc__)
    gas = gas_scenes.fractal(arguments.full)
    found = gas_runs(arguments, gas)[gas.name]
    bins = -6 + 0.2 * (np.arange(60) + 0.5)
    figure, axes = plt.subplots(figsize=(5.5, 4), layout="constrained")
    for time, colour in ((10, COLOURS[0]), (100, COLOURS[1]), (300, COLOURS[2])):
        density = np.mean([gas_run.at("charge_density", time) for gas_run in found], axis=0)
        axes.plot(bins, np.where(density > 0, density, np.nan), "o", color=colour, markersize=3, label=f"t = {time}")
    axes.plot(bins, np.exp(-(bins**2) / 2) / np.sqrt(2 * np.pi), color=INK, linewidth=1, label="Gaussian")
    axes.set(yscale="log", ylim=(1e-4, 1.5), xlabel=r"$q / \langle \delta q^2 \rangle^{1/2}$", ylabel="f")
    axes.legend(frameon=False, fontsize=8)
    save(figure, "granular_5_6")
    kurtosis = mean_of_seeds([gas_run.at("charge_kurtosis", 100) for gas_run in found])
    save_claims("granular_5_6", [
        claim("kurtosis of charges, t = 100 (Gaussian: 3)", "G 5.6", 3.0, number(kurtosis), note="the last fast impacts give a few grains much: tails are wider, and symmetric as signs are a fair coin's; the "
              "source says so itself of early times (5.5)")])


if __name__ == "__main__":
    main()
