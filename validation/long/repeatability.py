#!/usr/bin/env python3
"""Compares results of builds of the preset repeatable for processors with and without AVX-512, bit by bit.

PROGRAM is the build for AVX2. This script configures and builds build-repeatable-other for AVX-512, and compares both. On
processors without AVX-512, that build has all instructions of this processor. --other names a program to compare with instead. All shortened scenes of
tests/shipped_scenes.json are run. With --emulator the build is also compared with itself on an emulated processor, for which the
libraries may choose other code (Debian package qemu-user); this takes ten times as long. With --price only the user time of
some runs is measured, next to that of the other program."""
import argparse
import json
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
TIMES = {"seconds"}  # of the output of `solve --json`
PRICED = {  # scene -> changed keys, for about a second of one thread each
    "dendrite": {"field.threads": 1, "stop.time": 0.2},
    "large-dendrite": {"field.threads": 1, "population[0].count": 400, "stop.time": 0.01},
    "dendrite-3d": {"field.threads": 1, "stop.time": 0.005},
    "packing": {"minimize.threads": 1, "population[0].count": 3000, "domain.size": "[55e-3, 55e-3]"},
    "neutral-gas": {"mechanics.threads": 1, "stop.time": 8},
    "granular-gas": {"mechanics.threads": 1, "stop.time": 5.5},
    "polarized-gas": {"mechanics.threads": 1, "stop.time": 8.2},
}


def results(program, row, folder, emulator=()):
    """Returns all numbers of a run, or of `solve --json`, by name, as bytes."""
    words = [*emulator, str(program), row["command"], str(ROOT / "scenes" / row["scene"])]
    for key, value in row["settings"].items():
        words += ["--set", f"{key}={value}"]
    words += ["--out", "result.h5", "--overwrite", "--quiet"] if row["command"] == "run" else ["--json"]
    ended = subprocess.run(words, capture_output=True, cwd=folder, check=False)
    if ended.returncode:
        raise RuntimeError(f"{shlex.join(words)} ended with status {ended.returncode}: {ended.stderr.decode()[-300:]}")
    if row["command"] != "run":
        return {name: json.dumps(value) for name, value in json.loads(ended.stdout).items() if name not in TIMES}
    found = {}

    def keep(name, item):
        if isinstance(item, h5py.Dataset) and not name.startswith("provenance"):
            found[name] = np.asarray(item[()]).tobytes()

    with h5py.File(folder / "result.h5") as file:
        file.visititems(keep)
    return found


def differing(left, right):
    """Returns the names of arrays that differ or that only one result has."""
    return sorted(name for name in left.keys() | right.keys() if left.get(name) != right.get(name))


def build_other():
    """Configures and builds for other vectors than those of the preset; returns the program."""
    wide = "avx512vl" in Path("/proc/cpuinfo").read_text(encoding="utf-8")
    build = ROOT / "build-repeatable-other"
    words = ["-S", ROOT, "--preset", "repeatable", "-B", build, f"-DCMAKE_CXX_FLAGS=-march={'x86-64-v4' if wide else 'native'}"]
    subprocess.run(["cmake", *words], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["ninja", "-C", build, "lichtenberg"], check=True, stdout=subprocess.DEVNULL)
    return build / "lichtenberg"


def compare(kind, rows, first, second):
    """Prints and returns the scenes with differences. `first` and `second` run a row in a folder."""
    failed = []
    for row in rows:
        with tempfile.TemporaryDirectory(prefix="lichtenberg-bits-") as folder:
            start = time.monotonic()
            names = differing(first(row, Path(folder)), second(row, Path(folder)))
            print(f"{kind}: {row['scene']} {row['command']}: {len(names)} arrays differ {names[:3]} ({time.monotonic() - start:.1f} s)", flush=True)
            if names:
                failed.append(row["scene"])
    return failed


def user_time(program, scene):
    """Returns the user time (s) of a run of PRICED."""
    words = [program, "run", ROOT / f"scenes/{scene}.toml", "--quiet", "--overwrite", "--set", "output.picture=false"]
    for key, value in PRICED[scene].items():
        words += ["--set", f"{key}={value}"]
    with tempfile.TemporaryDirectory(prefix="lichtenberg-price-") as folder:
        child = subprocess.Popen(words, cwd=folder, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(child.pid, 0)
    if status:
        raise RuntimeError(f"{shlex.join(map(str, words))} ended with status {os.waitstatus_to_exitcode(status)}")
    return usage.ru_utime


def print_prices(scenes, program, other):
    """Prints the shortest of three user times for each program; the programs alternate."""
    for scene in scenes:
        times = [(user_time(other, scene), user_time(program, scene)) for _ in range(3)]
        usual, repeatable = (min(each) for each in zip(*times))
        print(f"{scene}: other {usual:.2f} s, repeatable {repeatable:.2f} s, ratio {repeatable / usual:.2f}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path, help="build of the preset repeatable, as build-repeatable/lichtenberg")
    parser.add_argument("--other", type=Path, help="compare with this program instead of a new build")
    parser.add_argument("--emulator", type=shlex.split, help='as "qemu-x86_64 -cpu Haswell"')
    parser.add_argument("--scene", action="append", help="only this scene; may be repeated")
    parser.add_argument("--price", type=Path, metavar="OTHER", help="measure user times of both programs only, as build/lichtenberg")
    request = parser.parse_args()
    if request.price:
        if request.other or request.emulator:
            parser.error("--price compares two given programs: leave out --other and --emulator")
        for scene in set(request.scene or []) - set(PRICED):
            parser.error(f"--scene {scene} has no price; allowed are {', '.join(PRICED)}")
        return print_prices(request.scene or PRICED, request.program.resolve(), request.price.resolve())
    if request.emulator and not shutil.which(request.emulator[0]):
        sys.exit(f"repeatability: {request.emulator[0]} is missing: apt-get install qemu-user")
    os.environ["LC_ALL"] = "C.UTF-8"
    program = request.program.resolve()
    other = (request.other or build_other()).resolve()
    rows = json.loads((ROOT / "tests/shipped_scenes.json").read_text(encoding="utf-8"))["rows"]
    for scene in set(request.scene or []) - {row["scene"] for row in rows}:
        sys.exit(f"repeatability: tests/shipped_scenes.json has no scene {scene}")
    rows = [row for row in rows if not request.scene or row["scene"] in request.scene]
    figures = {"scenes": len(rows)}
    failed = compare("two builds", rows, lambda row, folder: results(program, row, folder), lambda row, folder: results(other, row, folder))
    figures["differing_between_builds"] = len(failed)
    if request.emulator:
        there = compare("two processors", rows, lambda row, folder: results(program, row, folder),
                        lambda row, folder: results(program, row, folder, request.emulator))  # fmt: skip
        figures["differing_between_processors"] = len(there)
        failed += there
    if "LICHTENBERG_FIGURES" in os.environ:
        Path(os.environ["LICHTENBERG_FIGURES"]).write_text(json.dumps(figures), encoding="utf-8")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
