"""Runs of lichtenberg_conductors, the part of the program for a first build (src/conductors.cpp)."""
import os
import subprocess
import unittest

import h5py
import numpy as np

import runs

PART = os.path.join(os.path.dirname(runs.PROGRAM), "lichtenberg_conductors")


def datasets(path):
    """Values of all datasets of a result, by name, without the times that its computation took."""
    found = {}

    def keep(name, entry):
        if isinstance(entry, h5py.Dataset) and "/seconds/" not in name:
            found[name] = entry[()]
    with h5py.File(path) as file:
        file.visititems(keep)
    return found


class Conductors(unittest.TestCase):
    def run_part(self, *words):
        ended = subprocess.run([PART, *words], capture_output=True, text=True, cwd=runs.FOLDER, check=False)
        return ended.returncode, ended.stderr

    def test_a_run_has_the_bits_of_the_whole_program(self):
        for scene, stop in (("seedling", "0.1"), ("dendrite-3d", "0.1")):
            words = ["run", str(runs.HOME / f"scenes/{scene}.toml"), "--quiet", "--set", f"stop.time={stop}",
                     "--set", "population.count=12"]
            self.assertEqual(self.run_part(*words, "--out", f"{scene}-part.h5"), (0, ""))
            self.assertEqual(runs.program(*words, "--out", f"{scene}-whole.h5")[0], 0)
            part, whole = (datasets(runs.FOLDER / f"{scene}-{kind}.h5") for kind in ("part", "whole"))
            self.assertEqual(part.keys(), whole.keys())
            for name, values in part.items():
                np.testing.assert_array_equal(values, whole[name], name)

    def test_scenes_of_grains_are_refused(self):
        (runs.FOLDER / "grains.toml").write_text(runs.gas_scene())
        status, message = self.run_part("run", "grains.toml")
        self.assertEqual(status, 2)
        self.assertIn("grains.toml:", message)


if __name__ == "__main__":
    unittest.main()
