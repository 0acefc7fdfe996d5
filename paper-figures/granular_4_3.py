#!/usr/bin/python3
"""Figure G 4.3: contacts of tagged grains against time, charged and neutral."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gas_pictures import h5py
from gases import COLOURS, INK, TIME, gas_runs, draw_mean, number, mean_of_seeds, parse_arguments

TAGGED = 8


def contacts_of(path, warm):
    """Returns (times, [frames, grains] contacts of each grain)."""
    with h5py.File(path) as file:
        times = file["particles/conductors/position/time"][()] - warm
        grains = len(file["particles/conductors/radius"])
        ends = file["network/contacts_end"][()]
        pairs = file["network/contacts_of_all_frames"][()]
    begins = np.append(0, ends[:-1])
    return times, np.array([np.bincount(pairs[begin:end].ravel(), minlength=grains) for begin, end in zip(begins, ends)])


def main():
    arguments = parse_arguments(__doc__)
    charged, neutral = gas_scenes.exchanging(arguments.full, 5), gas_scenes.neutral(arguments.full)
    found = gas_runs(arguments, charged, neutral)
    figure, axes = plt.subplots(1, 3, figsize=(10.5, 3.4), layout="constrained")
    for panel, gas, words in ((axes[0], charged, "K = 5"), (axes[1], neutral, "neutral")):
        times, number_of = contacts_of(found[gas.name][0].result, gas.warm)
        for k in range(TAGGED):
            panel.step(times, number_of[:, k] + 0.06 * k, where="mid", linewidth=0.9)
        panel.set(xlabel=TIME, ylabel="contacts of a grain", ylim=(-0.3, 8.5), xlim=(0, times[-1]))
        panel.set_title(f"({'a' if gas is charged else 'b'}) {words}: {TAGGED} tagged grains", fontsize=9)
    for gas, colour, words in ((charged, COLOURS[0], "K = 5"), (neutral, INK, "neutral")):
        draw_mean(axes[2], found[gas.name], "contact_persistence", colour, words)
    axes[2].set(xlabel=TIME, ylabel="part of contacts left after 10 $t_0$", ylim=(0, 1), xlim=(0, None))
    axes[2].set_title("(c)", fontsize=9)
    axes[2].legend(frameon=False, fontsize=8)
    save(figure, "granular_4_3")
    ours = {gas.name: mean_of_seeds([gas_run.at("contact_persistence", 150) for gas_run in found[gas.name]])
            for gas in (charged, neutral)}
    times, number_of = contacts_of(found[charged.name][0].result, charged.warm)
    late = number_of[times > 50]
    lost = float((np.diff(late, axis=0) < 0).any(axis=0).mean())
    save_claims("granular_4_3", [
        claim("K = 5: part of the contacts of t = 140 that hold at 150", "G 4.3", "pronounced persistence",
              number(ours[charged.name]), "agrees" if ours[charged.name][0] - ours[charged.name][1] > 0.5 else "differs"),
        claim("the same, neutral", "G 4.3", "none", number(ours[neutral.name]),
              "agrees" if sum(ours[neutral.name]) < 0.1 else "differs"),
        claim("K = 5: grains that lose a contact after t = 50", "G 4.3", "occasional drops", f"{lost:.0%} of all, of one seed",
              "agrees" if 0 < lost else "differs")])


if __name__ == "__main__":
    main()
