"""validation/long.sh runs slices once per commit, keeps their results, and refuses faulty lists of checks."""
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

HOME = Path(__file__).resolve().parents[2]
RUNNER = [sys.executable, HOME / "validation/long/run.py"]
sys.path.insert(0, str(HOME / "validation/long"))
import run as runner  # noqa: E402


def entry(command, name="a", **others):
    lines = [f'name = "{name}"', 'shows = "It holds."', f"command = '''{command}'''", "minutes = 1"]
    return "[[check]]\n" + "\n".join([*lines, *(f"{key} = {json.dumps(value)}" for key, value in others.items())]) + "\n"


@unittest.skipUnless((HOME / ".git").exists(), "needs a git checkout")
class Long(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def words(self, text, *options):
        (self.folder / "checks.toml").write_text(text, encoding="utf-8")
        return [*RUNNER, "--checks", self.folder / "checks.toml", "--results", self.folder / "results", *options]

    def call(self, text, *options):
        return subprocess.run(self.words(text, *options), capture_output=True, text=True, check=False)

    def result(self, part="1", name="a"):
        return json.loads((self.folder / f"results/{name}-{part}.json").read_text(encoding="utf-8"))

    def store(self, at="0"):
        store = runner.Store(self.folder / "results", at)
        self.addCleanup(store.lock.close)
        return store

    def check(self, command):
        (self.folder / "checks.toml").write_text(entry(command, targets=["version_source"]), encoding="utf-8")
        return runner.checks_of(self.folder / "checks.toml")[0]

    def test_each_slice_runs_and_keeps_its_figures(self):
        command = 'echo "{\\"n\\": {slice}}" > $LICHTENBERG_FIGURES; test {slice} -lt {slices}'
        done = self.call(entry(command, slices=2, targets=["version_source"]))
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertEqual([self.result(part)["passed"] for part in "12"], [True, False])
        self.assertEqual(self.result("2")["failure"], "exit status 1")
        self.assertEqual([self.result(part)["figures"] for part in "12"], [{"n": 1}, {"n": 2}])

    def test_passed_slice_of_this_commit_is_kept_and_others_are_not(self):
        check, store = self.check("true"), self.store("1")
        store.write(check, "1", runner.run_slice(check, "1", store))
        self.assertTrue(store.read(check, "1")["passed"])
        store.at = "2"
        self.assertIsNone(store.read(check, "1"))

    def test_slice_beyond_its_time_is_killed_with_its_children(self):
        readable, log = os.pipe()  # read to its end: until nothing has it open for writing
        self.assertIsNone(runner.call(["bash", "-c", "(sleep 30; echo late) & wait"], log, 0.2))
        os.close(log)
        with os.fdopen(readable) as said:
            self.assertEqual(said.read(), "")

    def test_stopped_run_ends_its_slice_and_keeps_no_result(self):
        text = entry(f"echo $$ > {self.folder}/pid; sleep 100", targets=["version_source"])
        with subprocess.Popen(self.words(text), stdout=subprocess.DEVNULL) as run:
            while not (self.folder / "pid").exists() or not (self.folder / "pid").read_text().strip():
                time.sleep(0.05)
            run.send_signal(signal.SIGTERM)
            self.assertEqual(run.wait(), 143)
        with self.assertRaises(ProcessLookupError):
            os.kill(int((self.folder / "pid").read_text()), 0)
        self.assertFalse((self.folder / "results/a-1.json").exists())

    def test_second_run_in_the_same_folder_is_refused(self):
        first = self.store()
        done = self.call(entry("true", targets=["version_source"]))
        self.assertEqual(done.returncode, 2)
        self.assertIn(f"another run uses {first.folder}", done.stderr)

    def test_no_slice_begins_that_might_end_too_late(self):
        done = self.call(entry("true"), "--hours", "0.01")
        self.assertEqual(done.returncode, 3, done.stdout)
        self.assertFalse((self.folder / "results/a-1.json").exists())

    def test_faulty_checks_are_refused(self):
        for text, words in ((entry("true", nmae="x"), "'nmae' is unknown"), (entry("true").replace("minutes = 1", "minutes = 61"), "from 1 to 60"),
                            (entry("true") + entry("false"), "unique"), (entry("true", name="A b"), "small letters"),
                            (entry("true").replace("minutes = 1", ""), "missing"), ("[[check", "checks.toml"),
                            (entry("true", slices=0), "at least 1")):
            with self.subTest(words):
                done = self.call(text)
                self.assertEqual(done.returncode, 2, done.stdout)
                self.assertIn(words, done.stderr)
        self.assertIn("there is no check 'b'", self.call(entry("true"), "b").stderr)

    def test_shipped_checks_are_complete(self):
        self.assertTrue(runner.checks_of(HOME / "validation/long/checks.toml"))


if __name__ == "__main__":
    unittest.main()
