#!/usr/bin/python3
"""Figure 7.6: Strahler numbers of growing trees against their size.

Conductors of Strahler number 1, 2 and 3 in the largest runs, frame by frame, against the size M(t) of the tree, with the
published 0.455, 0.275 and 0.169 (D 7.18). The source shows one run of N = 324.
"""

import matplotlib.pyplot as plt
import numpy as np

import ensembles
from figures import claim, save, save_claims

PUBLISHED = {1: 0.455, 2: 0.275, 3: 0.169}


def series_of(ensemble, order):
    """Returns (M, sigma_order) by frame of each of the largest runs."""
    series = []
    for member in ensemble.largest():
        found = ensemble.analysis(member)
        size, numbers = found["connected"], found["strahler_number"]
        count = numbers[:, order] if order < numbers.shape[1] else np.zeros(len(size))
        series.append((size[size > 0], count[size > 0]))
    return series


def main():
    ensemble, name = ensembles.select_ensemble(__doc__.splitlines()[0], "figure_7_6")
    figure, panels = plt.subplots(3, 1, sharex=True, figsize=(5.5, 8), layout="constrained")
    claims = []
    for (order, published), axes in zip(PUBLISHED.items(), panels):
        series = series_of(ensemble, order)
        slope, largest = ensembles.pooled_slope(series), max(size.max() for size, _ in series)
        ensembles.draw_law(axes, published, largest, f"published, {published}")
        ensembles.draw_slope(axes, slope, largest)
        ensembles.scatter(axes, *(np.concatenate(parts) for parts in zip(*series)))
        axes.set_ylabel(rf"$\sigma_{order}(t)$")
        axes.legend(frameon=False, loc="upper left")
        claims.append(claim(f"conductors of Strahler number {order} over M(t), growing", "D 7.18", published, slope))
        stationary = ensemble.slope(f"strahler_{order}")
        claims.append(claim(f"conductors of Strahler number {order} over N, stationary", "D 7.18", published, stationary))
    panels[-1].set_xlabel(f"conductors in the tree $M(t)$; {len(series)} run(s) of $N$ = {largest}")
    save(figure, name)
    save_claims(name, claims)


if __name__ == "__main__":
    main()
