#!/usr/bin/python3
"""Whole steps of a charged gas by `lichtenberg run` and by LAMMPS (Debian's package `lammps`), on one core, in one run.

    gas_lammps.py [--program build/lichtenberg] [--grains 8516,50016] [--accuracy 1e-4] [--steps 100]

Grains of charge +1 and -1 at random places of a periodic box, volume fraction .0763, T = 1, in viscoelastic contact
(E = 278.6, D = 27.7); all forces in each step of .005. LAMMPS: the same places, velocities, charges and law of contact
(gran/hertz/history without tangential forces), PPPM, with the fastest of some cut-offs. Errors are rms errors of the charges'
forces over the rms force, against forces that are asked for to 1e-8.
"""
import argparse
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

ELASTIC, DISSIPATIVE, STEP = 278.6, 27.7, 0.005


def scene(grains, length, accuracy, steps):
    sides = "\n".join(f'{side} = "periodic"' for side in ("left", "right", "bottom", "top", "front", "back"))
    populations = "\n".join(f"[[population]]\ncount = {grains // 2}\ncharge = {q}\ntemperature = 1" for q in (1, -1))
    return f"""[reference]
[domain]
size = [{length}, {length}, {length}]
{sides}
{populations}
[effects.viscoelastic_contact]
elastic = {ELASTIC}
dissipative = {DISSIPATIVE}
[effects.coulomb]
strength = 1
accuracy = {accuracy}
[mechanics]
step = {STEP}
threads = 1
[stop]
time = {steps * STEP}
[output]
every = {steps * STEP}
picture = false
"""


def run_ours(program, folder, grains, length, accuracy, steps):
    """The first frame's places, velocities, charges and forces, and milliseconds a step by activity."""
    (folder / "gas.toml").write_text(scene(grains, length, accuracy, steps))
    subprocess.run([program, "run", "gas.toml", "--overwrite", "--quiet"], cwd=folder, check=True)
    with h5py.File(folder / "gas.h5") as file:
        grain = file["particles/conductors"]
        first = {name: grain[f"{name}/value"][0] for name in ("position", "velocity", "charge", "coulomb_force")}
        seconds = file["provenance/session-0/seconds"]
        spent = {name: 1e3 * seconds[name][()] / steps for name in ("contacts", "near", "mesh", "forces", "lists")}
    return first, spent


def lammps_input(cutoff, accuracy, steps, contacts):
    pairs = f"hybrid/overlay coul/long {cutoff} gran/hertz/history {2 * ELASTIC} 0 {4 * DISSIPATIVE} 0 0 0"
    return f"""units lj
atom_style hybrid sphere charge
comm_modify vel yes
read_data data
pair_style {pairs if contacts else f"coul/long {cutoff}"}
pair_coeff * * {"coul/long" if contacts else ""}
{"pair_coeff * * gran/hertz/history" if contacts else ""}
kspace_style pppm {accuracy}
neighbor 0.5 bin
fix 1 all nve
timestep {STEP}
dump 1 all custom 1000000 forces id fx fy fz
dump_modify 1 sort id format float %.15g
run {steps}
"""


def write_data(path, first, length):
    count = len(first["charge"])
    mass_density = 6 / np.pi
    lines = ["gas", "", f"{count} atoms", "1 atom types"]
    lines += [f"0 {length} {axis}lo {axis}hi" for axis in "xyz"] + ["", "Atoms # hybrid", ""]
    lines += [f"{i + 1} 1 {x} {y} {z} 1.0 {mass_density} {q}"
              for i, ((x, y, z), q) in enumerate(zip(first["position"], first["charge"]))]
    lines += ["", "Velocities", ""]
    lines += [f"{i + 1} {x} {y} {z} 0 0 0" for i, (x, y, z) in enumerate(first["velocity"])]
    path.write_text("\n".join(lines) + "\n")


def run_lammps(folder, cutoff, accuracy, steps, contacts):
    """Milliseconds a step."""
    (folder / "in").write_text(lammps_input(cutoff, accuracy, steps, contacts))
    done = subprocess.run(["lmp", "-in", "in", "-log", "none"], cwd=folder, capture_output=True, text=True,
                          env={"OMP_NUM_THREADS": "1", "PATH": "/usr/bin:/bin"})
    found = re.search(r"Loop time of (\S+) on", done.stdout)
    if not found:
        sys.exit("LAMMPS failed: " + (done.stdout + done.stderr)[-500:])
    return 1e3 * float(found[1]) / max(steps, 1)


def forces_of_lammps(folder):
    rows = [line.split() for line in (folder / "forces").read_text().splitlines()[9:]]
    return np.array([[float(x) for x in row[1:4]] for row in rows if len(row) == 4])


def error(force, reference):
    return np.sqrt(((force - reference)**2).sum() / (reference**2).sum())


def compare(arguments, grains):
    length = 70 * (grains / 50016)**(1 / 3)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        reference, _ = run_ours(arguments.program, folder, grains, length, 1e-8, 1)
        ours, spent = run_ours(arguments.program, folder, grains, length, arguments.accuracy, arguments.steps)
        parts = ", ".join(f"{what} {ms:.1f}" for what, ms in spent.items())
        mine = sum(spent.values())
        print(f"{grains} grains: lichtenberg {mine:.1f} ms a step ({parts}), "
              f"error {error(ours['coulomb_force'], reference['coulomb_force']):.1e}")
        write_data(folder / "data", reference, length)
        best = None
        for cutoff in (4, 5, 6, 7):
            run_lammps(folder, cutoff, arguments.accuracy, 0, contacts=False)
            wrong = error(forces_of_lammps(folder), reference["coulomb_force"])
            ms = run_lammps(folder, cutoff, arguments.accuracy, arguments.steps, contacts=True)
            print(f"    LAMMPS, cut-off {cutoff}: {ms:.1f} ms a step, error {wrong:.1e}")
            best = min(best or ms, ms)
        print(f"    the fastest of these takes {best / mine:.1f} times as long")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default="build/lichtenberg", help="the built program")
    parser.add_argument("--grains", default="8516,50016", help="numbers of grains")
    parser.add_argument("--accuracy", type=float, default=1e-4, help="asked of both")
    parser.add_argument("--steps", type=int, default=100, help="timed")
    arguments = parser.parse_args()
    arguments.program = Path(arguments.program).resolve()
    for grains in arguments.grains.split(","):
        compare(arguments, int(grains))


if __name__ == "__main__":
    main()
