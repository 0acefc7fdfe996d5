"""Runs each whole command of the pages in docs/how-to, in its order, on small scenes of the same names.

Commands on a CUDA device are left out. Those with mpirun run if it is installed.
"""
import contextlib
import io
import json
import os
import re
import shutil
import subprocess
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

import runs
from lichtenberg import load
from lichtenberg import core

SMALLER = {  # Replacements in a scene.
    "dendrite": {"count = 324": "count = 12", "cells = 512": "cells = 128", "time = 120.0": "time = 1.2"},
    "large-dendrite": {"count = 2500": "count = 12", "[15.36e-2, 15.36e-2]": "[1.28e-2, 1.28e-2]", "at = 7.68e-2": "at = 0.64e-2", "cells = 1536": "cells = 64", "time = 120.0": "time = 0.2"},
    "seedling": {"time = 120.0": "time = 0.02"},
    "two-disks": {},
    "pair": {},
    "dendrite-3d": {"count = 324": "count = 8", "time = 120.0": "time = 0.1"},
    "packing": {"count = 400": "count = 40", "[20e-3, 20e-3]": "[6.4e-3, 6.4e-3]"},
    "packing-spheres": {"count = 750": "count = 40", "[10e-3, 10e-3, 10e-3]": "[3.8e-3, 3.8e-3, 3.8e-3]"},
    "granular-gas": {"count = 8516": "count = 60", "[38.8, 38.8, 38.8]": "[7.4, 7.4, 7.4]", "time = 155": "time = 8", "every = 5": "every = 1"},
}
NO_PICTURE = {"[output]\n": "[output]\npicture = false\n"}  # Other scenes draw the picture at the end of a run.


def picture(path):
    """Pixels [h, w, 4] between 0 and 1."""
    import matplotlib.image

    return matplotlib.image.imread(path)


def coloured(path):
    """Share of a picture's pixels that are neither grey nor white nor black."""
    pixels = picture(path)[..., :3]
    return (np.ptp(pixels, axis=2) > 0.15).mean()


# Open MPI would otherwise refuse more processes than cores, and runs by root (in a container).
ANY_MPIRUN = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1",
               "OMPI_MCA_mpi_yield_when_idle": "1"}


class SmallScenes(unittest.TestCase):
    """A test in a new folder with small scenes."""

    def enter_folder(self, name):
        before = os.getcwd()
        os.makedirs(runs.FOLDER / name)
        os.chdir(runs.FOLDER / name)
        self.addCleanup(os.chdir, before)
        os.makedirs("scenes")
        for scene, changes in SMALLER.items():
            text = (runs.HOME / f"scenes/{scene}.toml").read_text()
            for old, new in (changes | NO_PICTURE if scene.startswith("dendrite") else changes).items():
                self.assertIn(old, text)
                text = text.replace(old, new)
            Path(f"scenes/{scene}.toml").write_text(text)
        shutil.copy("scenes/two-disks.toml", "scenes/dendrite-snapshot.toml")

    def call(self, command, before=""):
        ended = subprocess.run(f"{before}'{runs.PROGRAM}' {command}", shell=True, capture_output=True, text=True, check=False)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        return ended.stdout


