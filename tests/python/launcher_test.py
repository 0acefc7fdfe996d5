"""Tests of the script `lichtenberg` of the checkout, with a program of three files instead of ours."""
import os
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

LAUNCHER = Path(__file__).resolve().parents[2] / "lichtenberg"

PROJECT = """cmake_minimum_required(VERSION 3.25)
project(small C)
add_executable(lichtenberg main.c one.c two.c)
add_executable(conductors_program EXCLUDE_FROM_ALL conductors.c)
set_target_properties(conductors_program PROPERTIES OUTPUT_NAME lichtenberg_conductors)
"""
PRESETS = """{
  "version": 6,
  "configurePresets": [{"name": "release", "generator": "Ninja", "binaryDir": "${sourceDir}/build"}]
}
"""


def write_word(folder, word):
    (folder / "main.c").write_text(f'#include <stdio.h>\nint main(void) {{ return puts("{word}") < 0; }}\n')


def make_checkout(folder, word):
    """Makes the launcher and a program that prints the word."""
    (folder / "cmake").mkdir(parents=True)
    shutil.copy(LAUNCHER, folder / "lichtenberg")
    (folder / "cmake/debian-packages.txt").write_text("bash\n")
    (folder / "CMakeLists.txt").write_text(PROJECT)
    (folder / "CMakePresets.json").write_text(PRESETS)
    write_word(folder, word)
    (folder / "conductors.c").write_text('#include <stdio.h>\nint main(void) { return puts("conductors") < 0; }\n')
    for name in ("one", "two"):
        (folder / f"{name}.c").write_text(f"int {name}(void) {{ return 0; }}\n")


def states(folder):
    """Modification time of each file of a build."""
    return {path: path.stat().st_mtime_ns for path in sorted((folder / "build").rglob("*")) if path.is_file()}


class LauncherTest(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory(prefix="lichtenberg-launcher-")
        self.addCleanup(scratch.cleanup)
        self.root = Path(os.path.realpath(scratch.name))
        self.first = self.root / "first"
        make_checkout(self.first, "first")

    def start(self, folder, *words):
        """Output and errors of the launcher in a folder."""
        ended = subprocess.run([folder / "lichtenberg", *words], capture_output=True, text=True, cwd=self.root, check=False)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        return ended.stdout, ended.stderr

    def test_a_build_is_announced_and_a_start_without_one_is_not(self):
        output, said = self.start(self.first)
        self.assertEqual(output, "first\n")
        self.assertEqual(said, f"lichtenberg: building (the whole program: 4 minutes on two cores; log in {self.first}/build/build.log)\n")
        self.assertEqual(self.start(self.first), ("first\n", ""))

    def test_the_first_runs_of_conductors_build_their_part_alone(self):
        scenes = LAUNCHER.parent / "scenes"
        for name in ("dendrite", "dendrite-3d", "two-disks"):
            output, said = self.start(self.first, "run", scenes / f"{name}.toml", "--set", "effects.gravity.g=1")
            self.assertEqual(output, "conductors\n")
        self.assertEqual(self.start(self.first, "plot", "dendrite.h5")[0], "conductors\n")
        self.assertFalse((self.first / "build/lichtenberg").exists())
        (self.root / "other.toml").write_text("[effects.gravity]\n# units effects.coulomb\n[effects.gas_drag]\n")
        shutil.copytree(self.first, self.root / "second", symlinks=True)
        for folder, words in ((self.first, ("run", "other.toml")), (self.root / "second", ("solve", scenes / "two-disks.toml"))):
            output, said = self.start(folder, *words)
            self.assertEqual((output, said.count("the whole program: 4 minutes on two cores")), ("first\n", 1))
        self.assertEqual(self.start(self.first, "run", scenes / "dendrite.toml")[0], "first\n")

    def test_scenes_of_grains_and_packings_need_the_whole_program(self):
        shutil.copy(LAUNCHER.parent / "scenes/granular-gas.toml", self.root / "gas")
        self.assertEqual(self.start(self.first, "run", "gas")[0], "first\n")
        for name, words in (("granular-gas", ()), ("packing", ()), ("dendrite", ("--set", "effects.coulomb.accuracy=1e-3"))):
            folder = self.root / name
            make_checkout(folder, name)
            self.assertEqual(self.start(folder, "run", LAUNCHER.parent / f"scenes/{name}.toml", *words)[0], f"{name}\n")

    def test_the_launcher_names_the_effects_of_the_part_for_conductors(self):
        source = (LAUNCHER.parent / "src/effects/effects.cpp").read_text()
        kinds = re.findall(r"&(\w+)Options::kind\(\)", source[source.index("conductor_kinds()"):source.index("namespace {")])
        names = [re.sub(r"(?<!^)(?=[A-Z])", "_", kind).lower() for kind in kinds]
        self.assertIn("floating_conductors", names)
        self.assertIn(f"conductor_effects='{'|'.join(names)}'", LAUNCHER.read_text())

    def test_a_changed_source_is_built_and_announced(self):
        self.start(self.first)
        write_word(self.first, "changed")
        said = f"lichtenberg: building (log in {self.first}/build/build.log)\n"
        self.assertEqual(self.start(self.first), ("changed\n", said))

    def test_a_copied_folder_builds_its_own_sources(self):
        self.start(self.first)
        copy = self.root / "copy"
        shutil.copytree(self.first, copy, symlinks=True)
        write_word(copy, "copy")
        before = states(self.first)
        output, said = self.start(copy)
        self.assertEqual(output, "copy\n")
        self.assertIn(f"lichtenberg: {copy}/build was made for {self.first}: building again", said)
        self.assertEqual(states(self.first), before)
        self.assertEqual(self.start(copy), ("copy\n", ""))
        self.assertNotIn(str(self.first), (copy / "build/build.ninja").read_text())

    def test_a_folder_copied_without_a_change_does_not_use_the_old_place(self):
        self.start(self.first)
        copy = self.root / "copy"
        shutil.copytree(self.first, copy, symlinks=True)
        write_word(self.first, "changed")
        self.assertEqual(self.start(copy)[0], "first\n")

    def test_a_moved_folder_builds_anew(self):
        self.start(self.first)
        moved = self.first.rename(self.root / "moved")
        output, said = self.start(moved)
        self.assertEqual(output, "first\n")
        self.assertIn(f"lichtenberg: {moved}/build was made for {self.first}: building again", said)

    def test_a_configuration_that_failed_is_tried_again(self):
        (self.first / "CMakeLists.txt").write_text("no cmake\n")
        for _ in range(2):
            ended = subprocess.run([self.first / "lichtenberg"], capture_output=True, text=True, check=False)
            self.assertEqual(ended.returncode, 1)
            self.assertIn("lichtenberg: the build failed", ended.stderr)
        (self.first / "CMakeLists.txt").write_text(PROJECT)
        self.assertEqual(self.start(self.first)[0], "first\n")
        copy = self.root / "copy"
        shutil.copytree(self.first, copy, symlinks=True)
        (copy / "CMakeLists.txt").write_text("no cmake\n")
        self.assertEqual(subprocess.run([copy / "lichtenberg"], capture_output=True, check=False).returncode, 1)
        (copy / "CMakeLists.txt").write_text(PROJECT)
        self.assertEqual(self.start(copy)[0], "first\n")


if __name__ == "__main__":
    unittest.main()
