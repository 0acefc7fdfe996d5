#!/usr/bin/python3
"""Row 5: Singh and Mazza 2018, 2019, growth of aggregates in a gas of 50016 grains.

No new runs: the values are those of docs/measurements/figures.json (figures 4.5 and 5.5 of Singh 2019), from twenty
seeds at the source's size. They have 95 % intervals.
"""

from experiments import bounds, conditions_of, numbers_in, open_experiment, published, record, recorded, row

SEEDS = 20
EXPECTED = "The growth exponents of S are those of the source, as model, size and times are the same."
EXPECTED_BOUND = "Bound aggregates grow as coagulation does, with an exponent near that of Smoluchowski's equation, 1.5."
EXPECTED_SHAPE = "Aggregates have the fractal dimension of the source, which rises during the run."
CELLS = ("S counts cells whose density exceeds a threshold, not aggregates. It has no plateau: its slope rises during the "
         "run. The edge of a cell alone changes the exponent from 4.9 to 0.9 (edges of 1 to 5 diameters). The source "
         "states neither edge nor threshold, and this choice decides.")


def main():
    request = open_experiment(5, "Singh, Mazza 2018, 2019", __doc__)
    measured = recorded("figures of the source on grains")
    found = {each["claim"]: numbers_in(each["found"]) for each in measured["rows"]}
    neutral_z, charged_z = found["exponent z of S, neutral, t = 70 to 140"], found["z of S, K Q^2 = 5e-4, t = 50 to 100"]
    bound_z = found["z of the number mean of bound aggregates, 5e-4; 2e-5 late"]
    shape = found["D_f of bound clusters"]
    neutral = published(1.21, 1.17, 1.25, "S")
    rows = [row("z of S, neutral, t = 70 to 140", EXPECTED, neutral, bounds(*neutral_z[0], SEEDS)),
            row("z of S, neutral, t = 200 to 400", EXPECTED, neutral, bounds(*neutral_z[2], SEEDS), CELLS),
            row("z of S, charged, K Q^2 = 5e-4, t = 50 to 100", EXPECTED, published(1.49, 1.478, 1.502, "S"),
                bounds(*charged_z[0], SEEDS), CELLS),
            row("z of the number mean of bound aggregates, K Q^2 = 5e-4", EXPECTED_BOUND,
                published(1.49, 1.478, 1.502, "S"), bounds(*bound_z[0], SEEDS)),
            row("fractal dimension of bound clusters, early", EXPECTED_SHAPE, published(None, 1.94, 2.46, "S"),
                bounds(*shape[0], SEEDS)),
            row("fractal dimension of bound clusters, late", EXPECTED_SHAPE, published(None, 1.94, 2.46, "S"),
                bounds(*shape[1], SEEDS))]
    record(request, rows, conditions_of(measured, "paper-figures/make.sh granular_4_5 granular_5_5", 417))


if __name__ == "__main__":
    main()
