#!/usr/bin/python3
"""Figure G 4.8: charge against speed of grains at three times, and the mean square charge by speed."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gas_pictures import Grains
from gases import COLOURS, gas_runs, in_words, mean, parse_arguments

TIMES = (20, 100, 200)
FAST = 2.0


def main():
    arguments = parse_arguments(__doc__)
    gas = gas_scenes.exchanging(arguments.full, 5)
    found = gas_runs(arguments, gas)[gas.name]
    figure, axes = plt.subplots(1, 4, figsize=(12, 3.2), layout="constrained")
    bins = 0.1 + 0.2 * np.arange(20)
    for panel, time, colour in zip(axes, TIMES, COLOURS):
        grains = Grains(found[0].result, gas.warm, time)
        speed = np.linalg.norm(grains.velocity - grains.velocity.mean(axis=0), axis=1)
        panel.plot(speed / np.sqrt((speed**2).mean()), grains.charge / np.sqrt((grains.charge**2).mean()), ".", color=colour,
                   markersize=2, alpha=0.5, markeredgewidth=0)
        panel.axvspan(FAST, 5, color="#8c8c8c", alpha=0.12, linewidth=0)
        panel.set(xlim=(0, 5), ylim=(-5, 5), xlabel=r"$v / \langle v^2 \rangle^{1/2}$")
        panel.set_title(f"({'abc'[TIMES.index(time)]}) t = {time}", fontsize=9)
        middle, half = mean([gas_run.at("charge_by_speed", time) for gas_run in found])
        known = half < 0.6  # omits bins with few grains
        axes[3].errorbar(bins[known], middle[known], yerr=half[known], color=colour, marker="o", markersize=2.5,
                         linewidth=0.8, label=f"t = {time}")
    axes[0].set_ylabel(r"$q / \langle q^2 \rangle^{1/2}$")
    axes[3].axhline(1, color="#8c8c8c", linestyle=":", linewidth=1)
    axes[3].set(xlim=(0, 4), ylim=(0, 2.5), xlabel=r"$v / \langle v^2 \rangle^{1/2}$")
    axes[3].set_ylabel(r"$\langle q^2 | v\rangle / \langle q^2 \rangle$")
    axes[3].set_title("(d)", fontsize=9)
    axes[3].legend(frameon=False, fontsize=7)
    save(figure, "granular_4_8")
    fast = [mean(np.array([[np.nanmean(gas_run.at("charge_by_speed", time)[bins > FAST])] for gas_run in found])) for time in TIMES]
    link = [mean(np.array([[gas_run.at("charge_speed_correlation", time)] for gas_run in found])) for time in TIMES]
    words = [", ".join(in_words((float(m[0]), float(h[0]))) for m, h in pairs) for pairs in (fast, link)]
    save_claims("granular_4_8", [
        claim("K = 5: <q^2> of grains faster than 2 rms over the mean, t = 20, 100, 200", "G 4.8", "nearly neutral",
              words[0], "agrees" if fast[-1][0][0] < 0.3 else "fast grains have less, but not none"
              if fast[-1][0][0] < 0.9 else "differs"),
        claim("correlation of q^2 and v^2 at the same times", "G 4.8", "negative", words[1],
              "agrees" if link[-1][0][0] < 0 else "differs")])


if __name__ == "__main__":
    main()
