#!/usr/bin/env bash
# Builds a PETSc with CUDA from Debian's source package, for the preset `gpu`:
#   cmake/petsc-cuda.sh PREFIX [--mpi] [--arch 90] [--cuda /usr/local/cuda] [--source petsc_*.orig.tar.*] [--jobs N]
# apt downloads the source (PETSc 3.22 of Debian 13) from this machine's mirror without changes to its list of sources;
# --source uses a local file. --arch is the device's compute capability without the dot: 80 for an A100, 90 for an H100
# or H200. The build has double precision and one process, or with --mpi those of the MPI whose mpicc is in the PATH.
set -euo pipefail

here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
prefix='' source='' mpi='' arch=90 cuda=/usr/local/cuda jobs=$(nproc) suite=trixie

say() { printf 'petsc-cuda: %s\n' "$*" >&2; }

# fail MESSAGE [LOG]: prints the end of the log and the message, exits with status 1.
fail() {
  if [[ ${2:-} ]]; then tail -n 30 "$2" >&2; fi
  say "$1"
  exit 1
}

read_arguments() {
  while (($#)); do
    case $1 in
      --arch | --cuda | --source | --jobs)
        [[ ${2:-} ]] || fail "$1 needs a value"
        printf -v "${1#--}" '%s' "$2"
        shift 2
        ;;
      --mpi)
        mpi=yes
        shift
        ;;
      -*) fail "there is no option $1; known are --mpi, --arch, --cuda, --source and --jobs" ;;
      *)
        [[ ! $prefix ]] || fail "one folder to install into, not both $prefix and $1"
        prefix=$(realpath -m "$1")
        shift
        ;;
    esac
  done
  [[ $prefix ]] || fail "name the folder to install into, as in: cmake/petsc-cuda.sh \$HOME/petsc-cuda"
  [[ $arch =~ ^[0-9]+$ ]] || fail "--arch $arch: a compute capability without its dot, such as 90, is expected"
  [[ ! $source || -f $source ]] || fail "--source $source: there is no such file"
}

