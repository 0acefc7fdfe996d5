#!/usr/bin/python3
"""Figure G 5.1: clusters of ten grains and more at t = 20, 60, 100 (there 19, 59, 99)."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gas_pictures import Grains, draw
from gases import all_in_words, gas_runs, mean_of_seeds, parse_arguments

TIMES = (20, 60, 100)


def share_in_clusters(gas_run, time, grains):
    number = np.nan_to_num(gas_run.at("cluster_number", time))  # number of clusters by number of grains
    return float((number[10:] * np.arange(10, len(number))).sum() / grains)


def main():
    arguments = parse_arguments(__doc__)
    gases = [gas_scenes.fractal(arguments.full), gas_scenes.exchanging(arguments.full, 5)]
    found = gas_runs(arguments, *gases)
    figure, grid = plt.subplots(2, 3, figsize=(9.5, 6.6), layout="constrained")
    inside = {}
    for row, gas, words in zip(grid, gases, (r"$KQ^2$ = 2e-5", r"$KQ^2$ = 1e-4")):
        for axes, time in zip(row, TIMES):
            grains = Grains(found[gas.name][0].result, gas.warm, time)
            count = int(grains.in_clusters_of(10).sum())
            inside.setdefault(gas.name, []).append(mean_of_seeds([share_in_clusters(gas_run, time, gas.count)
                                                             for gas_run in found[gas.name]]))
            draw(axes, grains, 10, f"{words}, t = {grains.time:.0f}: {count} of {gas.count} in clusters")
    save(figure, "granular_5_1")
    weak, strong = (all_in_words(inside[gas.name]) for gas in gases)
    save_claims("granular_5_1", [
        claim("part of the grains in clusters of 10 and more, t = 20, 60, 100", "G 5.1", "clusters of ten at 19 (shown)",
              f"K Q^2 = 1e-4: {strong}; 2e-5: {weak}", "agrees for 1e-4" if inside[gases[1].name][0][0] > 0 else "differs",
              "K Q^2 decides; with Q = 1e-4 and one transfer a collision (K Q^2 = 1e-8) nothing clusters before t = 1000")])


if __name__ == "__main__":
    main()
