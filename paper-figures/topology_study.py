#!/usr/bin/python3
"""Studies the topology: endpoints f1 and branch points B against all parameters that may change them.

Each point is an ensemble of seeds (`lichtenberg ensemble`) that differs from the base in one parameter. The base is
scenes/dendrite.toml with 100 conductors in a box of equal density and S = 128. The pieces `size`, `cells` and
`tolerance` measure the error of these choices. Results are in output/study, one folder per point. Finished runs are not
repeated, so the study can proceed in pieces with limited time:

    topology_study.py --list                    pieces and their points
    topology_study.py gap hysteresis            these pieces, to their end
    topology_study.py --minutes 30              all pieces for at most half an hour; a new call continues
    topology_study.py --minutes 0               no runs: table and figure of the present results

Prints the table, and writes it to output/topology_study.md and the figure to output/topology_study.pdf and .png.
"""

import argparse
import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import matplotlib.pyplot as plt

from figures import OUTPUT, SOURCE, save
from table import shown

STUDY = OUTPUT / "study"
RADIUS = 0.775e-3  # m
PUBLISHED = {"endpoint_fraction": 0.252, "branch_fraction": 0.237}
SYMBOL = {"endpoint_fraction": "$f_1$", "branch_fraction": "$B$"}


def box(conductors, cells):
    """Returns settings for `conductors` at the density of scenes/dendrite.toml, in a square with the ground at the
    middle of a side."""
    side = 2.844e-2 * (conductors / 100) ** 0.5
    return {"population.count": conductors, "domain.size": f"[{side:.5g}, {side:.5g}]",
            "electrode[0].at": f"{side / 2:.6g}", "field.cells": cells}


BASE = ("dendrite", box(100, 128))


def dendrite(**changes):
    """Returns the base with other values; in keys, two underscores mean a dot."""
    return "dendrite", BASE[1] | {key.replace("__", "."): value for key, value in changes.items()}


# Name: the varied parameter, and for each point its label, its scene and its settings for `--vary`.
PIECES = {
    "source": ("the source's set-up", {
        "N = 324, S = 512": ("dendrite", {}),
        "N = 324, S = 256": ("dendrite", {"field.cells": 256}),
    }),
    "cells": ("grid, S", {str(cells): dendrite(field__cells=cells) for cells in (128, 256, 512)}),
    "tolerance": ("position tolerance / R", {
        f"{factor:g}": dendrite(mechanics__position_tolerance=factor * RADIUS) for factor in (1e-2, 1e-3, 1e-4)}),
    "size": ("conductors N, same density", {
        str(n): ("dendrite", box(n, cells))
        for n, cells in ((36, 76), (64, 104), (100, 128), (144, 152), (196, 180))}),
    "density": ("conductors N, same box", {str(n): dendrite(population__count=n) for n in (50, 75, 100, 125, 150)}),
    "gap": ("contact gap / R", {
        f"{factor:g}": dendrite(effects__contact_discharge__contact_distance=factor * RADIUS) for factor in (0.25, 0.5, 1, 1.5)}),
    "hysteresis": ("hysteresis", {
        f"{value:g}": dendrite(effects__contact_discharge__hysteresis=value) for value in (0.005, 0.02, 0.05, 0.1, 0.2)}),
    "current": ("current (nA)", {
        f"{value:g}": dendrite(effects__current_injection__current=value * 1e-9) for value in (0.02, 0.2, 2)}),
    "electrode": ("ground", {
        "half-disk, 0.3 mm": ("dendrite", BASE[1] | {"electrode[0].radius": 0.3e-3}),
        "half-disk, 2 mm": BASE,
        "half-disk, 6 mm": ("dendrite", BASE[1] | {"electrode[0].radius": 6e-3}),
        "side": ("dendrite-side", {}),
        "ring": ("dish", {}),
    }),
}
# Other definitions of the degree, for the base and the source's set-up; see `lichtenberg ensemble`.
READINGS = {"": "D 7.2: contacts, the ground is one", "_without_ground": "the ground does not count",
            "_in_tree": "in the tree A, without loops", "_without_hysteresis": "gap < R only, as D 7.1"}


def folder_of(point):
    scene, settings = point
    if point == BASE:
        return STUDY / "base"
    other = {key: value for key, value in settings.items() if scene != BASE[0] or BASE[1].get(key) != value}
    words = [scene, *(f"{key.split('.')[-1]}-{value}" for key, value in other.items())]
    if other == settings and settings:
        words.append("alone")  # the settings differ from the scene itself, not from the base
    return STUDY / "_".join(word.replace("[", "").replace("]", "").replace(", ", "x") for word in words)


def fill(program, point, seeds, seconds):
    """Runs or continues a point's ensemble for the remaining time. Returns whether it is complete."""
    scene, settings = point
    vary = [word for key, value in settings.items() for word in ("--vary", f"{key}={value}")]
    command = [program, "ensemble", SOURCE / "scenes" / f"{scene}.toml", *vary, "--seeds", seeds, "--out",
               folder_of(point), "--quiet"]
    process = subprocess.Popen([str(word) for word in command], stdout=subprocess.DEVNULL)
    try:
        process.wait(seconds)
    except (subprocess.TimeoutExpired, KeyboardInterrupt) as reason:
        process.send_signal(signal.SIGINT)
        process.wait()
        if isinstance(reason, KeyboardInterrupt):
            sys.exit(130)
    return process.returncode == 0


