"""Data in docs/measurements are complete, and the pages of docs/ agree with them and with the bibliography."""
import importlib.util
import unittest
from pathlib import Path

TOOL = Path(__file__).resolve().parents[2] / "docs/render_measurements.py"
SPEC = importlib.util.spec_from_file_location("render_measurements", TOOL)
render = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(render)

WHOLE = {"measures": "time", "unit": "s", "command": "build/x", "commit": "not kept", "machine": "one core", "date": "2026-01-31",
         "rows": [{"n": 1}]}

COMPARED = {"row": 1, "reference": "A 2000", "quantity": "x", "published": {"value": 1, "interval": [0, 2], "source": "A"},
            "expected": "It is 1.", "ours": {"value": 3, "interval": [2.5, 3.5], "runs": 2}, "verdict": "disagrees",
            "reason": "Drag.", "command": "x.py", "commit": "v1", "machine": "one core", "date": "2026-01-31", "seconds": 1}

CHANGED = {"assumption": "drag", "change": "no drag", "expected": "1", "ours": {"value": 1.9, "interval": [1.5, 2.3], "runs": 2},
           "verdict": "agrees", "command": "x.py --changes", "commit": "v1", "machine": "one core", "date": "2026-01-31", "seconds": 1}
COMPARED["changes"] = [CHANGED]


def ours(low, high):
    return {"ours": {"value": (low + high) / 2, "interval": [low, high], "runs": 2}}


