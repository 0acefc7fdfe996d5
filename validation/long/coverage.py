#!/usr/bin/python3
"""Counts the lines and branches of src/ and solvers/ that the quick tier executes, by gcovr.

    validation/long/coverage.py [--keep] [--write] [--lines FOLDER]

It builds the preset coverage. It runs its tests and prints a row for each folder. The option --keep counts without a
build and without tests. The option --write renews docs/measurements/coverage.json for docs/render_measurements.py. The
option --lines prints the lines of a folder that no test executes. Branches that only exceptions take are not counted.
CUDA files are not counted, because a device executes them. The exit status is 1 if a bound is not reached, if a test
fails, or if a file below LISTED has no reason in coverage.json.
"""
import argparse
import datetime
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

from run import commit  # of this folder

HOME = Path(__file__).resolve().parents[2]
BUILD = HOME / "build-coverage"
DATA = HOME / "docs/measurements/coverage.json"
BOUNDS = {"lines": 92.0, "branches": 80.0}  # per cent of src/ and solvers/
LISTED = 85.0  # per cent of lines: files below it are listed with a reason


def call(*words, check=True):
    return subprocess.run(list(map(str, words)), cwd=HOME, check=check)


def run_tests():
    """Builds and runs the quick tier, with counts from zero. Returns whether all tests pass."""
    call("cmake", "--preset", "coverage")
    call("ninja", "-C", BUILD, "tests")
    for path in BUILD.rglob("*.gcda"):
        path.unlink()
    return call("ctest", "--test-dir", BUILD, "--output-on-failure", "-j", (os.cpu_count() or 1) * 3 // 2, check=False).returncode == 0


def counted():
    """The files of gcovr's report: name -> list of (line, executions, [executions of each branch])."""
    report = BUILD / "coverage.json"
    call("gcovr", "--root", HOME, "--filter", "src/", "--filter", "solvers/", "--exclude-throw-branches", "--exclude-unreachable-branches",
         "--json", report, "-j", os.cpu_count() or 1, BUILD)  # fmt: skip
    return {
        each["file"]: [(line["line_number"], line["count"], [branch["count"] for branch in line["branches"]]) for line in each["lines"]
                       if not line["gcovr/noncode"]]
        for each in json.loads(report.read_text())["files"]
    }  # fmt: skip


def sums(files):
    """Row of counts and percentages of some files."""
    lines = [count > 0 for file in files for _, count, _ in file]
    branches = [count > 0 for file in files for _, _, each in file for count in each]
    share = lambda met: round(100 * sum(met) / len(met), 1) if met else 100.0
    return {"lines": len(lines), "lines_covered": share(lines), "branches": len(branches), "branches_covered": share(branches)}


def folder_rows(files):
    """Rows of the folders of src/ and solvers/, and of both together."""
    folders = sorted({str(Path(name).parent) for name in files})
    rows = [{"folder": folder} | sums([lines for name, lines in files.items() if str(Path(name).parent) == folder]) for folder in folders]
    return rows + [{"folder": "all"} | sums(files.values())]


def file_rows(files, reasons):
    """Rows of the files below LISTED, with the reason that the data state for each."""
    rows = []
    for name, lines in sorted(files.items()):
        row = sums([lines])
        if row["lines_covered"] < LISTED:
            missed = sum(count == 0 for _, count, _ in lines)
            rows.append({"file": name, "lines_missed": missed, "lines_covered": row["lines_covered"], "reason": reasons.get(name, "")})
    return rows


def measurement(measures, rows, **more):
    return {
        "page": "validation",
        "measures": measures,
        "unit": "1",
        "commit": commit() or "not kept",
        "machine": "any; gcc 12, preset coverage",
        "date": datetime.date.today().isoformat(),
        "command": "validation/long/coverage.py --write",
        "rows": rows,
        **more,
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--keep", action="store_true")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--lines", metavar="FOLDER")
    options = parser.parse_args()
    if not shutil.which("gcovr"):
        sys.exit("coverage.py: gcovr is missing (Debian package gcovr)")
    passed = options.keep or run_tests()
    files = counted()
    if options.lines:
        for name, lines in sorted(files.items()):
            if name.startswith(options.lines) and any(count == 0 for _, count, _ in lines):
                print(name, *(number for number, count, _ in lines if count == 0))
    reasons = {}
    if DATA.exists():
        reasons = {row["file"]: row["reason"] for each in json.loads(DATA.read_text()) for row in each["rows"] if "file" in row}
    folders, listed = folder_rows(files), file_rows(files, reasons)
    for row in folders:
        print("{folder:<36}{lines:>7} lines {lines_covered:>6} %{branches:>8} branches {branches_covered:>6} %".format(**row))
    whole = folders[-1]
    faults = [f"{whole[name + '_covered']} % of {name} are executed, fewer than {bound} %" for name, bound in BOUNDS.items()
              if whole[name + "_covered"] < bound]  # fmt: skip
    faults += [f"{row['file']}: {row['lines_covered']} % without a reason in {DATA.relative_to(HOME)}" for row in listed if not row["reason"]]
    faults += ["tests fail"] * (not passed)
    if options.write:
        note = "_covered: per cent of lines, and of branches without those of exceptions, that the tests of the quick tier execute."
        parts = [measurement("lines and branches that the quick tier executes", folders, note=note)]
        if listed:
            parts.append(measurement(f"files of which it executes less than {LISTED:g} % of the lines", listed))
        DATA.write_text(json.dumps(parts, indent=1) + "\n")
    if figures := os.environ.get("LICHTENBERG_FIGURES"):
        Path(figures).write_text(json.dumps({name: whole[name] for name in whole if name != "folder"}))
    for fault in faults:
        print("coverage:", fault)
    return bool(faults)


if __name__ == "__main__":
    sys.exit(main())
