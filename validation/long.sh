#!/usr/bin/env bash
# Runs the checks that take too long for ./lichtenberg test; validation/long.sh --help lists the options.
exec /usr/bin/python3 "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/long/run.py" "$@"