class Experiments(unittest.TestCase):
    def test_whole_row_has_no_fault(self):
        self.assertEqual(list(render.experiment_faults(COMPARED)), [])
        agreeing = {"published": {"value": None, "interval": [None, 3], "source": "M"}, "verdict": "agrees", "reason": "",
                    "changes": []}
        self.assertEqual(list(render.experiment_faults(COMPARED | agreeing)), [])

    def test_each_missing_key_is_a_fault(self):
        for key in COMPARED:
            with self.subTest(key):
                self.assertTrue(list(render.experiment_faults({k: v for k, v in COMPARED.items() if k != key})))

    def test_contradictions_are_faults(self):
        for change in ({"verdict": "agrees"}, {"reason": ""}, {"expected": ""}, {"unit": "m"},
                       {"published": {"value": 1, "interval": [0, 2], "source": "B"}},
                       {"published": {"value": 1, "interval": [2, 0], "source": "A"}},
                       {"published": {"value": 1, "interval": 2, "source": "A"}},
                       {"ours": {"value": 3, "interval": [2.5, 3.5]}}):
            with self.subTest(change):
                self.assertTrue(list(render.experiment_faults(COMPARED | change)))


    def test_each_missing_or_contradictory_key_of_a_change_is_a_fault(self):
        for change in [{k: v for k, v in CHANGED.items() if k != key} for key in CHANGED] + [CHANGED | other for other in (
                {"verdict": "disagrees"}, {"expected": ""}, {"unit": "m"}, {"against": "no gas"}, ours(2.5, 3.5))]:
            with self.subTest(change):
                self.assertTrue(list(render.experiment_faults(COMPARED | {"changes": [change]})))

    def test_change_against_another_one_has_no_fault(self):
        changes = [CHANGED, CHANGED | {"change": "no drag, no gas", "against": "no drag"}]
        self.assertEqual(list(render.experiment_faults(COMPARED | {"changes": changes})), [])

    def test_assumption_decides_if_its_change_moves_the_value_into_agreement(self):
        for found, decides in ((ours(1.5, 2.3), True),    # 3 - 1.9 = 1.1 is above the root of 0.5^2 + 0.4^2
                               (ours(0.9, 4.1), False),   # agrees by its wide interval alone
                               (ours(2.1, 2.2), False)):  # moves, but still disagrees
            verdict = "agrees" if found["ours"]["interval"][0] <= 2 else "disagrees"
            with self.subTest(found):
                row = COMPARED | {"changes": [CHANGED | found | {"verdict": verdict}]}
                self.assertEqual(list(render.experiment_faults(row)), [])
                self.assertEqual(render.deciding(row), ["drag"] if decides else [])

    def test_change_against_another_one_decides_by_it(self):
        first = CHANGED | ours(1.4, 2.2)
        second = CHANGED | ours(1.5, 2.3) | {"assumption": "gas", "change": "no gas", "against": "no drag"}
        self.assertEqual(render.deciding(COMPARED | {"changes": [first, second]}), ["drag"])

    def test_table_of_changes_has_all_rows_that_share_them(self):
        other = CHANGED | {"assumption": "gas", "change": "no gas"}
        rows = [COMPARED, COMPARED | {"quantity": "y", "changes": [CHANGED, other]}, COMPARED | {"quantity": "z", "changes": [other]}]
        self.assertEqual(list(render.change_tables(rows)), [
            "|changed|expected|x|y|z|", "|-|-|-|-|-|", "|nothing||3±0.5|3±0.5|3±0.5|",
            "|drag: no drag|1|1.9±0.4 agrees|1.9±0.4 agrees||",
            "|gas: no gas|1||1.9±0.4 agrees|1.9±0.4 agrees|",
            "|decides||drag|drag, gas|gas|", ""])

    def test_change_with_another_expectation_is_in_another_table(self):
        rows = [COMPARED, COMPARED | {"quantity": "y", "changes": [CHANGED | {"expected": "2"}]}]
        self.assertEqual([line for line in render.change_tables(rows) if line.startswith("|changed")],
                         ["|changed|expected|x|", "|changed|expected|y|"])

    def test_interval_is_half_width_or_bounds(self):
        for interval, text in (([0.5, 1.5], "1±0.5"), ([1, 1], "1"), ([0.5, 1.6], "1 [0.5, 1.6]"), ([None, 1.5], "1 [, 1.5]")):
            self.assertEqual(render.with_interval({"value": 1, "interval": interval}), text)

    def test_line_of_a_command_sums_its_changes(self):
        rows = [COMPARED | {"machine": render.MACHINE, "commit": "lichtenberg 1.0.0 (abc)", "changes": [
            CHANGED, CHANGED | {"change": "no gas", "command": "x.py --changes gas", "date": "2026-02-01", "seconds": 2}]}]
        self.assertEqual(list(render.condition_lines(rows)), [
            "- `x.py` (1 s), 2026-01-31, abc", "- `x.py --changes` (3 s), 2026-01-31, v1, one core, 2026-02-01"])


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
        self.assertEqual(list(render.faults(without | {"rows": [{"claim": "a text with 1"}]})), [])
        self.assertEqual(list(render.faults(WHOLE | {"unit": {"n": "1"}})), [])
        self.assertEqual(list(render.faults(WHOLE | {"unit": "see rows", "rows": [{"time of a step (s)": "of 1", "n": 1}]})), [])

    def test_number_without_unit_is_a_fault(self):
        for change in ({"unit": ""}, {"unit": {}}, {"unit": {"n": ""}}, {"unit": {"n": "1", "m": "1"}}, {"unit": "see rows"}, {"unit": 1}):
            with self.subTest(change):
                self.assertTrue(list(render.faults(WHOLE | change)))
        without = {k: v for k, v in WHOLE.items() if k != "unit"}
        for rows in ([{"time (s)": 1, "n": 1}], [{"values": [1, 2]}], [{"values": {"low": 1}}]):
            with self.subTest(rows):
                self.assertTrue(list(render.faults(without | {"rows": rows})))

    def test_unknown_key_is_a_fault(self):
        for change in ({"units": "s"}, {"repeats": 1}, {"commit": 1}):
            with self.subTest(change):
                self.assertTrue(list(render.faults(WHOLE | change)))

    def test_wrong_date_empty_rows_and_unknown_page_are_faults(self):
        for change in ({"date": "January"}, {"rows": []}, {"rows": [1]}, {"page": "nowhere"}):
            with self.subTest(change):
                self.assertTrue(list(render.faults(WHOLE | change)))

    def test_rows_share_columns_in_order_of_appearance(self):
        lines = list(render.section(WHOLE | {"rows": [{"n": 1}, {"n": 2, "t": [3, 4]}]}))
        self.assertEqual(lines[2:6], ["|n|t|", "|-|-|", "|1||", "|2|3, 4|"])

    def test_page_names_commit_machine_and_date(self):
        text = "\n".join(render.section(WHOLE | {"commit": "v1"}))
        for line in ("- Command: `build/x`", "- Commit: v1", "- Machine: one core", "- Date: 2026-01-31"):
            self.assertIn(line, text)
        text = "\n".join(render.section(WHOLE | {"command": "not kept", "commit": "not kept"}))
        self.assertIn("- Command: not recorded", text)
        self.assertIn("- Commit: not recorded", text)
        rows = [{"n": 1, "commit": "v1"}, {"n": 2}]
        self.assertIn("- Commit: in the rows, for 1 of 2", "\n".join(render.section(WHOLE | {"commit": "see rows", "rows": rows})))

    def test_titles_have_units(self):
        self.assertEqual(next(render.section(WHOLE)), "## Time (s)")
        self.assertEqual(list(render.section(WHOLE | {"unit": {"n": "mm"}}))[0:3], ["## Time", "", "|n (mm)|"])
        self.assertEqual(list(render.section(WHOLE | {"unit": "1"}))[0:3], ["## Time", "", "|n|"])

    def test_sparse_table_has_one_cell_of_values_for_each_row(self):
        rows = [{"case": n, f"key {n}": n} for n in range(render.LARGEST_TABLE + 1)]
        lines = list(render.section(WHOLE | {"rows": rows}))
        self.assertEqual(lines[2:5], ["|case|values|", "|-|-|", "|0|key 0: 0|"])

    def test_accents_of_the_bibliography_are_letters(self):
        self.assertEqual(render.plain(r'{G}u{\'e}nol{\'e}, H{\"u}bler, Cerd{\`a}, N{\o}rsett, 1--2'),
                         "Guénolé, Hübler, Cerdà, Nørsett, 1-2")


if __name__ == "__main__":
    unittest.main()
