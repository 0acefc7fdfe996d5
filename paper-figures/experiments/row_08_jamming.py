#!/usr/bin/python3
"""Row 8: O'Hern, Silbert, Liu and Nagel, Phys. Rev. E 68, 011306 (2003), jamming of frictionless particles.

Random positions in a periodic box relax, and the box shrinks in steps of 0.001 of the packing fraction, with a
minimization after each. Where the pressure appears, a search with smaller steps finds the jammed packing. Then the box
shrinks to given packing fractions above jamming. Contacts are means without rattlers.
"""

import tempfile
from pathlib import Path

import h5py
import numpy as np
from experiments import mean, open_experiment, picture, published, record, row, run

FRACTION = ("The packing fraction at jamming is that of a fast quench, 0.84 of disks and 0.64 of spheres, and up to 0.01 "
            "below, because 1024 particles jam earlier than many.")
CONTACTS = "At jamming 2d contacts a particle, less 2(d - 1)/N for N particles with load."
EXPONENT = "The excess contacts grow with the square root of the excess packing fraction."
SYSTEMS = {"disks": (2, 6, published(0.84, 0.835, 0.845, "A"), published(4, 3.98, 4.02, "A"),
                     published(0.5, 0.47, 0.53, "M")),
           "spheres": (3, 4, published(0.64, 0.635, 0.645, "A"), published(6, 5.97, 6.03, "A"),
                       published(0.5, 0.47, 0.53, "M"))}


def jam(program, name, seed, count):
    """Returns packing fractions and contacts of the loads of one run. The first load is the jammed packing."""
    with tempfile.TemporaryDirectory() as folder:
        result = Path(folder) / "jamming.h5"
        settings = ["--set", f"seed={seed}"]
        if count:  # as many particles in the same packing fraction
            dimension = SYSTEMS[name][0]
            length = {"disks": 41e-3, "spheres": 9.9e-3}[name] * (count / 1024) ** (1 / dimension)
            settings += ["--set", f"domain.size=[{', '.join(dimension * [str(length)])}]",
                         "--set", f"population[0].count={count}"]
        run(program, "run", Path(__file__).with_name(f"jamming_{name}.toml"), *settings, "--quiet", "--out", result)
        with h5py.File(result) as file:
            return [file[f"observables/{column}/value"][1:] for column in ("packing_fraction", "backbone_coordination")]


def exponent(fraction, contacts):
    """Returns the slope of the logarithm of the excess contacts against that of the excess fraction."""
    excess, above = fraction[1:] - fraction[0], contacts[1:] - contacts[0]
    return np.polyfit(np.log(excess), np.log(above), 1)[0]


def main():
    request = open_experiment(8, "O'Hern et al. 2003", __doc__)
    rows, curves = [], []
    for name, (_, seeds, fraction, contacts, power) in SYSTEMS.items():
        runs = [jam(request.program, name, seed, 64 if request.quick else 0)
                for seed in range(1, 3 if request.quick else seeds + 1)]
        reason = "more than N = 1024 particles, or slower cooling, would jam later"
        rows.append(row(f"packing fraction at jamming, {name}", FRACTION, fraction, mean([f[0] for f, _ in runs]), reason))
        reason = "contacts with overlaps below 1e-9 diameters do not count"
        rows.append(row(f"contacts a particle at jamming, {name} (interval assumed)", CONTACTS, contacts, mean([z[0] for _, z in runs]),
                        reason))
        reason = "rearrangements under load, which open contacts, in samples of 1024 particles"
        rows.append(row(f"exponent of the excess contacts, {name}", EXPONENT, power,
                        mean([exponent(f, z) for f, z in runs]), reason))
        curves.append((name, np.mean([f - f[0] for f, _ in runs], 0), np.mean([z - z[0] for _, z in runs], 0)))

    def draw(axes):
        for name, excess, above in curves:
            axes.loglog(excess[1:], above[1:], "o-", label=name)
        axes.loglog(excess[1:], 3 * excess[1:] ** 0.5, "--", color="grey", label="power 1/2")
        axes.set(xlabel="excess packing fraction", ylabel="excess contacts a particle")

    picture(request.plot, draw)
    record(request, rows)


if __name__ == "__main__":
    main()
