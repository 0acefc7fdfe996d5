#!/usr/bin/python3
"""Row 13: Falcon, Castaing and Creyssels, Eur. Phys. J. B 38, 475 (2004), and Creyssels et al., Eur. Phys. J. E (2017),
metal spheres under load.

A chain of 21 steel spheres is pressed between plates with 10 to 320 N. Smooth clean spheres have Holm's constriction
resistance of Hertz's contact radius, R ~ F^(-1/3). A film on the surfaces adds its resistance over the contact's area,
R ~ F^(-2/3). A random packing of 750 spheres under a plate has contacts that close under load. The saturation of the
voltage at 0.4 V a contact, by heating and welding of the spots, is not in the model.
"""

import json
import tempfile
from pathlib import Path

import numpy as np
from experiments import bounds, mean, open_experiment, picture, published, record, row, run

HERE = Path(__file__).parent
SEEDS = 4  # of the packing
AREA = 64e-6  # m^2, of the plates
HERTZ = "Every contact has the force of the plates: -1/3 exactly, up to the tolerance of the pressure."
FILM = ("A film of 1e-8 Ohm m^2 resists 50 to 200 times more than the constriction, so that the exponent is near -2/3, "
        "beyond -1/3 of elastic and -1/2 of plastic smooth contacts.")
PACKING = ("After a first run with one seed, -0.34: forces share in proportion to the load, and a few more contacts close "
           "under it.")
THEORY = published(-1 / 3, -1 / 3, -1 / 3, "A")
BEYOND = published(None, None, -0.5, "A")  # "much larger than the ones expected either with elastic or plastic contact"
MATERIALS = {"clean": [], "film": ["--film-resistance", 1e-8]}


def resistances(program, result, options):
    """Returns forces (N) and resistances (Ohm) of the particle-centred network at each load."""
    loads = json.loads(run(program, "network", result, "--loads", "--model", "particle", *options, "--json"))["loads"]
    return (np.array([AREA * load["pressure"] for load in loads]),
            np.array([load["networks"][0]["resistance"] for load in loads]))


def exponent(force, resistance):
    """Returns the exponent of R(F), and the largest deviation of a local one plus the tolerance of the pressures."""
    slopes = np.diff(np.log(resistance)) / np.diff(np.log(force))
    fit = np.polyfit(np.log(force), np.log(resistance), 1)[0]
    return bounds(fit, np.abs(slopes - fit).max() + 1e-6, len(force))


def main():
    request = open_experiment(13, "Falcon et al. 2004; Creyssels et al. 2017", __doc__)
    with tempfile.TemporaryDirectory() as folder:
        result = Path(folder) / "chain.h5"
        run(request.program, "run", HERE / "chain_under_load.toml", "--quiet", "--out", result)
        curves = {name: resistances(request.program, result, options) for name, options in MATERIALS.items()}
        packings = []
        for seed in range(1, 3 if request.quick else SEEDS + 1):
            result = Path(folder) / f"packing-{seed}.h5"
            run(request.program, "run", HERE / "packing_under_load.toml", "--set", f"seed={seed}", "--quiet", "--out",
                result, *(["--set", "compression.pressure=[1e5, 2e5]"] if request.quick else []))
            packings.append(exponent(*resistances(request.program, result, []))["value"])
    found = {name: exponent(*curve) for name, curve in curves.items()}
    rows = [row("exponent of R(F) of clean smooth spheres against theory", HERTZ, THEORY,
                found["clean"]),
            row("exponent of R(p) of a packing of clean smooth spheres against theory of one contact", PACKING, THEORY,
                mean(packings), "contacts that close under load add paths"),
            row("exponent of R(F) of clean smooth spheres against the measured one (interval assumed)", HERTZ, BEYOND, found["clean"],
                "no film and no roughness, which the authors name as the cause"),
            row("exponent of R(F) of spheres with a film against the measured one (interval assumed)", FILM, BEYOND, found["film"])]

    def draw(axes):
        for name, (force, resistance) in curves.items():
            axes.loglog(force, resistance, "o-", label=f"{name}: {found[name]['value']:.3f}")
        axes.set(xlabel="force (N)", ylabel="resistance (Ω)")

    picture(request.plot, draw)
    record(request, rows)


if __name__ == "__main__":
    main()