check_tools() {
  local tool library
  for tool in python3 gcc g++ make patch pkg-config tar; do
    command -v $tool >/dev/null || fail "$tool is missing: apt-get install python3 g++ make patch pkg-config"
  done
  if [[ $mpi ]]; then
    for tool in mpicc mpicxx; do
      command -v $tool >/dev/null || fail "--mpi: $tool is missing: apt-get install libopenmpi-dev"
    done
  fi
  [[ -x $cuda/bin/nvcc ]] || fail "there is no $cuda/bin/nvcc: install the CUDA toolkit, or say where it is with --cuda"
  [[ $(gcc -print-file-name=liblapack.so) == /* ]] || fail "LAPACK is missing: apt-get install liblapack-dev"
  for library in cudart cufft cublas cusparse cusolver curand; do
    [[ -e $cuda/lib64/lib$library.so ]] || fail "the CUDA toolkit in $cuda has no lib64/lib$library.so"
  done
}

# Downloads Debian 13's source package by apt with a separate list of sources that names this machine's mirror.
download() {
  local mirror log=$work/apt.log
  command -v apt-get >/dev/null || fail "without apt the source must be given: --source petsc_3.22.5+dfsg1.orig.tar.xz"
  # shellcheck disable=SC2016  # apt's own variables
  mirror=$(apt-get indextargets --format '$(REPO_URI)|$(LABEL)' 'Created-By: Packages' | sed -n 's/|Debian$//p' | head -n 1)
  [[ $mirror ]] || fail "this machine's apt knows no mirror of Debian: give the source with --source"
  mkdir -p "$work"/apt/{lists/partial,cache/archives/partial}
  printf 'deb-src [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] %s %s main\n' "$mirror" $suite >"$work/apt/sources.list"
  local own=(-o Dir::Etc::SourceList="$work/apt/sources.list" -o Dir::Etc::SourceParts=/dev/null
    -o Dir::State::Lists="$work/apt/lists" -o Dir::Cache="$work/apt/cache" -o APT::Sandbox::User=root)
  say "downloading the source of Debian 13 ($mirror)"
  { apt-get "${own[@]}" update && (cd "$work" && apt-get "${own[@]}" source --download-only --tar-only petsc); } >"$log" 2>&1 ||
    fail "apt-get could not get the source of petsc from Debian 13 (see $log); --source takes its orig tarball" "$log"
  source=$(compgen -G "$work/petsc_*.orig.tar.*" | grep -v '\.asc$' | head -n 1)
}

unpack() {
  local log=$work/patch.log
  mkdir "$work/petsc"
  tar -xf "$source" -C "$work/petsc" --strip-components=1
  local version
  version=$(awk '/define PETSC_VERSION_(MAJOR|MINOR)/ {printf "%s%s", dot, $3; dot = "."}' "$work/petsc/include/petscversion.h")
  [[ $version == 3.22 ]] || fail "$source is PETSc $version; the patch for CUDA 13 is for 3.22"
  patch -d "$work/petsc" -p1 <"$here/petsc-cuda13.patch" >"$log" 2>&1 || fail "the patch for CUDA 13 does not fit" "$log"
}

# --with-cuda-dir would link a library that CUDA 13 does not contain.
configure() {
  local log=$work/configure.log library libraries=() compilers=(--with-mpi=0 --with-cc=gcc --with-cxx=g++)
  if [[ $mpi ]]; then compilers=(--with-mpi=1 --with-cc=mpicc --with-cxx=mpicxx); fi
  for library in cudart cufft cublas cusparse cusolver curand; do libraries+=("$cuda/lib64/lib$library.so"); done
  say "configuring (log: $log)"
  (
    cd "$work/petsc"
    IFS=,
    python3 ./configure PETSC_DIR="$PWD" PETSC_ARCH=cuda --prefix="$prefix" \
      "${compilers[@]}" --with-fc=0 --with-debugging=0 --with-shared-libraries=1 \
      --with-cxx-dialect=17 --with-cuda-dialect=17 \
      --with-cuda=1 --with-cuda-arch="$arch" --with-cudac="$cuda/bin/nvcc" \
      --with-cuda-include="$cuda/include" --with-cuda-lib="[${libraries[*]}]" \
      "--with-blaslapack-lib=[-llapack,-lblas]" --with-x=0 --with-ssl=0 --with-petsc4py=0 \
      COPTFLAGS=-O3 CXXOPTFLAGS=-O3 CUDAOPTFLAGS=-O3
  ) >"$log" 2>&1 </dev/null || fail "PETSc could not be configured" "$log"
}

build() {
  local log=$work/build.log
  say "building with $jobs processes (log: $log)"
  # PETSc's own load limit would leave cores idle.
  make -C "$work/petsc" PETSC_DIR="$work/petsc" PETSC_ARCH=cuda MAKE_NP="$jobs" MAKE_LOAD=$((8 * jobs)) all \
    >"$log" 2>&1 </dev/null || fail "PETSc could not be built" "$log"
  make -C "$work/petsc" PETSC_DIR="$work/petsc" PETSC_ARCH=cuda install >>"$log" 2>&1 </dev/null ||
    fail "PETSc could not be installed into $prefix" "$log"
}

# Adds the flags of MPI to PETSc's file for pkg-config, which leaves them to mpicc.
add_mpi_flags() {
  local file=$prefix/lib/pkgconfig/PETSc.pc shown
  shown=$(mpicc -show)
  flags() { grep -oE -- " $1[^ ]+" <<<"$shown" | tr -d '\n'; }
  sed -i -e "s|^Cflags:.*|&$(flags -I)|" -e "s|^Libs:.*|&$(flags -L)$(flags -l)|" "$file"
}

read_arguments "$@"
check_tools
mkdir -p "$prefix" || fail "$prefix cannot be made"
work=$(mktemp -d "${TMPDIR:-/tmp}/petsc-cuda.XXXXXX")
if [[ $source ]]; then source=$(realpath "$source"); else download; fi
unpack
configure
build
if [[ $mpi ]]; then add_mpi_flags; fi
rm -rf "$work"
say "PETSc with CUDA is in $prefix; build lichtenberg with it:
  PKG_CONFIG_PATH=$prefix/lib/pkgconfig cmake --preset gpu -DCMAKE_CUDA_COMPILER=$cuda/bin/nvcc
  ninja -C build-gpu lichtenberg"
if [[ $mpi ]]; then
  say "if MPI cannot send from device memory, as Debian's Open MPI: PETSC_OPTIONS='-use_gpu_aware_mpi 0'"
fi
