#!/usr/bin/env python3
"""Compares instructions, cache misses and memory of fixed pieces of work with the last record.

    validation/gate.py [--build build-gate] [--record "REASON"] [NAME ...]

The counts are those of valgrind and do not depend on the processor or on the load of the machine. Cache misses, which have no
limit and take valgrind as long as the instructions, are counted for a record alone. The build must not use
AVX-512, which valgrind lacks: `cmake --preset gate; ninja -C build-gate benchmark_gate lichtenberg`. Prints a row per
piece. The last record is the first one of docs/measurements/gate.json.

Exits with 1 if a piece takes 5 % more instructions or 10 % more memory than in the last record. Exits with 2 for wrong
input. --record adds a record for this commit, with the reason for the change, and renders the page.
"""
import argparse
import concurrent.futures
import itertools
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HOME = Path(__file__).resolve().parents[1]
DATA = HOME / "docs/measurements/gate.json"
sys.path.insert(0, str(HOME / "validation/long"))
from run import commit  # noqa: E402

LIMITS = {"instructions (1e6)": 1.05, "memory (MiB)": 1.10}  # largest permitted ratio to the last record
RUNS = {  # scene -> changed keys; one thread each
    "dendrite": {"field.threads": 1, "field.cells": 128, "population[0].count": 60, "stop.time": 0.02},
    "dendrite-3d": {"field.threads": 1, "population[0].count": 10, "stop.time": 0.002},
    "granular-gas": {"mechanics.threads": 1, "population[0].count": 150, "domain.size": "[10,10,10]",
                     "equilibration[0].duration": 0.5, "stop.time": 2},
    "packing": {"minimize.threads": 1, "population[0].count": 500, "domain.size": "[22e-3,22e-3]"},
}


def refuse(message):
    print(f"gate.py: {message}", file=sys.stderr)
    sys.exit(2)


def pieces_of(build):
    """Returns the words of the command of each piece and each run, by name."""
    program = build / "benchmark_gate"
    if not program.exists() or not (build / "lichtenberg").exists():
        refuse(f"{build} lacks benchmark_gate or lichtenberg: cmake --preset gate; ninja -C build-gate benchmark_gate lichtenberg")
    done = subprocess.run([program, "--list"], capture_output=True, text=True, check=True)
    words = {name: [program, name] for name in done.stdout.split()}
    for scene, keys in RUNS.items():
        changes = [word for key, value in ({"output.picture": "false"} | keys).items()
                   for word in ("--set", f"{key}={value}")]
        words[f"run {scene}"] = [build / "lichtenberg", "run", HOME / f"scenes/{scene}.toml", "--quiet", *changes]
    return words


