#!/usr/bin/python3
"""Row 10: Dammer and Wolf, Phys. Rev. Lett. 93, 150602 (2004), coagulation of equally charged particles.

Smoluchowski's equation with the Brownian kernel and Fuchs's factor for charges proportional to the mass. Their abstract
states the limit of the relative width. In the limit of high barriers the two smallest aggregates always merge next. The
stationary distribution of sizes is then s^-2 from m to 2m, whose relative width is sqrt(1/(2 ln^2 2) - 1) = 0.20170.
"""

import json
import math

import numpy as np
from experiments import bounds, open_experiment, picture, published, record, row, run

EXPECTED = ("The width falls to sqrt(1/(2 ln^2 2) - 1) = 0.2017, the value of a gas in which the two smallest aggregates "
            "always merge next, and the approach is as one over the barrier.")
EXPECTED_PARAMETER = "The limit does not depend on the charge of a grain."
REPULSIONS = [0.05, 0.2]  # energy of two grains in contact over the temperature
UNTIL = 1e40
PUBLISHED = published(0.2017, 0.20165, 0.20175, "A")  # four digits


def width(program, repulsion, until):
    """Returns times, barriers of two mean aggregates over the temperature, widths and the relative error of S."""
    answer = json.loads(run(program, "theory", "smoluchowski", "--kernel", "brownian", "--repulsion", repulsion, "--until",
                            until, "--json"))
    columns = {name: np.array(column["values"], float) for name, column in answer["tables"][0]["columns"].items()}
    error = next(figure["value"] for figure in answer["figures"] if figure["name"] == "error")
    mean_size = 1 / columns["number"]
    return columns["time"], repulsion * mean_size ** (5 / 3), columns["width"], error


def limit(barrier, found):
    """Returns the limit of the width for an infinite barrier, and its error: lines in one over the barrier through the
    last third and the last sixth of the barriers."""
    lines = []
    for part in (1 - 1 / 3, 1 - 1 / 6):
        chosen = barrier > part * barrier[-1]
        lines.append(np.polyfit(1 / barrier[chosen], found[chosen], 1)[1])
    return lines[1], abs(lines[1] - lines[0]) + abs(found[-1] - lines[1]) / 3


def main():
    request = open_experiment(10, "Dammer, Wolf 2004", __doc__)
    until = 1e12 if request.quick else UNTIL
    rows, curves = [], []
    for repulsion in REPULSIONS[-1:] if request.quick else REPULSIONS:
        time, barrier, found, error = width(request.program, repulsion, until)
        curves.append((repulsion, barrier, found))
        value, uncertain = limit(barrier, found)
        # w^2 = S number - 1, so that dw = (1 + w^2) / (2 w) times the relative error of S.
        grid = (1 + value**2) / (2 * value) * error
        rows.append(row(f"limit of the relative width of sizes, repulsion {repulsion:g}, t = {until:g}",
                        EXPECTED if repulsion == REPULSIONS[0] or request.quick else EXPECTED_PARAMETER, PUBLISHED,
                        bounds(value, math.hypot(uncertain, grid))))

    def draw(axes):
        for repulsion, barrier, found in curves:
            axes.plot(barrier, found, label=f"repulsion {repulsion:g}")
        axes.axhline(PUBLISHED["value"], color="grey", label="published limit")
        axes.set(xscale="log", xlabel="barrier of two mean aggregates over the temperature", ylabel="relative width",
                 ylim=(0.15, 0.8))

    picture(request.plot, draw)
    record(request, rows)


if __name__ == "__main__":
    main()
