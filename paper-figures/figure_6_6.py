#!/usr/bin/python3
"""Figure 6.6: error of the approximate gradient descent against iterations.

Shown with an exponential fit and the predicted rate. Runs `error_decay` (two disks, d/2R = 4, eta = 0.01, S = 512; half a
minute).
"""

import re

import matplotlib.pyplot as plt
import numpy as np

from figures import build_folder, claim, run, save, save_claims


def main():
    text = run(build_folder(__doc__.splitlines()[0]) / "error_decay")
    iteration, error = np.loadtxt(text.splitlines(), unpack=True)
    predicted, exact = (float(re.search(name + r".*: (\S+)", text).group(1)) for name in ("small-step", "exact"))
    slope, intercept = np.polyfit(iteration, np.log(error), 1)
    print(f"fitted rate {-slope:.6f} an iteration; 2 eta C22 = {predicted:.6f}; -2 ln(1 - eta C22) = {exact:.6f}")

    figure, axes = plt.subplots(figsize=(5.5, 4))
    axes.semilogy(iteration[::10], error[::10], "o", color="tab:red", fillstyle="none", markersize=4, label="computed")
    axes.semilogy(iteration, np.exp(intercept + slope * iteration), color="tab:blue",
                  label=rf"fit, $\lambda$ = {-slope:.5f} (D 6.38)")
    axes.semilogy(iteration, error[0] * np.exp(-predicted * iteration), "--", color="black",
                  label=rf"$2\eta C_{{22}}$ = {predicted:.5f} (D 6.39)")
    axes.set_xlabel("iteration")
    axes.set_ylabel(r"error $\mathcal{E}$ (D 6.22), $\epsilon = Q = 1$")
    axes.legend()
    save(figure, "figure_6_6")
    # 6.39 is the first-order term of -2 ln(1 - eta C22) in eta C22; its error is the remainder.
    save_claims("figure_6_6", [claim(
        "rate of the gradient descent's error, 2 eta C22, its first order", "D 6.39", (predicted, exact - predicted),
        -slope, note="by more than the first order leaves out: relaxation is unfinished after 4 n10 sweeps")])


if __name__ == "__main__":
    main()
