#!/usr/bin/python3
"""Figure G 3.5: energy and temperature of gases with charge exchange, and of a neutral gas.

Grains exchange charge by a random walk or by the area in contact."""

import matplotlib.pyplot as plt

import gas_scenes
from figures import claim, save, save_claims
from gases import COLOURS, GREY, INK, TIME, differ, gas_runs, draw_mean, exponent, number, parse_arguments, theory


def draw(axes, arguments, found, name, words):
    for quantity, label, style in (("temperature", r"$\langle v^2\rangle/3$", COLOURS[0]), ("local_temperature", "T", COLOURS[2])):
        draw_mean(axes, found[name], quantity, style, f"{words}: {label}", notes=True, first=0.9)
    draw_mean(axes, found["neutral"], "local_temperature", INK, "neutral: T", notes=True, first=0.9)
    table = theory(arguments.program, "haff", "--scene", arguments.folder / "neutral-1.toml")[0]["course"]
    axes.plot(table["time"], table["temperature_lasting"], "--", color=GREY, label="theory, neutral")
    axes.set(xscale="log", yscale="log", xlabel=TIME, ylabel="energy a direction", xlim=(0.9, 320), ylim=(5e-4, 10))
    axes.legend(frameon=False, fontsize=7)


def main():
    arguments = parse_arguments(__doc__)
    walk, area = gas_scenes.walking(arguments.full, 0), gas_scenes.by_area(arguments.full)
    found = gas_runs(arguments, walk, area, gas_scenes.neutral(arguments.full))
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
    draw(axes[0], arguments, found, walk.name, "random walk")
    draw(axes[1], arguments, found, area.name, "contact area")
    for panel, letter in zip(axes, "ab"):
        panel.set_title(f"({letter})", fontsize=9)
    save(figure, "granular_3_5")
    slopes = {gas.name: exponent(found[gas.name], "local_temperature", 50, 150, notes=True) for gas in (walk, area)}
    neutral = exponent(found["neutral"], "local_temperature", 50, 150, notes=True)
    early, late = (exponent(found[walk.name], "local_temperature", *window, notes=True) for window in ((10, 40), (80, 150)))
    save_claims("granular_3_5", [
        claim("random walk: exponent of T, t = 80 ... 150", "G 3.5 a", 0.0, number(late),
              "levels off" if differ(late, early) and late[0] + late[1] > -0.2 else "differs",
              f"{early[0]:.2f} at t = 10 ... 40; charges that change in contact work on the grains; strength .3, rate 1, "
              "capacity 1, K = 1 are ours, the source has none"),
        claim("contact area: exponent of T, t = 50 ... 150", "G 3.5 b", number(neutral), number(slopes[area.name]),
              note="published: neutral, from the same set")])


if __name__ == "__main__":
    main()