def summary_of(point):
    """Returns means and intervals of a point if all its runs are finished, otherwise None."""
    path = folder_of(point) / "ensemble.json"
    if not path.exists():
        return None
    summary = json.loads(path.read_text())
    complete = all(member["state"] == "finished" for member in summary["members"])
    return summary["points"][0]["quantities"] if complete else None


def estimate(quantities, name):
    found = quantities[name]
    return [found["value"], found.get("half_width", float("nan"))]


def rows(pieces):
    """Returns (piece, label, quantities) of the complete points, and the labels of the others."""
    complete, incomplete = [], []
    for name in pieces:
        title, points = PIECES[name]
        for label, point in points.items():
            quantities = summary_of(point)
            if quantities:
                complete.append((title, label, quantities))
            else:
                incomplete.append(f"{title}: {label}")
    return complete, incomplete


def write_table(complete, incomplete):
    columns = {"connected_fraction": "M / N", "endpoint_fraction": "f1", "branch_fraction": "B", "loops": "loops",
               "strahler_fraction_1": "sigma_1 / M", "strahler_fraction_2": "sigma_2 / M",
               "strahler_fraction_3": "sigma_3 / M", "time": "time (s)", "field_solves": "field solves",
               "seconds": "wall time (s)"}
    lines = ["| varied | value | runs | " + " | ".join(columns.values()) + " |", "|---" * (len(columns) + 3) + "|"]
    for title, label, quantities in complete:
        cells = [shown(estimate(quantities, name)) for name in columns]
        lines.append(f"| {title} | {label} | {quantities['time']['sample']} | " + " | ".join(cells) + " |")
    lines += ["", "| set-up | degree | f1 | B |", "|---|---|---|---|"]
    for title, points in (("base", {"": BASE}), PIECES["source"]):
        for label, point in points.items():
            quantities = summary_of(point)
            for reading, words in READINGS.items() if quantities else ():
                cells = [shown(estimate(quantities, name + reading)) for name in PUBLISHED]
                lines.append(f"| {title} {label} | {words} | " + " | ".join(cells) + " |")
    if incomplete:
        lines += ["", "Not complete, and left out: " + "; ".join(incomplete) + "."]
    (OUTPUT / "topology_study.md").write_text("\n".join(lines) + "\n")
    print("\n".join(lines))


def draw(complete):
    """Draws a row per point with f1 and B and their intervals, and the published values and those of the base."""
    positions, ticks, row = [], [], 0.0
    for index, (title, label, _) in enumerate(complete):
        row += 1 if index and complete[index - 1][0] == title else 1.8
        positions.append(-row)
        ticks.append(f"{title} = {label}" if "=" not in label and " " not in label else f"{title}: {label}")
    figure, panels = plt.subplots(1, 2, sharey=True, figsize=(8.5, 1 + 0.24 * row), layout="constrained")
    base = summary_of(BASE)
    for axes, (name, published) in zip(panels, PUBLISHED.items()):
        axes.axvline(published, color="tab:blue", label=f"published, {published}")
        if base:
            value, half_width = estimate(base, name)
            axes.axvspan(value - half_width, value + half_width, color="tab:red", alpha=0.15, linewidth=0, label="base")
        values, half_widths = zip(*(estimate(quantities, name) for _, _, quantities in complete))
        axes.errorbar(values, positions, xerr=half_widths, linestyle="", marker="o", markersize=4, color="tab:red",
                      linewidth=1)
        axes.set_xlabel(SYMBOL[name] + ", mean and 95 % interval")
        axes.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1), ncols=2)
    panels[0].set_yticks(positions, ticks)
    save(figure, "topology_study")


def read_request():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pieces", nargs="*", metavar="PIECE", help="default: all")
    parser.add_argument("--list", action="store_true", help="name the pieces and their points")
    parser.add_argument("--seeds", type=int, default=16, help="runs of each point")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="stop after so long; the same goes on")
    parser.add_argument("--build", type=Path, default=SOURCE / "build", help="folder of the built programs")
    request = parser.parse_args()
    for piece in request.pieces:
        if piece not in PIECES:
            parser.error(f"there is no piece {piece}; there are {', '.join(PIECES)}")
    request.pieces = request.pieces or list(PIECES)
    return request


def main():
    request = read_request()
    if request.list:
        for name in request.pieces:
            print(f"{name:<12}{PIECES[name][0]}: {'; '.join(PIECES[name][1])}")
        return
    STUDY.mkdir(parents=True, exist_ok=True)
    end = time.monotonic() + 60 * request.minutes
    for name in request.pieces:
        for label, point in PIECES[name][1].items():
            left = end - time.monotonic()
            if left <= 0:
                break
            print(f"{name}: {label}", flush=True)
            if not fill(request.build.resolve() / "lichtenberg", point, request.seeds, min(left, 1e6)):
                print(f"{name}: {label} is not complete", flush=True)
    complete, incomplete = rows(request.pieces)
    if not complete:
        sys.exit("no point is complete: there is nothing to show")
    write_table(complete, incomplete)
    draw(complete)


if __name__ == "__main__":
    main()
