#!/usr/bin/python3
"""Figure 4.6: the wire's shape in a transverse field of 2 kV, simulated and fitted by D 4.15.

The source also fits B. It gives B and the displacements only as pictures.
"""

import matplotlib.pyplot as plt
import numpy as np

import wires
from figures import claim, request, save, save_claims

VOLTS = 2e3
# fraction of the largest displacement; 4.15 is for a long wire fixed at its ends, without a bound for 25 spheres
BY_EYE = 0.1


def cubic(x):
    """Returns D 4.15 without its factor B."""
    return (x - wires.LENGTH / 2) * (wires.LENGTH - x) * x


def main():
    wire, = wires.wires(request(__doc__.splitlines()[0]), [VOLTS])
    along, across = wire.shape()
    b = np.dot(across, cubic(along)) / np.dot(cubic(along), cubic(along))
    residual = np.sqrt(np.mean((across - b * cubic(along)) ** 2)) / np.abs(across).max()
    figure, axes = plt.subplots(figsize=(6, 3.6), layout="constrained")
    x = np.linspace(0, wires.LENGTH, 200)
    axes.plot(1e3 * along, 1e3 * across, "o", color="tab:red", fillstyle="none", label="simulation (2D)")
    axes.plot(1e3 * x, 1e3 * b * cubic(x), color="tab:blue",
              label=f"D 4.15, fitted $B$ = {b:.3g} m$^{{-2}}$")
    axes.set(xlabel="x (mm)", ylabel="y (mm)")
    axes.legend()
    save(figure, "figure_4_6")
    save_claims("figure_4_6", [
        claim("shape B (x - L/2)(L - x) x: rms residual over largest displacement", "D 4.15", "agrees",
              f"{100 * residual:.1f} %",
              f"agrees, by eye (within {100 * BY_EYE:g} %)" if residual < BY_EYE else "another shape"),
        claim("largest displacement at 2 kV (mm)", "D 4.6 (picture only)", "not printed",
              float(f"{1e3 * wire.largest():.3g}"), "nothing to compare", "two dimensions"),
    ])


if __name__ == "__main__":
    main()
