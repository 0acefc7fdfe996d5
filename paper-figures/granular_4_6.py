#!/usr/bin/python3
"""Figure G 4.6: growth compared with Smoluchowski's equation for the source's kernels; mean square displacement."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gases import COLOURS, INK, TIME, differ, gas_runs, draw_band, draw_mean, in_words, mean_of_seeds, parse_arguments, theory
from growth_report import stored_series, stored_exponents


def scaled(theory_time, theory_size, time, size):
    """Returns the theory's times multiplied so that it reaches the run's last size at the same time."""
    inside = size[-1] < np.nanmax(theory_size)
    factor = np.interp(size[-1], theory_size[np.isfinite(theory_size)], theory_time[np.isfinite(theory_size)]) / time[-1]
    return theory_time / factor if inside else theory_time


def main():
    arguments = parse_arguments(__doc__)
    neutral, charged = gas_scenes.neutral(arguments.full), gas_scenes.exchanging(arguments.full, 5)
    found = gas_runs(arguments, neutral, charged)
    tables, numbers = theory(arguments.program, "smoluchowski")
    growth = tables["growth"]
    figure, axes = plt.subplots(1, 2, figsize=(9.5, 4), layout="constrained")
    for point, quantity, theirs, colour, words in (("neutral", "density_cluster_size", "size_neutral", INK, "neutral, S of cells"),
                                                   ("5e-4", "mean_bound_aggregate", "size_charged", COLOURS[0],
                                                    "charged, bound aggregates")):
        time, size, half = stored_series(point, quantity)
        axes[0].plot(time, size, color=colour, linewidth=1.2, label=words)
        draw_band(axes[0], time, size, half, colour)
        axes[0].plot(scaled(growth["time"], growth[theirs], time, size), growth[theirs], "--", color=colour, linewidth=1,
                     label=rf"theory, $\beta$ = {2 if point == 'neutral' else 3}, time scaled")
    axes[0].set(xscale="log", yscale="log", xlabel=TIME, ylabel="size", xlim=(8, 500), ylim=(1, 1000))
    axes[0].set_title("(a) 50016 grains, twenty seeds", fontsize=9)
    axes[1].set_title("(b)", fontsize=9)
    for gas, colour, words in ((neutral, INK, "neutral"), (charged, COLOURS[0], "K = 5")):
        draw_mean(axes[1], found[gas.name], "mean_square_displacement", colour, words, first=9)
    axes[1].set(xscale="log", yscale="log", xlabel=TIME, ylabel="mean square displacement ($d_0^2$)")
    for panel in axes:
        panel.legend(frameon=False, fontsize=7, loc="upper left")
    save(figure, "granular_4_6")
    fitted = [numbers[f"fitted_exponent_{kind}"][0] for kind in ("neutral", "charged")]
    # From t = 10 on, which excludes the warm-up and the initial fast evolution.
    last = {gas.name: mean_of_seeds([gas_run.frames["mean_square_displacement"][-1] - gas_run.at("mean_square_displacement", 10)
                                for gas_run in found[gas.name]]) for gas in (neutral, charged)}
    ratio = last[charged.name][0] / last[neutral.name][0]
    steep = stored_exponents()["neutral", "density_cluster_size", 200, 400][:2]
    save_claims("granular_4_6", [
        claim("z of Smoluchowski's equation, beta = 2, 3", "G 4.19", "6/5, 3/2 (numerically 1.19, 1.49)",
              ", ".join(f"{value:.4f}" for value in fitted),
              "agrees within 1 %" if abs(fitted[0] / 1.2 - 1) < 0.01 and abs(fitted[1] / 1.5 - 1) < 0.01 else "differs",
              "in the limit; 4.17 and 4.18 print N^(1/6) for N^(2/3)"),
        claim("displacement from t = 10 on, charged over neutral", "G 4.6", "smaller", f"{ratio:.2f}",
              "undecided" if not differ(*last.values()) else "agrees" if ratio < 1 else "differs", f"{in_words(last[charged.name])} and {in_words(last[neutral.name])}"),
        claim("does the kernel of flight describe the gas", "G 4.6", "yes: slopes agree",
              f"S of cells of the neutral gas rises with {in_words(steep)} where theory has 1.2",
              "differs" if differ(steep, (1.2, 0)) else "agrees",
              "theory is of aggregates in flight; the neutral gas has none, its dense regions are flow")])


if __name__ == "__main__":
    main()
