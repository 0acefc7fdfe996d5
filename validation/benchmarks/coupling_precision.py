#!/usr/bin/python3
"""Measures the cost of accurate motion at several position tolerances, with and without predictions.

    coupling_precision.py scenes/dendrite.toml --time 0.3 --tolerances 4e-3,1e-3,2.5e-4,1e-4 --reference 1e-5

Runs the beginning of a scene. Tolerances are in radii of the smallest conductor. The error of a run is the final
distance of conductors from their positions in the run without predictions at the reference tolerance: maximum and rms
over all conductors. The scene is otherwise unchanged, including its frames: each requires a field solve, and
output.every is the default of mechanics.largest_step. Times are wall times including recording, with field.threads = 0:
one thread per core, fewer on small grids. Prints the table and draws it to OUTPUT (.png, .pdf or .svg).
"""

import argparse
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

PROGRAM = Path(__file__).resolve().parents[2] / "build" / "lichtenberg"
SERIES = {False: ("field solves alone", "tab:blue"), True: ("with predictions", "tab:red")}


def read_request():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--time", type=float, required=True, help="s, end of the runs")
    parser.add_argument("--tolerances", default="4e-3,1e-3,2.5e-4,1e-4")
    parser.add_argument("--reference", type=float, default=1e-5)
    parser.add_argument("--output", type=Path, default=Path("coupling-precision.png"))
    parser.add_argument("--program", type=Path, default=PROGRAM)
    return parser.parse_args()


def run(request, folder, predictor, tolerance):
    """Returns final positions (m, [conductors, 3]), field solves, predictions and wall time (s)."""
    values = {"mechanics.predictor": str(predictor).lower(), "mechanics.position_tolerance": tolerance,
              "stop.time": request.time, "stop.stationary": "false",
              "field.threads": 0}  # a member of an ensemble has one thread otherwise
    vary = [word for key, value in values.items() for word in ("--vary", f"{key}={value}")]
    out = folder / f"{predictor}-{tolerance:g}"
    command = [request.program, "ensemble", request.scene, *vary, "--seeds", 1, "--out", out, "--jobs", 1, "--quiet"]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    results = list(out.glob("*.h5"))
    if done.returncode != 0 or len(results) != 1:
        sys.exit(f"the run at a tolerance of {tolerance:g} m failed: {done.stderr.strip()}")
    with h5py.File(results[0]) as file:
        seconds = sum(data[()] for data in file["provenance/session-0/seconds"].values())
        solves, _, predictions = file["checkpoint/integers/counters"][:3]
        return file["particles/conductors/position/value"][-1], solves, predictions, seconds


def smallest_radius(scene):
    """Returns the smallest radius, m."""
    content = tomllib.loads(scene.read_text())
    bodies = [*content.get("conductor", []), *content.get("population", [])]
    radii = [body["radius"] for body in bodies]
    if not all(isinstance(radius, float) for radius in radii):
        sys.exit(f"{scene}: every radius must be a number")
    return min(radii)


def measure(request, folder):
    """Returns rows (predictor, tolerance, solves, predictions, seconds, largest error, rms error); lengths in radii."""
    radius = smallest_radius(request.scene)
    reference = run(request, folder, False, request.reference * radius)[0]
    rows = []
    for predictor in SERIES:
        for tolerance in map(float, request.tolerances.split(",")):
            position, solves, predictions, seconds = run(request, folder, predictor, tolerance * radius)
            error = np.linalg.norm(position - reference, axis=1) / radius
            rows.append((predictor, tolerance, solves, predictions, seconds, error.max(), np.sqrt(np.mean(error**2))))
            print("{} {:g}: {} field solves, {} predictions, {:.1f} s, error {:.2g}, rms {:.2g}".format(
                SERIES[predictor][0], *rows[-1][1:]), file=sys.stderr, flush=True)
    return rows


def print_table(rows):
    print("| | tolerance | field solves | predictions | wall time | largest error | rms error |\n" + "|---" * 7 + "|")
    for predictor, tolerance, solves, predictions, seconds, largest, rms in rows:
        print(f"| {SERIES[predictor][0]} | {tolerance:g} | {solves} | {predictions or ''} | {seconds:.1f} s | "
              f"{largest:.2g} radius | {rms:.2g} |")


def draw(request, rows):
    figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
    for predictor, (label, colour) in SERIES.items():
        mine = [row for row in rows if row[0] == predictor]
        for column, style, name in ((5, "o-", "largest"), (6, "s--", "rms")):
            axes.loglog([row[4] for row in mine], [row[column] for row in mine], style, color=colour, markersize=4,
                        label=f"{label}, {name}")
        label_style = {"xytext": (-4, -9), "ha": "right"} if predictor else {"xytext": (4, 4)}
        for row in mine:
            axes.annotate(f"{row[1]:g}", (row[4], row[5]), textcoords="offset points", fontsize=7, color=colour, **label_style)
    axes.set(xlabel="wall time (s)", ylabel="error of positions / radius",
             title=f"{request.scene.name} to {request.time:g} s, by position tolerance / radius")
    for formatted in (axes.xaxis.set_major_formatter, axes.xaxis.set_minor_formatter):
        formatted("{x:g}")
    axes.grid(which="both", alpha=0.2)
    axes.legend(frameon=False)
    figure.savefig(request.output, dpi=130)


def main():
    request = read_request()
    with tempfile.TemporaryDirectory() as folder:
        rows = measure(request, Path(folder))
    print_table(rows)
    draw(request, rows)


if __name__ == "__main__":
    main()
