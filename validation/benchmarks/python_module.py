#!/usr/bin/python3
"""Measures the Python module: start, overhead of a solve and of a frame, memory, and a compiled effect.

    python_module.py [--solves 1000] [--grains 100000] [--record]

--record writes docs/measurements/python-module.json. The program must be built with its module (ninja python_module).
"""
import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HOME = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(HOME / "python"))

import numpy as np

import lichtenberg as li

TABLES = {"medium": {"permittivity": 2.0}, "effects": {"floating_conductors": {}}}


def seconds_of(function, repeats):
    """Returns the median wall time of a call."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def import_time():
    start = "import time; t = time.perf_counter(); import lichtenberg; print(time.perf_counter() - t)"
    first = "import time; t = time.perf_counter(); import lichtenberg.core; lichtenberg.core.load(); import numpy; print(time.perf_counter() - t)"
    environment = {**os.environ, "PYTHONPATH": str(HOME / "python")}

    def run(code):
        words = [sys.executable, "-c", code]
        return float(subprocess.run(words, env=environment, check=True, capture_output=True, text=True).stdout)
    return [{"quantity": "import lichtenberg", "value": np.median([run(start) for _ in range(7)]), "unit": "s", "required": 0.15},
            {"quantity": "import with the module and numpy", "value": np.median([run(first) for _ in range(7)]), "unit": "s"}]


def random_scene(random, cells=64):
    return {**TABLES, "domain": {"size": [8e-3, 8e-3], "bottom": {"potential": 0.0}}, "field": {"cells": cells},
            "conductor": li.conductors(random.uniform(1.5e-3, 6.5e-3, (1, 2)), radius=random.uniform(2e-4, 1e-3), charge=1e-12)}


def solve_overhead():
    scene = li.Scene(random_scene(np.random.default_rng(1)))
    li.solve(scene)
    own = []

    def solve():
        answer = li.solve(scene)
        own.append(sum(answer.seconds.values()))
    wall = seconds_of(solve, 50)
    return [{"quantity": "solve of 64 cells in a warm process", "value": 1e3 * wall, "unit": "ms", "required": 3},
            {"quantity": "of it beyond the solver", "value": 1e3 * (wall - np.median(own)), "unit": "ms", "required": 1}]


def resident():
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def memory_growth(solves):
    random = np.random.default_rng(2)
    for _ in range(100):
        li.solve(random_scene(random))
    before = resident()
    for _ in range(solves):
        li.solve(random_scene(random))
    return [{"quantity": f"growth of memory over {solves} solves of random scenes", "value": (resident() - before) / 1e6, "unit": "MB"}]


def frame_overhead(grains):
    length = 38.8 * (grains / 8516) ** (1 / 3)  # at the density of the scene
    scene = li.Scene(str(HOME / "scenes/neutral-gas.toml"), {"population[0].count": grains, "domain.size": [length] * 3})
    run = li.Run(scene, record=False)
    frames = run.frames()
    next(frames)

    def read():
        frame = run._frame()
        return frame.position, frame.velocity
    return [{"quantity": f"a frame of {len(scene)} bodies", "value": 1e6 * seconds_of(run._frame, 200), "unit": "us", "required": 100},
            {"quantity": "the same with its arrays", "value": 1e6 * seconds_of(read, 20), "unit": "us"}]


def copied_effect():
    """Returns the source of Hertz's contact under another name."""
    header, source = ((HOME / f"src/effects/hertz_contact.{end}").read_text() for end in ("hpp", "cpp"))
    code = header.replace("#pragma once", "") + re.sub(r'#include "src/effects/hertz_contact.hpp"', "", source)
    code = code.replace("HertzContact", "CopiedContact").replace('"hertz_contact"', '"copied_contact"')
    return code + '\n#include "src/scene/compiled_effect.hpp"\nLICHTENBERG_EFFECT(lichtenberg::effects::CopiedContactOptions)\n'


def compiled_effect():
    with tempfile.TemporaryDirectory() as folder:
        os.environ["XDG_CACHE_HOME"] = folder
        start = time.perf_counter()
        effect = li.compile_effect(copied_effect())
        compiled = time.perf_counter() - start
    random = np.random.default_rng(3)
    n, spacing = 20, 2.02e-3
    grid = np.stack(np.meshgrid(*[np.arange(n)] * 3), -1).reshape(-1, 3) * spacing + 2e-3
    tables = {"domain": {"size": [0.05, 0.05, 0.05]}, "medium": {"permittivity": 2.0, "viscosity": 1e-3},
              "material": {"density": 1000.0}, "stop": {"time": 2e-3, "stationary": False}, "output": {"every": 1e-3, "picture": False},
              "conductor": li.conductors(grid + random.uniform(-9e-6, 9e-6, grid.shape), radius=1e-3)}

    for body in tables["conductor"]:
        body["velocity"] = random.uniform(-0.05, 0.05, 3)

    def run(name, effects):
        """Returns the processor time of a run and its last positions."""
        scene = li.Scene({**tables, "effects": {name: {"young": 1e6}, "stokes_drag": {}}}, compiled=effects)
        start = time.process_time()
        *_, last = li.Run(scene, record=False).frames()
        return time.process_time() - start, last.position
    rounds = [(run("hertz_contact", []), run("copied_contact", [effect])) for _ in range(7)]  # alternately
    built_in, own = (min(pair[k][0] for pair in rounds) for k in (0, 1))
    expected, found = (rounds[0][k][1] for k in (0, 1))
    if not (found == expected).all():
        sys.exit("the compiled effect moves the bodies differently")
    return [{"quantity": "compilation of Hertz's contact, once", "value": compiled, "unit": "s"},
            {"quantity": f"run of {n**3} spheres with the compiled effect over the built-in one", "value": own / built_in,
             "unit": "1", "required": 1.2}]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--solves", type=int, default=1000)
    parser.add_argument("--grains", type=int, default=100000)
    parser.add_argument("--record", action="store_true")
    options = parser.parse_args()
    rows = import_time() + solve_overhead() + memory_growth(options.solves) + frame_overhead(options.grains) + compiled_effect()
    for row in rows:
        row["value"] = float(f"{row['value']:.3g}")
        print(f"{row['quantity']:70} {row['value']:10.3g} {row['unit']:4} {row.get('required', '')}")
    if options.record:
        commit = subprocess.run(["git", "-C", HOME, "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True).stdout.strip()
        processor = next(line.split(": ")[1] for line in Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("model name"))
        record = {"page": "performance-parameters", "measures": "the Python module in process", "unit": "see rows",
                  "command": "validation/benchmarks/python_module.py --record", "commit": commit, "machine": processor,
                  "date": time.strftime("%Y-%m-%d"), "rows": rows}
        (HOME / "docs/measurements/python-module.json").write_text(json.dumps(record, indent=1) + "\n")


if __name__ == "__main__":
    main()
