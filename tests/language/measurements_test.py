"""Data in docs/measurements are complete, and the pages of docs/ agree with them."""
import importlib.util
import unittest
from pathlib import Path

TOOL = Path(__file__).resolve().parents[2] / "docs/render_measurements.py"
SPEC = importlib.util.spec_from_file_location("render_measurements", TOOL)
render = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(render)

WHOLE = {"measures": "time", "unit": "s", "command": "build/x", "machine": "one core", "date": "2026-01-31", "rows": [{"n": 1}]}


class Measurements(unittest.TestCase):
    def test_data_are_complete_and_pages_agree(self):
        self.assertEqual(render.check(), [])

    def test_whole_measurement_has_no_fault(self):
        self.assertEqual(list(render.faults(WHOLE)), [])

    def test_each_missing_key_is_a_fault(self):
        for key in WHOLE:
            with self.subTest(key):
                self.assertTrue(list(render.faults({k: v for k, v in WHOLE.items() if k != key})))

    def test_unit_may_be_in_keys_of_rows(self):
        without = {k: v for k, v in WHOLE.items() if k != "unit"}
        self.assertEqual(list(render.faults(without | {"rows": [{"time (s)": 1}]})), [])
        self.assertEqual(list(render.faults(without | {"units": {"n": "1"}})), [])

    def test_wrong_date_empty_rows_and_unknown_page_are_faults(self):
        for change in ({"date": "January"}, {"rows": []}, {"rows": [1]}, {"page": "nowhere"}):
            with self.subTest(change):
                self.assertTrue(list(render.faults(WHOLE | change)))

    def test_rows_share_columns_in_order_of_appearance(self):
        lines = list(render.section(WHOLE | {"rows": [{"n": 1}, {"n": 2, "t": [3, 4]}]}))
        self.assertEqual(lines[2:6], ["|n|t|", "|-|-|", "|1||", "|2|3, 4|"])


if __name__ == "__main__":
    unittest.main()
