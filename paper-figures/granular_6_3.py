#!/usr/bin/python3
"""Figure G 6.3: R / |eps^2 - 1| against the critical wave number; which mode is excited first."""

import matplotlib.pyplot as plt
import numpy as np

from figures import claim, save, save_claims
from gases import parse_arguments
from modes import modes

COLOURS = {0.9: "#0c7bdc", 0.7: "#1a1a1a", 0.5: "#d55e00"}


def switch(table):
    """Returns R / |eps^2 - 1| from which sound has the larger critical wave number, and both wave numbers there."""
    sound = np.nan_to_num(table["sound"]) > np.nan_to_num(table["heat"])
    first = int(np.argmax(sound))
    return table["charge_by_loss"][first], table["heat"][first - 1], table["sound"][first]


def main():
    arguments = parse_arguments(__doc__)
    figure, axes = plt.subplots(figsize=(5.5, 4.2), layout="constrained")
    rows, abrupt = [], True
    for eps, colour in COLOURS.items():
        table = modes(arguments.program, eps, 0.9)[0]["critical"]
        first = np.nan_to_num(table["sound"]) > np.nan_to_num(table["heat"])
        axes.plot(table["heat"], table["charge_by_loss"], color=colour, linewidth=1, label=rf"$\epsilon$ = {eps:g}")
        axes.plot(table["sound"], table["charge_by_loss"], "--", color=colour, linewidth=1)
        axes.plot(np.where(first, table["sound"], table["heat"]), table["charge_by_loss"], "o", color=colour,
                  markersize=2.5)
        at, heat, sound = switch(table)
        abrupt = abrupt and abs(sound - heat) > 0.1 * heat
        rows.append(f"{at:.1e} (k {heat:.3f} to {sound:.3f})")
    axes.set(xlabel=r"critical wave number $k l_0$ (line heat, dashes sound, dots the first)", yscale="log",
             ylabel=r"$R / |\epsilon^2 - 1|$", xlim=(0, None))
    axes.legend(frameon=False, fontsize=8)
    save(figure, "granular_6_3")
    save_claims("granular_6_3", [
        claim("from heat to sound at R / (1 - eps^2), restitution .9, .7, .5", "G 6.3",
              "heat first, then abruptly sound", "; ".join(rows),
              "agrees, at other values" if abrupt else "differs",
              "the heat mode ends at R of a few times 0.001; the source does not state R")])


if __name__ == "__main__":
    main()
