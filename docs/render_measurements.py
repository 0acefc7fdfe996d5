#!/usr/bin/env python3
"""Writes the pages of measured figures in docs/ from the data in docs/measurements.

Each JSON file holds one measurement or a list of them. A measurement is an object with these keys:

    measures  quantity that the rows contain
    unit      unit of all numbers; "" if the keys of the rows name their units
    command   command that repeats the measurement, or an object of several
    machine   processor, cores, compiler and other load
    date      date of the run, YYYY-MM-DD, or two of them as a range
    rows      list of objects that map a column to a value; columns are in order of first appearance
    commit    commit of the programs, if known; several may be named
    note      remark for the reader, optional
    page      page that shows the measurement (PAGES); without it no page does

    docs/render_measurements.py           writes the pages
    docs/render_measurements.py --check   exits with 1 if a measurement lacks a key or a page differs from the data
"""

import argparse
import json
import re
import sys
import textwrap
from pathlib import Path

HERE = Path(__file__).resolve().parent
DATA = HERE / "measurements"
REQUIRED = {"measures": str, "unit": str, "command": (str, dict), "machine": str, "date": str, "rows": list}
DATE = re.compile(r"\d{4}-\d{2}-\d{2}( to \d{4}-\d{2}-\d{2})?")

# Page -> (title, introduction).
PAGES = {
    "performance": ("Performance", "Times next to those of other programs, times of whole runs, and times of solves and "
                    "steps on processors. Ratios are more reliable than times, which depend on the machine. "
                    "[Devices](performance-device.md) and [numerical parameters](performance-parameters.md) have pages "
                    "of their own. [Negative results](measurements/negative-results-benchmarks.md) lists variants "
                    "that were measured and rejected."),
    "performance-device": ("Performance on a CUDA device", "Times on an NVIDIA H200. A run that is repeated on a device "
                           "gives bitwise identical results."),
    "performance-parameters": ("Cost and error by numerical parameter", "Iterations, solves and errors as functions of "
                               "tolerances and scene parameters. Counts of iterations do not depend on the machine."),
    "validation": ("Validation", "Claims, references and errors. `build/validation NAME` exits with 1 if an error exceeds "
                   "its bound; `ctest -L validation` runs the quick part of each program."),
    "figures": ("Published figures", "Published values and the values of this program, with a verdict each. D is the "
                "dissertation on conductors, G the source on grains ([bibliography](bibliography.md)). "
                "`paper-figures/make.sh` prints this comparison for new runs."),
}


def measurements(path):
    """Returns the measurements of a file as a list of objects."""
    data = json.loads(path.read_text(encoding="utf-8"))
    return data if isinstance(data, list) else [data]


def faults(measurement):
    """Yields one message for each missing, unknown or misused key of a measurement."""
    for key, kind in REQUIRED.items():
        if not isinstance(measurement.get(key), kind):
            yield f"'{key}' is missing or of a wrong type"
    if not DATE.fullmatch(str(measurement.get("date"))):
        yield "'date' is not YYYY-MM-DD, or two of these with ' to ' between them"
    if not measurement.get("rows") or not all(isinstance(row, dict) and row for row in measurement["rows"]):
        yield "'rows' is not a list of non-empty objects"
    if measurement.get("page", "validation") not in PAGES:
        yield f"'page' is none of {', '.join(PAGES)}"


def text(value):
    """Returns a value as the text of a table cell."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        return ", ".join(map(text, value))
    if isinstance(value, dict):
        return "; ".join(f"{key}: {text(part)}" for key, part in value.items())
    return str(value).replace("|", "\\|").replace("\n", " ")


def code(command):
    """Returns a command, or each of several with its name, as inline code."""
    if isinstance(command, dict):
        return "; ".join(f"{name}: `{part}`" for name, part in command.items())
    return f"`{command}`"


def wrapped(line):
    """Returns a line of prose or of a list in lines of at most 100 columns, any other line unchanged."""
    if line.startswith(("|", "#")) or not line:
        return line
    indent = "  " if line.startswith("- ") else ""
    return textwrap.fill(line, 100, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


def section(measurement):
    """Returns the lines of one measurement: heading, table and conditions."""
    columns = list(dict.fromkeys(key for row in measurement["rows"] for key in row))
    unit = f" ({measurement['unit']})" if measurement["unit"] else ""
    yield from (f"## {measurement['measures'][0].upper()}{measurement['measures'][1:]}{unit}", "")
    yield "|" + "|".join(text(column) for column in columns) + "|"
    yield "|" + "-|" * len(columns)
    for row in measurement["rows"]:
        yield "|" + "|".join(text(row.get(column, "")) for column in columns) + "|"
    yield ""
    if "note" in measurement:
        yield from (text(measurement["note"]), "")
    yield from (f"- Command: {code(measurement['command'])}", f"- Machine: {text(measurement['machine'])}",
                f"- Date: {measurement['date']}", "")


def page(name):
    """Returns the text of a page: its introduction and all measurements that name it, in the order of the files."""
    title, introduction = PAGES[name]
    lines = [f"# {title}", "", introduction, "", "`docs/render_measurements.py` writes this page from `docs/measurements`.", ""]
    for path in sorted(DATA.glob("*.json")):
        for measurement in measurements(path):
            if measurement.get("page") == name:
                lines += section(measurement)
    return "\n".join(map(wrapped, lines)).rstrip() + "\n"


def check():
    """Returns messages for faulty measurements and for pages that differ from the data."""
    messages = [f"{path.name}, measurement {number}: {fault}" for path in sorted(DATA.glob("*.json"))
                for number, measurement in enumerate(measurements(path), 1) for fault in faults(measurement)]
    if not messages:
        for name in PAGES:
            path = HERE / f"{name}.md"
            if not path.exists() or path.read_text(encoding="utf-8") != page(name):
                messages.append(f"docs/{name}.md differs from the data: run docs/render_measurements.py")
    return messages


def main():
    """Writes or checks the pages."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="compare only; exit status 1 if anything is wrong")
    if parser.parse_args().check:
        messages = check()
        print("\n".join(messages) or "all pages agree with the data")
        return 1 if messages else 0
    for name in PAGES:
        (HERE / f"{name}.md").write_text(page(name), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
