#!/usr/bin/python3
"""Row 13: Falcon, Castaing and Creyssels, Eur. Phys. J. B 38, 475 (2004), and Creyssels et al., Eur. Phys. J. E (2017),
metal spheres under load.

A chain of 21 steel spheres is pressed between plates with 10 to 320 N. Smooth clean spheres have Holm's constriction
resistance of Hertz's contact radius, R ~ F^(-1/3). A film on the surfaces adds its resistance over the contact's area,
R ~ F^(-2/3). A random packing of 750 spheres under a plate has contacts that close under load. The saturation of the
voltage at 0.4 V a contact, by heating and welding of the spots, is not in the model.
"""

import json
import re
import tempfile
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np
from experiments import Change, bounds, mean, open_experiment, picture, published, record, row, run, try_changes

HERE = Path(__file__).parent
SEEDS = 4  # of the packing
AREA = 64e-6  # m^2, of the plates
HERTZ = "Every contact has the force of the plates: -1/3 exactly, up to the tolerance of the pressure."
FILM = ("A film of 1e-8 Ohm m^2 resists 50 to 200 times more than the constriction, so that the exponent is near -2/3, "
        "beyond -1/3 of elastic and -1/2 of plastic smooth contacts.")
PACKING = ("After a first run with one seed, -0.34: forces share in proportion to the load, and a few more contacts close "
           "under it.")
LOADED = ("The exponent keeps its distance from -1/3 with another load and size. With the contacts of the first "
          "load alone it scatters around -1/3 too widely to decide.")
SURFACE = "A film or roughness decides, each alone. The authors name both."
THEORY = published(-1 / 3, -1 / 3, -1 / 3, "A")
BEYOND = published(None, None, -0.5, "A")  # "much larger than the ones expected either with elastic or plastic contact"
IN_PACKING = "exponent of R(p) of a packing of clean smooth spheres against theory of one contact"
CLEAN = "exponent of R(F) of clean smooth spheres against the measured one (interval assumed)"
STIFFNESS, MODULUS, RESISTIVITY = 131.6, 1.146e11, 7.2e-7  # of packing_under_load.toml
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


class Packing(NamedTuple):
    """Change of the packing: its settings, its first seed, and whether contacts are those of the first load."""

    settings: tuple = ()
    first: int = 1
    held: bool = False


class Chain(NamedTuple):
    """Change of the chain: options of the network, the number of spheres, and settings."""

    options: tuple = ()
    spheres: int = 21
    settings: tuple = ()


CHANGES = [
    Change("contacts", "those of the first load at all loads", "-0.335: only the shares of the force change", Packing(held=True)),
    Change("load", "1e5 to 1e6 Pa, not 1e4 to 1e5", "-0.35: more contacts close", Packing(("compression.pressure=[1e5, 3e5, 1e6]",))),
    Change("system size", "375 spheres in half the volume", "same", Packing((
        "population[0].count=375", "domain.size=[7.937e-3, 7.937e-3, 7.937e-3]"))),
    Change("walls", "periodic sides, no walls across", "same", Packing(tuple(
        f'domain.{side}="periodic"' for side in ("left", "right", "front", "back")))),
    Change("resolution", "net forces to 1e-11, not 1e-10", "same", Packing(("minimize.force_tolerance=1e-11",))),
    Change("seeds", "5 to 8", "same", Packing(first=5)),
    Change("film", "1e-8 Ohm m^2", "-0.66", Chain(("--film-resistance", 1e-8))),
    Change("film", "1e-10 Ohm m^2", "-0.50: as much as the constriction", Chain(("--film-resistance", 1e-10))),
    Change("roughness", "spots of 10 um, hardness 5e9 Pa", "-0.46", Chain((
        "--resistor", "greenwood", "--hardness", 5e9, "--spot-radius", 1e-5))),
    Change("load", "1 to 32 N, not 10 to 320", "same", Chain(settings=(
        "compression.pressure=[1.5625e4, 3.125e4, 6.25e4, 1.25e5, 2.5e5, 5e5]",))),
    Change("system size", "5 spheres, not 21", "same", Chain(spheres=5)),
    Change("resolution", "pressures to 1e-4, not 1e-6", "same", Chain(settings=("compression.tolerance=1e-4",))),
]


def words_of(settings):
    return [word for setting in settings for word in ("--set", setting)]


def hertz(radius, force):
    """Returns the radius of Hertz's contact."""
    return np.cbrt(0.75 * force * radius / MODULUS)