class Pages(SmallScenes):
    """Commands and Python blocks of the pages about one question each."""

    def commands(self, name):
        text = re.sub(r"\\\n\s*", "", (runs.HOME / f"docs/how-to/{name}.md").read_text())
        found = re.findall(r"^    (mpirun -n \d+ )?(?:\./|build/)lichtenberg (.*)$", text, re.MULTILINE)
        self.assertGreater(len(found), 0)
        return found

    def test_restart(self):
        self.enter_folder("restart")
        self.call("run scenes/dendrite.toml --quiet --set stop.time=0.5")
        for _, command in self.commands("restart"):
            with self.subTest(command):
                self.call(command.replace("stop.time=200", "stop.time=2"))
        self.assertEqual(len(load("dendrite.h5")), 13)  # the last command began again

    @runs.long
    def test_several_processes(self):
        self.enter_folder("several-processes")
        here = shutil.which("mpirun")
        self.enterContext(mock.patch.dict(os.environ, ANY_MPIRUN))
        for start, command in self.commands("several-processes"):
            with self.subTest(command):
                self.call(command, start if here else "")

    @runs.long
    def test_ensemble_over_machines(self):
        self.enter_folder("ensemble-over-machines")
        for _, command in self.commands("ensemble-over-machines")[::-1]:  # first the share, then the rest
            with self.subTest(command):
                self.call(command)
        table = json.loads(Path("seedling-ensemble/ensemble.json").read_text())
        self.assertEqual([member["state"] for member in table["members"]], ["finished"] * 24)

    def test_cite(self):
        for _, command in self.commands("cite"):
            self.assertRegex(self.call(command), r"^lichtenberg \d")

    def run_blocks(self, name):
        """Runs the Python blocks of a page in their order. Returns their names."""
        text = (runs.HOME / f"docs/how-to/{name}.md").read_text()
        names = {}
        with contextlib.redirect_stdout(io.StringIO()):
            for block in re.findall(r"^```python\n(.*?)^```", text, re.DOTALL | re.MULTILINE):
                exec(compile(block, f"{name}.md", "exec"), names)  # noqa: S102
        return names

    def test_read_charges_in_python(self):
        self.enter_folder("read-charges")
        self.call("run scenes/dendrite.toml --quiet --set stop.time=0.5")
        charge = self.run_blocks("read-charges-in-python")["charge"]
        self.assertEqual((charge.unit, charge.shape), ("C", (6, 12)))

    @unittest.skipUnless(core.find(), "the module of the package is not built")
    def test_solve_in_python(self):
        self.enter_folder("solve-in-python")
        self.assertEqual(self.run_blocks("solve-in-python")["s"].potential.unit, "V")
        self.assertEqual(load("short.h5").count, 36)

    def test_no_command_of_a_page_is_left_out(self):
        tested = {name.removeprefix("test_").replace("_", "-") for name in dir(self) if name.startswith("test_")}
        for page in (runs.HOME / "docs/how-to").glob("*.md"):
            blocks = re.findall(r"^    (?:mpirun -n \d+ )?(?:\./|build/)lichtenberg .*$|^```python$", page.read_text(), re.MULTILINE)
            if blocks and page.stem != "index":
                with self.subTest(page.name):
                    self.assertIn(page.stem, tested)


