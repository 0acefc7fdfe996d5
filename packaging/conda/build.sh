#!/usr/bin/env bash
set -euo pipefail
# conda-build sets CMAKE_ARGS.
export CMAKE_ARGS="$CMAKE_ARGS -DLICHTENBERG_NATIVE=OFF -DCMAKE_PREFIX_PATH=$PREFIX"
"$PYTHON" -m pip install . --verbose --no-deps --no-build-isolation