def held_resistances(result):
    """Returns pressures and resistances of a packing with the contacts of the first load only. Forces are those at each
    load. A contact that opens does not conduct."""
    with h5py.File(result) as file:
        radius = file["particles/conductors/radius"][()]
        frames = file["particles/conductors/position/value"][1:]
        height, pressure = (file[f"observables/{name}/value"][1:] for name in ("size_y", "pressure"))
    one, other = np.triu_indices(len(radius), 1)
    reach, reduced = radius[one] + radius[other], radius[one] * radius[other] / (radius[one] + radius[other])
    known, found = None, []
    for position, top in zip(frames, height):
        pair = 1 - np.linalg.norm(position[one] - position[other], axis=1) / reach
        walls = [1 - distance / radius for distance in (position[:, 1], top - position[:, 1])]
        known = known or [overlap > 1e-9 for overlap in (pair, *walls)]
        between, bottom, above = ((overlap * (overlap > 0) * kept) for overlap, kept in zip((pair, *walls), known))
        conductance = 2 / RESISTIVITY * hertz(reduced, STIFFNESS / reach * between**1.5)
        matrix = np.zeros((len(radius), len(radius)))
        np.add.at(matrix, (one, other), -conductance)
        matrix += matrix.T
        sides = [4 / RESISTIVITY * hertz(radius, STIFFNESS / radius * overlap**1.5) for overlap in (bottom, above)]
        matrix += np.diag(sides[0] + sides[1] - matrix.sum(axis=0) + 1e-12 * conductance.max())  # rattlers have no contact
        potential = np.linalg.solve(matrix, sides[1])
        found.append(1 / (sides[0] @ potential))
    return pressure, np.array(found)


def packing_exponent(program, seed, settings=(), held=False):
    """Returns the exponent of R(p) of a packing."""
    with tempfile.TemporaryDirectory() as folder:
        result = Path(folder) / "packing.h5"
        run(program, "run", HERE / "packing_under_load.toml", "--set", f"seed={seed}", "--quiet", "--out", result,
            *words_of(settings))
        return exponent(*(held_resistances(result) if held else resistances(program, result, [])))["value"]


def chain_curve(program, folder, options=(), spheres=21, settings=()):
    """Returns forces and resistances of the chain with a number of its spheres."""
    head, *parts = re.split(r"(?=\[\[conductor]])", (HERE / "chain_under_load.toml").read_text())
    scene, result = Path(folder) / "chain.toml", Path(folder) / "chain.h5"
    scene.write_text(head.replace("168e-3", f"{8 * spheres}e-3") + "".join(parts[:spheres]))
    if not result.exists():
        run(program, "run", scene, "--quiet", "--out", result, *words_of(settings))
    return resistances(program, result, options)


def changed(program, seeds, case):
    """Returns the exponent of the packing or of the chain with a change."""
    if isinstance(case, Packing):
        return {IN_PACKING: mean([packing_exponent(program, seed, case.settings, case.held)
                                  for seed in range(case.first, case.first + seeds)])}
    with tempfile.TemporaryDirectory() as folder:
        return {CLEAN: exponent(*chain_curve(program, folder, *case))}


def main():
    request = open_experiment(13, "Falcon et al. 2004; Creyssels et al. 2017", __doc__)
    seeds = 2 if request.quick else SEEDS
    if request.changes is not None:
        try_changes(request, CHANGES, lambda case: changed(request.program, seeds, case))
        return
    with tempfile.TemporaryDirectory() as folder:
        curves = {name: chain_curve(request.program, folder, options) for name, options in MATERIALS.items()}
    settings = ["compression.pressure=[1e5, 2e5]"] if request.quick else []
    packings = [packing_exponent(request.program, seed, settings) for seed in range(1, seeds + 1)]
    found = {name: exponent(*curve) for name, curve in curves.items()}
    rows = [row("exponent of R(F) of clean smooth spheres against theory", HERTZ, THEORY,
                found["clean"]),
            row(IN_PACKING, PACKING, THEORY,
                mean(packings), LOADED),
            row(CLEAN, HERTZ, BEYOND, found["clean"], SURFACE),
            row("exponent of R(F) of spheres with a film against the measured one (interval assumed)", FILM, BEYOND, found["film"])]

    def draw(axes):
        for name, (force, resistance) in curves.items():
            axes.loglog(force, resistance, "o-", label=f"{name}: {found[name]['value']:.3f}")
        axes.set(xlabel="force (N)", ylabel="resistance (Ω)")

    picture(request.plot, draw)
    record(request, rows)


if __name__ == "__main__":
    main()
