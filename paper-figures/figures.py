"""Functions for the figure scripts. They find and run the built programs, and save a figure as PDF and PNG. They also save
the comparison of its results with the source, for the table that make.sh prints (table.py)."""

import argparse
import json
import math
import subprocess
import sys
import tomllib
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")  # files only, without a display
import matplotlib.pyplot as plt

SOURCE = Path(__file__).resolve().parent.parent
OUTPUT = SOURCE / "paper-figures" / "output"
_program_version = "unknown"  # version and commit of the programs found by request()


def request(description, *foreign):
    """Parses the command line of a figure. Returns `build`, folder of the built programs; `results`, folder of the runs
    that figures share; and the figure's own options, pairs (option, help), that select other results."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--build", type=Path, default=SOURCE / "build", help="folder of the built programs")
    parser.add_argument("--results", type=Path, default=OUTPUT,
                        help="folder of the runs that figures share: those that it holds are not run again")
    for option, text in foreign:
        parser.add_argument(option, type=Path, help=text)
    found = parser.parse_args()
    found.build, found.results = found.build.resolve(), found.results.resolve()
    found.program = found.build / "lichtenberg"
    record_version(found.program)
    return found


def record_version(program):
    """Sets the program that the following rows name as their source."""
    global _program_version
    _program_version = version_of(program)


def version_of(program):
    if not program.exists():
        return "unknown"
    return run(program, "--version").strip()


def build_folder(description):
    """Returns the folder of the built programs, for a figure without shared runs."""
    return request(description).build


def name_for(name, foreign):
    """Returns the name of a figure. Figures of results chosen by the user have another name and are not in the table.
    """
    return f"other_{foreign.resolve().stem}_{name}" if foreign else name


def run(program, *arguments):
    """Returns the standard output of a built program. Exits with its message if it fails or is not built."""
    result = attempt(program, *arguments)
    if result.returncode != 0:
        refuse(program, result)
    return result.stdout


def attempt(program, *arguments):
    """Returns a subprocess.CompletedProcess for any status of the program."""
    if not program.exists():
        sys.exit(f"{program} does not exist: build it first, or give its folder with --build")
    return subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)


def refuse(program, result):
    sys.exit(f"{program.name} failed with status {result.returncode}: {result.stderr.strip()}")


def scene_in(path):
    """Returns the scene of a result file as a dictionary; empty if it cannot be read."""
    try:
        with h5py.File(path) as file:
            return tomllib.loads(file["scene/text"][()].decode())
    except (OSError, KeyError, tomllib.TOMLDecodeError):
        return None


def kept_run(program, scene, result, *options):
    """Returns the result file of a scene. An existing file is used if it belongs to this scene (comments aside).
    Otherwise a run with these options creates it under a temporary name until it ends; an interrupted run continues."""
    requested_scene = tomllib.loads(scene.read_text())
    if result.exists():
        if scene_in(result) == requested_scene:
            return result
        print(f"{result} is of another scene than {scene}: run again", flush=True)
    result.parent.mkdir(parents=True, exist_ok=True)
    unfinished = result.with_suffix(".part.h5")
    run(program, "run", scene, "--resume" if can_resume(unfinished, requested_scene) else "--overwrite", "--out", unfinished,
        *options)
    unfinished.rename(result)
    unfinished.with_suffix(".png").unlink(missing_ok=True)  # the run's own picture
    return result


def can_resume(path, requested_scene):
    if not path.exists() or scene_in(path) != requested_scene:
        return False
    with h5py.File(path) as file:
        return "checkpoint" in file


def save(figure, name):
    """Writes output/NAME.pdf and .png and prints their paths."""
    OUTPUT.mkdir(exist_ok=True)
    for suffix in (".pdf", ".png"):
        figure.savefig(OUTPUT / (name + suffix), dpi=200, bbox_inches="tight")
        print(OUTPUT / (name + suffix))
    plt.close(figure)


UNDECIDED = 0.2  # of the published value; a wider interval agrees with too many values


def claim(what, source, published, ours, verdict=None, note=""):
    """Returns a row of the table: a source's claim from a figure, and the result here.

    `published` and `ours`: a number, a pair (number, half width of its 95 % interval or error bound), or text. Without a
    verdict, both must be numbers, at least one with an interval. They differ if their difference exceeds both intervals
    together. They agree if they do not differ and both intervals together are within UNDECIDED of the published value;
    the verdict states that fraction. A given verdict must follow from the results.
    `note`: reason for a difference, omitted if they agree.
    """
    verdict = verdict or agreement(published, ours)
    return {"claim": what, "source": source, "published": published, "ours": ours, "verdict": verdict,
            "note": "" if verdict.startswith("agrees") else note}


def agreement(published, ours):
    """Returns the verdict on two numbers, at least one with an interval."""
    (theirs, allowed), (found, uncertain) = (pair if isinstance(pair, (tuple, list)) else (pair, 0)
                                             for pair in (published, ours))
    if not allowed and not uncertain:
        raise ValueError("a claim without any interval needs a verdict in words")
    interval = math.hypot(allowed, uncertain)
    if not math.isfinite(interval):
        return "undecided (one run has no interval)"
    if abs(found - theirs) > interval:
        return f"differs by {percent(found / theirs - 1, '+')} %" if theirs else "differs"
    if interval > UNDECIDED * abs(theirs):
        return f"undecided (± {percent(interval / abs(theirs))} %)" if theirs else "undecided"
    return f"agrees within {percent(interval / abs(theirs))} %"


def percent(ratio, sign=""):
    """Formats a ratio as a percentage with two digits."""
    return format(100 * ratio, sign + (".2g" if abs(ratio) < 0.995 else ".0f"))


def save_claims(name, claims):
    """Writes the rows of the figure NAME to output/NAME.json for table.py, each with the version of the programs. (A
    kept run stores its own version in its file.)"""
    OUTPUT.mkdir(exist_ok=True)
    rows = [{**row, "made with": _program_version} for row in claims]
    (OUTPUT / (name + ".json")).write_text(json.dumps(rows, indent=1) + "\n")
