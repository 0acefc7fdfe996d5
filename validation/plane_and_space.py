#!/usr/bin/python3
"""Compares runs in two and three dimensions.

For each seed there is a small dendrite of disks in a plane and one of spheres in a dish. The charge shuttle in two and
in three dimensions is compared with theory. Uses the command line; prints two tables.

  plane_and_space.py build/lichtenberg [--seeds 3] [--count 40] [--folder FOLDER]
"""

import argparse
import json
import math
import re
import subprocess
import tempfile
from pathlib import Path

import h5py
import numpy as np

RADIUS, PERMITTIVITY, VISCOSITY = 0.775e-3, 4.7 * 8.8541878128e-12, 0.7
SCENES = Path(__file__).resolve().parent.parent / "scenes"


def dendrite(count, in_space):
    """Returns scenes/dendrite-3d.toml with fewer spheres in a dish of equal density. The plane has disks and an
    electrode at the projected positions of the dish's spheres and electrode."""
    size = 5.12e-2 * math.sqrt(count / 324)
    text = (SCENES / "dendrite-3d.toml").read_text()
    for old, new in [("5.12e-2", f"{size:.6g}"), ("2.56e-2", f"{size / 2:.6g}"), ("count = 324", f"count = {count}")]:
        text = text.replace(old, new)
    text = text.replace("hysteresis = 0.2 ", "hysteresis = 0.05 ")  # as in scenes/dendrite.toml
    text = text.replace("[output]", "[output]\npicture = false")
    if in_space:
        return text
    for old, new in [(r", 5e-3\]", "]"), (r'shape = "sphere"\nposition = \[(.*), 2.1e-3\]', r'shape = "disk"\ncentre = [\1]'),
                     (r"region = \[\[0.0, 0.0, .*", "") , (r"\[mechanics\]\nkeep_height = true\n", ""),
                     (r"accuracy = 1e-3.*", "cells = 192")]:
        text, found = re.subn(old, new, text)
        assert found == 1, old
    return text


def shuttle(in_space):
    text = (SCENES / ("shuttle-3d.toml" if in_space else "shuttle.toml")).read_text()
    return re.sub(r"(?m)^every = .*", "every = 0.002", text).replace("[output]", "[output]\npicture = false")


def run(program, folder, name, text, *more):
    scene, result = folder / f"{name}.toml", folder / f"{name}.h5"
    scene.write_text(text)
    if not result.exists():
        subprocess.run([program, "run", scene, "--out", result, *more], check=True, capture_output=True)
    return result


def dendrite_quantities(program, result):
    """Returns the table's values of a run. These are the values of its last frame, and the largest and the mean potential
    after a second (or at the end of a shorter run). The last value is the fraction of edges of the spanning tree of
    conductors and ground that are contacts."""
    said = subprocess.run([program, "analyse", result, "--json"], check=True, capture_output=True, text=True)
    last = json.loads(said.stdout)["frames"][-1]
    with h5py.File(result) as file:
        group = file["particles/conductors/potential"]
        time, potential = group["time"][:], np.abs(group["value"][:])
    degrees = list(last["degree_fraction"]) + [0] * 5
    return {"connected": last["connected"], "complete after (s)": last["time"], "loops": last["loops"],
            "endpoints": last["endpoint_fraction"], "branch points": last["branch_fraction"],
            "f_1": degrees[1], "f_2": degrees[2], "f_3": degrees[3], "f_4": degrees[4],
            "edge (radii)": float(np.mean(last["edge_length_in_radii"])),
            "spanning tree's edges": last["emst_shared_edges"] / potential.shape[1],
            "mean potential at 1 s (V)": float(potential[min(np.searchsorted(time, 1 - 1e-9), len(time) - 1)].mean()),
            "largest potential (V)": float(potential.max())}


def shuttle_quantities(result):
    """Returns charge per crossing (C), its time (s) and the current (A), without the first two crossings, in which
    inertia settles."""
    with h5py.File(result) as file:
        group = file["particles/conductors/charge"]
        charge, time = group["value"][:, 0], group["time"][:]
    turned = np.flatnonzero(np.diff(np.sign(charge)) != 0)[2:]
    crossing = (time[turned[-1]] - time[turned[0]]) / (len(turned) - 1)
    amount = np.median(np.abs(charge))
    return amount, crossing, amount / crossing


def shuttle_table(program, folder):
    gap, distance, voltage = 10e-3, 1.155e-2, 18e3
    charge = 2 / 3 * np.pi**3 * PERMITTIVITY * RADIUS**2 * voltage / distance
    time = gap * 6 * np.pi * VISCOSITY * RADIUS / (charge * voltage / distance)
    rows = [(name, *shuttle_quantities(run(program, folder, f"shuttle-{name}", shuttle(name == "sphere"))))
            for name in ("disk", "sphere")] + [("sphere, theory", charge, time, charge / time)]
    print(f"{'shuttle':<16}{'charge (C)':>12}{'crossing (s)':>14}{'current (A)':>13}{'R_E (Ohm)':>12}")
    for name, *values in rows:
        print(f"{name:<16}{values[0]:>12.4g}{values[1]:>14.4g}{values[2]:>13.4g}{voltage / values[2]:>12.4g}")


def dendrite_table(program, folder, seeds, count):
    found = {True: [], False: []}
    for seed in range(1, seeds + 1):
        for in_space, rows in found.items():
            name = f"dendrite-{'dish' if in_space else 'plane'}-{count}-{seed}"
            rows.append(dendrite_quantities(program, run(program, folder, name, dendrite(count, in_space), "--set", f"seed={seed}")))
    print(f"\n{'dendrite':<30}{'plane':>24}{'dish':>24}")
    for key in found[True][0]:
        cells = []
        for in_space in (False, True):
            values = np.array([row[key] for row in found[in_space]])
            error = values.std(ddof=1) / math.sqrt(seeds) if seeds > 1 else math.nan
            cells.append(f"{values.mean():.4g} +- {error:.2g}")
        print(f"{key:<30}{cells[0]:>24}{cells[1]:>24}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--folder", help="keeps the runs there, and does not repeat those that it has")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(chosen.folder or scratch)
        folder.mkdir(parents=True, exist_ok=True)
        shuttle_table(chosen.program, folder)
        dendrite_table(chosen.program, folder, chosen.seeds, chosen.count)


if __name__ == "__main__":
    main()
