#!/usr/bin/env python3
"""Runs six small scenes on a CUDA device with each tool of NVIDIA's compute-sanitizer.

    validation/device/sanitizers.py [--program build-gpu/lichtenberg] [--tools memcheck,racecheck] [--cases NAME,...]

Memcheck finds accesses outside of allocated memory, and initcheck reads of uninitialized memory. Racecheck finds
unordered accesses to the shared memory of a block, and synccheck barriers that not all threads of a block reach. Prints
a row per run. Exits with 1 if a tool reports an error or a program fails, with 2 if the program or compute-sanitizer is missing.
"""
import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

HOME = pathlib.Path(__file__).resolve().parents[2]
TOOLS = ["memcheck", "initcheck", "racecheck", "synccheck"]
REPORTED = 86  # exit status that a tool gives a program with errors

# Version 2025.3.1 of the tools fails for kernels in while nodes of graphs: racecheck crashes and synccheck reports
# divergent barriers even for a kernel of one barrier without a branch. The host decides on loops instead.
ENVIRONMENT = os.environ | {"LICHTENBERG_CUDA_LOOPS": "host"}

SHORT_GAS = {"stop.time": "1", "output.every": "0.5", "output.picture": "false", "equilibration[0].duration": "0.2"}
CASES = {
    "solve": ("solve", "two-disks", {"field.cells": "128"}),
    "conductors": ("run", "seedling", {"stop.time": "0.05", "output.picture": "false"}),
    "resistors": ("run", "wire-growth", {"stop.time": "0.01", "output.picture": "false"}),
    "contacts": ("run", "neutral-gas", SHORT_GAS | {"population[0].count": "500", "domain.size": "[15, 15, 15]"}),
    "charges": ("run", "granular-gas", SHORT_GAS | {"population[0].count": "500", "domain.size": "[15, 15, 15]"}),
    "dipoles": ("run", "polarized-gas", SHORT_GAS | {"population[0].count": "200", "domain.size": "[11, 11, 11]",
                                                     "equilibration[1].duration": "0.2"}),
}


def command(program, case, folder):
    verb, scene, settings = CASES[case]
    words = [program, verb, str(HOME / "scenes" / f"{scene}.toml"), "--device", "cuda"]
    if verb == "run":
        words += ["--out", str(folder / f"{case}.h5"), "--overwrite"]
    for key, value in settings.items():
        words += ["--set", f"{key}={value}"]
    return words


def check(sanitizer, tool, program, case, folder, show):
    """Runs one case under one tool; returns (status, errors, seconds, output). `errors` is None without a summary."""
    words = [sanitizer, "--tool", tool, "--error-exitcode", str(REPORTED), "--print-limit", str(show)]
    start = time.monotonic()
    done = subprocess.run(words + command(program, case, folder), stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, errors="replace", cwd=folder, env=ENVIRONMENT)
    summary = re.findall(r"(?:ERROR SUMMARY: (\d+) error|RACECHECK SUMMARY: (\d+) hazard)", done.stdout)
    errors = max((int(a or b) for a, b in summary), default=None)
    return done.returncode, errors, time.monotonic() - start, done.stdout


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--program", default=str(HOME / "build-gpu" / "lichtenberg"))
    parser.add_argument("--tools", default=",".join(TOOLS))
    parser.add_argument("--cases", default=",".join(CASES))
    parser.add_argument("--show", type=int, default=3, help="errors that are printed for each run")
    options = parser.parse_args()
    options.tools, options.cases = options.tools.split(","), options.cases.split(",")
    for given, known in ((options.tools, TOOLS), (options.cases, CASES)):
        for name in given:
            if name not in known:
                parser.error(f"there is no {name!r}; known are {', '.join(known)}")
    return options


def main():
    options = arguments()
    sanitizer = shutil.which("compute-sanitizer") or shutil.which("/usr/local/cuda/bin/compute-sanitizer")
    if not sanitizer:
        print("sanitizers.py: compute-sanitizer is not on the PATH; it is part of the CUDA toolkit", file=sys.stderr)
        return 2
    if not shutil.which(options.program):
        print(f"sanitizers.py: --program: there is no program {options.program}", file=sys.stderr)
        return 2
    failed = 0
    print(f"{'tool':<11}{'case':<12}{'exit':>5}{'errors':>8}{'s':>8}", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for tool in options.tools:
            for case in options.cases:
                status, errors, seconds, output = check(sanitizer, tool, options.program, case, pathlib.Path(folder),
                                                        options.show)
                print(f"{tool:<11}{case:<12}{status:>5}{'?' if errors is None else errors:>8}{seconds:>8.1f}", flush=True)
                if status != 0 or errors != 0:
                    failed += 1
                    print("\n".join("    " + line for line in output.splitlines()[-40 * options.show:]), flush=True)
    print(f"{failed} of {len(options.tools) * len(options.cases)} runs failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
