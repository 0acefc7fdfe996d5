"""Wheel of the present build, and its installation into an empty environment. The sources are copied, so that the tree stays
clean."""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile
from pathlib import Path

import runs

BUILD = Path(runs.PROGRAM).resolve().parent
PYTHON = "/usr/bin/python3"
WHERE = '''"""Prints the Python of a command."""
import sys

from lichtenberg import compiled

HELP, ARGUMENTS = "Prints the Python of a command", []


def act(request):
    print(sys.executable, compiled.include_folder())
'''
SOLVE = "import sys, lichtenberg as li; from lichtenberg import installation as at; print(at.find_program(), *li.solve(sys.argv[1]).potential)"


def reason_to_skip():
    """Returns why no wheel can be made; empty if it can."""
    if not (BUILD / "cmake_install.cmake").exists():
        return f"{BUILD} is no build folder"
    if not list(BUILD.glob("_core*.so")):
        return "the module is not built (pybind11-dev is missing)"
    if "-fsanitize" in subprocess.run([runs.PROGRAM, "--version"], capture_output=True, text=True, check=True).stdout:
        return "Python cannot load a module with sanitizers"
    if subprocess.run([PYTHON, "-c", "import setuptools, wheel, pip"], capture_output=True, check=False).returncode:
        return "pip is missing (Debian's python3-pip)"
    return ""


if reason_to_skip():
    print(f"wheel_test: {reason_to_skip()}: skipped")
    sys.exit(77)


class WheelTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        scratch = tempfile.TemporaryDirectory(prefix="lichtenberg-wheel-")
        cls.addClassCleanup(scratch.cleanup)
        cls.root = Path(os.path.realpath(scratch.name))
        source = cls.root / "source"
        shutil.copytree(runs.HOME / "python", source / "python", ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
        for name in ("CMakeLists.txt", "README.md", "pyproject.toml", "setup.py"):
            shutil.copy(runs.HOME / name, source)
        # Not from outside: the program under test, and paths of packages.
        cls.environment = {key: value for key, value in os.environ.items() if not key.startswith(("LICHTENBERG", "PYTHON"))}
        pip = [PYTHON, "-m", "pip", "--disable-pip-version-check"]
        cls.run_command(*pip, "wheel", "--no-deps", "--no-build-isolation", "--no-index", "--wheel-dir", cls.root, source,
                        LICHTENBERG_BUILD=str(BUILD))
        (cls.wheel,) = cls.root.glob("*.whl")
        cls.run_command(PYTHON, "-m", "venv", "--without-pip", "--system-site-packages", cls.root / "venv")
        cls.run_command(*pip, "--python", cls.root / "venv/bin/python", "install", "--no-deps", "--no-index", cls.wheel)
        cls.program = cls.root / "venv/bin/lichtenberg"
        cls.package = next(cls.root.glob("venv/lib/python3*/site-packages/lichtenberg"))

    @classmethod
    def run_command(cls, *words, **variables):
        """Returns the output of a command that must succeed."""
        ended = subprocess.run(list(map(str, words)), capture_output=True, text=True, cwd=cls.root, check=False,
                               env={**cls.environment, **variables})
        assert ended.returncode == 0, f"{words} ended with {ended.returncode}\n{ended.stdout}{ended.stderr}"
        return ended.stdout

    def test_a_folder_without_a_build_is_refused(self):
        ended = subprocess.run([PYTHON, "setup.py", "build_ext"], capture_output=True, text=True, cwd=self.root / "source", check=False,
                               env={**self.environment, "LICHTENBERG_BUILD": "nowhere"})
        self.assertNotEqual(ended.returncode, 0)
        self.assertIn("LICHTENBERG_BUILD=nowhere is no build of lichtenberg", ended.stderr)

    def test_it_is_for_this_python_and_system_and_has_the_program_and_its_data(self):
        number = self.run_command(runs.PROGRAM, "--version").split()[1]
        python = f"cp3{sys.version_info.minor}"
        self.assertEqual(self.wheel.name, f"lichtenberg-{number}-{python}-{python}-linux_{os.uname().machine}.whl")
        names = zipfile.ZipFile(self.wheel).namelist()
        for name in ("bin/lichtenberg", "__main__.py", "commands/plot.py", "view.html", "py.typed", "scenes/two-disks.toml"):
            self.assertIn(f"lichtenberg/{name}", names)
        self.assertEqual([name for name in names if "__pycache__" in name], [])

    def test_its_command_is_the_built_program(self):
        built = self.run_command(runs.PROGRAM, "--version")
        self.assertEqual(self.run_command(self.program, "--version"), built)

    def test_its_program_calls_the_package_with_the_python_of_the_environment(self):
        folder = self.root / "commands"
        folder.mkdir()
        (folder / "where.py").write_text(WHERE)
        said = self.run_command(self.program, "where", LICHTENBERG_COMMANDS=str(folder))
        self.assertEqual(said.split(), [str(self.root / "venv/bin/python"), str(self.package / "include")])
        ended = subprocess.run([self.program, "where"], capture_output=True, text=True, check=False,
                               env={**self.environment, "LICHTENBERG_COMMANDS": str(folder), "LICHTENBERG_PYTHON": "/nowhere/python"})
        self.assertEqual(ended.returncode, 1)
        self.assertIn("/nowhere/python does not start", ended.stderr)

    def test_its_package_solves_and_finds_its_program(self):
        said = self.run_command(self.root / "venv/bin/python", "-c", SOLVE, self.package / "scenes/two-disks.toml").split()
        self.assertEqual(said[0], str(self.package / "bin/lichtenberg"))
        self.assertEqual(len(said), 3)

    def test_its_program_draws(self):
        self.run_command(self.program, "solve", self.package / "scenes/two-disks.toml", "--out", "two-disks.png")
        self.assertEqual((self.root / "two-disks.png").read_bytes()[:4], b"\x89PNG")


if __name__ == "__main__":
    unittest.main()
