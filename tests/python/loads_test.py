"""Packings with loads: resistance against load, refusals, pictures, and a run that is interrupted and resumed."""
import json
import signal
import subprocess
import time
import unittest
from functools import cache

import h5py
import numpy as np
import runs
from lichtenberg import load, view

CHAIN = """
[domain]
size = [8e-3, 8e-3, 24e-3]
[effects.soft_repulsion]
form = "hertzian"
stiffness = 39.1e3
[minimize]
force_tolerance = 1e-12
[compression]
plate = "back"
pressure = [1e5, 8e5]
tolerance = 1e-6
[network]
terminals = "front,back"
resistor = "hertz"
resistivity = 7.2e-7
elastic_modulus = 1.146e11
[output]
picture = false
""" + "".join(f"[[conductor]]\nposition = [4e-3, 4e-3, {4 + 8 * k}e-3]\nradius = 4e-3\n" for k in range(3))

DISKS = """
[domain]
size = [30e-3, 30e-3]
left = "periodic"
right = "periodic"
[[population]]
count = 400
radii = [0.5e-3, 0.7e-3]
overlapping = true
[effects.soft_repulsion]
form = "harmonic"
[compression]
filling = [0.86, 0.88]
step = 0.02
[minimize]
force_tolerance = 1e-10
[output]
picture = false
"""


@cache
def loaded_disks():
    return runs.made("disks", DISKS)


class Loads(unittest.TestCase):
    def test_chain_has_the_resistance_of_hertz_at_each_load(self):
        chain = runs.made("chain", CHAIN)
        status, text, complaint = runs.program("network", chain, "--loads", "--json")
        self.assertEqual(status, 0, complaint)
        loads = json.loads(text)["loads"]
        self.assertEqual([load["frame"] for load in loads], [1, 2])
        for load in loads:
            force = load["pressure"] * 64e-6
            between, wall = (np.cbrt(0.75 * force * radius / 1.146e11) for radius in (2e-3, 4e-3))
            expected = 7.2e-7 * (2 / (2 * between) + 2 / (4 * wall))
            for network in load["networks"]:
                # Net forces up to 5e-6 N, 1e-12 stiffness over diameter, change forces of 6 N by 8e-7
                self.assertAlmostEqual(network["resistance"] / expected, 1, delta=1e-6)
        # Eight times the force, half the resistance, within these and the tolerance of both pressures
        first, second = (load["networks"][0]["resistance"] for load in loads)
        self.assertAlmostEqual(first / second, 2, delta=4e-6)
        _, table, _ = runs.program("network", chain, "--loads", "--model", "particle")
        self.assertIn("# load  packing_fraction  pressure in Pa      particle-centred", table)

    def test_loads_are_refused_where_there_are_none(self):
        table = CHAIN[CHAIN.index("[compression]"):CHAIN.index("[network]")]
        packing = runs.made("unloaded", CHAIN.replace(table, ""))
        status, _, complaint = runs.program("network", packing, "--loads")
        self.assertEqual((status, "it has no loads" in complaint), (2, True), complaint)
        chain = runs.made("refused", CHAIN)
        for option in (["--frame", "1"], ["--voltage", "2"], ["--out", "x.png"], ["--terminals", "0,all"]):
            status, _, complaint = runs.program("network", chain, "--loads", *option)
            self.assertEqual((status, "with --loads" in complaint), (2, True), complaint)

    def test_pressure_beyond_a_packing_fraction_of_1_exits_with_2(self):
        scene = DISKS.replace("filling = [0.86, 0.88]", "pressure = [1e9]")
        (runs.FOLDER / "beyond.toml").write_text(scene)
        status, _, complaint = runs.program("run", "beyond.toml", "--quiet")
        self.assertEqual((status, "the pressure 1e+09 is not reached" in complaint), (2, True), complaint)

    def test_pictures_of_loads_have_their_own_domain(self):
        disks = loaded_disks()
        for words in (["plot", disks], ["plot", disks, "--frame", "1"], ["network", disks]):
            status, _, complaint = runs.program(*words, "--overwrite")
            self.assertEqual(status, 0, complaint)
        with h5py.File(disks) as file:
            edges = file["particles/conductors/box/edges/value"][:, 0, 0]
            self.assertEqual(list(edges), list(file["observables/size_x/value"]))
            self.assertLess(edges[2], edges[1])

    def test_run_from_a_load_needs_its_domain(self):
        disks = loaded_disks()
        with load(disks) as result:
            size = result.frame(1).size.tolist()
        (runs.FOLDER / "next.toml").write_text(DISKS)
        start = ["run", "next.toml", "--quiet", "--overwrite", "--from", disks, "--frame", "1"]
        status, _, complaint = runs.program(*start)
        self.assertEqual((status, f"domain.size = [{size[0]}, {size[1]}]" in complaint), (2, True), complaint)
        status, _, complaint = runs.program(*start, "--set", f"domain.size={size}")
        self.assertEqual(status, 0, complaint)
        with load(runs.FOLDER / "next.h5") as result:
            self.assertEqual(result.size.tolist(), size)
            self.assertAlmostEqual(float(result.observables["packing_fraction"][0]), 0.86, delta=1e-12)

    def test_exported_box_and_page_have_the_size_of_each_load(self):
        disks = loaded_disks()
        out = runs.FOLDER / "disks.xyz"
        status, _, complaint = runs.command("export", disks, "--to", "xyz", "--out", out, "--overwrite")
        self.assertEqual(status, 0, complaint)
        with load(disks) as result:
            sizes = [frame.size.tolist() for frame in result]
            self.assertLess(sizes[2][0], sizes[1][0])
            np.testing.assert_allclose(view.Page(result, range(3)).about["sizes"], sizes, rtol=1e-5)  # it has six digits
        boxes = [line.split('"')[1].split() for line in out.read_text().splitlines() if line.startswith("Lattice")]
        self.assertEqual([[box[0], box[4]] for box in boxes], [[f"{length:.10g}" for length in size] for size in sizes])

    def test_interrupted_run_resumes_with_identical_loads(self):
        whole = runs.made("whole", DISKS.replace("0.88]", "0.861, 0.862, 0.863, 0.864, 0.865]"))
        (runs.FOLDER / "parts.toml").write_text((runs.FOLDER / "whole.toml").read_text())
        running = subprocess.Popen([runs.PROGRAM, "run", "parts.toml", "--quiet"], cwd=runs.FOLDER,
                                   stderr=subprocess.DEVNULL)
        while running.poll() is None and not (runs.FOLDER / "parts.h5").exists():
            time.sleep(0.001)
        running.send_signal(signal.SIGTERM)
        if running.wait() != 0:  # it was not over yet
            status, _, complaint = runs.program("run", "parts.toml", "--resume", "--quiet")
            self.assertEqual(status, 0, complaint)
        with h5py.File(whole) as one, h5py.File(runs.FOLDER / "parts.h5") as other:
            for name in ("particles/conductors/position/value", "observables/size_x/value", "observables/pressure/value"):
                self.assertTrue(np.array_equal(one[name][()], other[name][()]), name)


if __name__ == "__main__":
    unittest.main()
