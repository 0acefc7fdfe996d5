# Recipe for Spack 1.0 and newer. Untested: it was neither concretized nor built.
import os

from spack_repo.builtin.build_systems.cmake import CMakePackage, generator

from spack.package import *


class Lichtenberg(CMakePackage):
    """Motion of charged conductors, packings and grains, which touch, exchange charge and form
    structures: program, C++ library and Python package."""

    # Source archive that packaging/release makes, in the working directory.
    manual_download = True
    url = f"file://{os.getcwd()}/lichtenberg-1.0.0.tar.gz"

    license("BSD-3-Clause")

    version("1.0.0")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("doctest", type="build")
    depends_on("py-pybind11@2.10:", type="build")

    depends_on("boost@1.74:")
    depends_on("cli11@2.1:")
    depends_on("eigen@3.4:3")
    depends_on("fftw@3:~mpi")
    depends_on("fmt@9:")
    # One process writes results, so HDF5 has no MPI. PETSc must not require another HDF5.
    depends_on("hdf5@1.10:~mpi")
    depends_on("mpi")
    depends_on("nlohmann-json@3.11:")
    depends_on("petsc@3.18:+mpi~complex~hdf5")
    depends_on("random123@1.13:")
    depends_on("suite-sparse@5.12:")
    depends_on("sundials@6.4:6+klu~mpi")
    depends_on("tomlplusplus@3.3:")
    depends_on("zlib-api")

    depends_on("python@3.9:", type=("build", "link", "run"))
    depends_on("py-h5py@3.5:~mpi", type="run")
    depends_on("py-matplotlib@3.5:", type="run")
    depends_on("py-numpy@1.21:", type="run")

    generator("ninja")
    build_targets = ["lichtenberg", "python_module"]

    def cmake_args(self):
        return [
            self.define("LICHTENBERG_NATIVE", False),  # Spack adds the flags of its target
            self.define("CMAKE_REQUIRE_FIND_PACKAGE_pybind11", True),
            self.define("Python_EXECUTABLE", python.path),
        ]

    def install(self, spec, prefix):
        # The target install would also build tests and benchmarks.
        cmake("--install", self.build_directory)

    def setup_run_environment(self, env):
        env.prepend_path("PYTHONPATH", self.prefix.share.lichtenberg.python)
