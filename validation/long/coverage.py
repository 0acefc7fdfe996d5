#!/usr/bin/python3
"""Counts the lines, branches and functions of src/ and solvers/ that the quick tier executes, by gcovr.

    validation/long/coverage.py [--keep] [--write] [--lines FOLDER]

It builds the preset coverage. It runs its tests and prints a row for each folder. The option --keep counts without a
build and without tests. The option --write renews docs/measurements/coverage.json and the page of documentation. The
option --lines prints the lines and functions of a folder that no test executes. Branches that only exceptions take are
not counted. All instances of a template are one function. CUDA files are not counted, because a device executes them.
The exit status is 1 if a bound is not reached, if a test fails, or if a file below LISTED has no reason in coverage.json.
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


class File:
    """Counts of a source file: executions of lines {line: count}, of branches [count], of functions {first line: count}."""

    def __init__(self, report):
        lines = [line for line in report["lines"] if not line["gcovr/noncode"]]
        self.lines = {line["line_number"]: line["count"] for line in lines}
        self.branches = [branch["count"] for line in lines for branch in line["branches"]]
        self.functions = {}
        for each in report["functions"]:
            self.functions[each["lineno"]] = self.functions.get(each["lineno"], 0) + each["execution_count"]

    def missed(self):
        return [number for number, count in self.lines.items() if count == 0]


def counted():
    """The files of gcovr's report by name."""
    report = BUILD / "coverage.json"
    call("gcovr", "--root", HOME, "--filter", "src/", "--filter", "solvers/", "--exclude-throw-branches", "--exclude-unreachable-branches",
         "--json", report, "-j", os.cpu_count() or 1, BUILD)  # fmt: skip
    return {each["file"]: File(each) for each in json.loads(report.read_text())["files"] if each["lines"]}


def sums(files):
    """Row of the counts of some files, each with the per cent that was executed."""
    row = {}
    for name in ("lines", "branches", "functions"):
        counts = [count > 0 for file in files for count in (getattr(file, name) if name == "branches" else getattr(file, name).values())]
        row |= {name: len(counts), f"{name} executed (%)": round(100 * sum(counts) / len(counts), 1) if counts else 100.0}
    return row


def folder_rows(files):
    """Rows of the folders of src/ and solvers/, and of both together."""
    folders = sorted({str(Path(name).parent) for name in files})
    rows = [{"folder": folder} | sums([file for name, file in files.items() if str(Path(name).parent) == folder]) for folder in folders]
    return rows + [{"folder": "all"} | sums(files.values())]


def file_rows(files, reasons):
    """Rows of the files below LISTED, with the reason that the data state for each."""
    shares = [(name, sums([file])["lines executed (%)"], len(file.missed())) for name, file in sorted(files.items())]
    return [{"file": name, "lines missed": missed, "lines executed (%)": share, "reason": reasons.get(name, "")}
            for name, share, missed in shares if share < LISTED]  # fmt: skip


def measurement(measures, rows, **more):
    return {
        "page": "coverage",
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
        for name, file in sorted(files.items()):
            if name.startswith(options.lines) and file.missed():
                print(f"{name}: lines", *file.missed())
                print(f"{name}: functions", *(first for first, count in file.functions.items() if count == 0))
    reasons = {}
    if DATA.exists():
        reasons = {row["file"]: row["reason"] for each in json.loads(DATA.read_text()) for row in each["rows"] if "file" in row}
    folders, listed = folder_rows(files), file_rows(files, reasons)
    for row in folders:
        print(f"{row['folder']:<36}", *(f"{row[name]:>6} {name} {row[name + ' executed (%)']:>5} %" for name in ("lines", "branches", "functions")))
    whole = folders[-1]
    faults = [f"{whole[f'{name} executed (%)']} % of {name} are executed, fewer than {bound} %" for name, bound in BOUNDS.items()
              if whole[f"{name} executed (%)"] < bound]  # fmt: skip
    faults += [f"{row['file']}: {row['lines executed (%)']} % of the lines, without a reason in {DATA.relative_to(HOME)}"
               for row in listed if not row["reason"]]  # fmt: skip
    faults += ["tests fail"] * (not passed)
    if options.write:
        parts = [measurement("lines, branches and functions that the quick tier executes", folders)]
        if listed:
            parts.append(measurement(f"files of which it executes less than {LISTED:g} % of the lines", listed))
        DATA.write_text(json.dumps(parts, indent=1) + "\n")
        call(sys.executable, HOME / "docs/render_measurements.py")
    if figures := os.environ.get("LICHTENBERG_FIGURES"):
        Path(figures).write_text(json.dumps({name: value for name, value in whole.items() if name != "folder"}))
    for fault in faults:
        print("coverage:", fault)
    return bool(faults)


if __name__ == "__main__":
    sys.exit(main())
