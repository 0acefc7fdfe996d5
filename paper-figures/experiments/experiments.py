"""Functions for comparisons with published experiments and simulations: one script per row of docs/experiments.md.

A script states its expectation, runs the program, and records rows (render_measurements.py describes their keys). With
--quick it does the least that tests need, and writes a file only with --out.
"""

import argparse
import json
import os
import re
import sys
import time
from datetime import date
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from ensembles import student_factor  # noqa: E402
from figures import SOURCE, attempt, refuse, run, version_of  # noqa: E402

RESULTS = SOURCE / "docs" / "measurements" / "experiments"
__all__ = ["SOURCE", "attempt", "bounds", "conditions_of", "mean", "numbers_in", "open_experiment", "periodic_box", "picture",
           "published", "record", "recorded", "refuse", "row", "run"]


def open_experiment(number, reference, description):
    """Parses the command line of row `number`. Returns `program`, `quick`, `out` (file of the rows, or None), `plot`,
    and the fields that all of its rows share."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--program", type=Path, default=SOURCE / "build" / "lichtenberg", help="built program")
    parser.add_argument("--quick", action="store_true", help="the least that a test needs; records only with --out")
    parser.add_argument("--out", type=Path, help="file of the rows (default: in docs/measurements/experiments)")
    parser.add_argument("--plot", type=Path, help="picture to write (.png, .pdf, .svg)")
    found = parser.parse_args()
    found.program = found.program.resolve()
    if found.out is None and not found.quick:
        found.out = RESULTS / f"row-{number:02d}.json"
    found.shared = {"row": number, "reference": reference}
    found.script = f"paper-figures/experiments/{Path(sys.argv[0]).name}{' --quick' if found.quick else ''}"
    found.started = time.monotonic()
    return found


def periodic_box(edge):
    """Returns the first lines of a scene of grains in a periodic cube of this edge (d0)."""
    sides = [f'{name} = "periodic"' for name in ("left", "right", "bottom", "top", "front", "back")]
    return "\n".join(["[units]", "[domain]", f"size = [{edge!r}, {edge!r}, {edge!r}]", *sides, ""])


def mean(values):
    """Returns {"value", "interval", "runs"} of independent runs: their mean and its 95 % interval by Student's t."""
    values = np.asarray(values, float)
    if len(values) < 2:
        raise ValueError("one run has no interval: state its error bound with bounds()")
    half = student_factor(len(values) - 1) * values.std(ddof=1) / np.sqrt(len(values))
    return bounds(values.mean(), half, len(values))


def bounds(value, half_width, runs=1):
    """Returns {"value", "interval", "runs"} of a value with an error bound, such as that of a solution."""
    return {"value": float(value), "interval": [float(value - half_width), float(value + half_width)], "runs": runs}


def rounded(part):
    """Returns a value with its interval in ten digits."""
    def short(number):
        return None if number is None else float(f"{number:.10g}")

    return {**part, "value": short(part["value"]), "interval": [short(bound) for bound in part["interval"]]}


def recorded(measures):
    """Returns the measurement of docs/measurements/figures.json with this name."""
    measurements = json.loads((SOURCE / "docs" / "measurements" / "figures.json").read_text(encoding="utf-8"))
    return next(each for each in measurements if each["measures"] == measures)


def numbers_in(text):
    """Returns the pairs (value, half width) of each "a ± b" in a text."""
    return [(float(value), float(half)) for value, half in re.findall(r"([-\d.]+) ± ([\d.]+)", text)]


def conditions_of(measurement, command, seconds):
    """Returns the conditions of an earlier measurement for record()."""
    return {"command": command, "seconds": seconds, **{key: measurement[key] for key in ("commit", "machine", "date")}}


def published(value, low, high, source):
    """Returns a published value. `low`, `high`: its interval, None without a bound. `source`: S (read in full), A (read
    in the abstract) or M (from memory, to be checked)."""
    return {"value": value, "interval": [low, high], "source": source}


def overlap(one, other):
    """Returns true if two intervals have a common point. None is no bound."""
    (a, b), (c, d) = one, other
    return (a is None or d is None or a <= d) and (b is None or c is None or c <= b)


def row(quantity, expected, theirs, ours, reason=""):
    """Returns a row. `expected`: expectation, written before the run. `theirs`: published(). `ours`: mean() or bounds().
    They agree if the intervals overlap. A row that disagrees needs a reason: the assumption that decides."""
    verdict = "agrees" if overlap(theirs["interval"], ours["interval"]) else "disagrees"
    return {"quantity": quantity, "published": rounded(theirs), "expected": expected, "ours": rounded(ours),
            "verdict": verdict, "reason": "" if verdict == "agrees" else reason}


def machine():
    """Returns processor and cores as text."""
    info = Path("/proc/cpuinfo")
    names = [line.partition(":")[2].strip() for line in info.read_text().splitlines() if line.startswith("model name")]
    return f"{names[0] if names else 'unknown processor'}, {os.cpu_count()} cores"


def record(request, rows, conditions=None):
    """Prints the rows of a script and writes them to its file. `conditions`: command, commit, machine, date and seconds
    of earlier runs, from which the rows are taken. Exits with 1 if a row that disagrees has no reason."""
    shared = conditions or {"command": request.script, "commit": version_of(request.program), "machine": machine(),
              "date": date.today().isoformat(), "seconds": round(time.monotonic() - request.started, 1)}
    rows = [{**request.shared, **each, **shared} for each in rows]
    for each in rows:
        low, high = each["ours"]["interval"]
        print(f"{each['quantity']}: published {each['published']['value']} {each['published']['interval']}, "
              f"ours {each['ours']['value']:.5g} [{low:.5g}, {high:.5g}]: {each['verdict']}")
    if request.out:
        request.out.parent.mkdir(parents=True, exist_ok=True)
        request.out.write_text(json.dumps(rows, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    open_ends = [each["quantity"] for each in rows if each["verdict"] == "disagrees" and not each["reason"]]
    if open_ends:
        sys.exit(f"state the reason why these disagree: {', '.join(open_ends)}")


def picture(path, draw):
    """Draws into one pair of axes with draw(axes) and writes the picture, if a path is given."""
    if path is None:
        return
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(5, 3.6))
    draw(axes)
    axes.legend()
    figure.savefig(path, dpi=200, bbox_inches="tight")
    plt.close(figure)
