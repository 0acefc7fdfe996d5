"""What the figure scripts share: finding the built programs, running them, saving a figure as PDF and PNG."""

import argparse
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
