#!/usr/bin/python3
"""Times whole steps of a charged gas by `lichtenberg run` and by LAMMPS (Debian's package `lammps`) on one core.

    gas_lammps.py [--program build/lichtenberg] [--grains 8516,50016] [--accuracy 1e-4] [--steps 100] [--every 10]
    gas_lammps.py --contacts [--grains 8516,50016] [--steps 100] [--step .02]
    gas_lammps.py --contact-errors

Grains of charge +1 and -1 are at random positions in a periodic box with volume fraction .0763, T = 1, in viscoelastic
contact (E = 278.6, D = 27.7). All forces act in each step of .005. LAMMPS uses equal positions, velocities, charges and
contact law (gran/hertz/history without tangential or attractive forces: limit_damping), PPPM, and the fastest of
several cut-offs. Errors are rms errors of the charges' forces over the rms force, relative to forces with an accuracy
of 1e-8.

`--every 10`: charges' forces in each tenth contact step. lichtenberg keeps them constant over ten steps and then
corrects; LAMMPS applies impulses (run_style respa). Nothing is analysed during the steps, unlike in a run, which does
so ten times per frame. `--contacts`: without charges. Times are processor milliseconds per contact step.

The contact error is the largest error of restitution of isolated pairs that meet at v = 1, over phases of the step at
onset. It is printed with each time. `--contact-errors` prints it as a function of the step length, to find the `--step`
of lichtenberg that equals LAMMPS' .005.
"""
import argparse
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

ELASTIC, DISSIPATIVE, STEP = 278.6, 27.7, 0.005
CONTACT_STEPS = 29  # steps of STEP in the shortest contact, .147 at twice the largest speed of 5e4 grains


def contact_steps(step):
    """Returns the number of steps of this length in the shortest contact."""
    return round(CONTACT_STEPS * STEP / step)


PERIODIC = "\n".join(f'{side} = "periodic"' for side in ("left", "right", "bottom", "top", "front", "back"))


def gas_of(grains, length, coulomb, step, contact_steps):
    """Returns the common beginning of all scenes here; tables of grains and of charges' forces are texts. step None:
    the program's own choice."""
    return f"""[units]
[domain]
size = [{length}, {length}, {length}]
{PERIODIC}
{grains}
[effects.viscoelastic_contact]
stiffness = {ELASTIC}
damping = {DISSIPATIVE}
{coulomb}
[mechanics]
{f"step = {step}" if step else ""}
contact_substeps = {contact_steps}
threads = 1"""


def scene(grains, length, accuracy, steps, every=1, step=STEP):
    """Returns a scene for `steps` STEPs. Contact steps have the length `step`. If an accuracy is given, charges' forces
    act each `every` contact steps."""
    coulomb = f"[effects.coulomb]\ncoupling_constant = 1\naccuracy = {accuracy}" if accuracy else ""
    populations = "\n".join(f"[[population]]\ncount = {grains // 2}\ncharge = {q}\ntemperature = 1" for q in (1, -1))
    return gas_of(populations, length, coulomb, every * step if accuracy else None, contact_steps(step)) + f"""
[stop]
time = {steps * STEP}
[output]
every = {10 * steps * STEP}
picture = false
"""


def processor_seconds(command, folder):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, env={**os.environ, "OMP_NUM_THREADS": "1"})
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        sys.exit(f"{command[0]} failed: " + (done.stdout + done.stderr)[-500:])
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def milliseconds_a_step(seconds_of, steps, every):
    """Returns the milliseconds per step of a function of the number of steps, without set-up and the first steps."""
    return 1e3 * (seconds_of(steps + every) - seconds_of(every)) / steps


def run_ours(program, folder, grains, length, accuracy, steps, every=1, step=STEP):
    """Returns processor seconds."""
    (folder / "gas.toml").write_text(scene(grains, length, accuracy, steps, every, step))
    return processor_seconds([program, "run", "gas.toml", "--overwrite", "--quiet"], folder)


def first_frame(folder):
    names = ("position", "velocity", "charge", "coulomb_force")
    with h5py.File(folder / "gas.h5") as file:
        grain = file["particles/conductors"]
        return {name: grain[f"{name}/value"][0] for name in names if name in grain}


# Without limit_damping, forces become attractive before contacts end, and the restitution at v = 1, .33, changes by
# .08.
GRANULAR = f"gran/hertz/history {2 * ELASTIC} 0 {4 * DISSIPATIVE} 0 0 0 limit_damping"


