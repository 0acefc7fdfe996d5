"""Functions for the figures of grains: runs of their gases (gas_scenes.py) with many seeds, stored results, means with
intervals.

Each run leaves its scene (NAME.toml) and the results of `lichtenberg analyse` by frame with its own time series
(NAME.json). Gases with pictures also leave the result file of the first seed. These are used again if the scene is
unchanged.
"""

import argparse
import concurrent.futures
import json
import math
import os
import tempfile
import tomllib
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
from matplotlib.ticker import NullFormatter

import figures
from ensembles import student_factor


def parse_arguments(description):
    """Parses the command line of a figure of gases."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--build", type=Path, default=figures.SOURCE / "build", help="folder of the built programs")
    parser.add_argument("--results", type=Path, default=figures.OUTPUT, help="folder of the runs that figures share")
    parser.add_argument("--full", action="store_true", help="the source's size, where it can be on a CUDA device")
    parser.add_argument("--seeds", type=int, help="runs of each gas (default: as many as an hour permits)")
    parser.add_argument("--processes", type=int, default=os.cpu_count(), help="runs at a time")
    arguments = parser.parse_args()
    arguments.program = arguments.build.resolve() / "lichtenberg"
    arguments.folder = arguments.results.resolve() / ("gases-full" if arguments.full else "gases")
    figures.record_version(arguments.program)
    return arguments


@dataclass
class GasRun:
    """Stored results of one run: arrays over its frames and over its records, in time since the warm-up."""

    frames: dict
    notes: dict
    result: Path

    def at(self, name, time):
        """Returns the value of the frame nearest to this time."""
        return self.frames[name][int(np.argmin(np.abs(self.frames["time"] - time)))]


def read_gas_run(path, warm, result):
    kept = json.loads(path.read_text())
    frames, notes = ({name: as_array(rows) for name, rows in kept[group].items()} for group in ("frames", "notes"))
    for group in (frames, notes):
        group["time"] = group["time"] - warm
    return GasRun(frames, notes, result)


def as_array(rows):
    """Returns an array over frames. null becomes NaN, and rows of several numbers are padded to the longest."""
    if rows and isinstance(rows[0], list):
        width = max(map(len, rows))
        rows = [row + [None] * (width - len(row)) for row in rows]
    return np.array(rows, dtype=float)


def keep(program, result, path):
    """Writes the kept results of a result file as JSON."""
    found = json.loads(figures.run(program, "analyse", result, "--json"))
    frames = {name: [frame[name] for frame in found["frames"]] for name in found["units"]}
    path.write_text(json.dumps({"frames": frames, "notes": found["notes"], "growth": found["growth"]}))


def cached_gas_run(arguments, gas, seed):
    """Returns the results of one seed; runs it unless results of the same scene are stored."""
    scene, path, result = (arguments.folder / f"{gas.name}-{seed}{suffix}" for suffix in (".toml", ".json", ".h5"))
    text = gas.scene(seed)
    same = scene.exists() and tomllib.loads(scene.read_text()) == tomllib.loads(text)
    pictured = gas.pictured and seed == 1
    if not (same and path.exists() and (result.exists() or not pictured)):
        arguments.folder.mkdir(parents=True, exist_ok=True)
        path.unlink(missing_ok=True)
        scene.write_text(text)
        options = ["--device", "cuda"] if arguments.full and gas.device else []
        figures.kept_run(arguments.program, scene, result, *options)
        keep(arguments.program, result, path)
        if not pictured:
            result.unlink()
    return read_gas_run(path, gas.warm, result)


def gas_runs(arguments, *gases):
    """Returns {name: [results of each seed]}; uses all processors."""
    with concurrent.futures.ThreadPoolExecutor(arguments.processes) as pool:
        runs = {gas.name: [pool.submit(cached_gas_run, arguments, gas, seed)
                           for seed in range(1, 1 + (arguments.seeds or gas.seeds))] for gas in gases}
        return {name: [run.result() for run in futures] for name, futures in runs.items()}


def mean(values):
    """Returns the mean of each column and the half width of its 95 % interval over rows (seeds), ignoring NaN; infinite
    for one row."""
    values = np.asarray(values, float)
    number = np.isfinite(values).sum(axis=0)
    middle = np.where(number > 0, np.nansum(values, axis=0) / np.maximum(number, 1), np.nan)
    deviation = np.sqrt(np.nansum((values - middle) ** 2, axis=0) / np.maximum(number - 1, 1))
    factor = np.vectorize(lambda n: student_factor(int(n) - 1) / math.sqrt(n) if n > 1 else math.inf, otypes=[float])
    with np.errstate(invalid="ignore"):
        return middle, np.where(number > 1, deviation * factor(number), np.inf)


def over_seeds(runs, name, notes=False):
    """Returns (times, mean, half width) of a quantity over the seeds of a gas."""
    groups = [gas_run.notes if notes else gas_run.frames for gas_run in runs]
    shortest = min(len(group["time"]) for group in groups)
    middle, half = mean([group[name][:shortest] for group in groups])
    return groups[0]["time"][:shortest], middle, half


def exponent(runs, name, first, last, notes=False):
    """Returns the mean slope of ln NAME over ln t between two times, with the half width of its 95 % interval over
    seeds."""
    slopes = []
    for gas_run in runs:
        group = gas_run.notes if notes else gas_run.frames
        chosen = (group["time"] >= first) & (group["time"] <= last) & (group[name] > 0)
        if chosen.sum() >= 3:
            slopes.append(np.polyfit(np.log(group["time"][chosen]), np.log(group[name][chosen]), 1)[0])
    if not slopes:
        return math.nan, math.inf
    middle, half = mean(np.array(slopes)[:, None])
    return float(middle[0]), float(half[0])


def draw_mean(axes, runs, name, colour, label, notes=False, factor=1.0, first=0.0, style="-"):
    """Draws the mean over seeds as a line and its interval as a band, from `first` on."""
    time, middle, half = over_seeds(runs, name, notes)
    shown = (time > first) & np.isfinite(middle)
    axes.plot(time[shown], factor * middle[shown], style, color=colour, linewidth=1.2, label=label)
    if np.isfinite(half[shown]).any():
        draw_band(axes, time[shown], factor * middle[shown], factor * half[shown], colour)


def draw_band(axes, time, middle, half, colour):
    """Draws an interval. For positive means it is symmetric on a logarithmic axis, which cannot show values below zero.
    """
    with np.errstate(all="ignore"):
        low = np.where(middle > 0, middle / (1 + half / middle), middle - half)
    axes.fill_between(time, low, middle + half, color=colour, alpha=0.2, linewidth=0)


def plain_ticks(*panels):
    """Removes labels between powers of ten, which would overlap."""
    for axes in panels:
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.yaxis.set_minor_formatter(NullFormatter())


def theory(program, *arguments):
    """Returns the results of `lichtenberg theory`: tables by name, each {column: values}, and its figures, lists by
    name."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "answer.json"
        figures.run(program, "theory", *arguments, "--json", path)
        answer = json.loads(path.read_text())
    tables = {table["name"]: {name: as_array(column["values"]) for name, column in table["columns"].items()}
              for table in answer["tables"]}
    numbers = {}
    for figure in answer["figures"]:
        numbers.setdefault(figure["name"], []).append(figure["value"])
    return tables, numbers


