#!/usr/bin/python3
"""Figure G 4.7: distribution of speeds, neutral and charged, at several times, and Maxwell's."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gases import COLOURS, GREY, gas_runs, in_words, mean, parse_arguments

TIMES = (20, 50, 100, 200)
FAST = 2.5  # rms speeds, beyond which tails are compared


def maxwell(x):
    return np.sqrt(54 / np.pi) * x**2 * np.exp(-1.5 * x**2)


def beyond(found, time):
    """Returns the fraction of grains faster than FAST over Maxwell's, mean over seeds with its half width."""
    x = np.linspace(0, 5, 5001)
    expected = np.trapezoid(maxwell(x[x >= FAST]), x[x >= FAST]) if hasattr(np, "trapezoid") else np.trapz(maxwell(x[x >= FAST]), x[x >= FAST])
    shares = [gas_run.at("speed_density", time)[25:].sum() * 0.1 / expected for gas_run in found]
    middle, half = mean(np.array(shares)[:, None])
    return float(middle[0]), float(half[0])


def main():
    arguments = parse_arguments(__doc__)
    neutral, charged = gas_scenes.neutral(arguments.full), gas_scenes.exchanging(arguments.full, 5)
    found = gas_runs(arguments, neutral, charged)
    figure, axes = plt.subplots(1, 2, figsize=(9.5, 4), layout="constrained", sharey=True)
    bins = 0.05 + 0.1 * np.arange(50)
    for panel, gas, words in ((axes[0], neutral, "(a) neutral"), (axes[1], charged, "(b) K = 5")):
        inset = panel.inset_axes([0.58, 0.58, 0.4, 0.4])
        for time, colour in zip(TIMES, COLOURS):
            density = np.mean([gas_run.at("speed_density", time) for gas_run in found[gas.name]], axis=0)
            panel.plot(bins, np.where(density > 0, density, np.nan), "o-", color=colour, markersize=2, linewidth=0.7,
                       label=f"t = {time}")
            inset.plot(bins, density, color=colour, linewidth=0.8)
        panel.plot(bins, maxwell(bins), ":", color=GREY, label="Maxwell")
        inset.plot(bins, maxwell(bins), ":", color=GREY)
        inset.set(xlim=(0, 2.5))
        inset.tick_params(labelsize=6)
        panel.set(yscale="log", ylim=(1e-4, 2.5), xlim=(0, 5), xlabel=r"$v / \langle v^2 \rangle^{1/2}$")
        panel.set_title(words, fontsize=9)
        panel.legend(frameon=False, fontsize=7, loc="lower left")
    axes[0].set_ylabel("f")
    save(figure, "granular_4_7")
    tails = {gas.name: [beyond(found[gas.name], time) for time in (50, 200)] for gas in (neutral, charged)}
    moments = {gas.name: mean(np.array([[gas_run.at("sonine", t) for t in (20, 200)] for gas_run in found[gas.name]]))
               for gas in (neutral, charged)}
    words = {name: ", ".join(in_words(pair) for pair in zip(*pairs)) for name, pairs in moments.items()}
    save_claims("granular_4_7", [
        claim("neutral: a_2 at t = 20, 200", "G 4.7 a", "relaxes to Maxwell", words[neutral.name],
              "agrees" if abs(moments[neutral.name][0][1]) < 0.1 else "differs",
              "with the flow in the speeds; the larger the box, the more of it"),
        claim("K = 5: a_2 at t = 20, 200", "G 4.7 b", "does not relax", words[charged.name],
              "agrees" if moments[charged.name][0][1] > 0.1 else "differs"),
        claim(f"K = 5: grains faster than {FAST} rms over Maxwell's, t = 50, 200", "G 4.7 b", "fat tail",
              ", ".join(in_words(tail) for tail in tails[charged.name])
              + "; neutral " + ", ".join(in_words(tail) for tail in tails[neutral.name]),
              "agrees" if tails[charged.name][1][0] > 2 else "differs")])


if __name__ == "__main__":
    main()