def lammps_input(cutoff, accuracy, steps, contacts, every):
    """Returns the input of LAMMPS. cutoff None: without charges."""
    styles = [f"coul/long {cutoff}"] * (cutoff is not None) + [GRANULAR] * contacts
    coefficients = ["coul/long"] * (cutoff is not None) + ["gran/hertz/history"] * contacts
    overlay = len(styles) > 1
    lines = ["units lj", "atom_style hybrid sphere charge", "comm_modify vel yes", "read_data data",
             "pair_style " + ("hybrid/overlay " if overlay else "") + " ".join(styles)]
    lines += [f"pair_coeff * * {name if overlay else ''}" for name in coefficients]
    if cutoff is not None:
        lines += [f"kspace_style pppm {accuracy}"]
    if every > 1 and overlay:
        lines += [f"run_style respa 2 {every} hybrid 2 1 kspace 2", "neigh_modify delay 0"]
    outer = every if overlay else 1
    skin = 0.3 if cutoff is None else 0.5 if outer == 1 else 1  # the fastest grain flies .25 in ten steps
    return "\n".join(lines + [f"neighbor {skin} bin", "fix 1 all nve", f"timestep {outer * STEP}",
                              "dump 1 all custom 1000000 forces id fx fy fz",
                              "dump_modify 1 sort id format float %.15g", f"run {steps // outer}", ""])


def write_data(path, first, length):
    count = len(first["position"])
    charge = first.get("charge", np.zeros(count))
    mass_density = 6 / np.pi
    lines = ["gas", "", f"{count} atoms", "1 atom types"]
    lines += [f"0 {length} {axis}lo {axis}hi" for axis in "xyz"] + ["", "Atoms # hybrid", ""]
    lines += [f"{i + 1} 1 {x} {y} {z} 1.0 {mass_density} {q}"
              for i, ((x, y, z), q) in enumerate(zip(first["position"], charge))]
    lines += ["", "Velocities", ""]
    lines += [f"{i + 1} {x} {y} {z} 0 0 0" for i, (x, y, z) in enumerate(first["velocity"])]
    path.write_text("\n".join(lines) + "\n")


def run_lammps(folder, cutoff, accuracy, steps, contacts=True, every=1):
    """Returns processor seconds."""
    (folder / "in").write_text(lammps_input(cutoff, accuracy, steps, contacts, every))
    return processor_seconds(["lmp", "-in", "in", "-log", "none"], folder)


def forces_of_lammps(folder):
    rows = [line.split() for line in (folder / "forces").read_text().splitlines()[9:]]
    return np.array([[float(x) for x in row[1:4]] for row in rows if len(row) == 4])


PHASES, BOX = 36, 30  # pairs, with onsets at evenly spaced phases of a step; d0
GAP = 0.1