def memory_of(words, folder):
    """Runs a command and returns the largest memory (MiB) of its process."""
    child = subprocess.Popen(words, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    said = child.stderr.read()
    _, status, usage = os.wait4(child.pid, 0)
    if status:
        reason = "".join(said.strip().splitlines()[-1:])
        raise RuntimeError(f"{' '.join(map(str, words))} ended with status {os.waitstatus_to_exitcode(status)}: {reason}")
    return round(usage.ru_maxrss / 1024, 1)


def count_of(words, piece, folder, misses):
    """Returns millions of instructions of a command under valgrind, with `misses` also those of misses of the last cache."""
    part = ["--instr-atstart=no"] if words[0].name == "benchmark_gate" else []
    if misses:
        part += ["--cache-sim=yes", "--LL=8388608,16,64", "--I1=32768,8,64", "--D1=32768,8,64"]
    valgrind = ["valgrind", "--tool=callgrind", "--callgrind-out-file=counts", *part]
    done = subprocess.run([*valgrind, *words], cwd=folder, capture_output=True, text=True, check=False)
    counts = folder / "counts"
    if done.returncode or not counts.exists():
        raise RuntimeError(f"{piece} under valgrind: " + "; ".join(done.stderr.strip().splitlines()[-3:]))
    text = counts.read_text(encoding="utf-8")
    events = re.search(r"^events: (.*)", text, re.MULTILINE)[1].split()
    numbers = map(int, re.search(r"^totals: (.*)", text, re.MULTILINE)[1].split())
    totals = dict(itertools.zip_longest(events, numbers, fillvalue=0))  # the file omits zeros at the end
    found = {"instructions (1e6)": round(totals["Ir"] / 1e6, 1)}
    if misses:
        found["cache misses (1e6)"] = round((totals["ILmr"] + totals["DLmr"] + totals["DLmw"]) / 1e6, 3)
    return found


def measure(piece, words, misses):
    """Returns the row of a piece."""
    with tempfile.TemporaryDirectory() as first, tempfile.TemporaryDirectory() as second:
        memory = memory_of(words, Path(first))
        return {"piece": piece, **count_of(words, piece, Path(second), misses), "memory (MiB)": memory}


def faults_of(row, last, commit):
    """Yields a message for each limit that a row exceeds."""
    for quantity, limit in LIMITS.items():
        if row[quantity] > limit * last[quantity]:
            yield (f"{row['piece']}: {quantity} grew by {100 * (row[quantity] / last[quantity] - 1):.1f} %, from {last[quantity]} "
                   f"at commit {commit} to {row[quantity]}; allowed are {100 * (limit - 1):.0f} %")


def record(rows, reason, build):
    """Adds a record to the data: the newest is the first. Renders the page."""
    times = subprocess.run([build / "benchmark_gate", "--time"], capture_output=True, text=True, check=True, cwd=HOME).stdout
    ratio = dict(line.split() for line in times.splitlines())
    for row in rows:
        if row["piece"] in ratio:
            row["time over a transform"] = float(ratio[row["piece"]])
    data, at = json.loads(DATA.read_text(encoding="utf-8")) if DATA.exists() else [], commit() or "not kept"
    data.insert(0, {
        "page": "performance-history", "measures": f"work at commit {at}: {reason}", "unit": "1",
        "command": "validation/gate.py --record REASON", "commit": at, "date": time.strftime("%Y-%m-%d"),
        "machine": "valgrind's counts, independent of the machine; memory and times from a processor with AVX2", "rows": rows})
    DATA.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    subprocess.run([sys.executable, HOME / "docs/render_measurements.py"], check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", metavar="NAME", nargs="*", help="pieces; default all")
    parser.add_argument("--build", type=Path, default=HOME / "build-gate", help="folder of the build")
    parser.add_argument("--record", metavar="REASON", help="add a record with the reason for the change")
    options = parser.parse_args()
    if not shutil.which("valgrind"):
        refuse("valgrind is missing: apt-get install valgrind")
    options.build = options.build.resolve()
    words = pieces_of(options.build)
    for name in options.names:
        if name not in words:
            refuse(f"there is no piece {name!r}; known are {', '.join(words)}")
    if options.record and options.names:
        refuse("--record needs all pieces: give no names")
    chosen = {name: words[name] for name in options.names or words}
    last = json.loads(DATA.read_text(encoding="utf-8"))[0] if DATA.exists() else {"rows": [], "commit": ""}
    known = {row["piece"]: row for row in last["rows"]}
    rows, faults = [], []
    print(f"{'piece':<20}{'1e6 instructions':>18}{'ratio':>7}{'1e6 misses':>12}{'MiB':>9}{'ratio':>7}", flush=True)
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        for row in pool.map(lambda name: measure(name, chosen[name], bool(options.record)), chosen):
            rows.append(row)
            old = known.get(row["piece"])
            ratio = {key: f"{row[key] / old[key]:.3f}" if old else "-" for key in LIMITS}
            print(f"{row['piece']:<20}{row['instructions (1e6)']:>18}{ratio['instructions (1e6)']:>7}{row.get('cache misses (1e6)', '-'):>12}"
                  f"{row['memory (MiB)']:>9}{ratio['memory (MiB)']:>7}", flush=True)
            faults += faults_of(row, old, last["commit"]) if old else [f"{row['piece']} has no record in {DATA.name}: --record makes one"]
    if options.record:
        record(rows, options.record, options.build)
        return 0
    print("\n".join(faults) or "no piece exceeds its limits")
    return 1 if faults else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except RuntimeError as error:
        sys.exit(f"gate.py: {error}")
