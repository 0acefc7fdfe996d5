#!/usr/bin/python3
"""Figure G 5.5: mass of clusters against their radius of gyration, and their fractal dimension against time."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gases import COLOURS, GREY, INK, TIME, gas_runs, draw_band, in_words, mean_of_seeds, over_seeds, plain_ticks, parse_arguments, rises
from growth_report import stored_series

TIMES = (100, 200, 300)
WORST = 0.25  # largest standard error of a dimension that is drawn


def draw_known(axes, members, colour, label):
    """Draws a time series of the small set where its scatter over seeds is small."""
    time, middle, half = over_seeds(members, "bound_fractal_dimension")
    known = half < 2 * WORST
    if known.any():
        axes.errorbar(time[known], middle[known], yerr=half[known], color=colour, marker="o", markersize=2, linewidth=0.6,
                      elinewidth=0.5, alpha=0.8, label=label)


def main():
    arguments = parse_arguments(__doc__)
    fillings = {filling: gas_scenes.fractal(arguments.full, filling) for filling in gas_scenes.FILLINGS}
    weak, strong = fillings[0.076], gas_scenes.fractal(arguments.full, strength=5)
    found = gas_runs(arguments, *fillings.values(), strong)
    # too few clusters (about ten) give no reliable dimension
    for gas_run in (gas_run for members in found.values() for gas_run in members):
        dimension, error = (gas_run.frames["bound_fractal_dimension" + name] for name in ("", "_error"))
        dimension[~(error < WORST)] = np.nan
    figure, grid = plt.subplots(2, 2, figsize=(8.5, 6.6), layout="constrained")
    for axes, letter, time in zip(grid.flat, "abc", TIMES):
        mass, radius = (np.concatenate([gas_run.at("bound_shape_" + name, time) for gas_run in found[weak.name]])
                        for name in ("grains", "gyration"))
        there = (mass > 0) & np.isfinite(radius)
        dimension = mean_of_seeds([gas_run.at("bound_fractal_dimension", time) for gas_run in found[weak.name]])
        words = in_words(dimension)
        axes.plot(radius[there], mass[there], ".", color=COLOURS[0], markersize=5, alpha=0.5, markeredgewidth=0)
        ends = np.array([radius[there].min(), radius[there].max()])
        log_m, log_r = np.log(mass[there]), np.log(radius[there])
        line = np.exp(log_m.mean() + dimension[0] * (np.log(ends) - log_r.mean()))
        axes.plot(ends, line, color=INK, linewidth=1, label=f"$D_f$ = {words}")
        axes.set(xscale="log", yscale="log", xlabel="$R_g$ ($d_0$)", ylabel="grains")
        axes.set_title(f"({letter}) K = 1, t = {time}", fontsize=9)
        axes.legend(frameon=False, fontsize=7)
    axes = grid[1, 1]
    for (filling, gas), colour in zip(fillings.items(), COLOURS):
        draw_known(axes, found[gas.name], colour, rf"$\phi$ = {filling:g}, K = 1")
    draw_known(axes, found[strong.name], GREY, r"$\phi$ = 0.076, K = 5")
    for point, style in (("2e-5", "-"), ("5e-4", "--")):
        time, value, half = stored_series(point, "bound_fractal_dimension")
        known = half < WORST
        axes.plot(time[known], value[known], style, color=INK, linewidth=1.2, label=f"$KQ^2$ = {point}, 50016 grains")
        draw_band(axes, time[known], value[known], half[known], INK)
    for value, words in ((1.94, "BCCA"), (2.46, "DLPCA")):
        axes.axhline(value, color=GREY, linestyle="--", linewidth=0.8)
        axes.text(3, value + 0.01, words, fontsize=7, color=GREY)
    axes.set(xlabel=TIME, ylabel="$D_f$", ylim=(1.2, 2.8), xlim=(0, 305))
    axes.set_title("(d)", fontsize=9)
    axes.legend(frameon=False, fontsize=6.5, loc="lower right", ncols=2)
    plain_ticks(*grid.flat[:3])
    save(figure, "granular_5_5")
    ours, stages = [], []
    for point, times in (("2e-5", (100, 200, 300)), ("5e-4", (20, 50, 100, 150))):
        time, value, half = stored_series(point, "bound_fractal_dimension")
        stages.append([(value[time == t][0], half[time == t][0]) for t in times])
        ours.append(f"K Q^2 = {point}: " + ", ".join(in_words((value[time == t][0], half[time == t][0])) for t in times)
                    + f" at t = {', '.join(map(str, times))}")
    save_claims("granular_5_5", [
        claim("D_f of bound clusters, 50016 grains, twenty seeds", "G 5.5", "1.94 to 2.46, rising", "; ".join(ours),
              "agrees" if all(map(rises, stages)) and all(1.94 - half <= d <= 2.46 + half for members in stages for d, half in members)
              else "differs",
              "fitted as log R_g on log m")])


if __name__ == "__main__":
    main()
