"""validation/gate.py names each piece of work that takes more than the last record allows."""
import importlib.util
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

HOME = Path(__file__).resolve().parents[2]
SPEC = importlib.util.spec_from_file_location("gate", HOME / "validation/gate.py")
gate = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(gate)

OLD = {"piece": "a", "instructions (1e6)": 100.0, "cache misses (1e6)": 1.0, "memory (MiB)": 50.0}


class Gate(unittest.TestCase):
    def test_growth_beyond_a_limit_is_a_fault_that_names_piece_and_commit(self):
        for change, words in (({"instructions (1e6)": 105.1}, ["instructions", "5.1 %"]), ({"memory (MiB)": 55.1}, ["memory", "10.2 %"])):
            faults = list(gate.faults_of(OLD | change, OLD, "12345678"))
            self.assertEqual(len(faults), 1)
            for word in ["a:", "12345678", *words]:
                self.assertIn(word, faults[0])

    def test_growth_within_the_limits_is_no_fault(self):
        change = {"instructions (1e6)": 104.9, "memory (MiB)": 54.9, "cache misses (1e6)": 9.0}
        self.assertEqual(list(gate.faults_of(OLD | change, OLD, "12345678")), [])

    def test_build_without_the_programs_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, HOME / "validation/gate.py", "--build", folder], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr, "lacks benchmark_gate|valgrind is missing")


if __name__ == "__main__":
    unittest.main()
