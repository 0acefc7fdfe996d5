#!/usr/bin/env python3
"""Compares results of builds of the preset repeatable for processors with and without AVX-512, bit by bit.

PROGRAM is the build for AVX2. It is compared with a build for AVX-512 (for SSE 4.2 on processors without AVX-512), for which this
script configures and builds build-repeatable-other; with --other with that program. All shortened scenes of
tests/shipped_scenes.json are run. With --emulator the build is also compared with itself on an emulated processor, for which the
libraries may choose other code (Debian package qemu-user); this takes ten times as long."""
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
    words = ["-S", ROOT, "--preset", "repeatable", "-B", build, f"-DCMAKE_CXX_FLAGS=-march=x86-64-v{4 if wide else 2}"]
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


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path, help="build of the preset repeatable, as build-repeatable/lichtenberg")
    parser.add_argument("--other", type=Path, help="compare with this program instead of a new build")
    parser.add_argument("--emulator", type=shlex.split, help='as "qemu-x86_64 -cpu Haswell"')
    parser.add_argument("--scene", help="only this scene")
    request = parser.parse_args()
    if request.emulator and not shutil.which(request.emulator[0]):
        sys.exit(f"repeatability: {request.emulator[0]} is missing: apt-get install qemu-user")
    os.environ["LC_ALL"] = "C.UTF-8"
    program = request.program.resolve()
    other = (request.other or build_other()).resolve()
    rows = json.loads((ROOT / "tests/shipped_scenes.json").read_text(encoding="utf-8"))["rows"]
    rows = [row for row in rows if request.scene in (None, row["scene"])]
    if not rows:
        sys.exit(f"repeatability: tests/shipped_scenes.json has no scene {request.scene}")
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
