"""Comparisons with published experiments: verdicts, and a short script."""
import importlib.util
import json
import subprocess
import sys
import unittest
from types import SimpleNamespace

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

    def test_changes_are_added_to_the_recorded_rows(self):
        recorded = json.loads((runs.HOME / "docs/measurements/experiments/row-03.json").read_text())
        out = runs.FOLDER / "changes.json"
        for row in recorded:
            row.pop("changes", None)
        out.write_text(json.dumps(recorded))
        script = [sys.executable, FOLDER / "row_03_metal_wall.py", "--quick", "--program", runs.PROGRAM, "--out", out, "--changes"]
        ended = subprocess.run([*script, "density"], capture_output=True, text=True, check=False)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        exponent, threshold = json.loads(out.read_text())
        self.assertNotIn("changes", exponent)
        self.assertEqual([change["assumption"] for change in threshold["changes"]], ["density"])
        self.assertEqual(list(render.experiment_faults(threshold)), [])
        low, high = threshold["changes"][0]["ours"]["interval"]
        expected = threshold["ours"]["value"] * 2.5**0.5
        self.assertTrue(low <= expected <= high, (low, expected, high))
        ended = subprocess.run([*script, "weather"], capture_output=True, text=True, check=False)
        self.assertEqual((ended.returncode, "weather: use place of the charge, " in ended.stderr), (1, True), ended.stderr)

    def test_new_rows_keep_the_changes_of_those_that_disagree(self):
        out = runs.FOLDER / "kept.json"
        request = SimpleNamespace(out=out, shared={"row": 1, "reference": "A"})
        changes = [{"change": "no drag"}]
        out.write_text(json.dumps([{"quantity": quantity, "changes": changes} for quantity in ("x", "y")]))
        theirs = experiments.published(1, 0.9, 1.1, "A")
        experiments.record(request, [experiments.row("x", "It is 1.", theirs, experiments.bounds(2, 0.1), "Drag."),
                                     experiments.row("y", "It is 1.", theirs, experiments.bounds(1, 0.1))], {"seconds": 1})
        self.assertEqual([row.get("changes") for row in json.loads(out.read_text())], [changes, None])


if __name__ == "__main__":
    unittest.main()
