"""Builds a wheel: CMake builds the program and the module, and installs them with the package (cmake/wheel.cmake).

The environment variable CMAKE_ARGS has options for CMake. LICHTENBERG_BUILD names the folder of a finished build; without it,
setup.py builds in build-wheel/."""
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

HERE = Path(__file__).resolve().parent


def version():
    """Returns the version that CMakeLists.txt states."""
    return re.search(r"^project\(lichtenberg VERSION (\S+)", (HERE / "CMakeLists.txt").read_text(encoding="utf-8"), re.M)[1]


def cmake(*words):
    """Calls CMake. Ends without a traceback if it fails, because its output states the cause."""
    try:
        status = subprocess.run(["cmake", *map(str, words)], check=False).returncode
    except FileNotFoundError:
        sys.exit("setup.py: there is no cmake on the PATH: install CMake 3.25 or newer")
    if status:
        sys.exit(f"setup.py: cmake {words[0]} ended with status {status}, see its output above")


def configure(folder):
    """Configures a build for this Python."""
    options = ["-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_INSTALL_RPATH_USE_LINK_PATH=ON", "-DCMAKE_REQUIRE_FIND_PACKAGE_pybind11=ON"]
    try:
        import pybind11

        options.append(f"-Dpybind11_DIR={pybind11.get_cmake_dir()}")
    except ImportError:
        pass  # CMake searches for it, as for the other libraries
    if shutil.which("ninja"):
        options.append("-GNinja")
    try:
        options += [f"-DPython_EXECUTABLE={sys.executable}", *shlex.split(os.environ.get("CMAKE_ARGS", ""))]
    except ValueError as error:
        sys.exit(f"setup.py: CMAKE_ARGS={os.environ['CMAKE_ARGS']} is not valid ({error})")
    cmake("-S", HERE, "-B", folder, *options)


def is_build(folder):
    """Whether a folder has a build of lichtenberg by CMake."""
    cache = Path(folder) / "CMakeCache.txt"
    return cache.is_file() and "CMAKE_PROJECT_NAME:STATIC=lichtenberg" in cache.read_text(encoding="utf-8").splitlines()


class Build(build_ext):
    """Builds with CMake."""

    def run(self):
        if self.editable_mode:
            sys.exit("setup.py: an editable installation is not possible, because the module is compiled: use PYTHONPATH=python")
        folder = os.environ.get("LICHTENBERG_BUILD")
        if not folder:
            folder = HERE / f"build-wheel/cmake-{sys.implementation.cache_tag}"
            configure(folder)
            jobs = os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL") or os.cpu_count()
            cmake("--build", folder, "--parallel", jobs, "--target", "lichtenberg", "python_module")
        elif not is_build(folder):
            sys.exit(f"setup.py: LICHTENBERG_BUILD={folder} is no build of lichtenberg: name one, or leave the variable out")
        package = Path(self.build_lib) / "lichtenberg"
        shutil.rmtree(package, ignore_errors=True)
        cmake("--install", folder, "--prefix", package, "--component", "wheel", "--strip")
        module = package / Path(self.get_ext_filename("_core")).name
        if not module.exists():
            sys.exit(f"setup.py: {folder} has no module {module.name}, which {sys.executable} needs: build it for this Python")


setup(
    version=version(),
    packages=["lichtenberg"],
    package_dir={"": "python"},
    ext_modules=[Extension("lichtenberg._core", [])],
    cmdclass={"build_ext": Build},
    options={"build": {"build_base": "build-wheel"}},
)
