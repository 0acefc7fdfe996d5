#!/usr/bin/python3
"""Figure G 4.1: cooling of repelling grains, and of neutral and charged viscoelastic grains, with theory."""

import matplotlib.pyplot as plt
import numpy as np

import gas_scenes
from figures import claim, save, save_claims
from gases import COLOURS, GREY, INK, TIME, all_in_words, differ, gas_runs, draw_mean, exponent, number, parse_arguments, rises, theory

LINES = dict(zip(gas_scenes.REPULSIONS, (INK, *COLOURS)))


def draw_repelling(axes, arguments, found, gases):
    for gas, (strength, colour) in zip(gases, LINES.items()):
        draw_mean(axes, found[gas.name], "temperature", colour, f"K = {strength:g}", notes=True)
        scene = arguments.folder / f"{gas.name}-1.toml"
        table = theory(arguments.program, "monopolar" if strength else "haff", "--scene", scene)[0]["course"]
        axes.plot(table["time"], table["temperature"], "--", color=colour, linewidth=0.8)
    axes.set(xscale="log", yscale="log", xlabel=TIME, ylabel="T", xlim=(0.3, 1000), ylim=(1e-4, 15))
    axes.set_title("(a) all repel each other, restitution .9", fontsize=9)
    axes.plot([], [], "--", color=GREY, label="theory, nothing fitted")
    axes.legend(frameon=False, fontsize=7)


def draw_viscoelastic(axes, arguments, found):
    draw_mean(axes, found["neutral"], "local_temperature", INK, "neutral", notes=True, first=0.5)
    for strength, colour in zip(gas_scenes.STRENGTHS, COLOURS):
        draw_mean(axes, found[f"exchange-{strength:g}"], "local_temperature", colour, f"K = {strength:g}", notes=True,
                  first=0.5)
    table = theory(arguments.program, "haff", "--scene", arguments.folder / "neutral-1.toml")[0]["course"]
    axes.plot(table["time"], table["temperature_lasting"], "--", color=GREY, label="theory, neutral")
    level = np.interp(30, table["time"], table["temperature_lasting"])
    axes.plot([30, 200], [level, level * (200 / 30) ** (-5 / 3)], ":", color=INK, label=r"G: $t^{-5/3}$")
    axes.set(xscale="log", yscale="log", xlabel=TIME, ylabel="T relative to the flow", xlim=(0.5, 250))
    axes.set_title("(b) viscoelastic, charges exchanged", fontsize=9)
    axes.legend(frameon=False, fontsize=7)


def main():
    arguments = parse_arguments(__doc__)
    repelling = [gas_scenes.monopolar(arguments.full, strength) for strength in gas_scenes.REPULSIONS]
    found = gas_runs(arguments, *repelling, gas_scenes.neutral(arguments.full),
                    *(gas_scenes.exchanging(arguments.full, strength) for strength in gas_scenes.STRENGTHS))
    figure, axes = plt.subplots(1, 2, figsize=(9.5, 4), layout="constrained")
    draw_repelling(axes[0], arguments, found, repelling)
    draw_viscoelastic(axes[1], arguments, found)
    save(figure, "granular_4_1")
    claims = [claim("K = 0: exponent of T, t = 30 ... 300", "G 4.1 a", -2.0,
                    number(exponent(found["monopolar-0"], "temperature", 30, 300, notes=True)),
                    note="Haff's own between these times is -1.9 and more")]
    late = [exponent(found[gas.name], "temperature", 300, 1000, notes=True) for gas in repelling]
    claims.append(claim("K = 0, .01, .1, 1: exponent of T, t = 300 ... 1000", "G 4.1 a", "slower and earlier for larger K",
                        all_in_words(late), "agrees" if rises(late) else "differs"))
    ours = {name: exponent(found[name], "local_temperature", 20, 150, notes=True)
            for name in ("neutral", *(f"exchange-{strength:g}" for strength in gas_scenes.STRENGTHS))}
    flow = exponent(found["neutral"], "temperature", 20, 150, notes=True)
    table = theory(arguments.program, "haff", "--scene", arguments.folder / "neutral-1.toml")[0]["course"]
    chosen = (table["time"] >= 20) & (table["time"] <= 150)
    expected = np.polyfit(np.log(table["time"][chosen]), np.log(table["temperature_lasting"][chosen]), 1)[0]
    claims.append(claim("neutral: exponent of T, t = 20 ... 150", "G 4.1 b", -5 / 3, number(ours["neutral"]), note=(
        f"-5/3 belongs to restitution -> 1; theory with the true restitution has {expected:.2f}, and T with the flow in it "
        f"{flow[0]:.2f} in this box: flow counted as temperature")))
    claims.append(claim("K = .25, 1, 5: exponent of T, t = 20 ... 150", "G 4.1 b", "as neutral",
                        all_in_words(ours[f"exchange-{s:g}"] for s in gas_scenes.STRENGTHS),
                        "differs" if any(differ(value, ours["neutral"]) for value in ours.values()) else
                        "agrees within the intervals", "the exponents differ by a few times 0.01"))
    save_claims("granular_4_1", claims)


if __name__ == "__main__":
    main()
