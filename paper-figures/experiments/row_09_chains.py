#!/usr/bin/python3
"""Row 9: chains behind a series resistor (Belkin, Hubler, Bezryadin 2015; Han, Bezryadin 2026).

Spheres in castor oil lie between a grounded plate and two plates, which one circuit connects with a source behind a
resistor. Chains of spheres carry charge between the plates (scenes/wire-growth.toml). Published: the resistance of the
structure tends to the series resistance, and of two structures behind one resistor usually one survives.
"""

import tempfile
from pathlib import Path

import h5py
import numpy as np

from experiments import attempt, mean, open_experiment, picture, published, record, refuse, row

SERIES = [1e10, 1e11, 1e12]  # ohm
SEEDS = range(1, 5)
TIME = 0.6  # s
LATE = 0.25  # part of a run, at its end, over which currents are averaged
SURVIVES = 0.9  # part of the current that the surviving chain carries at least
EXPECTED_RESISTANCE = ("Disagrees: the forces on the spheres fall with the voltage that the resistor leaves, but "
                       "nothing in the model stops growth at equal resistances.")
EXPECTED_SURVIVOR = ("Agrees: the chain that forms first takes the voltage from the other electrode, whose spheres are "
                     "then hardly driven.")
REASON_RESISTANCE = ("Contacts have a fixed resistance and spheres shuttle at low currents. The resistance of the "
                     "structure follows from the number of chains and gaps, and no force breaks a chain that carries a "
                     "large current.")
REASON_SURVIVOR = "Both electrodes have one potential, so that a chain at one does not discharge spheres at the other."

SCENE = Path(__file__).with_name("two_chains.toml")


def late_charges(program, series, seed, time):
    """Runs the scene. Returns the charges (C) that were delivered late in the run, to the lower, the upper and the
    grounded plate and by the source."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "chains.h5"
        result = attempt(program, "run", SCENE, "--out", out, "--quiet", "--set", f"seed={seed}", "--set",
                         f"stop.time={time}", "--set", f"circuit[0].resistance={series}")
        if result.returncode != 0:
            refuse(program, result)
        with h5py.File(out) as file:
            delivered = file["observables/charge_delivered/value"][:]
    return delivered[-1] - delivered[-1 - int(LATE * (len(delivered) - 1))]


def main():
    request = open_experiment(9, "Belkin, Hubler, Bezryadin 2015; Han, Bezryadin 2026", __doc__)
    seeds, resistors, time = (SEEDS, SERIES, TIME) if not request.quick else (range(1, 3), SERIES[1:2], 0.05)
    ratios, shares = [], []
    for series in resistors:
        for seed in seeds:
            lower, upper, _, node = late_charges(request.program, series, seed, time)
            span = LATE * time
            structure = (18e3 - series * node / span) / (node / span)
            ratios.append(np.log10(structure / series))
            total = abs(lower) + abs(upper)
            shares.append(max(abs(lower), abs(upper)) / total)
            print(f"R_s = {series:.0e} ohm, seed {seed}: R_f / R_s = {structure / series:.3g}, shares of the current "
                  f"{abs(lower) / total:.2f} and {abs(upper) / total:.2f}", flush=True)
    survivors = [share > SURVIVES for share in shares]
    rows = [row("logarithm to base 10 of structure resistance over series resistance", EXPECTED_RESISTANCE,
                published(0, -0.3, 0.3, "S"), mean(ratios), REASON_RESISTANCE),
            row("part of the runs in which one of two chains carries more than 90 % of the current", EXPECTED_SURVIVOR,
                published(None, 0.5, 1, "A"), mean(np.array(survivors, float)), REASON_SURVIVOR)]

    def draw(axes):
        axes.plot(np.repeat(resistors, len(seeds)), 10 ** np.array(ratios), "o", label="ours")
        axes.plot(resistors, np.ones(len(resistors)), label="published")
        axes.set(xscale="log", yscale="log", xlabel="series resistance (ohm)",
                 ylabel="structure over series resistance")

    picture(request.plot, draw)
    record(request, rows)


if __name__ == "__main__":
    main()
