#!/usr/bin/python3
"""Tabulates and draws the work of a charged gas and of LAMMPS on one core against the number of grains.

    gas_scaling.py [--program build/benchmark_gas] [--grains 1000,10000,...] [--accuracy 1e-4] [--lammps-up-to 100000]
                   [--device FIGURES.json] [--host FIGURES.json] [--json FILE] [--out PICTURE]
    gas_scaling.py --draw FILE --out PICTURE

Grains of charge +1 and -1 are at random positions with G's density, T = 1, and steps of .005 with all forces in each.
`benchmark_gas` runs once per number, to measure its peak memory. Times are processor milliseconds of one core. LAMMPS
runs as in gas_lammps.py at the cut-off --cutoff. FIGURES.json holds the times of a device, or with --host those of one
core of a larger machine, as {"device": its name, "rows": [{"grains": N, "forces": ms, "step": ms}, ...]}. The option
--draw draws the file written by --json.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import gas_lammps

INK, BLUE, SKY, ORANGE, GREEN = "#1a1a1a", "#0072b2", "#56b4e9", "#d55e00", "#009e73"
SMALL, LARGE = 30000, 1000000  # fewer grains get more steps, more get fewer


def steps_for(grains):
    return 50 if grains < SMALL else 10 if grains < LARGE else 3 if grains < 3 * LARGE else 1


def repeats_for(grains):
    return 3 if grains < 3 * LARGE else 2


def run_with_memory(command):
    """Returns the output and the peak resident size in MiB."""
    with tempfile.TemporaryFile("w+") as out:
        process = subprocess.Popen(command, stdout=out)
        _, status, usage = os.wait4(process.pid, 0)
        if status != 0:
            sys.exit(f"{command[0]} failed")
        out.seek(0)
        return out.read(), usage.ru_maxrss / 1024


def run_ours(arguments, grains):
    """Returns a row of processor times. The additional time of steps with charges is two evaluations of forces, because
    charges change between them."""
    command = [str(arguments.program), "--sizes", str(grains), "--accuracies", f"0,{arguments.accuracy:g}", "--sample", "0"]
    command += ["--steps", str(steps_for(grains)), "--repeats", str(repeats_for(grains))]
    text, memory = run_with_memory(command)
    lines = text.splitlines()
    title = next(k for k, line in enumerate(lines) if line.split()[:1] == ["grains"])
    names = lines[title].replace("set-up", "setup").split()
    neutral, charged = ([float(word) if word != "-" else 0 for word in line.split()] for line in lines[title + 1:title + 3])
    row, alone = dict(zip(names, charged)), dict(zip(names, neutral))["CPU"]
    forces = (row["CPU"] - alone) / 2
    return {"grains": grains, "forces": forces, "step": alone + forces, "contacts": alone, "setup": row["setup"],
            "MiB": memory}, lines[0]


def run_lammps(arguments, grains):
    """Returns the times of forces and steps. lichtenberg provides the positions, because LAMMPS cannot create them."""
    length = 70 * (grains / 50016)**(1 / 3)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        gas_lammps.run_ours(arguments.lichtenberg, folder, grains, length, 1e-2, 1)
        gas_lammps.write_data(folder / "data", gas_lammps.first_frame(folder), length)
        forces, step = (gas_lammps.milliseconds_a_step(
            lambda n: gas_lammps.run_lammps(folder, arguments.cutoff, arguments.accuracy, n, contacts), steps_for(grains), 1)
                        for contacts in (False, True))
    return {"grains": grains, "forces": forces, "step": step}


def print_head(machine):
    print(f"A charged gas; {machine}")
    columns = ["grains", "forces", "step", "contacts", "set-up (ms)", "MiB", "us a grain"]
    print(" ".join(f"{name:>12}" for name in columns) + "   LAMMPS: forces, step   device: forces, step")


def print_row(row, others):
    text = " ".join(f"{value:>12.4g}" for value in row.values()) + f" {1e3 * row['step'] / row['grains']:>12.3g}  "
    for rows in others:
        other = next((each for each in rows if each["grains"] == row["grains"]), None)
        text += f" {other['forces']:>10.4g} {other['step']:>10.4g}" if other else " " * 22
    print(text, flush=True)


def draw_lines(axes, rows, name, style, colour, label):
    known = [row for row in rows if row.get(name)]
    if known:
        axes.plot([row["grains"] for row in known], [row[name] for row in known], style, color=colour, markersize=4,
                  linewidth=1.2, label=label)


def draw(ours, lammps, device, host, title):
    plt.rcParams.update({"font.size": 8, "savefig.dpi": 160})
    figure, (time, memory) = plt.subplots(1, 2, figsize=(7.5, 4.2), layout="constrained", width_ratios=[1.6, 1])
    for rows, colour, name in ((ours, BLUE, "one core"), (host["rows"], SKY, host["device"]),
                               (lammps, ORANGE, "LAMMPS, one core"), (device["rows"], GREEN, device["device"])):
        draw_lines(time, rows, "step", "o-", colour, f"{name}: step")
        draw_lines(time, rows, "forces", "s--", colour, f"{name}: forces of charges")
    draw_lines(time, ours, "contacts", "^:", INK, "one core: step without charges")
    draw_lines(memory, ours, "MiB", "o-", BLUE, "largest resident size")
    draw_lines(memory, host["rows"], "MiB", "o-", SKY, host["device"])
    time.set(xscale="log", yscale="log", xlabel="grains", ylabel="ms")
    memory.set(xscale="log", yscale="log", xlabel="grains", ylabel="MiB")
    for axes in (time, memory):
        axes.grid(True, which="major", linewidth=0.3)
        axes.tick_params(which="minor", length=0)
        axes.legend(frameon=False, fontsize=7, loc="upper left", bbox_to_anchor=(0, -0.14), ncols=2 if axes is time else 1)
    figure.suptitle(title, fontsize=8)
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, default=Path("build/benchmark_gas"))
    parser.add_argument("--lichtenberg", type=Path, default=Path("build/lichtenberg"),
                        help="program that writes the positions for LAMMPS")
    parser.add_argument("--grains", default="1000,10000,100000,1000000", help="even numbers")
    parser.add_argument("--accuracy", type=float, default=1e-4, help="accuracy of the forces of both programs")
    parser.add_argument("--lammps-up-to", type=int, default=0, help="grains; 0: without LAMMPS")
    parser.add_argument("--cutoff", type=float, default=6, help="of LAMMPS")
    parser.add_argument("--device", type=Path, help="figures of a device")
    parser.add_argument("--host", type=Path, help="figures of one core of another machine")
    parser.add_argument("--draw", type=Path, help="figures that were written before: nothing is measured")
    parser.add_argument("--json", type=Path, help="file to write all figures to")
    parser.add_argument("--out", type=Path, help="picture to write")
    arguments = parser.parse_args()
    if arguments.draw:
        found = json.loads(arguments.draw.read_text())
        title = f"A charged gas at an accuracy of {arguments.accuracy:g}; {found['machine']}"
        draw(found["ours"], found["lammps"], found["device"], found["host"], title).savefig(arguments.out)
        return
    arguments.program, arguments.lichtenberg = arguments.program.resolve(), arguments.lichtenberg.resolve()
    device, host = (json.loads(path.read_text()) if path else {"device": "", "rows": []}
                    for path in (arguments.device, arguments.host))
    ours, lammps, machine = [], [], ""
    for grains in map(int, arguments.grains.split(",")):
        row, machine = run_ours(arguments, grains)
        ours.append(row)
        if grains <= arguments.lammps_up_to:
            lammps.append(run_lammps(arguments, grains))
        if len(ours) == 1:
            print_head(machine)
        print_row(row, (lammps, device["rows"]))
        if arguments.json:
            arguments.json.write_text(json.dumps({"machine": machine, "ours": ours, "lammps": lammps, "device": device,
                                                  "host": host}, indent=1))
    title = f"A charged gas at an accuracy of {arguments.accuracy:g}; {machine}"
    if arguments.out:
        draw(ours, lammps, device, host, title).savefig(arguments.out)


if __name__ == "__main__":
    main()
