#!/usr/bin/python3
"""Figure 4.7: the wire's largest displacement against the transverse voltage, below the critical one."""

import json

import matplotlib.pyplot as plt
import numpy as np

import wires
from figures import build_folder, claim, run, save, save_claims

VOLTS = [v for v in wires.RUNS if v <= 10e3]
LINEAR = 4e3  # V: up to here displacements are below a fifth of a diameter


def main():
    build = build_folder(__doc__.splitlines()[0])
    theory = json.loads(run(build / "chapter_4"))["wire"]
    volts = np.array(VOLTS)
    largest = np.array([wire.largest() for wire in wires.wires(build, VOLTS)])
    small = volts <= LINEAR
    slope = np.dot(volts[small], largest[small]) / np.dot(volts[small], volts[small])
    exponent = np.polyfit(np.log(volts[small]), np.log(largest[small]), 1)[0]
    figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
    axes.plot(1e-3 * volts, 1e3 * largest, "o", color="tab:red", fillstyle="none", label="simulation (2D)")
    axes.plot(1e-3 * volts, 1e3 * slope * volts, color="tab:blue", label=f"linear: {1e6 * slope:.3g} mm/kV")
    axes.plot(1e-3 * volts, 1e3 * theory["largest_whole_gap"] * volts, "--", color="tab:gray",
              label="D 4.16, one gap's tension at every place (3D)")
    axes.set(xlabel=r"transverse voltage (kV)", ylabel=r"$y_{max}$ (mm)")
    axes.legend(fontsize=8)
    save(figure, "figure_4_7")
    save_claims("figure_4_7", [
        claim("y_max ~ V^p at small displacements: p", "D 4.16", 1, float(f"{exponent:.3g}"),
              "agrees" if abs(exponent - 1) < 0.1 else "differs"),
        claim("y_max over the linear law near 10 kV", "D 4.16", 1, float(f"{largest[-1] / (slope * volts[-1]):.3g}"),
              "superlinear before it breaks: the bent wire is longer, its gaps wider, its tension less"),
        claim("y_max / V (mm/kV)", "D 4.16, corrected B: tension at all places, or shared by them",
              f"{1e6 * theory['largest_whole_gap']:.2g} or {1e6 * theory['largest_whole_gap_shared']:.2g}",
              float(f"{1e6 * slope:.3g}"),
              "less than either: in two dimensions the wire screens itself from the transverse field"),
    ])


if __name__ == "__main__":
    main()
