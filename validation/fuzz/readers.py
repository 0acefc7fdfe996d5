#!/usr/bin/python3
"""Reads damaged results by the commands in Python and by the package.

    validation/fuzz/readers.py [--program build/lichtenberg] [--cases 500] [--seed 1] [--first 0] [--jobs 1] [--keep FOLDER]

`fuzz results` tries the readers of the library in process. `fuzz draw` next to the program makes the results; a seed
determines them and their readers. A reader may read a result or refuse it (exit status 1 or 2 and an error message). It
fails if it ends by a signal, takes more than a minute, prints a traceback, or prints nan without a warning. Exits with 1
if a reader fails.
"""
import argparse
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HOME = Path(__file__).resolve().parents[2]
LIMIT = 60  # s, per reader
LOAD = """
import sys, warnings; sys.path.insert(0, sys.argv[1]); warnings.simplefilter("ignore")
import lichtenberg
try:
    with lichtenberg.load(sys.argv[2]) as result:
        [result[name] for name in result.columns], result.tables, result.observables, result.summary, result.provenance
        [frame.time for frame in result], result.scene, result.title, result.field
except lichtenberg.InputError as error:
    sys.exit(f"lichtenberg: {error}")
"""
READERS = {
    "analyse": ["analyse", "run.h5"],
    "plot": ["plot", "run.h5", "--out", "out.png"],
    "series": ["plot", "--series", "run.h5", "--out", "out.png"],
    "view": ["view", "run.h5", "--out", "out.html"],
    "xyz": ["export", "run.h5", "--to", "xyz", "--out", "out.xyz"],
    "csv": ["export", "run.h5", "--to", "csv", "--out", "out-csv"],
    "vtk": ["export", "run.h5", "--to", "vtk", "--out", "out-vtk"],
}


def failure_of(words, folder):
    """Returns the failure of a reader, or None."""
    process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=folder,
                               text=True, errors="replace", start_new_session=True)  # fmt: skip
    try:
        out, err = process.communicate(timeout=LIMIT)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        return f"no end after {LIMIT} s"
    if process.returncode < 0 or process.returncode > 2:
        return f"status {process.returncode}: {err[-300:]}"
    if "Traceback" in err or "terminate called" in err:
        return err[-600:]
    if process.returncode == 0 and not err.strip() and re.search(r"(?<![\w.])-?nan\b", out, re.IGNORECASE):
        return f"nan: {re.search(r'.*nan.*', out, re.IGNORECASE)[0]}"
    if process.returncode > 0 and not err.strip():
        return "no error message"
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, default=HOME / "build/lichtenberg")
    parser.add_argument("--cases", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="folder for the results that a reader fails on")
    request = parser.parse_args()
    program, start = request.program.resolve(), time.monotonic()
    os.environ |= {"HDF5_USE_FILE_LOCKING": "FALSE", "LICHTENBERG": str(program)}
    failures = 0

    def attempt(number):
        reader = random.Random(f"{request.seed} {number}").choice([*READERS, "load", "load"])
        words = ["/usr/bin/python3", "-c", LOAD, HOME / "python", "run.h5"] if reader == "load" else [program, *READERS[reader]]
        wrong = failure_of(words, folder / str(number))
        if wrong and request.keep:
            shutil.copytree(folder / str(number), request.keep / str(number), dirs_exist_ok=True)
        shutil.rmtree(folder / str(number))
        return wrong and f"case {number} of seed {request.seed}: {reader}: {wrong}"

    with tempfile.TemporaryDirectory(prefix="lichtenberg-damaged-") as name, ThreadPoolExecutor(request.jobs) as pool:
        folder = Path(name)
        subprocess.run([program.with_name("fuzz"), "draw", "--seed", str(request.seed), "--first", str(request.first), "--cases",
                        str(request.cases), "--keep", folder], check=True)  # fmt: skip
        for failure in filter(None, pool.map(attempt, range(request.first, request.first + request.cases))):
            failures += 1
            print(failure, flush=True)
    print(f"{request.cases} damaged results from {request.first} of seed {request.seed} on: {failures} failures")
    if figures := os.environ.get("LICHTENBERG_FIGURES"):
        rate = request.cases / (time.monotonic() - start)
        Path(figures).write_text(json.dumps({"cases": request.cases, "broken rules": failures, "cases per second": rate}), encoding="utf-8")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
