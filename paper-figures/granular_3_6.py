#!/usr/bin/python3
"""Figures G 3.6 to 3.8: grains that exchange charge by a random walk, from three distributions of charge.

The figures show distributions, temperature, and positions at t = 1 and 100."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gas_pictures import Grains, draw
from gases import COLOURS, TIME, all_in_words, differ, gas_runs, draw_mean, mean, mean_of_seeds, parse_arguments

WIDTHS = (0, 2, 8)  # z of G 3.49
BINS = np.linspace(-6, 6, 61)


def late(gas_run, name):
    """Returns the mean over the frames after t = 135."""
    return np.mean(gas_run.frames[name][gas_run.frames["time"] > 135], axis=0)


def main():
    arguments = parse_arguments(__doc__)
    gases = {z: gas_scenes.walking(arguments.full, z) for z in WIDTHS}
    found = gas_runs(arguments, *gases.values())
    figure = plt.figure(figsize=(10, 8), layout="constrained")
    panels = figure.subplot_mosaic("abc\n048\nxyz")
    middles = (BINS[1:] + BINS[:-1]) / 2
    for (z, gas), colour in zip(gases.items(), COLOURS):
        density = np.mean([gas_run.at("charge_density", 100) for gas_run in found[gas.name]], axis=0)
        panels["a"].plot(middles, density, color=colour, linewidth=1, label=f"z = {z}")
        draw_mean(panels["b"], found[gas.name], "local_temperature", colour, f"z = {z}", notes=True, first=0.4)
        shells = np.array([late(gas_run, "density_structure") for gas_run in found[gas.name]])
        middle, half = mean(shells)
        panels["c"].errorbar(np.arange(1, 1 + len(middle)), middle, yerr=np.where(np.isfinite(half), half, 0), color=colour, marker="o", markersize=3,
                             linewidth=0.8, label=f"z = {z}")
        for key, time in zip(("048"[WIDTHS.index(z)], "xyz"[WIDTHS.index(z)]), (1, 100)):
            grains = Grains(found[gas.name][0].result, gas.warm, time)
            draw(panels[key], grains, 3, f"z = {z}, t = {grains.time:.0f}; clusters of 3 and more coloured")
    normal = np.exp(-(middles**2) / 2) / np.sqrt(2 * np.pi)
    panels["a"].plot(middles, normal, ":", color="#8c8c8c", label="Gaussian")
    panels["a"].set(xlabel=r"$q / \langle q^2 \rangle^{1/2}$", ylabel="f, t = 100", xlim=(-4, 4))
    panels["b"].set(xscale="log", yscale="log", xlabel=TIME, ylabel="T")
    panels["c"].axhline(1, color="#8c8c8c", linestyle=":")
    panels["c"].set(xlabel="waves across the box", ylabel="structure factor of density, end", ylim=(0, 2))
    for key in "abc":
        panels[key].legend(frameon=False, fontsize=7)
        panels[key].set_title(f"({key})", fontsize=9)
    save(figure, "granular_3_6")
    last = {name: [mean_of_seeds([late(gas_run, name) for gas_run in found[gas.name]]) for gas in gases.values()]
            for name in ("mean_square_charge", "local_temperature", "charge_kurtosis")}
    structure = [mean_of_seeds([np.mean(late(gas_run, "density_structure")) for gas_run in found[gas.name]])
                 for gas in gases.values()]

    def row(words, name, published):
        same = not any(differ(one, other) for one in last[name] for other in last[name])
        return claim(f"z = 0, 2, 8: {words}, t > 135", "G 3.6-3.8", published, all_in_words(last[name]),
                     "agrees within the intervals" if same else "differs")

    save_claims("granular_3_6", [
        row("<q^2>", "mean_square_charge", "the same"), row("T", "local_temperature", "the same, steady"),
        row("kurtosis of charges", "charge_kurtosis", "the same shape"),
        claim("structure factor of density, six shells of waves, t > 135", "G 3.6-3.8", "homogeneous (1)",
              all_in_words(structure), "agrees" if not any(differ(one, (1, 0.2)) for one in structure) else "differs")])


if __name__ == "__main__":
    main()
