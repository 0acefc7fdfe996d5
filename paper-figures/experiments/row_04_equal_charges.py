#!/usr/bin/python3
"""Row 4: Scheffler and Wolf, Granular Matter 4, 103 (2002), cooling of grains with equal charges.

Their dissipation rate is that of neutral grains times exp(-U_eff / T), with an effective barrier U_eff below the energy
U of two grains in contact. T falls as t^-2 down to the barrier, and then as 1 / ln t.
"""

import math
import tempfile
from pathlib import Path

import h5py
import numpy as np
from experiments import mean, open_experiment, periodic_box, picture, published, record, row, run

GRAINS, RESTITUTION = 343, 0.8
EXPECTED_HAFF = "Far above the barrier the gas cools as without charges: T ~ (1 + t/tau)^-2."
EXPECTED_BARRIER = ("The rate of cooling below T = U_eff / 2 gives the published effective barrier within its interval, "
                    "because neighbours take over a part of the energy that a pair needs.")
EXPECTED_EARLY = "The same barrier describes the rate at temperatures near U."
# Filling -> (end of the run, number of seeds). A thinner gas takes longer to cool below the barrier.
FILLINGS = {0.0763: (2000, 3), 0.15: (1000, 3)}

GAS = """
[[population]]
count = {grains}
temperature = {temperature}
charge = 1
[[equilibration]]
duration = 20
temperature = {temperature}
[effects.linear_contact]
stiffness = {stiffness}
restitution = {restitution}
[effects.coulomb]
coupling_constant = {barrier}
accuracy = 1e-3
[stop]
time = {end}
[output]
every = {every}
picture = false
"""


def temperatures(program, filling, temperature, barrier, end, seed, stiffness=1000):
    """Returns times (t0, from the end of the equilibration) and temperatures of a gas. Momentum is conserved at 0."""
    edge = (GRAINS * math.pi / (6 * filling)) ** (1 / 3)
    with tempfile.TemporaryDirectory() as folder:
        scene, result = Path(folder) / "gas.toml", Path(folder) / "gas.h5"
        scene.write_text(periodic_box(edge) + GAS.format(
            grains=GRAINS, temperature=temperature, barrier=barrier, end=20 + end, stiffness=stiffness,
            restitution=RESTITUTION, every=min(10, end / 40)))
        run(program, "run", scene, "--quiet", "--set", f"seed={seed}", "--out", result)
        with h5py.File(result) as file:
            energy = file["observables/kinetic_energy"]
            time, found = energy["time"][()] - 20, 2 * energy["value"][()] / (3 * (GRAINS - 1))
    return time[time >= 0], found[time >= 0]


def rate(filling):
    """Returns the constant a of dT/dt = -2 a T^(3/2) of a neutral gas (Haff 1983, contact value of Carnahan 1969)."""
    density, contact = filling * 6 / math.pi, (1 - filling / 2) / (1 - filling) ** 3
    return 2 / 3 * math.sqrt(math.pi) * (1 - RESTITUTION**2) * density * contact


def effective_barrier(time, found, first, last, filling):
    """Returns U_eff of dT/dt = -2 a T^(3/2) exp(-U_eff/T) between two temperatures, by bisection of its integral."""
    here, there = (int(np.argmax(found < bound)) if bound > 0 else len(found) - 1 for bound in (first, last))
    log_t = np.linspace(math.log(found[there]), math.log(found[here]), 401)
    wanted = 2 * rate(filling) * (time[there] - time[here])
    low, high = 0.0, 20 * first
    while high - low > 1e-12:
        middle = (low + high) / 2
        values = np.exp(middle / np.exp(log_t) - log_t / 2)
        integral = float(((values[1:] + values[:-1]) / 2 * np.diff(log_t)).sum())
        low, high = (middle, high) if integral < wanted else (low, middle)
    return (low + high) / 2


def published_ratio(filling):
    """Returns U_eff / U with its interval: 1 - c_0 phi^(1/3) + c_1 phi^(2/3), c_0 = 2.40 +- 0.15, c_1 = 1.44 +- 0.15."""
    x = filling ** (1 / 3)
    value, half = 1 - 2.40 * x + 1.44 * x**2, math.hypot(0.15 * x, 0.15 * x**2)
    return published(value, value - half, value + half, "M")


def haff_exponent(program, seeds):
    """Returns the exponents of T by 1 + t/tau from T = 0.7 to 0.1, ten times a barrier of 0.01, of several runs."""
    exponents = []
    for seed in seeds:
        time, found = temperatures(program, 0.0763, 1, 0.01, 30, seed, stiffness=1e4)
        chosen = (found < 0.7) & (found > 0.1)
        exponents.append(np.polyfit(np.log(1 + rate(0.0763) * time[chosen]), np.log(found[chosen]), 1)[0])
    return exponents


def main():
    request = open_experiment(4, "Scheffler, Wolf 2002", __doc__)
    rows = [row("exponent of T by 1 + t/tau at T from 70 to 10 times U (interval assumed)", EXPECTED_HAFF, published(-2, -2.1, -1.9, "A"),
                mean(haff_exponent(request.program, range(1, 3 if request.quick else 5))))]
    curves, barrier = [], 0.1
    for filling, (end, seeds) in {} if request.quick else FILLINGS.items():
        late, early = [], []
        for seed in range(1, seeds + 1):
            time, found = temperatures(request.program, filling, barrier, barrier, end, seed)
            expected = published_ratio(filling)["value"] * barrier
            late.append(effective_barrier(time, found, expected / 2, 0, filling) / barrier)
            early.append(effective_barrier(time, found, 0.7 * barrier, 0.3 * barrier, filling) / barrier)
        curves.append((filling, time, found))
        rows.append(row(f"U_eff / U at filling {filling} below T = U_eff / 2", EXPECTED_BARRIER, published_ratio(filling),
                        mean(late)))
        if filling == 0.0763:
            rows.append(row(f"U_eff / U at filling {filling} from T = 0.7 to 0.3 U", EXPECTED_EARLY,
                            published_ratio(filling), mean(early),
                            "At T near U charges are weakly correlated: neighbours screen a pair less. The only change "
                            "against the row above is the range of temperatures, so that strong correlation decides."))

    def draw(axes):
        for filling, time, found in curves:
            axes.plot(time, found, label=f"filling {filling}")
        axes.set(xscale="log", yscale="log", xlabel="time (t0)", ylabel="temperature (m0 v0^2)")

    picture(request.plot, draw)
    record(request, rows)


if __name__ == "__main__":
    main()
