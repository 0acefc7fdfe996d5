#!/usr/bin/python3
"""Figure G 7.4: energy and temperature of a polarized gas, without and with drag by another gas."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gases import COLOURS, GREY, TIME, gas_runs, draw_mean, exponent, in_words, number, mean_of_seeds, parse_arguments


def main():
    arguments = parse_arguments(__doc__)
    alone = gas_scenes.polarized(arguments.full, 0.075)
    blown = gas_scenes.polarized(arguments.full, 0.075, gas_scenes.BLOWN)
    found = gas_runs(arguments, alone, blown)
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained", sharey=True)
    for panel, gas, words in ((axes[0], alone, "(a) S = 0"), (axes[1], blown, "(b) S = .05")):
        draw_mean(panel, found[gas.name], "temperature", COLOURS[0], r"$\langle v^2 \rangle / 3$", notes=True, first=0.9)
        draw_mean(panel, found[gas.name], "local_temperature", COLOURS[2], "T", notes=True, first=0.9)
        panel.set(xscale="log", yscale="log", xlabel=TIME)
        panel.set_title(words, fontsize=9)
    free = gas_scenes.BLOWN**2 * np.tanh(0.05 / 2)
    axes[1].axhline(free, color=GREY, linestyle="--", linewidth=0.8, label=r"free grains: $\sigma^2 \tanh(S \tau_g / 2)$")
    axes[0].set_ylabel("energy a direction")
    axes[1].legend(frameon=False, fontsize=8)
    save(figure, "granular_7_4")
    slopes = [exponent(found[gas.name], "local_temperature", 100, 300, notes=True) for gas in (alone, blown)]
    plateau = mean_of_seeds([np.mean(gas_run.notes["local_temperature"][gas_run.notes["time"] > 100]) / free
                        for gas_run in found[blown.name]])
    save_claims("granular_7_4", [
        claim("S = 0: exponent of T, t = 100 ... 300", "G 7.4 a", "cools", number(slopes[0]),
              "agrees" if sum(slopes[0]) < -1 else "differs"),
        claim("S = .05: exponent of T, t = 100 ... 300", "G 7.4 b", 0.0, number(slopes[1]),
              "agrees" if abs(slopes[1][0]) + slopes[1][1] < 0.1 else "differs"),
        claim("plateau over the temperature of free grains", "G 7.4 b", "not stated", in_words(plateau), "below 1" if sum(plateau) < 1 else "1",
              "collisions take the rest; speed and hold of the gas decide, and the source states neither")])


if __name__ == "__main__":
    main()
