#!/usr/bin/python3
"""Figure G 5.7: temperature, charge and number of clusters, with kinetic theory; the Mach number."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gases import COLOURS, INK, TIME, differ, gas_runs, draw_mean, exponent, in_words, over_seeds, parse_arguments, rises, theory
from growth_report import stored_series


def main():
    arguments = parse_arguments(__doc__)
    gas = gas_scenes.fractal(arguments.full)
    found = gas_runs(arguments, gas)[gas.name]
    table = theory(arguments.program, "kinetic", "--scene", arguments.folder / f"{gas.name}-1.toml")[0]["course"]
    figure, axes = plt.subplots(1, 3, figsize=(11.5, 3.8), layout="constrained")
    density = 6 / np.pi * gas.filled  # number density of grains
    panels = (("bound_cluster_local_temperature", "temperature", 1, "T of clusters"),
              ("bound_cluster_square_charge", "square_charge", 1, r"$\langle q^2 \rangle$ of clusters"),
              ("bound_clusters", "density", density / gas.count, "clusters a volume ($1/d_0^3$)"))
    for panel, letter, (measured, expected, factor, label) in zip(axes, "abc", panels):
        draw_mean(panel, found, measured, COLOURS[0], "bound clusters", factor=factor, first=5)
        panel.plot(table["time"], table[expected], color=INK, linewidth=1, label="theory, merging")
        panel.plot(table["time"], table[expected + "_bouncing"], "--", color=INK, linewidth=1, label="theory, no merging")
        panel.set(xscale="log", yscale="log", xlabel=TIME, ylabel=label, xlim=(1, 320))
        panel.set_title(f"({letter})", fontsize=9)
    inset = axes[2].inset_axes([0.2, 0.14, 0.42, 0.42])
    for name, style, words in (("mach_number", "--", "Mach"), ("mach_number_of_flow", "-", "noise off")):
        draw_mean(inset, found, name, COLOURS[2], words, first=5)
        inset.lines[-1].set_linestyle(style)
    inset.set(xscale="log", yscale="log")
    axes[2].yaxis.set_minor_formatter(plt.NullFormatter())
    inset.tick_params(labelsize=6)
    inset.legend(frameon=False, fontsize=6)
    axes[0].legend(frameon=False, fontsize=7)
    save(figure, "granular_5_7")
    ratios, off = [], []
    for measured, expected, factor, _ in panels:
        time, middle, half = over_seeds(found, measured)
        n = int(np.abs(time - 100).argmin())
        there = np.interp(100, table["time"], table[expected])
        ratios.append(in_words((float(factor * middle[n] / there), float(factor * half[n] / there))))
        off.append(max(factor * middle[n] / there, there / factor / middle[n]))
    slopes = [exponent(found, "mach_number_of_flow", *window) for window in ((20, 100), (100, 300))]
    full_time, full, _ = stored_series("2e-5", "mach_number_of_flow")
    full_slopes = [np.polyfit(np.log(full_time[chosen]), np.log(full[chosen]), 1)[0]
                   for chosen in ((full_time >= 20) & (full_time <= 100), (full_time >= 100) & (full_time <= 300))]
    save_claims("granular_5_7", [
        claim("T, <q^2>, number of clusters at t = 100 over theory with merging", "G 5.7", "closely predicted",
              ", ".join(ratios), f"within a factor of {max(off):.1f}, nothing fitted",
              "sizes differ, correlated velocities, more charge made at T = 10"),
        claim("exponent of the Mach number, t = 20 ... 100 and 100 ... 300", "G 5.7 c", "faster from t = 1e2 on",
              f"{in_words(slopes[0])}, {in_words(slopes[1])}; 50016 grains {full_slopes[0]:.2f}, {full_slopes[1]:.2f}",
              "agrees" if rises(slopes) and full_slopes[1] > full_slopes[0] else "undecided" if not differ(*slopes) else "differs",
              "without the Mach number that temperature alone gives a cell; with it the raw number has a floor that hides the early rise")])


if __name__ == "__main__":
    main()
