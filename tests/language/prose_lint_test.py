"""The language checker finds faults of each rule, and only those."""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

TOOL = Path(__file__).resolve().parent / "prose_lint.py"

FAULTS = {
    "private": "/// The field that a particle felt.\n",
    "what": "/// Returns what the solver needs.\n",
    "headless": "/// Of all particles the largest.\n",
    "sentence": "/// Returns " + "one and " * 30 + "no more numbers.\n",
    "history": "/// This used to be a function.\n",
    "hash": "/// Measured at 3e28ce9.\n",
    "test-name": f'TEST_CASE("{"gas: one two " * 8}") {{}}\n',
    "identifier": "double blind_way = 0;\n",
}
CLEAN = "/// Returns the distance (m) between two particles.\ndouble distance(int i, int j);\n"


class ProseLint(unittest.TestCase):
    def run_on(self, text, *words):
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "file.cpp").write_text(text, encoding="utf-8")
            for command in (["init", "-q"], ["add", "."]):
                subprocess.run(["git", "-C", folder, *command], check=True)
            return subprocess.run([sys.executable, str(TOOL), folder, "--identifiers", *words], capture_output=True, text=True)

    def test_each_rule_finds_its_fault(self):
        for rule, text in FAULTS.items():
            with self.subTest(rule):
                self.assertEqual(self.run_on(text + CLEAN, "--limit", f"{rule}=0").returncode, 1)

    def test_plain_text_has_no_fault(self):
        self.assertEqual(self.run_on(CLEAN, "--limit", "0").returncode, 0)

    def test_a_limit_allows_as_many_faults(self):
        self.assertEqual(self.run_on(FAULTS["what"] + CLEAN, "--limit", "what=1").returncode, 0)


if __name__ == "__main__":
    unittest.main()
