#!/usr/bin/python3
"""Figures G 3.6 to 3.8: grains that exchange charge by a random walk, from three distributions of charge: distributions,
temperature, and where they are at t = 1 and 100."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gas_pictures import Grains, draw
from gases import COLOURS, TIME, courses, draw_mean, in_words, mean, requested

WIDTHS = (0, 2, 8)  # z of G 3.49
BINS = np.linspace(-6, 6, 61)


def main():
    asked = requested(__doc__)
    gases = {z: gas_scenes.walking(asked.full, z) for z in WIDTHS}
    found = courses(asked, *gases.values())
    figure = plt.figure(figsize=(10, 8), layout="constrained")
    panels = figure.subplot_mosaic("ab.\n048\nxyz")
    middles = (BINS[1:] + BINS[:-1]) / 2
    for (z, gas), colour in zip(gases.items(), COLOURS):
        density = np.mean([course.at("charge_density", 100) for course in found[gas.name]], axis=0)
        panels["a"].plot(middles, density, color=colour, linewidth=1, label=f"z = {z}")
        draw_mean(panels["b"], found[gas.name], "local_temperature", colour, f"z = {z}", notes=True, first=0.4)
        for key, time in zip(("048"[WIDTHS.index(z)], "xyz"[WIDTHS.index(z)]), (1, 100)):
            grains = Grains(found[gas.name][0].result, gas.warm, time)
            draw(panels[key], grains, 3, f"z = {z}, t = {grains.time:.0f}; clusters of 3 and more coloured")
    normal = np.exp(-(middles**2) / 2) / np.sqrt(2 * np.pi)
    panels["a"].plot(middles, normal, ":", color="#8c8c8c", label="Gaussian")
    panels["a"].set(xlabel=r"$q / \langle q^2 \rangle^{1/2}$", ylabel="f, t = 100", xlim=(-4, 4))
    panels["b"].set(xscale="log", yscale="log", xlabel=TIME, ylabel="T")
    for key in "ab":
        panels[key].legend(frameon=False, fontsize=7)
    save(figure, "granular_3_6")
    last = {name: {z: mean(np.array([[np.mean(course.frames[name][-3:])] for course in found[gas.name]]))
                   for z, gas in gases.items()} for name in ("mean_square_charge", "local_temperature", "charge_kurtosis")}
    structure = [np.mean([np.mean(course.frames["density_structure"][-1]) for course in found[gas.name]])
                 for gas in gases.values()]
    shown = {name: ", ".join(in_words((float(m[0]), float(h[0]))) for m, h in of.values()) for name, of in last.items()}
    same = {name: max(m[0] for m, _ in of.values()) < 1.3 * min(m[0] for m, _ in of.values()) for name, of in last.items()}
    save_claims("granular_3_6", [
        claim("z = 0, 2, 8: <q^2> at the end", "G 3.6-3.8", "the same", shown["mean_square_charge"],
              "agrees within 30 %" if same["mean_square_charge"] else "differs"),
        claim("z = 0, 2, 8: T at the end", "G 3.6-3.8", "the same, steady", shown["local_temperature"],
              "agrees within 30 %" if same["local_temperature"] else "differs"),
        claim("z = 0, 2, 8: kurtosis of charges at the end", "G 3.6-3.8", "the same shape", shown["charge_kurtosis"],
              "agrees within 30 %" if same["charge_kurtosis"] else "differs"),
        claim("structure factor of the longest waves at the end", "G 3.6-3.8", "homogeneous (1)",
              ", ".join(f"{value:.2f}" for value in structure), "agrees" if max(structure) < 2 else "differs")])


if __name__ == "__main__":
    main()
