"""Forces of charges by LAMMPS."""
import math
import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from ..errors import Failure, InputError
from . import Method

# Particles are at rest, so each step is an evaluation and no neighbour list is rebuilt.
COMMANDS = """units lj
atom_style charge
read_data data
pair_style coul/long {cutoff}
pair_coeff * *
kspace_style pppm {accuracy}
neighbor 0.3 bin
dump forces all custom 1000000 forces id fx fy fz
dump_modify forces sort id format float %.17g
run {steps}
"""
LEAST_STEPS, WORK = 3, 50000  # steps of one grain, enough for its timer, which resolves milliseconds
HEAD = 9  # header lines of the file of forces


class Lammps(Method):
    name, kind = "lammps", "charges"
    description = "LAMMPS' PPPM (Gauss, B-splines of order 5), by its own clock"

    def candidates(self, sweep):
        cutoffs = [cutoff for cutoff in (4.0, 5.0, 6.0, 7.0) if cutoff <= min(sweep.subject["lengths"]) / 2]
        return [
            ({"accuracy": accuracy, "cutoff": cutoff}, (2 - math.log10(accuracy)) ** 3)
            for accuracy in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
            for cutoff in cutoffs
        ]

    def prepare(self, sweep, settings):
        if not sweep.subject["periodic"]:
            raise InputError("LAMMPS is compared in periodic boxes only")
        if not shutil.which("lmp"):
            raise InputError("LAMMPS is not installed: there is no command `lmp` (Debian's package lammps)")
        count = len(sweep.subject["charge"])
        steps = max(LEAST_STEPS, WORK // count)
        folder = tempfile.TemporaryDirectory(prefix="lichtenberg-")
        path = Path(folder.name)
        (path / "data").write_text(data_of(sweep.subject), encoding="utf-8")
        (path / "in").write_text(COMMANDS.format(steps=steps, **settings), encoding="utf-8")

        def run():
            words, environment = ["lmp", "-in", "in", "-log", "none"], {**os.environ, "OMP_NUM_THREADS": "1"}
            streams = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
            ended = subprocess.run(words, cwd=folder.name, env=environment, check=False, **streams)
            found = re.search(r"Loop time of (\S+) on[\s\S]*?([0-9.]+)% CPU use", ended.stdout)
            rows = [line.split()[1:] for line in (path / "forces").read_text(encoding="utf-8").splitlines()[HEAD:]] if found else []
            if ended.returncode != 0 or len(rows) != count:
                raise Failure("LAMMPS failed")
            seconds = float(found[1]) * float(found[2]) / 100 / steps
            return {"force": [float(component) for row in rows for component in row]}, seconds

        return run


def data_of(subject):
    lines = ["grains", "", f"{len(subject['charge'])} atoms", "1 atom types"]
    lines += [f"0 {length:.17g} {axis}lo {axis}hi" for length, axis in zip(subject["lengths"], "xyz")]
    lines += ["", "Masses", "", "1 1", "", "Atoms # charge", ""]
    positions = zip(*[iter(subject["position"])] * 3)
    lines += [
        f"{i} 1 {q:.17g} {x:.17g} {y:.17g} {z:.17g}" for i, (q, (x, y, z)) in enumerate(zip(subject["charge"], positions), 1)
    ]
    return "\n".join(lines) + "\n"
