#!/usr/bin/python3
"""Figures G 7.1 and 7.5: dipole moment of clusters against their mass, by polarizability, and in a gas that exerts
drag."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gases import COLOURS, GREY, differ, gas_runs, in_words, mean, mean_of_seeds, plain_ticks, parse_arguments


def by_grains(found, name, time):
    """Returns (grains, mean over seeds) of a dipole of clusters against their number of grains."""
    rows = [gas_run.at(name, time) for gas_run in found]
    width = max(map(len, rows))
    with np.errstate(all="ignore"):
        means, _ = mean([np.pad(row, (0, width - len(row)), constant_values=np.nan) for row in rows])
    grains = np.arange(width)
    return grains[np.isfinite(means)], means[np.isfinite(means)]


def largest(found, time):
    return [float(np.max(gas_run.at("largest_cluster", time))) for gas_run in found]


def main():
    arguments = parse_arguments(__doc__)
    gases = {a: gas_scenes.polarized(arguments.full, a) for a in gas_scenes.POLARIZABILITIES[1:]}
    blown = gas_scenes.polarized(arguments.full, 0.075, gas_scenes.BLOWN)
    found = gas_runs(arguments, *gases.values(), blown)
    times = (140, 380, 600) if arguments.full else (140, 200, 300)
    figure, grid = plt.subplots(2, 3, figsize=(10, 6), layout="constrained", sharex=True)
    strongest = gases[0.075]
    for column, time in zip(grid.T, times):
        for (a, gas), colour in zip(gases.items(), COLOURS):
            grains, dipole = by_grains(found[gas.name], "induced_dipole", time)
            column[0].plot(grains, dipole, ".", color=colour, markersize=4, label=f"A = {a:g}: induced")
        grains, dipole = by_grains(found[strongest.name], "charge_dipole", time)
        column[0].plot(grains, dipole, "x", color=GREY, markersize=3, markeredgewidth=0.6, label="A = .075: of the charges")
        for gas, colour, words in ((strongest, COLOURS[1], "S = 0"), (blown, COLOURS[2], "S = .05")):
            grains, dipole = by_grains(found[gas.name], "induced_dipole", time)
            column[1].plot(grains, dipole, ".", color=colour, markersize=4, label=words)
        for axes in column:
            axes.set(xscale="log", yscale="log")
        column[0].set_title(f"G 7.1, t = {time}", fontsize=9)
        column[1].set_title(f"G 7.5, t = {time}", fontsize=9)
        column[1].set_xlabel("grains of a cluster")
    for row in grid:
        row[0].set_ylabel(r"$|\sum\mu|$, mean ($q_0 d_0$)")
        row[0].set_ylim(bottom=0.2 * row[0].get_ylim()[0])  # space for the legend
        row[0].legend(frameon=False, fontsize=6, loc="lower right")
    plain_ticks(*grid.flat)
    save(figure, "granular_7_1")
    def part(members, name, least, most, power=0):
        """Returns for each seed the mean dipole of clusters of least to most grains, over grains^power."""
        dipoles = [gas_run.at(name, times[-1])[least : most + 1] for gas_run in members]
        return np.array([np.nanmean(row / np.arange(least, least + len(row)) ** power) for row in dipoles])

    strong, weak = found[strongest.name], found[gases[0.005].name]
    ratio, a_grain = (mean_of_seeds(part(strong, "induced_dipole", 20, 10**6, power) / part(strong, "induced_dipole", 2, 5, power))
                      for power in (0, 1))
    by_strength = mean_of_seeds(part(strong, "induced_dipole", 2, 4) / part(weak, "induced_dipole", 2, 4).mean())
    last, free = (mean_of_seeds(largest(found[gas.name], times[-1])) for gas in (blown, strongest))
    share = mean_of_seeds([np.sum(gas_run.at("cluster_number", times[-1])[6:]) / np.sum(gas_run.at("cluster_number", times[-1])[2:])
                      for gas_run in found[blown.name]])
    save_claims("granular_7_1", [
        claim("A = .075: net dipole of clusters of 20 and more over those of 2 to 5", "G 7.1", "smaller",
              f"{in_words(ratio)}; a grain {in_words(a_grain)}",
              "agrees" if sum(ratio) < 1 else "a cluster's grows, a grain's falls" if ratio[0] - ratio[1] > 1 > sum(a_grain)
              else "undecided",
              "dipoles of a cluster's grains cancel as random ones do, so that the sum still grows with its root"),
        claim("the same by A: .075 over .005, dimers to tetramers", "G 7.1", "grows with A", in_words(by_strength),
              "agrees" if by_strength[0] - by_strength[1] > 1 else "differs"),
        claim(f"S = .05: largest cluster at t = {times[-1]}", "G 7.5", "5 and less survive (caption: 5 and more)",
              f"{in_words(last)}, {in_words(share)} of the clusters larger than 5; without the gas {in_words(free)}",
              "most are so small" if sum(share) < 0.5 and differ(last, free) else "differs",
              "how small they stay depends on the gas's speed and how long it holds, which the source does not state: "
              "1 v0 and 1 t0 here")])


if __name__ == "__main__":
    main()
