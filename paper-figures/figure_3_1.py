#!/usr/bin/python3
"""Figure 3.1, analogue: resistance of a growing structure against time, for four series resistances.

The source shows an experiment with nanotubes in toluene. The resistance R_f of its structure tends to the series
resistance R_s, at which the structure takes the most power from a source behind R_s (D 3.2.2). Here spheres in castor
oil grow (scenes/wire-growth.toml). Runs `lichtenberg run` four times.

Runs with an energy error above the bound for their steps and grid (analysis/circuit.hpp; `lichtenberg run` warns about
them) have hollow symbols and enter no claim. The uncertainty of a resistance is its variation over the last quarter of a
run, from the 10th to the 90th percentile (the bars in the figure). R_f agrees with R_s if R_s is in this interval in
every valid run.
"""

import sys
import tempfile
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np

from ensembles import student_factor
from figures import SOURCE, claim, kept_run, request, save, save_claims

RESISTANCES = [1e10, 1e11, 1e12, 1e13]  # ohm, in series
SCENE = SOURCE / "scenes" / "wire-growth.toml"
WINDOW = 10  # frames per average of a resistance; shuttling conductors transfer charge in portions


def simulate(arguments, resistance):
    """Runs the scene with this series resistance (ohm). Returns the times of the frames (s), the charge delivered by each
    source (C) and their potentials (V) behind the resistance. Also returns the final energy error and its bound as
    fractions of the supplied energy."""
    lines = [f"series_resistance = {resistance:g}" if line.startswith("series_resistance") else line
             for line in SCENE.read_text().splitlines()]
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "wire-growth.toml"
        scene.write_text("\n".join(lines).replace("[output]", "[output]\npicture = false"))
        result = kept_run(arguments.program, scene, arguments.results / f"wire-growth-{resistance:.0e}.h5")
    with h5py.File(result) as file:
        if "summary/allowed_energy_imbalance" not in file:
            sys.exit(f"{result} is of an earlier version, which did not say how far its energy is off: remove it")
        return (file["observables/energy/time"][:], file["observables/charge_delivered/value"][:],
                [file[f"scene/electrodes/{k}/potential"][()] for k in range(2)],
                abs(file["summary/relative_energy_imbalance"][()]), file["summary/allowed_energy_imbalance"][()])


def structure_resistance(time, delivered, potential, series):
    """Returns the middle of each window (s) and the mean resistance (ohm) between the electrodes in it."""
    span = time[WINDOW:] - time[:-WINDOW]
    flow = (delivered[WINDOW:] - delivered[:-WINDOW]) / span[:, None]  # A, by each supply
    voltage = potential[0] - series * flow[:, 0] - potential[1]
    return 0.5 * (time[WINDOW:] + time[:-WINDOW]), voltage / (0.5 * (flow[:, 0] - flow[:, 1]))


def power_law(x, y):
    """Returns the exponent of y as a power of x with the half width of its 95 % interval, from the scatter about the
    law."""
    x, y = np.log(x) - np.log(x).mean(), np.log(y) - np.log(y).mean()
    exponent, freedom = x @ y / (x @ x), len(x) - 2
    if freedom == 0:
        return exponent, np.inf
    return exponent, student_factor(freedom) * np.sqrt(np.sum((y - exponent * x) ** 2) / freedom / (x @ x))


def claims(series, end, low, high):
    """Returns claims of the valid runs. Arguments: R_s, the median of R_f in the last quarter, and its percentiles
    there (ohm)."""
    if len(series) < 2:
        return []
    exponent, half_width = power_law(series, end)
    ratio = end / series
    agrees = np.all((low <= series) & (series <= high))
    return [claim(f"resistance R_f of a structure grown behind R_s, over R_s, from {series[0]:.0e} to "
                  f"{series[-1]:.0e} ohm", "D 3.2.2, figure 3.1", "1: R_f tends to R_s",
                  f"{ratio.min():.2g} to {ratio.max():.2g}",
                  "agrees within the scatter in time" if agrees else "differs",
                  note="one seed, and still falling: nothing in the model stops R_f at R_s"),
            claim("exponent of R_f as a power of R_s", "D 3.2.2, figure 3.1", 1, (exponent, half_width),
                  note="the interval is the scatter about the power law")]


def main():
    arguments = request(__doc__.splitlines()[0])
    figure, (against_time, final) = plt.subplots(1, 2, figsize=(10, 4.2))
    ends, lows, highs, sound = [], [], [], []
    for k, series in enumerate(RESISTANCES):
        time, delivered, potential, off, allowed = simulate(arguments, series)
        sound.append(off <= allowed)
        middle, resistance = structure_resistance(time, delivered, potential, series)
        shown = np.where(resistance > 0, resistance, np.nan)
        against_time.semilogy(middle, shown, color=f"C{k}", label=f"$R_s$ = {series:.0e} $\\Omega$")
        against_time.axhline(series, color=f"C{k}", linestyle=":", linewidth=1)
        last = resistance[-len(resistance) // 4:]
        for percentile, values in ((10, lows), (50, ends), (90, highs)):
            values.append(np.percentile(last, percentile))
        final.loglog(series, ends[-1], "o", color=f"C{k}", fillstyle="full" if sound[-1] else "none")
        final.loglog([series, series], [max(lows[-1], 1), highs[-1]], color=f"C{k}")
        print(f"R_s = {series:.0e} ohm: R_f = {ends[-1]:.3g} ohm in the last quarter, R_f / R_s = "
              f"{ends[-1] / series:.3g}; energy off by {100 * off:.2g} % where {100 * allowed:.2g} % are accounted for")
    line = [RESISTANCES[0] / 3, RESISTANCES[-1] * 3]
    final.loglog(line, line, color="tab:blue", label="$R_f = R_s$: the structure takes up most power")
    against_time.set(xlabel="$t$ (s)", ylabel=r"$R_f$ ($\Omega$)")
    against_time.legend(fontsize=8, ncol=2, loc="lower center", bbox_to_anchor=(0.5, 1))
    if not all(sound):
        final.plot([], [], "o", color="grey", fillstyle="none", label="energy out of balance")
    final.set(xlabel=r"$R_s$ ($\Omega$)", ylabel=r"$R_f$ in the last quarter ($\Omega$)")
    final.legend(fontsize=8, loc="lower center", bbox_to_anchor=(0.5, 1))
    save(figure, "figure_3_1")
    save_claims("figure_3_1", claims(*(np.array(values)[sound] for values in (RESISTANCES, ends, lows, highs))))


if __name__ == "__main__":
    main()
