"""Scripts of scenes/cluster with substitutes for Slurm and ssh (folder cluster), which start the shares as processes."""
import json
import os
import shutil
import subprocess
import time
import unittest
from pathlib import Path

import runs


class Cluster(unittest.TestCase):
    """A test in a new folder with a scene gas.toml and the substitutes."""

    def setUp(self):
        self.folder = runs.FOLDER / self.id().rpartition(".")[2]
        self.queue = self.folder / "queue"
        self.queue.mkdir(parents=True)
        shutil.copytree(runs.HOME / "tests/python/cluster", self.folder / "bin")
        (self.folder / "gas.toml").write_text(runs.gas_scene())
        (self.folder / "hosts.txt").write_text("one  # a comment\n\n# all of it a comment\ntwo\n")

    def start(self, script, *words, **names):
        environment = os.environ | {"QUEUE": str(self.queue), "LICHTENBERG": runs.PROGRAM} | names
        environment["PATH"] = f"{self.folder / 'bin'}:{environment['PATH']}"
        command = ["bash", str(runs.HOME / "scenes/cluster" / script), *words]
        return subprocess.Popen(
            command, cwd=self.folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )

    def end(self, process, status):
        said = process.communicate()[0]
        self.assertEqual(process.returncode, status, said)
        return said

    def call(self, script, *words, status=0, **names):
        return self.end(self.start(script, *words, **names), status)

    def points(self, out):
        """The ensemble's means without the wall time, and its members' states."""
        table = json.loads((self.folder / out / "ensemble.json").read_text())
        for point in table["points"]:
            point["quantities"] = {name: value for name, value in point["quantities"].items() if name != "seconds"}
        return table["points"], {member["name"]: member["state"] for member in table["members"]}

    def expect_table_of_one_machine(self, words):
        subprocess.run([runs.PROGRAM, "ensemble", *words, "--out", "whole", "--quiet"], cwd=self.folder, capture_output=True, check=True)
        self.assertEqual(self.points("gas-ensemble"), self.points("whole"))

    def test_slurm_array_continues_an_interrupted_share_and_makes_the_table(self):
        words = ["gas.toml", "--seeds", "3", "--set", "stop.time=40"]
        said = self.call("slurm.sh", "2", *words, "--", "--time=1:00:00", LIMITED="1")
        self.assertIn("job 100 runs 2 shares, then job 101 makes the table", said)
        self.assertEqual([path.name for path in self.queue.glob("requeued-*")], ["requeued-100001"])
        options = [json.loads((self.queue / f"options-{job}.json").read_text()) for job in (100, 101)]
        self.assertEqual((options[0]["time"], options[0]["array"], options[0]["signal"]), ("1:00:00", "1-2", "B:USR1@300"))
        self.assertEqual(options[1]["dependency"], "afterany:100")
        self.expect_table_of_one_machine(words)
        self.assertIn("all members are finished", self.call("slurm.sh", "2", *words))

    def test_slurm_array_names_members_that_failed(self):
        words = ["gas.toml", "--vary", "population.count=8,5000", "--set", "stop.time=0.1"]  # 5000 grains do not fit
        self.call("slurm.sh", "2", *words)
        self.assertIn("1 of 2 members are not finished: count-5000", (self.folder / "ensemble-100-table.log").read_text())
        self.assertIn("count-5000 failed: ", (self.folder / "ensemble-100-2.log").read_text())

    def test_slurm_script_refuses_wrong_input_before_it_queues(self):
        self.assertIn("usage: ", self.call("slurm.sh", "0", "gas.toml", status=2))
        self.assertIn("missing.toml", self.call("slurm.sh", "2", "missing.toml", status=2))
        for words, sentence in (
            (["--seed", "3"], "--seed"),
            (["--out", "gas.toml/x"], "cannot be made"),
            (["--gather"], "leave out --gather"),
            (["--share=1/2"], "leave out --share=1/2"),
            (["--jobs", "2"], "leave out --jobs"),
        ):
            self.assertIn(sentence, self.call("slurm.sh", "2", "gas.toml", *words, status=2))
        (self.folder / "bin/sbatch").unlink()
        if not shutil.which("sbatch"):
            self.assertIn("sbatch is missing", self.call("slurm.sh", "2", "gas.toml", status=2))
        self.assertEqual(list(self.queue.iterdir()), [])

    def test_hosts_share_the_members_and_a_lost_host_is_named(self):
        words = ["gas.toml", "--seeds", "3", "--set", "stop.time=0.2"]
        ssh = str(self.folder / "bin/ssh")
        (self.folder / "with-lost.txt").write_text("one\nlost\n")
        said = self.call("hosts.sh", "with-lost.txt", *words, status=1, SSH=ssh)
        self.assertIn("share 2 on lost ended with status 255: see ensemble-hosts-2.log", said)
        self.assertIn("1 of 3 members are not finished: seed-2", said)
        self.call("hosts.sh", "hosts.txt", *words, SSH=ssh)
        self.expect_table_of_one_machine(words)

    @runs.long
    def test_hosts_script_that_is_ended_goes_on_with_the_same_command(self):
        words = ["hosts.txt", "gas.toml", "--seeds", "3", "--jobs", "1", "--set", "stop.time=40"]
        process = self.start("hosts.sh", *words, SSH=str(self.folder / "bin/ssh"))
        while process.poll() is None and not list(self.folder.glob("gas-ensemble/*.h5")):
            time.sleep(0.01)
        process.terminate()
        self.assertIn("stopped; the same command goes on", self.end(process, 143))
        self.call("hosts.sh", *words, SSH=str(self.folder / "bin/ssh"))
        self.expect_table_of_one_machine(words[1:])

    def test_hosts_script_refuses_wrong_input_before_any_share_starts(self):
        ssh = str(self.folder / "bin/ssh")
        Path(self.folder / "empty.txt").write_text("# none\n")
        Path(self.folder / "mpi.txt").write_text("one slots=4\n")
        for words, sentence in (
            (["gas.toml"], "usage: "),
            (["no.txt", "gas.toml"], "the file of hosts no.txt cannot be read"),
            (["empty.txt", "gas.toml"], "names no host"),
            (["mpi.txt", "gas.toml"], "'one slots=4' is no host name"),
            ([".", "gas.toml"], "the file of hosts . cannot be read"),
            (["hosts.txt", "gas.toml", "--gather"], "leave out --gather"),
            (["hosts.txt", "missing.toml"], "missing.toml"),
        ):
            self.assertIn(sentence, self.call("hosts.sh", *words, status=2, SSH=ssh))
        self.assertEqual(list(self.folder.glob("ensemble-hosts-*")), [])


if __name__ == "__main__":
    unittest.main()
