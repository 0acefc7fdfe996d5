"""Builds the container of packaging/container, which compiles the whole program, and runs it. The environment variable
LICHTENBERG_CONTAINER_TOOL names docker, podman or buildah; without it the test is skipped."""
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import runs

TOOL = os.environ.get("LICHTENBERG_CONTAINER_TOOL")
IMAGE = "lichtenberg-test"
USER = "1234:1234"  # has no account and no folder in the image

if not TOOL:
    print("container_test: LICHTENBERG_CONTAINER_TOOL names no container tool: skipped")
    sys.exit(77)


def tool(*words):
    ended = subprocess.run([TOOL, *map(str, words)], stdout=subprocess.PIPE, text=True, check=False)
    assert ended.returncode == 0, f"{TOOL} {words} ended with {ended.returncode}\n{ended.stdout}"
    return ended.stdout


def run_in_container(folder, *words):
    """Returns the output of the program for a user without an account. The folder is /work."""
    options = ["--user", USER, "-v", f"{folder}:/work"]
    if TOOL != "buildah":
        return tool("run", "--rm", *options, IMAGE, *words)
    container = tool("from", IMAGE).strip()
    try:
        return tool("run", *options, container, "--", "lichtenberg", *words)
    finally:
        tool("rm", container)


class ContainerTest(unittest.TestCase):
    def test_the_image_runs_a_scene_and_draws_it(self):
        tool("build", "-t", IMAGE, "-f", runs.HOME / "packaging/container/Containerfile", runs.HOME)
        with tempfile.TemporaryDirectory() as folder:
            os.chmod(folder, 0o777)
            (Path(folder) / "gas.toml").write_text(runs.gas_scene().replace("picture = false", ""))
            self.assertTrue(run_in_container(folder, "--version").startswith("lichtenberg "))
            run_in_container(folder, "run", "gas.toml", "--quiet")
            self.assertEqual((Path(folder) / "gas.png").read_bytes()[:4], b"\x89PNG")
            run_in_container(folder, "run", "/usr/share/lichtenberg/scenes/two-grains.toml", "--quiet")
            self.assertEqual(os.stat(Path(folder) / "two-grains.h5").st_uid, 1234)


if __name__ == "__main__":
    unittest.main()
