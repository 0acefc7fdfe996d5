"""Short part of validation/damaged_results.py: damaged results end no reader by a signal, a hang or a traceback."""
import subprocess
import sys
import unittest

import runs

FILES = 30  # This part of 2000 files includes all kinds of damage.


class Damaged(unittest.TestCase):
    def test_every_reader_refuses_or_reads_damaged_results(self):
        script = runs.HOME / "validation/damaged_results.py"
        words = [sys.executable, script, "--files", str(FILES), "--no-segments"]
        ended = subprocess.run(words, capture_output=True, text=True, check=False)
        self.assertEqual(ended.returncode, 0, ended.stdout + ended.stderr)
        self.assertIn(f"0 failures with {FILES} damaged results", ended.stdout)


if __name__ == "__main__":
    unittest.main()
