#!/usr/bin/python3
"""Figure G 4.2: clusters of ten grains and more (coloured), neutral and charged, at several times."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gas_pictures import Grains, draw
from gases import gas_runs, in_words, mean_of_seeds, parse_arguments, rises

TIMES = (50, 100, 150)
LEAST = 10


def first_time(found, least=20):
    """Returns the time when the largest cluster has `least` grains, at a resolution of ten: mean over seeds with its
    half width."""
    times = []
    for gas_run in found:
        large = np.flatnonzero(gas_run.frames["largest_cluster"] >= least)
        large = large[gas_run.frames["time"][large] > 20] if len(large) else large
        times.append(gas_run.frames["time"][large[0]] if len(large) else np.nan)
    middle, half = mean_of_seeds(times)
    return middle, max(half, 5)  # frames are ten units apart


def main():
    arguments = parse_arguments(__doc__)
    gases = [gas_scenes.neutral(arguments.full)] + [gas_scenes.exchanging(arguments.full, strength) for strength in (0.25, 5)]
    found = gas_runs(arguments, *gases)
    figure, grid = plt.subplots(len(TIMES), len(gases), figsize=(8, 8.2), layout="constrained")
    for column, (gas, words) in zip(grid.T, zip(gases, ("neutral", "K = .25", "K = 5"))):
        for axes, time in zip(column, TIMES):
            grains = Grains(found[gas.name][0].result, gas.warm, time)
            inside = grains.in_clusters_of(LEAST).sum()
            draw(axes, grains, LEAST, f"{words}, t = {time}: {inside} of {gas.count} in clusters")
    save(figure, "granular_4_2")
    onsets = [first_time(found[gas.name]) for gas in gases]
    stuck = mean_of_seeds([gas_run.at("largest_cluster", 150) for gas_run in found["neutral"]])
    save_claims("granular_4_2", [
        claim("a cluster of 20 in contact from t on, neutral, K = .25, 5", "G 4.2", "earlier for larger K",
              ", ".join("never" if np.isnan(onset[0]) else in_words(onset) for onset in onsets),
              "agrees" if np.isnan(onsets[0][0]) and rises([onsets[2], onsets[1]]) else "differs"),
        claim("neutral: clusters stick", "G 4.2", "no: dense and elongated, without contacts",
              f"largest in contact at t = 150: {in_words(stuck)} grains", "agrees" if stuck[0] < LEAST else "differs")])


if __name__ == "__main__":
    main()
