#!/usr/bin/python3
"""Measures errors and costs of runs of conductors from many instants of one run, for one or two programs.

    motion_errors.py --tolerance 3.1e-6 --against OTHER/build/lichtenberg

A scene runs until the last start. From each start, every program continues for --time. The first program also runs
without predictions at a tighter tolerance, as the reference. The error is the rms final distance of conductors from the
reference, in radii. An exchanged order of two group merges can change an error tenfold. The results are therefore
geometric means over the starts, the ratio of both programs with its standard error, and the number of errors above
three times the median. Runs have one thread.
"""

import argparse
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build" / "lichtenberg"


def read_request():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", type=Path, default=ROOT / "scenes" / "dendrite.toml")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--starts", default="0.3:1.6:14", help="first instant, last and number (s)")
    parser.add_argument("--time", type=float, default=0.1, help="s, from each start")
    parser.add_argument("--tolerance", type=float, default=7.75e-7, help="m, mechanics.position_tolerance")
    parser.add_argument("--exact", type=float, default=7.75e-8, help="position tolerance of the reference runs (m)")
    parser.add_argument("--program", type=Path, default=PROGRAM)
    parser.add_argument("--against", type=Path, help="another program")
    return parser.parse_args()


def instants(words):
    """Returns the first and last instant and their number, and the interval. Frames of a run have equal intervals."""
    first, last, number = words.split(":")
    first, last, number = float(first), float(last), int(number)
    every = (last - first) / (number - 1) if number > 1 else 0
    if every <= 0 or abs(first / every - round(first / every)) > 1e-6:
        sys.exit(f"--starts {words}: at least two starts are needed, the first at a multiple of the interval between them")
    return first, last, number


def run(program, scene, out, settings, start=()):
    """Returns field solves and predictions."""
    words = [str(program), "run", str(scene), *start, "--out", str(out), "--overwrite"]
    for key, value in {"field.threads": 1, "output.picture": "false", "output.field": "none", **settings}.items():
        words += ["--set", f"{key}={value}"]
    said = subprocess.run(words, check=True, capture_output=True, text=True).stdout
    numbers = [re.search(rf"^{name} +(\d+)", said, re.MULTILINE) for name in ("field solves", "predictions")]
    return np.array([int(number[1]) if number else 0 for number in numbers])


def read_positions(result):
    with h5py.File(result) as file:
        conductors = file["particles/conductors"]
        return conductors["position/value"][-1], conductors["radius"][:]


def error(result, exact):
    position, radius = read_positions(result)
    away = np.linalg.norm(position - read_positions(exact)[0], axis=1) / radius
    return np.sqrt(np.mean(away**2))


def main():
    request = read_request()
    first, last, number = instants(request.starts)
    programs = [request.program] + ([request.against] if request.against else [])
    counts, errors = [np.zeros(2, int) for _ in programs], [[] for _ in programs]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        starts, exact, out = folder / "starts.h5", folder / "exact.h5", folder / "out.h5"
        every = (last - first) / (number - 1)
        seed = {"seed": request.seed}
        run(request.program, request.scene, starts, {**seed, "stop.time": last, "output.every": every})
        with h5py.File(starts) as file:
            times = file["particles/conductors/position/time"][:]
        for instant in np.linspace(first, last, number):
            frame = int(np.argmin(abs(times - instant)))
            start = ("--from", str(starts), "--frame", str(frame))
            lasts = {**seed, "stop.time": request.time, "output.every": request.time}
            tight = {"mechanics.position_tolerance": request.exact, "mechanics.predictor": "false"}
            run(request.program, request.scene, exact, {**lasts, **tight}, start)
            for k, program in enumerate(programs):
                tolerance = {"mechanics.position_tolerance": request.tolerance}
                counts[k] += run(program, request.scene, out, {**lasts, **tolerance}, start)
                errors[k].append(error(out, exact))
    for program, count, found in zip(programs, counts, np.array(errors)):
        outliers = np.sum(found > 3 * np.median(found))
        print(f"{program}: {count[0]} field solves, {count[1]} predictions, error {np.exp(np.log(found).mean()):.2e} "
              f"radii, {outliers} of {len(found)} above three times the median")
    if request.against:
        logarithm = np.log(errors[0]) - np.log(errors[1])
        mean = np.exp(logarithm.mean())
        print(f"the first over the second: {mean:.2f} +- {mean * logarithm.std(ddof=1) / np.sqrt(len(logarithm)):.2f}")


if __name__ == "__main__":
    main()
