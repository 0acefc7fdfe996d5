"""Figures 7.3 and 7.4: a count of the network against its size, in stationary states and during growth."""

import matplotlib.pyplot as plt
import numpy as np

import ensembles
from figures import claim, save, save_claims


def draw_stationary(axes, ensemble, quantity, symbol, published):
    conductors, counts = ensemble.values("conductors"), ensemble.values(quantity)
    largest, slope = conductors.max(), ensemble.slope(quantity)
    ensembles.draw_law(axes, published, largest, f"published, {published}")
    ensembles.draw_slope(axes, slope, largest)
    ensembles.scatter(axes, conductors, counts)
    axes.set_xlabel("conductors $N$")
    axes.set_ylabel(f"${symbol}$, stationary")
    axes.legend(frameon=False, loc="upper left")
    return slope


def draw_growth(axes, ensemble, quantity, symbol, published):
    series = []
    for member in ensemble.largest():
        size, count = ensemble.growth(member, "connected", quantity)
        series.append((size[size > 0], count[size > 0]))
    largest = max(size.max() for size, _ in series)
    slope = ensembles.pooled_slope(series)
    ensembles.draw_law(axes, published, largest, f"published, {published}")
    ensembles.draw_slope(axes, slope, largest)
    ensembles.scatter(axes, *(np.concatenate(parts) for parts in zip(*series)))
    axes.set_xlabel(f"conductors in the tree $M(t)$; {len(series)} run(s) of $N$ = {largest}")
    axes.set_ylabel(f"${symbol}(t)$, growing")
    axes.legend(frameon=False, loc="upper left")
    return slope


def draw(name, description, quantity, symbol, published, sources):
    """Draws the figure and saves its two claims: proportionality to N in stationary states and to M(t) at all times."""
    ensemble, name = ensembles.select_ensemble(description, name)
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(5.5, 7.5), layout="constrained")
    stationary = draw_stationary(top, ensemble, quantity, symbol, published)
    growing = draw_growth(bottom, ensemble, quantity, symbol, published)
    save(figure, name)
    words = quantity.replace("_", " ")
    save_claims(name, [claim(f"{words} over N, stationary", sources[0], published, stationary),
                       claim(f"{words} over M(t), growing", sources[1], published, growing)])
