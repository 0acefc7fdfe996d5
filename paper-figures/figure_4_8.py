#!/usr/bin/python3
"""Figure 4.8: the wire's resistance against the transverse voltage, and the voltage at which it breaks."""

import json

import matplotlib.pyplot as plt
import numpy as np

import wires
from figures import build_folder, claim, run, save, save_claims

PUBLISHED = {"critical": (8.5e3, 0.7e3), "step": 8.7e3, "low": 198e9, "high": 693e9}
BROKEN = 2 * wires.RADIUS  # m: a wire displaced by a diameter and more, and going on


def broken(wire):
    """The wire has given way: it is displaced by more than a diameter and still going."""
    time, middle = wire.time, len(wire.time) // 2
    across = np.abs(wire.across - wire.across[:, ::-1]).max(axis=1) / 2
    quarter = len(time) // 4
    early, late = across[middle + quarter] - across[middle], across[-1] - across[middle + quarter]
    return across[-1] > BROKEN and (late > early or across[-1] > 2 * BROKEN)


def main():
    build = build_folder(__doc__.splitlines()[0])
    theory = json.loads(run(build / "chapter_4"))["wire"]
    runs = wires.wires(build, list(wires.RUNS))
    volts = np.array([wire.volts for wire in runs])
    ohms = np.array([wire.resistance() for wire in runs])
    gone = np.array([broken(wire) for wire in runs])
    for wire, ohm, is_gone in zip(runs, ohms, gone):
        print(f"{wire.volts:7g} V  {1e-9 * ohm:9.3g} GOhm  {'broken' if is_gone else 'whole'}")
    lower, upper = volts[~gone].max(), volts[gone].min()
    critical, half = (lower + upper) / 2, (upper - lower) / 2
    low = np.median(ohms[~gone])
    gentle = next(wire for wire in runs if wire.volts == 2e3)
    along, across = gentle.shape()
    cubic = (along - wires.LENGTH / 2) * (wires.LENGTH - along) * along
    stretching = gentle.volts * theory["largest_shape_coefficient_disks"] / (across @ cubic / (cubic @ cubic))
    figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
    axes.axvspan(*(1e-3 * (PUBLISHED["critical"][0] + s * PUBLISHED["critical"][1]) for s in (-1, 1)),
                 color="tab:blue", alpha=0.2, label=r"experiment, $V_C = 8.5 \pm 0.7$ kV")
    finite = np.isfinite(ohms)
    axes.plot(1e-3 * volts[finite], 1e-9 * ohms[finite], "o", color="tab:red", fillstyle="none",
              label="simulation (2D, castor oil's drag)")
    step = np.array([0, PUBLISHED["step"], PUBLISHED["step"], volts.max()])
    axes.plot(1e-3 * step, 1e-9 * np.array([PUBLISHED["low"]] * 2 + [PUBLISHED["high"]] * 2), color="tab:blue",
              label="the source's step: 198 to 693 G$\\Omega$")
    axes.axvline(1e-3 * critical, color="tab:red", linestyle=":",
                 label=f"simulated wire breaks, {1e-3 * critical:.3g} kV")
    axes.axvline(1e-3 * stretching, color="tab:gray", linestyle="--",
                 label=f"theory of stretching, from B at 2 kV: {1e-3 * stretching:.3g} kV")
    axes.set(yscale="log", xlabel="transverse voltage (kV)", ylabel=r"resistance (G$\Omega$)")
    axes.legend(fontsize=8)
    save(figure, "figure_4_8")
    field = {key: theory[key] * 1e-3 for key in theory if "critical_field" in key}
    save_claims("figure_4_8", [
        claim("critical transverse voltage (kV)", "D 4.3.3, experiment", (8.5, 0.7),
              (float(f"{1e-3 * critical:.3g}"), float(f"{1e-3 * half:.2g}"))),
        claim("critical voltage of the simulated wire (kV), from its B at 2 kV: no balance once the bent wire, longer, has "
              "too little tension", "not in D", f"{1e-3 * stretching:.3g} (this theory)",
              float(f"{1e-3 * critical:.3g}"), "within a fifth: it breaks by stretching, not by the angle of 4.17"),
        claim("critical field from 4.21 as printed (kV/m)", "D 4.21", 334,
              float(f"{field['printed_critical_field']:.3g}"), "does not follow from the printed parameters"),
        claim("critical field, corrected (kV/m): tension of the mean gap, of the whole gap, of it shared by 26 places",
              "D 4.20, experiment 8.5 kV over 20 mm", 425,
              ", ".join(f"{field[key]:.3g}" for key in ("critical_field_mean_gap", "critical_field_whole_gap",
                                                        "critical_field_whole_gap_shared")),
              "the last is nearest: a tension acts only where the gap is"),
        claim("resistance of the whole wire (GOhm)", "D 4.8", 198, float(f"{1e-9 * low:.3g}"),
              "less: the drag is that of spheres in free oil, not on the bottom of a dish; and two dimensions"),
        claim("resistance, broken over whole", "D 4.8", 3.5,
              f"{ohms[gone].min() / low:.2g} and more", "rises by a factor of more than two, as in the source"),
    ])


if __name__ == "__main__":
    main()
