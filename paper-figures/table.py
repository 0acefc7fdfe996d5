#!/usr/bin/python3
"""Prints the table of the sources' claims and the results here, and writes it to output/table.md.

The rows come from the figure scripts (figures.claim) in output/, with the version of the programs. Arguments: figures
that have just failed."""

import json
import math
import re
import sys

from figures import OUTPUT

HEADINGS = ("figure", "claim", "source", "published", "ours", "verdict", "note")


def shown(value):
    """Formats a number, a number with its interval (two digits, and the number to the same decimal), or a text."""
    if isinstance(value, list):
        number, half_width = value
        if half_width == math.inf:
            return f"{number:.4g} (one run)"
        if not 0 < half_width < math.inf:
            return f"{number:.4g} ± {half_width:g}"
        decimals = max(0, 1 - math.floor(math.log10(half_width)))
        return f"{number:.{decimals}f} ± {half_width:.{decimals}f}"
    return f"{value:.4g}" if isinstance(value, (int, float)) else value


def label(figure):
    """Returns the label of a figure: 7_1 is figure 7.1; other names are words."""
    return re.sub(r"(?<=\d)_(?=\d)", ".", figure).replace("_", " ")


def saved(failed):
    """Yields pairs (figure, row)."""
    for path in sorted([*OUTPUT.glob("figure_*.json"), *OUTPUT.glob("granular_*.json")]):
        figure = path.stem.removeprefix("figure_")
        if figure not in failed:
            for row in json.loads(path.read_text()):
                yield label(figure), row


def rows(failed):
    for figure, row in saved(failed):
        yield (figure, *(shown(row.get(heading, "")) for heading in HEADINGS[1:]))
    for figure in failed:
        yield (label(figure), "", "", "", "", "the script failed", "")


def versions(failed):
    """Returns a line for each version of the programs with the figures that it made."""
    figures = {}
    for figure, row in saved(failed):
        figures.setdefault(row.get("made with", "unknown"), set()).add(figure)
    return [f"Made with {version}: {', '.join(sorted(figures[version]))}." for version in sorted(figures)]


def main():
    cells = [HEADINGS, *sorted(rows(sys.argv[1:]), key=lambda row: row[0])]
    widths = [max(map(len, column)) for column in zip(*cells)]
    lines = ["| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths)) + " |" for row in cells]
    lines.insert(1, "|" + "|".join("-" * (width + 2) for width in widths) + "|")
    lines += ["", *versions(sys.argv[1:])]
    OUTPUT.mkdir(exist_ok=True)
    (OUTPUT / "table.md").write_text("\n".join(lines) + "\n")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
