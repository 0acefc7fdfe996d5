"""Method of `work-precision` added from outside by one file in Python: it calls the program's own `solve`."""
import json
import os
import sys
import unittest
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python"))
import runs

SCENE = """
[domain]
size = [16e-3, 16e-3]
bottom = { potential = 0.0 }
[medium]
permittivity = 4e-11
[[conductor]]
position = [5.13e-3, 8.07e-3]
radius = 1e-3
charge = 1e-10
[[conductor]]
position = [11.02e-3, 7.91e-3]
radius = 1e-3
charge = -0.7e-10
[effects.floating_conductors]
[field]
cells = 64
"""

MODULE = '''"""`lichtenberg compare`: work-precision with a method more."""
import lichtenberg
from lichtenberg.commands import work_precision
from lichtenberg.methods import Method


class Solve(Method):
    name, description, kind = "solve", "the program as a process", "field"

    def candidates(self, sweep):
        return [({"S": cells}, cells**2) for cells in (32, 64, 128)]

    def prepare(self, sweep, settings):
        def run():
            found = lichtenberg.solve(sweep.request.scene, {"field.cells": settings["S"], "field.tolerance": 1e-8})
            return {name: getattr(found, name).tolist() for name in ("potential", "charge", "force")}, None

        return run


class Wrong(Method):
    name, description, kind = "wrong", "answers that are none", "field"

    def candidates(self, sweep):
        return [({"number": number}, 1) for number in range(5)]

    def prepare(self, sweep, settings):
        empty = {"potential": [], "charge": [], "force": []}
        answers = [empty, {"potential": [float("nan")] * 2}, {"potential": {1, 2}}, 3]

        def run():
            return answers[int(settings["number"])], 1.0

        return run


HELP, ARGUMENTS = work_precision.HELP, work_precision.ARGUMENTS


def act(request):
    work_precision.act(request, [Wrong(), Solve()])
'''


class MethodFromOutside(unittest.TestCase):
    def test_its_errors_are_those_of_the_method_that_it_calls(self):
        folder = runs.FOLDER / "methods"
        folder.mkdir()
        (folder / "compare.py").write_text(MODULE)
        (runs.FOLDER / "disks.toml").write_text(SCENE)
        with mock.patch.dict(os.environ, LICHTENBERG_COMMANDS=str(folder)):
            words = ["disks.toml", "--methods", "wrong,cut-cell,solve", "--sizes", "32,64,128", "--json"]
            status, output, complaint = runs.program("compare", *words)
            refused = runs.program("compare", "disks.toml", "--methods", "sovle", "--out", "other.png")
        self.assertEqual(status, 0, complaint)
        reasons = [entry["reason"] for entry in json.loads(output)["left_out"] if entry["method"] == "wrong"]
        expected = ("form", "unstable", "form", "form", "IndexError in the method")
        for reason, words in zip(reasons, expected, strict=True):
            self.assertIn(words, reason)
        errors = {"cut-cell": {}, "solve": {}}
        for point in json.loads(output)["points"]:
            if point["settings"].get("tolerance", 1e-8) == 1e-8:
                errors[point["method"]][point["settings"]["S"]] = point["errors"]
        self.assertEqual(list(errors["solve"]), [32, 64, 128])
        # Same grid, tolerance and arithmetic. `solve` multiplies by the depth and the comparison divides: two
        # roundings.
        rounding = 2 * sys.float_info.epsilon
        for cells, own in errors["solve"].items():
            for quantity in ("potentials", "charges", "forces"):
                self.assertAlmostEqual(own[quantity], errors["cut-cell"][cells][quantity], delta=rounding)
        self.assertEqual(refused[0], 2)
        self.assertIn("did you mean solve?", refused[2])


if __name__ == "__main__":
    unittest.main()
