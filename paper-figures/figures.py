"""What the figure scripts share: finding the built programs, running them, saving a figure as PDF and PNG, and what the
figure says beside what the source says, for the table that make.sh prints (table.py)."""

import argparse
import json
import math
import subprocess
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")  # files only, no display
import matplotlib.pyplot as plt

SOURCE = Path(__file__).resolve().parent.parent
OUTPUT = SOURCE / "paper-figures" / "output"


def build_folder(description):
    """The folder of the built programs, from the command line (--build, default: build beside the sources)."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--build", type=Path, default=SOURCE / "build", help="folder of the built programs")
    return parser.parse_args().build.resolve()


def run(program, *arguments):
    """Standard output of a built program. Ends with its message if it fails or has not been built."""
    if not program.exists():
        sys.exit(f"{program} does not exist: build it first, or give its folder with --build")
    result = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"{program.name} failed with status {result.returncode}: {result.stderr.strip()}")
    return result.stdout


def save(figure, name):
    """Writes output/NAME.pdf and .png and says so."""
    OUTPUT.mkdir(exist_ok=True)
    for suffix in (".pdf", ".png"):
        figure.savefig(OUTPUT / (name + suffix), dpi=200, bbox_inches="tight")
        print(OUTPUT / (name + suffix))
    plt.close(figure)


def claim(what, source, published, ours, verdict=None):
    """A row of the table: what a source claims by a figure, and what we find.

    published, ours: a number, a pair (number, half width of its 95 % interval), or text. Without a verdict they must be
    numbers of which one at least has an interval: they agree if they differ by no more than both intervals allow, and the
    verdict says how much that is.
    """
    return {"claim": what, "source": source, "published": published, "ours": ours,
            "verdict": verdict or _agreement(published, ours)}


def _agreement(published, ours):
    (theirs, allowed), (found, uncertain) = (pair if isinstance(pair, (tuple, list)) else (pair, 0)
                                             for pair in (published, ours))
    if not allowed and not uncertain:
        raise ValueError("a claim without any interval needs a verdict in words")
    interval = math.hypot(allowed, uncertain)
    if abs(found - theirs) <= interval:
        return f"agrees within {100 * abs(interval / theirs):.2g} %" if theirs else "agrees"
    return f"differs by {100 * (found / theirs - 1):+.2g} %" if theirs else "differs"


def save_claims(name, claims):
    """Writes the rows of the figure NAME to output/NAME.json, where table.py finds them."""
    OUTPUT.mkdir(exist_ok=True)
    (OUTPUT / (name + ".json")).write_text(json.dumps(claims, indent=1) + "\n")