INK, NEUTRAL, GREY = "#1a1a1a", "#1a1a1a", "#8c8c8c"
COLOURS = ("#0c7bdc", "#009e73", "#d55e00", "#cc79a7")  # distinguishable for colour-blind readers (Okabe & Ito)
TIME = "time after the warm-up ($t_0$)"


def number(value):
    """Returns the pair (number, half width) of a row whose interval may be missing."""
    return [float(value[0]), float(value[1])]


def mean_of_seeds(values):
    """Returns (mean, half width of its 95 % interval) of one number per seed."""
    middle, half = mean(np.array(values, float)[:, None])
    return float(middle[0]), float(half[0])


def all_in_words(values):
    return ", ".join(map(in_words, values))


def differ(one, other):
    """Returns whether two pairs (number, half width) differ by more than both intervals allow."""
    return abs(one[0] - other[0]) > math.hypot(one[1], other[1])


def rises(pairs):
    """Returns whether values increase monotonically, and from first to last by more than the intervals allow."""
    return all(a[0] < b[0] for a, b in zip(pairs, pairs[1:])) and differ(pairs[0], pairs[-1])


def in_words(value, unit=""):
    """Formats a number with its interval, for rows of several numbers."""
    middle, half = value
    return (f"{middle:.3g}" + (f" ± {half:.2g}" if np.isfinite(half) else " (one run)")) + unit


def guide(axes, first, last, level, power, label, **style):
    """Draws a power of time through `level` at `first`."""
    times = np.array([first, last])
    axes.plot(times, level * (times / first) ** power, color=GREY, linewidth=1, **{"linestyle": ":", **style}, label=label)
