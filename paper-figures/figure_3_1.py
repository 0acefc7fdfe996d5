#!/usr/bin/python3
"""Figure 3.1's kind: resistance of a growing structure against time, for four series resistances.

The source shows an experiment with nanotubes in toluene, whose structure's resistance R_f tends to the series resistance R_s,
the value at which the structure takes up the most power from a supply behind R_s (D 3.2.2). Here spheres in castor oil
(scenes/wire-growth.toml) do the growing. Runs `lichtenberg run` four times.
"""

import tempfile
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np

from figures import SOURCE, claim, kept_run, request, save, save_claims

RESISTANCES = [1e10, 1e11, 1e12, 1e13]  # ohm, in series
SCENE = SOURCE / "scenes" / "wire-growth.toml"
SOUND = 0.01  # of the supplied energy: runs whose energy is off by more are shown hollow and are in no claim
WINDOW = 10  # frames that a resistance is averaged over: shuttling conductors carry charge in portions


def simulate(asked, resistance):
    """Time of the frames (s), charge that each supply has delivered (C), their potentials (V) behind that resistance, and
    the energy that is left over in its balance as a fraction of what was supplied."""
    lines = [f"series_resistance = {resistance:g}" if line.startswith("series_resistance") else line
             for line in SCENE.read_text().splitlines()]
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "wire-growth.toml"
        scene.write_text("\n".join(lines).replace("[output]", "[output]\npicture = false"))
        result = kept_run(asked.program, scene, asked.results / f"wire-growth-{resistance:.0e}.h5")
    with h5py.File(result) as file:
        observables = file["observables"]
        return (observables["energy/time"][:], observables["charge_delivered/value"][:],
                [file[f"scene/electrodes/{k}/potential"][()] for k in range(2)], energy_left_over(observables))


def energy_left_over(observables):
    supplied = observables["energy_by_supplies/value"][:]
    stored_and_lost = sum(observables[name]["value"][:] for name in observables
                          if name in ("energy", "energy_kinetic", "energy_elastic") or name.startswith("heat_"))
    balance = stored_and_lost - supplied
    return np.abs(balance - balance[0]).max() / supplied[-1]


def structure_resistance(time, delivered, potential, series):
    """Middle of each window (s) and the resistance (ohm) of what is between the electrodes, of the means over it."""
    span = time[WINDOW:] - time[:-WINDOW]
    flow = (delivered[WINDOW:] - delivered[:-WINDOW]) / span[:, None]  # A, by each supply
    voltage = potential[0] - series * flow[:, 0] - potential[1]
    return 0.5 * (time[WINDOW:] + time[:-WINDOW]), voltage / (0.5 * (flow[:, 0] - flow[:, 1]))


def main():
    asked = request(__doc__.splitlines()[0])
    figure, (against_time, final) = plt.subplots(1, 2, figsize=(10, 4.2))
    ends, sound = [], []
    for k, series in enumerate(RESISTANCES):
        time, delivered, potential, left_over = simulate(asked, series)
        sound.append(left_over < SOUND)
        middle, resistance = structure_resistance(time, delivered, potential, series)
        shown = np.where(resistance > 0, resistance, np.nan)
        against_time.semilogy(middle, shown, color=f"C{k}", label=f"$R_s$ = {series:.0e} $\\Omega$")
        against_time.axhline(series, color=f"C{k}", linestyle=":", linewidth=1)
        last = resistance[-len(resistance) // 4:]
        ends.append(np.median(last))
        final.loglog(series, ends[-1], "o", color=f"C{k}", fillstyle="full" if sound[-1] else "none")
        final.loglog([series, series], np.percentile(last, [10, 90]).clip(1), color=f"C{k}")
        print(f"R_s = {series:.0e} ohm: R_f = {ends[-1]:.3g} ohm in the last quarter, R_f / R_s = "
              f"{ends[-1] / series:.3g}; energy left over {left_over:.1g} of the supplied")
    line = [RESISTANCES[0] / 3, RESISTANCES[-1] * 3]
    final.loglog(line, line, color="tab:blue", label="$R_f = R_s$: the structure takes up most power")
    against_time.set(xlabel="$t$ (s)", ylabel=r"$R_f$ ($\Omega$)")
    against_time.legend(fontsize=8, ncol=2, loc="lower center", bbox_to_anchor=(0.5, 1))
    final.set(xlabel=r"$R_s$ ($\Omega$)", ylabel=r"$R_f$ in the last quarter ($\Omega$)")
    final.legend(fontsize=8, loc="lower center", bbox_to_anchor=(0.5, 1))
    save(figure, "figure_3_1")
    behind, found = np.array(RESISTANCES)[sound], np.array(ends)[sound]
    ratio = found / behind
    exponent = np.polyfit(np.log(behind), np.log(found), 1)[0]
    save_claims("figure_3_1", [
        claim(f"resistance R_f of a structure grown behind R_s, over R_s, from {behind[0]:.0e} to "
              f"{behind[-1]:.0e} ohm", "D 3.2.2, figure 3.1",
              "1: R_f tends to R_s", f"{ratio.min():.2g} to {ratio.max():.2g}",
              "agrees" if 1 / 3 < ratio.min() and ratio.max() < 3 else "differs (one seed)"),
        claim("exponent of R_f as a power of R_s", "D 3.2.2, figure 3.1", "1", f"{exponent:.2f}",
              "undecided (three runs of one seed, still falling)")])


if __name__ == "__main__":
    main()
