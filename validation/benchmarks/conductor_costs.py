#!/usr/bin/python3
"""Measures the cost of runs of conductors by their number: events, field solves, predictions and the time of each.

    conductor_costs.py --conductors 324,1000,2500,5000 --time 0.05 --json costs.json --output conductor-costs.png

The scenes are scenes/large-dendrite.toml with other numbers of conductors at equal density (.23 of the area) and cells
of .1 mm. Each has three runs with one thread. The first takes nearly no simulated time and measures the start. The
second is short and without predictions; it gives the time of a field solve. The third lasts until --time. Its time
minus start and field solves is the time of the predictions, including contacts, motion and recording. Times are
processor times. Prints the table with the exponents of N and draws it to OUTPUT (.png, .pdf or .svg). The
option --device FIGURES.json adds the results of another run. The option --json FILE writes such a file, with
--run-with='--device cuda' for a device.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import matplotlib.ticker
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
SCENE = ROOT / "scenes" / "large-dendrite.toml"
CELLS = {324: 512, 1000: 896, 2500: 1408, 5000: 1984}  # per side; many factors of two
CELL = 1e-4  # m
COUNTERS = ("solves", "iterations", "predictions", "steps", "rejected_steps", "corrections", "taken_back", "made", "lost",
            "regroupings")


def read_request():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--conductors", default="324,1000,2500,5000")
    parser.add_argument("--time", type=float, default=0.05, help="s, end of the runs")
    parser.add_argument("--json", type=Path, help="where the figures go, by number of conductors")
    parser.add_argument("--device", type=Path, help="such a file of a device")
    parser.add_argument("--run-with", default="", help="more words for `lichtenberg run`")
    parser.add_argument("--output", type=Path, default=Path("conductor-costs.png"))
    parser.add_argument("--program", type=Path, default=ROOT / "build" / "lichtenberg")
    return parser.parse_args()


def cells_of(count):
    """Returns the cells per side: a multiple of 64 at the density of the others."""
    return CELLS.get(count) or 64 * max(2, round(28.2 * np.sqrt(count) / 64))


def run(request, folder, count, time, predictor=True):
    """Returns the counters of the run and `seconds`, its processor time."""
    cells = cells_of(count)
    side, out = cells * CELL, folder / f"{count}.h5"
    values = {"population[0].count": count, "domain.size": f"[{side}, {side}]", "electrode[0].at": side / 2,
              "field.cells": cells, "field.threads": 1, "stop.time": time, "output.picture": "false",
              "output.field": '"none"', "mechanics.predictor": str(predictor).lower()}
    words = [word for key, value in values.items() for word in ("--set", f"{key}={value}")]
    command = [request.program, "run", SCENE, "--quiet", "--overwrite", "--out", out, *words, *request.run_with.split()]
    before = os.times()
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    after = os.times()
    if done.returncode != 0:
        sys.exit(f"the run of {count} conductors failed: {done.stderr.strip()}")
    with h5py.File(out) as file:
        found = dict(zip(COUNTERS, map(int, file["checkpoint/integers/counters"][()])))
    found["seconds"] = after.children_user - before.children_user
    return found


def measure(request, count, folder):
    """Returns the counts of the run to --time without its start, and times in s."""
    start = run(request, folder, count, 1e-9)

    def beyond_start(time, predictor):
        return {key: value - start[key] for key, value in run(request, folder, count, time, predictor).items()}

    plain = beyond_start(request.time * min(1, 324 / count), False)
    whole = beyond_start(request.time, True)
    price = plain["seconds"] / plain["solves"]
    return {**whole, "cells": cells_of(count), "start": start["seconds"], "solve_price": price,
            "prediction_price": (whole["seconds"] - price * whole["solves"]) / whole["predictions"],
            "of_a_second": whole["seconds"] / request.time}


def print_table(figures):
    print("| N | S | contacts made, lost | groups changed | field solves, iterations, price (ms) | predictions, price (ms) | "
          "taken back | a second of it (s) |\n" + "|---" * 8 + "|")
    for count, f in figures.items():
        print(f"| {count} | {f['cells']} | {f['made']}, {f['lost']} | {f['regroupings']} | {f['solves']}, "
              f"{f['iterations'] / max(1, f['solves']):.1f}, {1e3 * f['solve_price']:.1f} | {f['predictions']}, "
              f"{1e3 * f['prediction_price']:.2f} | {f['taken_back']} of {f['taken_back'] + f['corrections']} | "
              f"{f['of_a_second']:.0f} |")


SERIES = (("regroupings", "changes of groups", "tab:green"), ("predictions", "predictions", "tab:red"),
          ("solves", "field solves", "tab:blue"))
PRICES = (("solve_price", "field solve", "tab:blue"), ("prediction_price", "prediction", "tab:red"))


def exponent(counts, values):
    return np.polyfit(np.log(counts), np.log(values), 1)[0] if len(counts) > 1 else np.nan


def draw_panel(axes, figures, device, series, scale):
    for key, label, colour in series:
        for data, style, where in ((figures, "o-", ""), (device, "s--", ", device")):
            points = [(count, scale * f[key]) for count, f in data.items() if f[key] > 0]
            if not points:
                continue
            counts, values = zip(*points)
            axes.loglog(counts, values, style, color=colour, markersize=4,
                        label=f"{label}{where}: $N^{{{exponent(counts, values):.1f}}}$")
    counts = list(figures)
    axes.set(xlabel="conductors")
    axes.set_xticks(counts, map(str, counts))
    axes.xaxis.set_minor_locator(matplotlib.ticker.NullLocator())
    axes.grid(alpha=0.2)
    axes.legend(frameon=False, fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.15), ncols=2)


def draw(request, figures, device):
    figure, (numbers, prices, whole) = plt.subplots(1, 3, figsize=(13, 4.3), layout="constrained")
    draw_panel(numbers, figures, device, SERIES, 1 / request.time)
    numbers.set(ylabel="a simulated second", title="how often")
    draw_panel(prices, figures, device, PRICES, 1e3)
    prices.set(ylabel="ms of processor time", title="price")
    counts = np.array(list(figures), dtype=float)
    first = next(iter(figures.values()))["of_a_second"]
    whole.loglog(counts, first * counts / counts[0], ":", color="grey", label="like N")
    draw_panel(whole, figures, device, (("of_a_second", "all", "black"),), 1)
    whole.set(ylabel="s of processor time", title="a simulated second")
    figure.savefig(request.output, dpi=130)


def main():
    request = read_request()
    figures = {}
    with tempfile.TemporaryDirectory() as folder:
        for count in map(int, request.conductors.split(",")):
            figures[count] = measure(request, count, Path(folder))
            print(f"{count}: {figures[count]}", file=sys.stderr, flush=True)
            if request.json:
                request.json.write_text(json.dumps(figures, indent=1))
    device = {int(count): f for count, f in json.loads(request.device.read_text()).items()} if request.device else {}
    print_table(figures)
    draw(request, figures, device)


if __name__ == "__main__":
    main()
