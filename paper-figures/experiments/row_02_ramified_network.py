#!/usr/bin/python3
"""Row 2: Jun and Huebler 2005, Soni 2011, ramified networks of steel spheres in a dish of oil.

No new runs: the values are those of docs/measurements/figures.json, from plane scenes of eight seeds each, with 95 %
intervals. row_02_round_dish.py has the dish in space.
"""

from experiments import bounds, conditions_of, numbers_in, open_experiment, published, record, recorded, row

SEEDS = 8
EXPECTED = ("The shares of ends and branch points are those of the experiment, as they are properties of trees whose contacts "
            "form by attraction and do not depend on the third dimension.")
EXPECTED_RING = "A ring electrode changes the shares as little as a straight one."
RING = ("100 spheres lie as densely as those of the dish here, and form loops. Against the row above the electrode, the "
        "number and the density of spheres differ. With the ring replaced by a half-disk alone the share of ends is 0.283 "
        "± 0.025, and with half of the spheres in that box 0.242 ± 0.026: the density at the start decides.")
REPORTED = {"endpoints": 0.252, "branch points": 0.237}


def main():
    request = open_experiment(2, "Jun, Huebler 2005; Soni 2011", __doc__)
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
