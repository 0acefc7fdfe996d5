"""Comparisons with published experiments: verdicts, and a short script."""
import importlib.util
import json
import subprocess
import sys
import unittest

import runs

FOLDER = runs.HOME / "paper-figures/experiments"
sys.path.insert(0, str(FOLDER))
import experiments  # noqa: E402

SPEC = importlib.util.spec_from_file_location("render_measurements", runs.HOME / "docs/render_measurements.py")
render = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(render)


class Experiments(unittest.TestCase):
    def test_verdict_is_that_of_the_intervals(self):
        for low, high, verdict in ((0.9, 1.1, "agrees"), (1.3, None, "disagrees"), (None, 1.0, "agrees"),
                                   (None, None, "agrees"), (1.2, 1.3, "agrees")):
            with self.subTest((low, high)):
                found = experiments.row("x", "y", experiments.published(1, low, high, "A"), experiments.bounds(1.1, 0.1))
                self.assertEqual(found["verdict"], verdict)

    def test_mean_has_the_interval_of_student(self):
        found = experiments.mean([1, 2, 3])
        self.assertEqual((found["value"], found["runs"]), (2, 3))
        self.assertAlmostEqual(found["interval"][1] - 2, 4.303 / 3**0.5, places=3)
        with self.assertRaises(ValueError):
            experiments.mean([1])

    def test_a_short_script_agrees_and_records_complete_rows(self):
        out = runs.FOLDER / "row.json"
        ended = subprocess.run([sys.executable, FOLDER / "row_15_arrays.py", "--quick", "--program", runs.PROGRAM,
                                "--out", out], capture_output=True, text=True, check=False)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        for row in json.loads(out.read_text()):
            with self.subTest(row["quantity"]):
                self.assertEqual(list(render.experiment_faults(row)), [])
                self.assertEqual(row["verdict"], "agrees")


if __name__ == "__main__":
    unittest.main()
