#!/usr/bin/python3
"""Figure 4.7: the wire's largest displacement against the transverse voltage, below the critical one."""

import json

import matplotlib.pyplot as plt
import numpy as np

import wires
from figures import claim, request, run, save, save_claims

VOLTS = [v for v in wires.RUNS if v <= 10e3]
LINEAR = 4e3  # V; displacements are below 0.2 diameters up to here


def stretching(displacement):
    """Returns the increase by stretching of the exponent 1 of 4.16 at this largest displacement (m). The law is y (1 +
    c)^-3/2 ~ V, with c the length added by bending over that of the gaps (validation/theory, disks), so d ln y / d ln V
    = (1 + c) / (1 - 2c)."""
    b = 12 * np.sqrt(3) * displacement / wires.LENGTH**3
    added = b**2 * wires.LENGTH**5 / 40 / (wires.LENGTH - 2 * wires.N * wires.RADIUS)
    return (1 + added) / (1 - 2 * added) - 1


def side(value, others):
    """Describes the position of a value relative to several others."""
    return "less than any" if value < min(others) else "more than any" if value > max(others) else "between them"


def main():
    arguments = request(__doc__.splitlines()[0])
    theory = json.loads(run(arguments.build / "chapter_4"))["wire"]
    volts = np.array(VOLTS)
    largest = np.array([wire.largest() for wire in wires.wires(arguments, VOLTS)])
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
    # Validity of 4.16: the linear law is fitted up to LINEAR, where stretching is largest.
    allowed = stretching(slope * LINEAR)
    per_volt = [theory["largest_whole_gap"], theory["largest_whole_gap_shared"]]
    save_claims("figure_4_7", [
        claim("y_max ~ V^p at small displacements: p", "D 4.16", 1, (exponent, allowed)),
        claim("y_max over the linear law near 10 kV", "D 4.16", 1,
              (largest[-1] / (slope * volts[-1]), allowed),
              note="superlinear before it breaks: the bent wire is longer, its gaps wider, its tension less"),
        claim("y_max / V (mm/kV)", "D 4.16, corrected B: tension at all positions, or divided among them",
              " or ".join(f"{1e6 * value:.2g}" for value in per_volt), float(f"{1e6 * slope:.3g}"),
              side(slope, per_volt),
              "in two dimensions the wire screens itself from the transverse field" if slope < min(per_volt) else ""),
    ])


if __name__ == "__main__":
    main()
