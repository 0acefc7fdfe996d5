#!/usr/bin/python3
"""Figure G 5.1: clusters of ten grains and more at t = 19, 59, 99."""

import matplotlib.pyplot as plt

import gas_scenes
from figures import claim, save, save_claims
from gas_pictures import Grains, draw
from gases import courses, requested

TIMES = (19, 59, 99)


def main():
    asked = requested(__doc__)
    gases = [gas_scenes.fractal(asked.full), gas_scenes.exchanging(asked.full, 5)]
    found = courses(asked, *gases)
    figure, grid = plt.subplots(2, 3, figsize=(9.5, 6.6), layout="constrained")
    inside = {}
    for row, gas, words in zip(grid, gases, (r"$KQ^2$ = 2e-5", r"$KQ^2$ = 1e-4")):
        for axes, time in zip(row, TIMES):
            grains = Grains(found[gas.name][0].result, gas.warm, time)
            count = int(grains.in_clusters_of(10).sum())
            inside.setdefault(gas.name, []).append(count / gas.count)
            draw(axes, grains, 10, f"{words}, t = {grains.time:.0f}: {count} of {gas.count} in clusters")
    save(figure, "granular_5_1")
    weak, strong = (", ".join(f"{share:.1%}" for share in inside[gas.name]) for gas in gases)
    save_claims("granular_5_1", [
        claim("grains in clusters of 10 and more, t = 19, 59, 99", "G 5.1", "clusters of ten at 19 (shown)",
              f"K Q^2 = 1e-4: {strong}; 2e-5: {weak}", "agrees for 1e-4" if inside[gases[1].name][0] > 0 else "differs",
              "K Q^2 decides; with Q = 1e-4 and one transfer a collision (K Q^2 = 1e-8) nothing clusters before t = 1000")])


if __name__ == "__main__":
    main()
