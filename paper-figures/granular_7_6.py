#!/usr/bin/python3
"""Figure G 7.6: clusters of three grains and more in a polarized gas that another gas drags."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gas_pictures import Grains, draw
from gases import gas_runs, parse_arguments


def chains(grains, sizes):
    """Returns the fraction of clusters of these sizes without a loop in which grains touch at most two others."""
    numbers, inverse, size = np.unique(grains.cluster, return_inverse=True, return_counts=True)
    degree = np.bincount(grains.contacts.ravel(), minlength=len(grains.cluster))
    pairs = np.bincount(inverse[grains.contacts[:, 0]], minlength=len(numbers))
    most = np.zeros(len(numbers), int)
    np.maximum.at(most, inverse, degree)
    counted = (size >= sizes[0]) & (size <= sizes[1])
    return float(((most <= 2) & (pairs == size - 1))[counted].mean()), int(counted.sum())


def main():
    arguments = parse_arguments(__doc__)
    gas = gas_scenes.polarized(arguments.full, 0.075, gas_scenes.BLOWN)
    found = gas_runs(arguments, gas)[gas.name]
    grains = Grains(found[0].result, gas.warm, gas.until)
    figure, axes = plt.subplots(figsize=(6, 5.6), layout="constrained")
    draw(axes, grains, 3, f"A = .075, S = .05, t = {grains.time:.0f}: clusters of 3 and more coloured")
    save(figure, "granular_7_6")
    share, clusters = chains(grains, (3, 6))
    save_claims("granular_7_6", [
        claim("clusters of 3 to 6 grains that are chains", "G 7.6", "small chains", f"{share:.0%} of {clusters}",
              "agrees" if share > 0.5 else "differs", "the others are branched or closed")])


if __name__ == "__main__":
    main()
