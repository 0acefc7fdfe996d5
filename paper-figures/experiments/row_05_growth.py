#!/usr/bin/python3
"""Row 5: Singh and Mazza 2018, 2019, growth of aggregates in a gas of 50016 grains.

The values are those of docs/measurements/figures.json (figures 4.5 and 5.5 of Singh 2019) and of growth_exponents.csv,
from up to twenty seeds at the source's size, with 95 % intervals. Only --changes makes runs. Changes of definitions are
also those of this table, and changes of the gas are runs of 4000 grains.
"""

import json
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from experiments import (SOURCE, Change, bounds, conditions_of, numbers_in, open_experiment, published, record, recorded, row,
                         run, try_changes)

sys.path.insert(0, str(SOURCE / "paper-figures"))

import gas_scenes  # noqa: E402
from growth_report import exponent, stored_exponents  # noqa: E402
from growth_study import gas_of  # noqa: E402

SEEDS = 20
NEUTRAL, CHARGED = "z of S, neutral, t = 200 to 400", "z of S, charged, K Q^2 = 5e-4, t = 50 to 100"
EXPECTED = "The growth exponents of S are those of the source, as model, size and times are the same."
EXPECTED_BOUND = "Bound aggregates grow as coagulation does, with an exponent near that of Smoluchowski's equation, 1.5."
EXPECTED_SHAPE = "Aggregates have the fractal dimension of the source, which rises during the run."
CELLS = ("S counts dense cells, not aggregates, and its slope rises during the run. The time, and edge and threshold of a "
         "cell, decide. The source states neither edge nor threshold. The charged gas grows as published in the number mean "
         "of bound aggregates.")


CONSTANT, SMALL = "[effects.linear_contact]\nstiffness = 278.6\nrestitution = 0.3", "4000 grains"
STORED = {  # quantity: point and interval of time in growth_exponents.csv, and other intervals
    NEUTRAL: ("neutral", (200, 400), ((50, 100), (70, 140), (100, 200))),
    CHARGED: ("5e-4", (50, 100), ((20, 40), (70, 140)))}
DEFINITIONS = {"cells of 1 d0": (1.0, 1), "cells of 1.5 d0": (1.5, 2), "cells of 2.5 d0": (2.5, 8), "cells of 3 d0": (3.0, 14),
               "cells of 3.9 d0": (3.9, 28), "cells of 5 d0": (5.0, 59), "cells with 2 grains, not 4": (2.0, 2),
               "cells with 6 grains": (2.0, 6), "cells of 2.5 d0 with 12 grains": (2.5, 12)}


def stored_changes(conditions):
    """Returns changes of definitions of S, in cells of 2 d0 with at least 4 grains, and of its interval of time."""
    def case(quantity, assumption, change, expected, *key):
        return Change(assumption, change, expected, (quantity, key), conditions=conditions)

    for quantity, (point, window, others) in STORED.items():
        yield from (case(quantity, "time", f"t = {first} to {last}", "same (source)", point, "density_cluster_size",
                         first, last) for first, last in others)
        yield from (case(quantity, "definition", change, "same (source)", point, *cells, *window)
                    for change, cells in DEFINITIONS.items())
        mean_of = "mean_bound_aggregate" if quantity == CHARGED else "mean_aggregate"
        yield case(quantity, "quantity", "number mean of grains in " + ("bound " if quantity == CHARGED else "") + "aggregates",
                   "1.5, as in coagulation" if quantity == CHARGED else "0: no aggregates", point, mean_of, *window)
    yield case(CHARGED, "law", "K Q^2 = 2e-5", "same (source)", "2e-5", "density_cluster_size", 50, 100)


