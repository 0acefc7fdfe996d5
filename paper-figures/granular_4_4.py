#!/usr/bin/python3
"""Figure G 4.4: mean magnitude of charge against time, and sizes of clusters of dense cells, charged and neutral."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gases import (COLOURS, GREY, INK, TIME, differ, gas_runs, draw_mean, in_words, number, mean_of_seeds, over_seeds, plain_ticks, parse_arguments,
                   theory)
from growth_report import stored_series

TIMES = (50, 100, 150)
STATED = {50: (-1.62, -2.51), 100: (), 150: (-1.34, -2.45)}  # slopes, charged and neutral


def draw_charge(axes, arguments, early, found):
    draw_mean(axes, found, "mean_charge_magnitude", COLOURS[1], "K = 1", notes=True, first=0.9)
    draw_mean(axes, early, "mean_charge_magnitude", COLOURS[1], None, notes=True)
    table = theory(arguments.program, "haff", "--scene", arguments.folder / "early-1.toml")[0]["course"]
    charge = np.sqrt(2 * table["square_charge_lasting"] / np.pi)  # for Gaussian charges
    axes.plot(table["time"], charge, "--", color=GREY, label="theory, Gaussian charges")
    axes.set(xscale="log", yscale="log", xlabel=TIME, ylabel=r"mean $|q|$ ($q_0$)", xlim=(0.1, 200))
    axes.set_title("(a)", fontsize=9)
    axes.legend(frameon=False, fontsize=7)
    return charge[-1]


def numbers_by_size(found, time):
    """Returns means over seeds of N_s in logarithmic bins: (sizes, numbers per unit of size)."""
    rows = [gas_run.at("density_cluster_number", time) for gas_run in found]
    width = max(map(len, rows))
    number = np.mean([np.nan_to_num(np.pad(row, (0, width - len(row)))) for row in rows], axis=0)
    edges = np.unique(np.round(1.5 ** np.arange(0, 25)))
    sizes, counts = [], []
    for low, high in zip(edges, edges[1:]):
        inside = number[int(low) : int(min(high, width))]
        if inside.sum() > 0:
            sizes.append(np.sqrt(low * (high - 1)))
            counts.append(inside.sum() / (high - low))
    return np.array(sizes), np.array(counts)


def exponents(found, time):
    return mean_of_seeds([gas_run.at("density_cluster_exponent", time) for gas_run in found])


def main():
    arguments = parse_arguments(__doc__)
    charged, neutral, one, early = (gas_scenes.exchanging(arguments.full, 5), gas_scenes.neutral(arguments.full),
                                    gas_scenes.exchanging(arguments.full, 1), gas_scenes.early(arguments.full))
    found = gas_runs(arguments, charged, neutral, one, early)
    figure, grid = plt.subplots(2, 2, figsize=(8.5, 6.6), layout="constrained")
    expected = draw_charge(grid[0, 0], arguments, found["early"], found[one.name])
    for axes, letter, time in zip(grid.flat[1:], "bcd", TIMES):
        for gas, colour, words in ((charged, COLOURS[0], "K = 5"), (neutral, INK, "neutral")):
            sizes, counts = numbers_by_size(found[gas.name], time)
            tau = exponents(found[gas.name], time)
            known = in_words(tau).replace("one run", "of one seed alone")
            label = f"{words}: $\\tau$ = {known}" if np.isfinite(tau[0]) else f"{words}: too few for an exponent"
            axes.plot(sizes, counts, "o-", color=colour, markersize=3, linewidth=0.8, label=label)
        for slope, style, gas in zip(STATED[time], ("--", ":"), ("charged", "neutral")):
            axes.plot([1, 8], [150, 150 * 8**slope], style, color=GREY, linewidth=0.8, label=f"G, {gas}: {slope}")
        axes.set(xscale="log", yscale="log", xlabel="cells $s$", ylabel="$N_s$", xlim=(0.9, 70), ylim=(1e-2, 300))
        axes.set_title(f"({letter}) t = {time}", fontsize=9)
        axes.legend(frameon=False, fontsize=7)
    plain_ticks(*grid.flat)
    save(figure, "granular_4_4")
    time, middle, half = over_seeds(found["early"], "mean_charge_magnitude", notes=True)
    claims = [claim("K = 1: mean |q| at t = 10, over early charging's", "G 4.4 a", "follows the ansatz early, then below",
                    in_words((middle[-1] / expected, half[-1] / expected)),
                    "above" if differ((middle[-1], half[-1]), (expected, 0)) and middle[-1] > expected else "agrees",
                    "the ansatz adds magnitudes and fits its factor; random signs add variances, and from T = 10 three "
                    "grains meet often, each touch of which counts".replace("|", ""))]
    for words, point, source in (("charged", "5e-4", (-1.62, -1.34)), ("neutral", "neutral", (-2.51, -2.45))):
        times, tau, widths = stored_series(point, "density_cluster_exponent")
        ours = [number((-tau[times == t][0], widths[times == t][0])) for t in (100, 150)]
        claims.append(claim(f"{words}, 50016 grains: -tau at t = 100, 150 by maximum likelihood", "G 4.4",
                            f"{source[0]} -> {source[1]} (t = 50 -> 150)", "; ".join(in_words(one) for one in ours),
                            "falls as said, other values" if abs(ours[1][0]) < abs(ours[0][0]) and differ(*ours) else "differs",
                            "lines through logarithmic bins weigh the few large clusters as much as the many small ones"))
    save_claims("granular_4_4", claims)


if __name__ == "__main__":
    main()
