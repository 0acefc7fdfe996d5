#!/usr/bin/python3
"""Row 2: Jun and Huebler 2005, Soni 2011, ramified networks of steel spheres in a dish of oil.

The values are those of docs/measurements/figures.json, from plane scenes of eight seeds each, with 95 % intervals. Only
--changes makes runs. row_02_round_dish.py has the dish in space.
"""

from experiments import (SOURCE, Change, bounds, conditions_of, ensemble, numbers_in, open_experiment, published, record,
                         recorded, row, try_changes)

SEEDS = 8
EXPECTED = ("The shares of ends and branch points are those of the experiment, as they are properties of trees whose contacts "
            "form by attraction and do not depend on the third dimension.")
EXPECTED_RING = "A ring electrode changes the shares as little as a straight one."
RING = ("Fewer spheres or a smaller gap, which give fewer ends with a half-disk, give more of them in the ring. The "
        "half-disk alone comes closest.")
IN_RING = "endpoints over N, 100 spheres in a ring"
COUNT, DISTANCE = "population.count", "effects.contact_discharge.contact_distance"
# Arguments: scene, settings, ending of the names of the quantities. Boxes have the area of the ring.
CHANGES = [
    Change("density", "75 spheres in the ring", "fewer contacts at the start: 0.28", ("dish", {COUNT: 75})),
    Change("density", "50 spheres in the ring", "0.25, as with 50 in the box", ("dish", {COUNT: 50})),
    Change("contact law", "contacts below a gap of R/2, not R", "0.25", ("dish", {DISTANCE: 0.3875e-3})),
    Change("electrode", "half-disk of 2 mm in a box, not a ring", "0.28, as with 100 in the box", ("dendrite", {
        COUNT: 100, "domain.size": "[2.792e-2, 2.792e-2]", "electrode[0].at": 1.396e-2, "population.min_gap": 0.125e-3,
        "field.cells": 224})),
    Change("current", "2 nA, not 0.2 nA", "same", ("dish", {"effects.current_injection.current": 2e-9})),
    Change("resolution", "a radius of 12.4 cells, not 6.2", "same", ("dish", {"field.cells": 512})),
    Change("seeds", "9 to 13", "same", ("dish", {"seed": 9})),
    Change("definition", "degrees without the contacts that close loops", "more: 0.35", ("dish", {}, "_in_tree")),
    Change("definition", "degrees without contacts with the ring", "more: 0.33", ("dish", {}, "_without_ground")),
    Change("system size", "200 spheres, twice the area", "0.3: fewer spheres near the ring", ("dish", {
        COUNT: 200, "domain.size": "[4.525e-2, 4.525e-2]", "electrode[0].centre": "[2.2625e-2, 2.2625e-2]",
        "electrode[0].radius": 2.2275e-2, "field.cells": 362})),
]
REPORTED = {"endpoints": 0.252, "branch points": 0.237}


def changed(program, seeds, scene, settings, ending=""):
    """Returns the mean of the disagreeing quantity over seeds."""
    found = ensemble(program, SOURCE / "scenes" / f"{scene}.toml", settings, seeds)
    return {IN_RING: bounds(*found["endpoint_fraction" + ending])}


def main():
    request = open_experiment(2, "Jun, Huebler 2005; Soni 2011", __doc__)
    if request.changes is not None:
        try_changes(request, CHANGES, lambda argument: changed(request.program, 2 if request.quick else 5, *argument))
        return
    large = recorded("figures of the dissertation on conductors")
    claims = {each["claim"]: numbers_in(str(each["found"])) for each in large["rows"]}
    small = recorded("endpoints f1 and branch points B by condition, 100 spheres, eight seeds")
    ring = next(each for each in small["rows"] if "dish.toml" in each["changed"])
    rows = []
    for name, value in REPORTED.items():
        theirs = published(value, value - 0.0005, value + 0.0005, "S")
        rows.append(row(f"{name} over N, 324 spheres", EXPECTED, theirs,
                        bounds(*claims[f"{name} over N, 324 spheres"][0], SEEDS)))
        rows.append(row(f"{name} over N, 100 spheres in a ring", EXPECTED_RING, theirs,
                        bounds(*numbers_in(ring["f1" if name == "endpoints" else "B"])[0], SEEDS), RING))
    record(request, rows, conditions_of(large, "paper-figures/make.sh 7_3 7_4; paper-figures/topology_study.py --seeds 8", 0))


if __name__ == "__main__":
    main()