def gas_changes():
    """Returns changes of the gas, in runs of 4000 grains."""
    def cases(quantity, gas, more):
        yield Change("system size", SMALL, "2.2: clusters soon span the box", (quantity, gas))
        for assumption, change, expected, other in more:
            yield Change(assumption, f"{SMALL}, {change}", expected, (quantity, other), SMALL)

    neutral, charged = replace(gas_of(0, 400), count=4000), replace(gas_of(5e-4, 100), count=4000)
    same, hot = "same", ("start", "temperature 5, not 10", "same")
    steps = ("resolution", "90 substeps of a contact, not 45", same)
    law = ("law", "constant restitution 0.3")
    yield from cases(NEUTRAL, neutral, [(*law, "1: it cools faster", replace(neutral, contact=CONSTANT)),
                                        (*hot, replace(neutral, temperature=5)), (*steps, replace(neutral, steps=90))])
    finer = replace(charged, effects=(gas_scenes.impacts(), gas_scenes.coulomb(5e-4 / gas_scenes.RATE**2, 1e-4)))
    yield from cases(CHARGED, charged, [(*law, same, replace(charged, contact=CONSTANT)),
                                        (*hot, replace(charged, temperature=5)), (*steps, replace(charged, steps=90)),
                                        ("resolution", "forces to 1e-4, not 1e-3", same, finer)])


def member(program, gas, seed):
    """Returns a run of a gas as in the files of growth_study.py."""
    with tempfile.TemporaryDirectory() as folder:
        scene, result = Path(folder) / "gas.toml", Path(folder) / "gas.h5"
        scene.write_text(gas.scene(seed))
        run(program, "run", scene, "--quiet", "--out", result)
        frames = json.loads(run(program, "analyse", result, "--json"))["frames"]
    return {"warm": gas_scenes.WARM, "frames": {key: [frame[key] for frame in frames] for key in ("time", "density_cluster_size")}}


def changed(program, seeds, quantity, changed_to):
    """Returns the exponent of a key of growth_exponents.csv, or of runs of a gas."""
    if isinstance(changed_to, tuple):
        return {quantity: bounds(*stored_exponents()[changed_to])}
    members = [member(program, changed_to, seed) for seed in range(1, seeds + 1)]
    return {quantity: bounds(*exponent(members, "density_cluster_size", *STORED[quantity][1]))}


def main():
    request = open_experiment(5, "Singh, Mazza 2018, 2019", __doc__)
    measured = recorded("figures of the source on grains")
    conditions = conditions_of(measured, "paper-figures/make.sh granular_4_5 granular_5_5", 417)
    if request.changes is not None:
        try_changes(request, [*stored_changes({**conditions, "seconds": 0}), *gas_changes()],
                    lambda argument: changed(request.program, 8 if argument[0] == NEUTRAL else 5, *argument))
        return
    shape = next(numbers_in(each["found"]) for each in measured["rows"] if each["claim"] == "D_f of bound clusters")
    z = {key: bounds(*value) for key, value in stored_exponents().items()}
    neutral, charged = published(1.21, 1.17, 1.25, "S"), published(1.49, 1.478, 1.502, "S")
    cells = "density_cluster_size"
    rows = [row("z of S, neutral, t = 70 to 140", EXPECTED, neutral, z["neutral", cells, 70, 140]),
            row(NEUTRAL, EXPECTED, neutral, z["neutral", cells, 200, 400], CELLS),
            row(CHARGED, EXPECTED, charged, z["5e-4", cells, 50, 100], CELLS),
            row("z of the number mean of bound aggregates, K Q^2 = 5e-4", EXPECTED_BOUND, charged,
                z["5e-4", "mean_bound_aggregate", 50, 100]),
            row("fractal dimension of bound clusters, early", EXPECTED_SHAPE, published(None, 1.94, 2.46, "S"),
                bounds(*shape[0], SEEDS)),
            row("fractal dimension of bound clusters, late", EXPECTED_SHAPE, published(None, 1.94, 2.46, "S"),
                bounds(*shape[1], SEEDS))]
    record(request, rows, conditions)


if __name__ == "__main__":
    main()
