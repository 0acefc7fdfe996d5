"""What the figure scripts share: finding the built programs, running them, saving a figure as PDF and PNG, and what the
figure says beside what the source says, for the table that make.sh prints (table.py)."""

import argparse
import json
import math
import subprocess
import sys
import tomllib
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")  # files only, no display
import matplotlib.pyplot as plt

SOURCE = Path(__file__).resolve().parent.parent
OUTPUT = SOURCE / "paper-figures" / "output"
_made_with = "unknown"  # version and commit of the programs that request() found


def request(description, *foreign):
    """The command line of a figure: `build`, folder of the built programs; `results`, folder of the runs that figures
    share; and the figure's own options of results to show in their place, pairs (option, help)."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--build", type=Path, default=SOURCE / "build", help="folder of the built programs")
    parser.add_argument("--results", type=Path, default=OUTPUT,
                        help="folder of the runs that figures share: those that it holds are not run again")
    for option, text in foreign:
        parser.add_argument(option, type=Path, help=text)
    found = parser.parse_args()
    found.build, found.results = found.build.resolve(), found.results.resolve()
    found.program = found.build / "lichtenberg"
    made_with(found.program)
    return found


def made_with(program):
    """From here on, rows say that this program made them."""
    global _made_with
    _made_with = version_of(program)


def version_of(program):
    if not program.exists():
        return "unknown"
    return run(program, "--version").strip()


def build_folder(description):
    """The folder of the built programs, for a figure that shares no runs."""
    return request(description).build


def name_for(name, foreign):
    """The name of a figure; a figure of results that its user named has another, which is no row of the table."""
    return f"other_{foreign.resolve().stem}_{name}" if foreign else name


def run(program, *arguments):
    """Standard output of a built program. Ends with its message if it fails or has not been built."""
    result = attempt(program, *arguments)
    if result.returncode != 0:
        refuse(program, result)
    return result.stdout


def attempt(program, *arguments):
    """The same, whatever the program's status: a subprocess.CompletedProcess."""
    if not program.exists():
        sys.exit(f"{program} does not exist: build it first, or give its folder with --build")
    return subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)


def refuse(program, result):
    sys.exit(f"{program.name} failed with status {result.returncode}: {result.stderr.strip()}")


def scene_in(path):
    """The scene that a result file is of, as a dictionary; nothing if it cannot be read."""
    try:
        with h5py.File(path) as file:
            return tomllib.loads(file["scene/text"][()].decode())
    except (OSError, KeyError, tomllib.TOMLDecodeError):
        return None


def kept_run(program, scene, result, *options):
    """The result file of a scene: the one that is there if it is of this very scene (comments aside), else of a new
    run with these options, which has that name only when it has ended. A run that was stopped goes on."""
    asked = tomllib.loads(scene.read_text())
    if result.exists():
        if scene_in(result) == asked:
            return result
        print(f"{result} is of another scene than {scene}: run again", flush=True)
    result.parent.mkdir(parents=True, exist_ok=True)
    unfinished = result.with_suffix(".part.h5")
    run(program, "run", scene, "--resume" if can_go_on(unfinished, asked) else "--overwrite", "--out", unfinished,
        *options)
    unfinished.rename(result)
    unfinished.with_suffix(".png").unlink(missing_ok=True)  # the run's own picture
    return result


def can_go_on(path, asked):
    if not path.exists() or scene_in(path) != asked:
        return False
    with h5py.File(path) as file:
        return "checkpoint" in file


def save(figure, name):
    """Writes output/NAME.pdf and .png and says so."""
    OUTPUT.mkdir(exist_ok=True)
    for suffix in (".pdf", ".png"):
        figure.savefig(OUTPUT / (name + suffix), dpi=200, bbox_inches="tight")
        print(OUTPUT / (name + suffix))
    plt.close(figure)


UNDECIDED = 0.2  # of the published value: an interval wider than that agrees with too much


def claim(what, source, published, ours, verdict=None, note=""):
    """A row of the table: what a source claims by a figure, and what we find.

    published, ours: a number, a pair (number, half width of its 95 % interval or bound of its error), or text. Without
    a verdict they must be numbers of which one at least has an interval: they differ if by more than both intervals
    allow, and agree if not and both together are within UNDECIDED of the published value; the verdict says how much
    that is. A verdict that is given must come from what is found, too. note: why they differ, dropped if they agree.
    """
    verdict = verdict or agreement(published, ours)
    return {"claim": what, "source": source, "published": published, "ours": ours, "verdict": verdict,
            "note": "" if verdict.startswith("agrees") else note}


def agreement(published, ours):
    """The verdict on two numbers, of which one at least has an interval."""
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
    """To two digits."""
    return format(100 * ratio, sign + (".2g" if abs(ratio) < 0.995 else ".0f"))


def save_claims(name, claims):
    """Writes the rows of the figure NAME to output/NAME.json, where table.py finds them, each with the version of the
    programs that it was made with. (A run that was kept has its own in its file.)"""
    OUTPUT.mkdir(exist_ok=True)
    rows = [{**row, "made with": _made_with} for row in claims]
    (OUTPUT / (name + ".json")).write_text(json.dumps(rows, indent=1) + "\n")
