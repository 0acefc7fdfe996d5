# Finds the libraries that lichtenberg needs, for this build and for find_package(lichtenberg).
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(SUNDIALS REQUIRED)
find_package(fmt REQUIRED)
find_package(CHOLMOD REQUIRED)
find_package(PkgConfig REQUIRED)
# PETSc's headers include those of MPI. A project in C++ only finds MPI by its own compiler.
get_property(languages GLOBAL PROPERTY ENABLED_LANGUAGES)
if("C" IN_LIST languages)
  find_package(MPI REQUIRED COMPONENTS C)
else()
  find_package(MPI REQUIRED COMPONENTS CXX)
  if(NOT TARGET MPI::MPI_C)
    add_library(MPI::MPI_C INTERFACE IMPORTED)
    target_link_libraries(MPI::MPI_C INTERFACE MPI::MPI_CXX)
  endif()
endif()
pkg_check_modules(PETSC REQUIRED QUIET IMPORTED_TARGET PETSc)
# Removes Debian's compile options of PETSc (-D_FORTIFY_SOURCE and others): all libraries use the same flags.
set_property(TARGET PkgConfig::PETSC PROPERTY INTERFACE_COMPILE_OPTIONS)
pkg_check_modules(FFTW REQUIRED QUIET IMPORTED_TARGET fftw3)
find_package(ZLIB REQUIRED)
# HDF5 without MPI, because a single process writes. The parallel HDF5 includes an mpi.h that differs from that of a
# PETSc without MPI. Debian names the serial library hdf5-serial; its symbols have versions of their own.
pkg_search_module(SERIAL_HDF5 REQUIRED QUIET IMPORTED_TARGET hdf5-serial hdf5)
# An installation of toml++ has files for pkg-config if Meson made it, and for CMake if CMake made it.
pkg_check_modules(TOMLPLUSPLUS QUIET IMPORTED_TARGET tomlplusplus)
if(NOT TARGET PkgConfig::TOMLPLUSPLUS)
  find_package(tomlplusplus REQUIRED)
  add_library(PkgConfig::TOMLPLUSPLUS ALIAS tomlplusplus::tomlplusplus)
endif()
# Header-only library without CMake files.
find_path(RANDOM123_INCLUDE_DIR Random123/philox.h REQUIRED)
mark_as_advanced(RANDOM123_INCLUDE_DIR)
if(NOT TARGET Random123::Random123)
  add_library(Random123::Random123 INTERFACE IMPORTED)
  set_target_properties(Random123::Random123 PROPERTIES INTERFACE_INCLUDE_DIRECTORIES ${RANDOM123_INCLUDE_DIR})
endif()
