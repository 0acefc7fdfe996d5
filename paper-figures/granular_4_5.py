#!/usr/bin/python3
"""Figure G 4.5: growth of clusters of dense cells and of aggregates, and its local exponent.

Shown by K Q^2 for neutral and charged gases, at the source's size with twenty seeds (growth_study.py) and for the runs
of this set."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gases import COLOURS, GREY, INK, TIME, all_in_words, differ, gas_runs, draw_band, draw_mean, guide, number, parse_arguments
from growth_report import condition_exponents, stored_series, stored_exponents

POINTS = {"neutral": (INK, "neutral"), "2e-5": (COLOURS[1], r"$KQ^2$ = 2e-5"), "5e-4": (COLOURS[3], r"$KQ^2$ = 5e-4")}


def draw_stored(axes, quantity):
    for point, (colour, words) in POINTS.items():
        if quantity == "mean_bound_aggregate" and point == "neutral":
            continue
        time, middle, half = stored_series(point, quantity)
        axes.plot(time, middle, color=colour, linewidth=1.2, label=words)
        draw_band(axes, time, middle, half, colour)


def draw_slopes(axes, quantity, p=2):
    """Draws local exponents of the means (G 4.11)."""
    for point, (colour, words) in POINTS.items():
        if quantity == "mean_bound_aggregate" and point == "neutral":
            continue
        time, middle, _ = stored_series(point, quantity)
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
    axes.set(xscale="log", yscale="log", xlabel=TIME, ylabel="$S$ (cells)", ylim=(0.7, 150))
    axes.set_title(f"(e) this set, {len(found['neutral'])} seeds", fontsize=9)
    axes.legend(frameon=False, fontsize=7)


def main():
    arguments = parse_arguments(__doc__)
    found = gas_runs(arguments, gas_scenes.neutral(arguments.full), *(gas_scenes.exchanging(arguments.full, k) for k in gas_scenes.STRENGTHS))
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


def ranged(values):
    """Returns whether exponents of consecutive intervals differ by more than their uncertainties allow."""
    return any(differ(one, other) for one, other in zip(values, values[1:]))


def within(values, least, most):
    return all(least - half <= value <= most + half for value, half in values)


def claims(z):
    """Returns claims on the stored exponents."""
    neutral, strong, weak = ("neutral", "5e-4", "2e-5")
    size, bound, mean_of = "density_cluster_size", "mean_bound_aggregate", "mean_aggregate"
    no_plateau = "the local exponent of (4.8) never rests: it grows from 0 on until a cluster spans the box"
    exponents = {key: value[:2] for key, value in z.items()}
    neutral_windows = [exponents[neutral, size, *window] for window in ((50, 100), (100, 200), (200, 400))]
    weak_windows = [exponents[weak, size, *window] for window in ((50, 100), (100, 150), (150, 290))]
    same_time = [exponents[strong, size, 50, 100], exponents[weak, size, 50, 100]]
    same_stage = [exponents[strong, mean_of, 20, 40], exponents[weak, mean_of, 100, 200]]
    late = [exponents[strong, bound, 50, 100], exponents[strong, bound, 100, 150], exponents[weak, bound, 150, 290]]
    thresholds = [exponents[strong, 2.0, 4, 50, 100], exponents[strong, 2.0, 6, 50, 100]]
    edges = [exponents[key] for key in ((strong, 1.0, 1, 50, 100), (strong, 1.5, 2, 50, 100), (strong, 2.5, 8, 50, 100),
                                 (strong, 3.0, 14, 50, 100), (strong, 3.9, 28, 50, 100))]
    by_condition, names = condition_exponents(), ("N = 4000", "N = 50016", "forces to 1e-2", "forces to 1e-4")
    unmoved = [by_condition[name] for name in ("base", *names)]
    moved = [by_condition[name] for name in ("base", "constant restitution .3", "D = 8", "phi = .137")]
    return [
        claim("neutral: z of S, t = 70 ... 140", "G 4.9", (1.21, 0.04), number(exponents[neutral, size, 70, 140]), note=no_plateau),
        claim("neutral: z of S, t = 50 ... 100, 100 ... 200, 200 ... 400", "G 4.5", "saturates at 1.21",
              all_in_words(neutral_windows), "differs" if ranged(neutral_windows) else "saturates", no_plateau),
        claim("K Q^2 = 5e-4: z of S, t = 50 ... 100", "G 4.10", (1.49, 0.012), number(exponents[strong, size, 50, 100]),
              note=no_plateau),
        claim("K Q^2 = 2e-5: z of S, t = 50 ... 100, 100 ... 150, 150 ... 290", "G 4.5", "saturates at 1.5",
              all_in_words(weak_windows), "differs" if ranged(weak_windows) else "saturates", no_plateau),
        claim("the same for all K: z of S, t = 50 ... 100, K Q^2 = 5e-4 and 2e-5", "G 4.5", "the same",
              all_in_words(same_time), "differs" if differ(*same_time) else "agrees within the intervals",
              "at the same time they are at other stages: t sqrt(K Q^2) counts"),
        claim("the same at the same t sqrt(K Q^2), .45 ... .9: z of the number mean of aggregates", "G 4.5", "the same",
              all_in_words(same_stage), f"{abs(same_stage[0][0] - same_stage[1][0]):.2f} apart"
              if differ(*same_stage) else "agrees within the intervals"),
        claim("charged: z of the number mean of bound aggregates, K Q^2 = 5e-4, t = 50 ... 100 and 100 ... 150; 2e-5, "
              "150 ... 290", "G 4.10", "1.49", all_in_words(late),
              "agrees within .2" if within(late, 1.29, 1.69) else "differs",
              "this mean, not S, nearly has a plateau; in the weaker gas it still rises"),
        claim("threshold: z of S, cells of 2, 4 grains or 6, K Q^2 = 5e-4, t = 50 ... 100", "G, footnote 4.1",
              "does not matter", all_in_words(thresholds),
              "differs" if differ(*thresholds) or ranged(edges) else "agrees within the intervals",
              "and cells of 1 to 4 at a third of the closest packing give " + ", ".join(f"{edge[0]:.1f}" for edge in edges)),
        claim(f"z of the number mean of bound aggregates from 3 to 6, K Q^2 = 1e-4: 16000 grains; {', '.join(names)}", "G 4.5",
              "the same", all_in_words(unmoved),
              "differs" if any(differ(one, unmoved[0]) for one in unmoved) else "agrees within the intervals",
              "thirteen seeds each"),
        claim("the same: restitution of this gas, constant .3, D = 8, filling .137", "G 4.5", "not said", all_in_words(moved),
              "restitution and filling move it" if any(differ(one, moved[0]) for one in moved) else "the same",
              "at one stage, whatever the time; onsets differ by a factor of three")]


if __name__ == "__main__":
    main()
