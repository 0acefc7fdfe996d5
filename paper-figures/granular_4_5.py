#!/usr/bin/python3
"""Figure G 4.5: growth of clusters of dense cells and of aggregates, and its local exponent; by K Q^2, neutral beside
charged, at the source's size with twenty seeds (growth_study.py) beside the runs of this set."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gases import COLOURS, GREY, INK, TIME, courses, draw_mean, guide, in_words, number, requested
from growth_report import stored_course, stored_exponents

POINTS = {"neutral": (INK, "neutral"), "2e-5": (COLOURS[1], r"$KQ^2$ = 2e-5"), "5e-4": (COLOURS[3], r"$KQ^2$ = 5e-4")}


def draw_stored(axes, quantity):
    for point, (colour, words) in POINTS.items():
        if quantity == "mean_bound_aggregate" and point == "neutral":
            continue
        time, middle, half = stored_course(point, quantity)
        axes.plot(time, middle, color=colour, linewidth=1.2, label=words)
        axes.fill_between(time, np.maximum(middle - half, 0.05 * middle), middle + half, color=colour, alpha=0.2, linewidth=0)


def draw_slopes(axes, quantity, p=2):
    """Local exponents of the means (G 4.11)."""
    for point, (colour, words) in POINTS.items():
        if quantity == "mean_bound_aggregate" and point == "neutral":
            continue
        time, middle, _ = stored_course(point, quantity)
        later = time >= p * time[0]
        before = np.exp(np.interp(np.log(time[later] / p), np.log(time), np.log(middle)))
        axes.plot(1 / time[later], np.log(middle[later] / before) / np.log(p), color=colour, linewidth=1.2, label=words)
    for z, words in ((1.21, "G: 1.21"), (1.49, "G: 1.49")):
        axes.axhline(z, color=GREY, linestyle=":" if z < 1.3 else "--", linewidth=1, label=words)
    axes.set(xlabel="$1 / t$ ($1/t_0$)", xlim=(0, 0.03), ylim=(-0.2, 6 if quantity == "density_cluster_size" else 2.2))


def draw_small(axes, found):
    for strength, colour in zip(gas_scenes.STRENGTHS, COLOURS):
        draw_mean(axes, found[f"exchange-{strength:g}"], "density_cluster_size", colour, f"K = {strength:g}", first=15)
    draw_mean(axes, found["neutral"], "density_cluster_size", INK, "neutral", first=15)
    guide(axes, 40, 180, 1.5, 1.49, r"G: $t^{1.49}$", linestyle="--")
    guide(axes, 40, 180, 1.2, 1.21, r"G: $t^{1.21}$")
    axes.set(xscale="log", yscale="log", xlabel=TIME, ylabel="$S$ (cells)")
    axes.set_title("(e) this set", fontsize=9)
    axes.legend(frameon=False, fontsize=7)


def main():
    asked = requested(__doc__)
    found = courses(asked, gas_scenes.neutral(asked.full), *(gas_scenes.exchanging(asked.full, k) for k in gas_scenes.STRENGTHS))
    figure = plt.figure(figsize=(10.5, 6.4), layout="constrained")
    panels = figure.subplot_mosaic("abe\ncde")
    for above, below, letters, quantity, words in (("a", "c", "ac", "density_cluster_size", "$S$ of dense cells (G 4.8)"),
                                                   ("b", "d", "bd", "mean_bound_aggregate", "number mean of bound aggregates")):
        draw_stored(panels[above], quantity)
        panels[above].set(xscale="log", yscale="log", xlabel=TIME, ylabel=words)
        draw_slopes(panels[below], quantity)
        panels[below].set_ylabel("local exponent")
        panels[above].set_title(f"({letters[0]}) 50016 grains, twenty seeds", fontsize=9)
        panels[below].set_title(f"({letters[1]})", fontsize=9)
    guide(panels["a"], 40, 150, 2, 1.49, r"G: $t^{1.49}$", linestyle="--")
    guide(panels["a"], 60, 150, 1.1, 1.21, r"G: $t^{1.21}$")
    panels["a"].legend(frameon=False, fontsize=7)
    panels["d"].legend(frameon=False, fontsize=7)
    draw_small(panels["e"], found)
    save(figure, "granular_4_5")
    save_claims("granular_4_5", claims(stored_exponents()))


def claims(z):
    """Of the stored exponents."""
    neutral, strong, weak = ("neutral", "5e-4", "2e-5")
    size, bound, mean_of = "density_cluster_size", "mean_bound_aggregate", "mean_aggregate"
    no_plateau = "the local exponent of (4.8) never rests: it grows from 0 on until a cluster spans the box"
    return [
        claim("neutral: z of S, t = 70 ... 140", "G 4.9", (1.21, 0.04), number(z[neutral, size, 70, 140]), note=no_plateau),
        claim("neutral: z of S, t = 50 ... 100, 100 ... 200, 200 ... 400", "G 4.5", "saturates at 1.21",
              ", ".join(in_words(z[neutral, size, *window][:2]) for window in ((50, 100), (100, 200), (200, 400))), "differs",
              no_plateau),
        claim("K Q^2 = 5e-4: z of S, t = 50 ... 100", "G 4.10", (1.49, 0.012), number(z[strong, size, 50, 100]),
              note=no_plateau),
        claim("K Q^2 = 2e-5: z of S, t = 50 ... 100, 100 ... 150, 150 ... 290", "G 4.5", "saturates at 1.5",
              ", ".join(in_words(z[weak, size, *window][:2]) for window in ((50, 100), (100, 150), (150, 290))), "differs",
              no_plateau),
        claim("the same for all K: z of S, t = 50 ... 100, K Q^2 = 5e-4 and 2e-5", "G 4.5", "the same",
              f"{in_words(z[strong, size, 50, 100][:2])}, {in_words(z[weak, size, 50, 100][:2])}", "differs",
              "at the same time they are at other stages: t sqrt(K Q^2) counts"),
        claim("the same at the same t sqrt(K Q^2), .45 ... .9: z of the number mean of aggregates", "G 4.5", "the same",
              f"{in_words(z[strong, mean_of, 20, 40][:2])}, {in_words(z[weak, mean_of, 100, 200][:2])}",
              f"nearly, {abs(z[strong, mean_of, 20, 40][0] - z[weak, mean_of, 100, 200][0]):.2f} apart"),
        claim("charged: z of the number mean of bound aggregates, K Q^2 = 5e-4, t = 50 ... 100 and 100 ... 150; 2e-5, "
              "150 ... 290", "G 4.10", "1.49",
              ", ".join(in_words(z[key][:2]) for key in ((strong, bound, 50, 100), (strong, bound, 100, 150),
                                                         (weak, bound, 150, 290))),
              "near it", "this mean, not S, has what comes near a plateau; in the weaker gas it still rises"),
        claim("threshold: z of S, cells of 2, 4 grains or 6, K Q^2 = 5e-4, t = 50 ... 100", "G, footnote 4.1",
              "does not matter", f"{in_words(z[strong, 2.0, 4, 50, 100][:2])}, {in_words(z[strong, 2.0, 6, 50, 100][:2])}",
              "differs", "and cells of 1 to 4 at a third of the closest packing give "
              + ", ".join(f"{z[key][0]:.1f}" for key in ((strong, 1.0, 1, 50, 100), (strong, 1.5, 2, 50, 100),
                                                         (strong, 2.5, 8, 50, 100), (strong, 3.0, 14, 50, 100),
                                                         (strong, 3.9, 28, 50, 100))))]


if __name__ == "__main__":
    main()
