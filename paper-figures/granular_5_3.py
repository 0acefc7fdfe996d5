#!/usr/bin/python3
"""Figure G 5.3: temperature, charge, density and Bjerrum number of clusters against time, by filling and by K."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gases import COLOURS, GREY, INK, TIME, all_in_words, differ, gas_runs, draw_mean, in_words, mean_of_seeds, plain_ticks, parse_arguments

PANELS = (("bound_cluster_local_temperature", "T of clusters"), ("bound_cluster_square_charge", r"$\langle q^2\rangle$ of clusters"),
          ("clusters", "clusters in contact a grain"), ("bound_bjerrum", "B"))


def plateau(found, name="bound_bjerrum"):
    """Returns the largest value after t = 20, mean over seeds with its half width."""
    return mean_of_seeds([np.nanmax(gas_run.frames[name][gas_run.frames["time"] > 20]) for gas_run in found])


def time_of_charge_maximum(found):
    return mean_of_seeds([gas_run.frames["time"][np.nanargmax(gas_run.frames["bound_cluster_square_charge"])] for gas_run in found])


def main():
    arguments = parse_arguments(__doc__)
    fillings = {filling: gas_scenes.fractal(arguments.full, filling) for filling in gas_scenes.FILLINGS}
    strengths = {0.4: gas_scenes.fractal(arguments.full, strength=0.4), 5: gas_scenes.fractal(arguments.full, strength=5)}
    found = gas_runs(arguments, *fillings.values(), *strengths.values())
    figure, grid = plt.subplots(2, 2, figsize=(9, 6.6), layout="constrained")
    for axes, letter, (name, label) in zip(grid.flat, "abcd", PANELS):
        for (filling, gas), colour in zip(fillings.items(), (COLOURS[0], COLOURS[1], INK, COLOURS[3])):
            factor = 1 / gas.count if name == "clusters" else 1
            draw_mean(axes, found[gas.name], name, colour, rf"$\phi$ = {filling:g}, K = 1", factor=factor, first=5)
        for (strength, gas), style in zip(strengths.items(), ("--", ":")):
            draw_mean(axes, found[gas.name], name, COLOURS[2], rf"$\phi$ = 0.076, K = {strength:g}",
                      factor=1 / gas.count if name == "clusters" else 1, first=5, style=style)
        axes.set(xscale="log", yscale="log", xlabel=TIME, ylabel=label)
        axes.set_title(f"({letter})", fontsize=9)
    grid[1, 1].axhline(1, color=GREY, linewidth=0.8)
    grid[1, 1].text(11, 1.12, "G: B does not pass 1", fontsize=7, color=GREY)
    grid[0, 0].legend(frameon=False, fontsize=7)
    plain_ticks(*grid.flat)
    save(figure, "granular_5_3")
    all_gases = [*fillings.values(), *strengths.values()]
    bjerrum = {gas.name: plateau(found[gas.name]) for gas in all_gases}
    middle = fillings[0.076]
    at = [mean_of_seeds([gas_run.at("clusters", t) / middle.count for gas_run in found[middle.name]]) for t in (0, 30, 300)]
    onsets = [time_of_charge_maximum(found[gas.name]) for gas in (strengths[0.4], middle, strengths[5])]
    save_claims("granular_5_3", [
        claim("largest B, phi = .013, .03, .076, .137; K = .4, 5", "G 5.11", "below 1 and near it",
              ", ".join(in_words(bjerrum[gas.name]) for gas in all_gases),
              "passes 1, by less than a factor of two" if any(b - half > 1 for b, half in bjerrum.values())
              and all(b < 2 or half > 1 for b, half in bjerrum.values()) else
              "differs" if any(b - half > 1 for b, half in bjerrum.values()) else "agrees",
              "the bound belongs to the printed functions: corrected rates are smooth for any B"),
        claim("<q^2> of clusters is largest at t (K = .4, 1, 5)", "G 5.3 b", "near 1e2", all_in_words(onsets),
              "earlier" if all(sum(onset) < 100 for onset in onsets) else "agrees", "charge is made in the first three units and then only merged away; halved at .27 / sqrt(K Q^2)"),
        claim("clusters in contact a grain at t = 0, 30, 300", "G 5.3 c", "falls, rises, falls by fragmentation",
              all_in_words(at), "agrees, for another reason" if at[1][0] > at[0][0] and at[2][0] < at[1][0]
              and differ(at[0], at[1]) and differ(at[1], at[2]) else "differs",
              "at T = 10 grains touch in flight; they part as collisions become rarer; nothing breaks")])


if __name__ == "__main__":
    main()
