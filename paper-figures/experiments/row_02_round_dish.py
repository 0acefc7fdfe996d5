#!/usr/bin/python3
"""Row 2: ramified networks of steel spheres in a round dish of oil (Jun and Hübler 2005, Soni 2011).

Scene dish-3d.toml: spheres that start together in the middle of a round dish, with a grounded rim. One run per seed goes
on until all spheres are connected and at rest. End points, branch points and Strahler numbers are those of the trees.
"""

import json
import tempfile
from pathlib import Path

from experiments import RESULTS, SOURCE, mean, open_experiment, published, record, row, run

EXPECTED = ("The fractions follow from the geometry of trees and depend little on the dish, so that they are those of the "
            "experiment within 0.05; contacts at a gap of a radius may add end points.")
REASON = ("The rim carries many short trees of 70 spheres, and the spheres lie densely, as in the plane with a ring. The "
          "published values have no interval.")
PUBLISHED = {"endpoint_fraction": (0.252, "end points"), "branch_fraction": (0.237, "branch points"),
             1: (0.455, "spheres of Strahler number 1"), 2: (0.275, "spheres of Strahler number 2"),
             3: (0.169, "spheres of Strahler number 3")}


def fractions(program, seed, settings):
    """Returns the fractions of PUBLISHED in the last frame of a run."""
    with tempfile.TemporaryDirectory() as folder:
        result = Path(folder) / "dish.h5"
        words = [word for setting in [f"seed={seed}", "output.picture=false", *settings] for word in ("--set", setting)]
        run(program, "run", SOURCE / "scenes" / "dish-3d.toml", "--quiet", "--output", result, *words)
        last = json.loads(run(program, "analyse", result, "--json"))["frames"][-1]
    numbers = last["strahler_number"] + [0] * 4
    return {key: last[key] if isinstance(key, str) else numbers[key] / max(last["connected"], 1) for key in PUBLISHED}


def main():
    request = open_experiment(2, "Jun, Huebler 2005; Soni 2011", __doc__)
    if request.out == RESULTS / "row-02.json":  # which has the rows of the plane
        request.out = RESULTS / "row-02-space.json"
    settings = ["stop.time=0.2", "population.count=40"] if request.quick else []
    runs = [fractions(request.program, seed, settings) for seed in range(1, 3 if request.quick else 9)]
    rows = []
    for key, (value, name) in PUBLISHED.items():
        theirs = published(value, value - 0.0005, value + 0.0005, "S")
        found = row(f"{name} over N, 70 spheres in a torus in space", EXPECTED, theirs, mean([each[key] for each in runs]))
        if found["verdict"] == "disagrees":
            found["reason"] = REASON
        rows.append(found)
    record(request, rows)


if __name__ == "__main__":
    main()
