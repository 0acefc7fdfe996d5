"""Functions for comparisons with published experiments and simulations: one script per row of docs/experiments.md.

A script states its expectation, runs the program, and records rows (render_measurements.py describes their keys). With
--quick it does the least that tests need, and writes a file only with --out.
"""

import argparse
import json
import os
import re
import sys
import tempfile
import time
from datetime import date
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from ensembles import student_factor  # noqa: E402
from figures import SOURCE, attempt, refuse, run, version_of  # noqa: E402

RESULTS = SOURCE / "docs" / "measurements" / "experiments"
__all__ = ["SOURCE", "Change", "attempt", "bounds", "conditions_of", "ensemble", "mean", "numbers_in", "open_experiment",
           "periodic_box", "picture", "published", "record", "recorded", "refuse", "row", "run", "try_changes"]


class Change(NamedTuple):
    """One changed assumption of an experiment. `expected` is written before the run."""

    assumption: str
    change: str
    expected: str
    argument: object = None  # of the script's own function
    against: str = ""  # the change to compare with, if not the row itself
    conditions: dict = None  # as in record()


def open_experiment(number, reference, description, name=""):
    """Parses the command line of row `number`, whose file is `name` (default: row-NN). Returns `program`, `quick`, `changes` (names of assumptions, None without
    --changes), `out` (file of the rows, or None), `recorded` (file of the recorded rows), `plot`, and
    the fields that all of its rows share."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--program", type=Path, default=SOURCE / "build" / "lichtenberg", help="built program")
    parser.add_argument("--quick", action="store_true", help="the least that a test needs; records only with --out")
    parser.add_argument("--changes", nargs="*", metavar="ASSUMPTION", help="change one assumption at a time, all or these, and "
                        "add the results to the recorded rows")
    parser.add_argument("--out", type=Path, help="file of the rows (default: in docs/measurements/experiments)")
    parser.add_argument("--plot", type=Path, help="picture to write (.png, .pdf, .svg)")
    found = parser.parse_args()
    found.program = found.program.resolve()
    found.recorded = RESULTS / f"{name or f'row-{number:02d}'}.json"
    if found.out is None and not found.quick:
        found.out = found.recorded
    found.shared = {"row": number, "reference": reference}
    words = [] if found.changes is None else ["--changes", *(f"'{name}'" if " " in name else name for name in found.changes)]
    found.script = " ".join([f"paper-figures/experiments/{Path(sys.argv[0]).name}", *(["--quick"] if found.quick else []), *words])
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


def verdict_of(theirs, ours):
    """Returns "agrees" if the intervals overlap, else "disagrees"."""
    return "agrees" if overlap(theirs["interval"], ours["interval"]) else "disagrees"


def row(quantity, expected, theirs, ours, reason=""):
    """Returns a row. `expected`: expectation, written before the run. `theirs`: published(). `ours`: mean() or bounds().
    They agree if the intervals overlap. A row that disagrees needs a reason: the assumption that decides."""
    verdict = verdict_of(theirs, ours)
    return {"quantity": quantity, "published": rounded(theirs), "expected": expected, "ours": rounded(ours),
            "verdict": verdict, "reason": "" if verdict == "agrees" else reason}


def machine():
    """Returns processor and cores as text."""
    info = Path("/proc/cpuinfo")
    names = [line.partition(":")[2].strip() for line in info.read_text().splitlines() if line.startswith("model name")]
    return f"{names[0] if names else 'unknown processor'}, {os.cpu_count()} cores"


def conditions_now(request, started):
    """Returns the conditions of runs since `started` (time.monotonic())."""
    return {"command": request.script, "commit": version_of(request.program), "machine": machine(),
            "date": date.today().isoformat(), "seconds": round(time.monotonic() - started, 1)}


def read_rows(path):
    return json.loads(path.read_text(encoding="utf-8")) if path and path.exists() else []


def write_rows(path, rows):
    if path:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(rows, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def tell(name, published_value, ours, verdict):
    low, high = ours["interval"]
    print(f"{name}: published {published_value['value']} {published_value['interval']}, "
          f"ours {ours['value']:.5g} [{low:.5g}, {high:.5g}]: {verdict}", flush=True)


def record(request, rows, conditions=None):
    """Prints the rows of a script and writes them to its file, with the changes that this has. `conditions`: command,
    commit, machine, date and seconds of earlier runs, from which the rows are taken. Exits with 1 if a row that
    disagrees has no reason."""
    shared = conditions or conditions_now(request, request.started)
    changes = {each["quantity"]: each["changes"] for each in read_rows(request.out) if "changes" in each}
    rows = [{**request.shared, **each, **shared} for each in rows]
    for each in rows:
        tell(each["quantity"], each["published"], each["ours"], each["verdict"])
        if each["verdict"] == "disagrees" and each["quantity"] in changes:
            each["changes"] = changes[each["quantity"]]
    write_rows(request.out, rows)
    open_ends = [each["quantity"] for each in rows if each["verdict"] == "disagrees" and not each["reason"]]
    if open_ends:
        sys.exit(f"state the reason why these disagree: {', '.join(open_ends)}")


def try_changes(request, cases, measure):
    """Makes each Change of `cases`, or those that --changes names, and adds the results to the recorded rows.
    `measure` returns {quantity: mean() or bounds()} of a case's argument."""
    unknown = set(request.changes) - {case.assumption for case in cases}
    if unknown:
        sys.exit(f"--changes {', '.join(sorted(unknown))}: use {', '.join(dict.fromkeys(case.assumption for case in cases))}")
    order = [case.change for case in cases]
    for case in cases:
        if request.changes and case.assumption not in request.changes:
            continue
        started = time.monotonic()
        found = measure(case.argument)
        shared = case.conditions or conditions_now(request, started)
        rows = read_rows(request.out or request.recorded)
        for quantity, ours in found.items():
            here = next(each for each in rows if each["quantity"] == quantity)
            made = {"assumption": case.assumption, "change": case.change, **({"against": case.against} if case.against else {}),
                    "expected": case.expected, "ours": rounded(ours), "verdict": verdict_of(here["published"], ours), **shared}
            others = [each for each in here.get("changes", []) if each["change"] in order and each["change"] != case.change]
            here["changes"] = sorted([*others, made], key=lambda each: order.index(each["change"]))
            tell(f"{case.assumption}: {case.change}: {quantity}", here["published"], ours, made["verdict"])
        write_rows(request.out, rows)


def ensemble(program, scene, settings, seeds):
    """Returns {quantity: (value, half width of its 95 % interval, runs)} of `lichtenberg ensemble` on one core.
    `settings`: {key: value} of the scene."""
    words = [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]
    with tempfile.TemporaryDirectory() as folder:
        answer = json.loads(run(program, "ensemble", scene, *words, "--seeds", seeds, "--jobs", 1, "--quiet", "--json",
                                "--out", folder))
    return {name: (each["value"], each["half_width"], each["sample"])
            for name, each in answer["points"][0]["quantities"].items() if "half_width" in each}


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