def pairs(step):
    """Returns positions and velocities of pairs that meet along x at v = 1, with different phases of a step."""
    grains = []
    for k in range(PHASES):
        y, z, distance = 2.5 + 5 * (k % 6), 2.5 + 5 * (k // 6), 1 + GAP + k / PHASES * step
        grains += [((BOX / 2 - distance / 2, y, z), (0.5, 0, 0)), ((BOX / 2 + distance / 2, y, z), (-0.5, 0, 0))]
    return grains


END_OF_PAIRS = 1.0  # the contacts are open again: gap, contact of .34


def restitutions_of_ours(program, folder, at, step):
    """Returns restitutions for contact steps of this length. At v = 1, four substeps of the shortest contact are
    longer."""
    conductors = "\n".join(f"[[conductor]]\nposition = {list(position)}\nvelocity = {list(velocity)}\nradius = 0.5"
                           for position, velocity in pairs(at))
    (folder / "pairs.toml").write_text(gas_of(conductors, BOX, "", step, 4) + f"""
[stop]
time = {END_OF_PAIRS}
[output]
every = {10 * END_OF_PAIRS}
picture = false
""")
    processor_seconds([program, "run", "pairs.toml", "--overwrite", "--quiet"], folder)
    with h5py.File(folder / "pairs.h5") as file:
        return -np.diff(file["particles/conductors/velocity/value"][-1][:, 0])[::2]


def restitutions_of_lammps(folder, step):
    positions, velocities = zip(*pairs(step))
    write_data(folder / "data", {"position": positions, "velocity": velocities}, BOX)
    (folder / "in").write_text("\n".join([
        "units lj", "atom_style hybrid sphere charge", "comm_modify vel yes", "read_data data", f"pair_style {GRANULAR}",
        "pair_coeff * *", "neighbor 0.3 bin", "fix 1 all nve", f"timestep {step}", f"run {round(END_OF_PAIRS / step)}",
        "write_dump all custom velocities id vx modify sort id format float %.15g", ""]))
    processor_seconds(["lmp", "-in", "in", "-log", "none"], folder)
    rows = [line.split() for line in (folder / "velocities").read_text().splitlines()[9:]]
    return -np.diff([float(vx) for _, vx in rows])[::2]


def contact_errors(program, folder, step, step_of_lammps=STEP):
    """Returns the largest errors of restitution of lichtenberg and LAMMPS, relative to steps of 1/400 of a contact."""
    exact = -restitutions_of_ours(program, folder, step, 8e-4).mean()
    return (np.abs(-restitutions_of_ours(program, folder, step, step) - exact).max(),
            np.abs(-restitutions_of_lammps(folder, step_of_lammps) - exact).max())


def show_contacts(program, step):
    """Prints the errors of the contacts of the comparison."""
    with tempfile.TemporaryDirectory() as name:
        ours, lammps = contact_errors(program, Path(name), step)
    print(f"contacts: lichtenberg {contact_steps(step)} steps of {step:g} in the shortest, restitution off by {ours:.1e}; "
          f"LAMMPS {CONTACT_STEPS} of {STEP:g}, {lammps:.1e}")


def show_contact_errors(program):
    print("error of restitution at v = 1, worst phase")
    with tempfile.TemporaryDirectory() as name:
        for step in (0.00125, 0.0025, 0.005, 0.01, 0.02, 0.03, 0.04):
            ours, lammps = contact_errors(program, Path(name), step, step)
            print(f"steps of {step:g}, {contact_steps(step)} in the shortest contact of a gas: lichtenberg {ours:.1e}, "
                  f"LAMMPS {lammps:.1e}")


def error(force, reference):
    return np.sqrt(((force - reference)**2).sum() / (reference**2).sum())


def compare(arguments, grains):
    length = 70 * (grains / 50016)**(1 / 3)
    every, steps = arguments.every, arguments.steps // arguments.every * arguments.every
    accuracy = None if arguments.contacts else arguments.accuracy
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        ours = lambda n: run_ours(arguments.program, folder, grains, length, accuracy, n, every, arguments.step)
        mine = milliseconds_a_step(ours, steps, every)
        first = first_frame(folder)
        write_data(folder / "data", first, length)
        if arguments.contacts:
            ms = milliseconds_a_step(lambda n: run_lammps(folder, None, None, n), steps, 1)
            print(f"{grains} grains, contacts alone: lichtenberg {mine:.2f} ms a step, LAMMPS {ms:.2f}: "
                  f"{ms / mine:.2f} times as long")
            return
        run_ours(arguments.program, folder, grains, length, 1e-8, 1)
        reference = first_frame(folder)["coulomb_force"]
        print(f"{grains} grains, charges every {every} steps: lichtenberg {mine:.2f} ms a step, "
              f"error {error(first['coulomb_force'], reference):.1e}")
        best = None
        for cutoff in arguments.cutoffs:
            run_lammps(folder, cutoff, accuracy, 0, contacts=False)
            wrong = error(forces_of_lammps(folder), reference)
            ms = milliseconds_a_step(lambda n: run_lammps(folder, cutoff, accuracy, n, every=every), steps, every)
            print(f"    LAMMPS, cut-off {cutoff}: {ms:.1f} ms a step, error {wrong:.1e}")
            best = min(best or ms, ms)
        print(f"    the fastest of these takes {best / mine:.1f} times as long")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default="build/lichtenberg", help="the built program")
    parser.add_argument("--grains", default="8516,50016", help="numbers of grains")
    parser.add_argument("--accuracy", type=float, default=1e-4, help="accuracy of the forces of both programs")
    parser.add_argument("--steps", type=int, default=100, help="timed, of contacts")
    parser.add_argument("--every", type=int, default=1, help="steps of contacts from one force of charges to the next")
    parser.add_argument("--contacts", action="store_true", help="without charges")
    parser.add_argument("--contact-errors", action="store_true", help="of both, by the length of the step; nothing is timed")
    parser.add_argument("--step", type=float, default=STEP,
                        help="of contacts, ours; times are still those of .005, LAMMPS' step")
    parser.add_argument("--cutoffs", type=lambda text: [float(x) for x in text.split(",")], default=[4, 5, 6, 7],
                        help="of LAMMPS")
    arguments = parser.parse_args()
    arguments.program = Path(arguments.program).resolve()
    if arguments.contact_errors:
        return show_contact_errors(arguments.program)
    show_contacts(arguments.program, arguments.step)
    for grains in arguments.grains.split(","):
        compare(arguments, int(grains))


if __name__ == "__main__":
    main()