class Table(SmallScenes):
    """Files or output of each command; `said` is its output."""

    def run_first(self, said):
        self.assertEqual(len(load("dendrite.h5")), 13)

    def run_from(self, said):
        with load("other.h5") as other, load("dendrite.h5") as before:
            np.testing.assert_array_equal(other.frame(0)["position"], before.frame(10)["position"])
            self.assertIn("viscosity", str(other.provenance[0]["command_line"]))

    def dish(self, said):
        with load("dendrite-3d.h5") as result:
            self.assertEqual((result.count, result.dimension, len(result)), (8, 3, 2))
            np.testing.assert_array_equal(result.frame(1)["position"][:, 2], result.frame(0)["position"][:, 2])

    def explain(self, said):
        self.assertRegex(said, r"conductors +12\n")

    def solve(self, said):
        self.assertIn("652.1", said)
        self.assertIn("capacitance matrix", said)

    def work_precision(self, said):
        self.assertIn("multipole", said)
        self.assertGreater(picture("dendrite-snapshot-work-precision.png").shape[0], 300)

    def ensemble(self, said):
        table = json.loads(Path("seedling-ensemble/ensemble.json").read_text())
        self.assertEqual([member["state"] for member in table["members"]], ["finished"] * 24)
        self.assertIn("95 %", said)

    def analyse(self, said):
        self.assertIn("Strahler", said)

    def gas(self, said):
        with load("granular-gas.h5") as result:
            self.assertEqual(result.count, 60)
            self.assertGreater(result.tables["gas"]["collisions"][-1], 0)

    def analyse_gas(self, said):
        with load("granular-gas.h5") as result:
            self.assertIn("analysis", result.tables)

    def theory(self, said):
        self.assertTrue([name for name in os.listdir() if "kinetic" in name and name.endswith(".png")])

    def packing(self, said):
        with load("packing.h5") as result:
            self.assertEqual(result.dimension, 2)
            self.assertLess(result.tables["relaxation"]["largest_force"][-1], result.tables["relaxation"]["largest_force"][0])

    def network(self, said):
        self.assertRegex(said, r"resistance +[0-9.e+-]+")

    def plot(self, said):
        self.assertIn("dendrite-frame-10-potential.png shows frame 10 by potential", said)
        self.assertGreater(coloured("dendrite-frame-10-potential.png"), 0.3)

    def film(self, said):
        self.assertIn("13 frames", said)
        self.assertEqual(Path("dendrite.mp4").read_bytes()[4:8], b"ftyp")

    def series(self, said):
        self.assertGreater(coloured("dendrite-series.png"), 0.001)

    def view(self, said):
        self.assertIn("<canvas", Path("dendrite.html").read_text())

    def vtk(self, said):
        self.assertLessEqual({"particles.pvd", "tree.pvd", "contacts.pvd", "field.vti"}, set(os.listdir("dendrite-vtk")))

    def xyz(self, said):
        self.assertEqual(Path("dendrite.xyz").read_text()[:3], "12\n")

    def csv(self, said):
        self.assertEqual(len(Path("dendrite-csv/particles.csv").read_text().splitlines()), 1 + 13 * 12)

    def help_scene(self, said):
        self.assertIn("effects.contact_discharge", said)

    def manual(self, said):
        self.assertIn(".SS film RESULT", Path("lichtenberg.1").read_text())

    CHECKS = {
        "run --resume scenes/dendrite.toml": run_first,
        "run scenes/dendrite.toml --from dendrite.h5 --frame 10 --out other.h5 --set medium.viscosity=1.4": run_from,
        "run scenes/dendrite-3d.toml": dish,
        "explain scenes/dendrite.toml": explain,
        "solve scenes/two-disks.toml --capacitance": solve,
        "work-precision scenes/dendrite-snapshot.toml": work_precision,
        "ensemble scenes/seedling.toml --conductors 16,25,36 --seeds 8": ensemble,
        "analyse dendrite.h5": analyse,
        "run scenes/granular-gas.toml": gas,
        "theory kinetic --scene scenes/granular-gas.toml --plot": theory,
        "analyse granular-gas.h5": analyse_gas,
        "run scenes/packing.toml": packing,
        "network packing.h5": network,
        "plot dendrite.h5 --frame 10": plot,
        "film dendrite.h5": film,
        "plot --series dendrite.h5": series,
        "view dendrite.h5": view,
        "export dendrite.h5 --to vtk": vtk,
        "export dendrite.h5 --to xyz": xyz,
        "export dendrite.h5 --to csv": csv,
        "help scene": help_scene,
        "help man >lichtenberg.1": manual,
    }

    # No scene setting makes this command shorter.
    SHORTER = {"work-precision scenes/dendrite-snapshot.toml": " --sizes 64,128"}

    @runs.long
    def test_each_command(self):
        page = (runs.HOME / "docs/how-to/index.md").read_text()
        table = page[page.index("## Commands by task") : page.index("## Questions")]
        commands = [command for command in re.findall(r"`\./lichtenberg ([^`]*)`", table) if "..." not in command]
        self.assertEqual(commands, list(self.CHECKS))
        self.enter_folder("how-to")
        self.call("run scenes/dendrite.toml --quiet --set stop.time=0.5")  # --resume continues this run.
        for command, check in self.CHECKS.items():
            with self.subTest(command):
                check(self, self.call(command + self.SHORTER.get(command, "")))


if __name__ == "__main__":
    unittest.main()
