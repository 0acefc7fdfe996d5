#!/usr/bin/env bash
# Runs an ensemble on a list of hosts by ssh, and then makes its table.
#
#   scenes/cluster/hosts.sh HOSTS SCENE [options of `lichtenberg ensemble`]
#   scenes/cluster/hosts.sh hosts.txt scenes/seedling.toml --conductors 16,25,36 --seeds 8
#
# HOSTS is a file with a host name on each line; # begins a comment. Each host runs one share on all its cores. All hosts
# must see the present folder and the program at the same path, and ssh must not ask for a password. Messages of share K
# are in ensemble-hosts-K.log. The same command continues after a failure or an interruption: finished members are not
# run again. LICHTENBERG names another program, SSH another command for `ssh`.
set -euo pipefail

if (($# < 2)); then
  echo 'usage: hosts.sh HOSTS SCENE [options of lichtenberg ensemble]' >&2
  exit 2
fi
script=$(readlink -f "${BASH_SOURCE[0]}")
program=${script%/scenes/cluster/hosts.sh}/lichtenberg
if [[ ! -x $program ]]; then program=lichtenberg; fi
program=${LICHTENBERG:-$program}

if [[ ! -r $1 || -d $1 ]]; then
  echo "hosts.sh: the file of hosts $1 cannot be read" >&2
  exit 2
fi
mapfile -t hosts < <(sed 's/#.*//; s/^[[:space:]]*//; s/[[:space:]]*$//; /^$/d' "$1")
shift
if ((${#hosts[@]} == 0)); then
  echo 'hosts.sh: the file of hosts names no host' >&2
  exit 2
fi
for host in "${hosts[@]}"; do
  if [[ $host == -* || $host == *[[:space:]]* ]]; then
    echo "hosts.sh: '$host' is no host name: the file of hosts has one name on each line" >&2
    exit 2
  fi
done
ensemble=("$@")
table=()  # the options without --jobs, which is for runs only
while (($#)); do
  case $1 in
    --gather | --share | --share=*)
      echo "hosts.sh: leave out $1: each host gets its own share, and the script makes the table" >&2
      exit 2
      ;;
    --jobs) shift ;;
    --jobs=*) ;;
    *) table+=("$1") ;;
  esac
  if (($#)); then shift; fi
done

# Wrong input is refused before any share starts.
status=0
message=$("$program" ensemble "${table[@]}" --gather 2>&1 >/dev/null) || status=$?
if ((status > 1)); then
  echo "$message" >&2
  exit $status
fi

# A terminal on the remote side (-tt) makes the share end with this script.
processes=()
stop() {
  trap '' INT TERM HUP
  kill "${processes[@]}" 2>/dev/null || true
  wait
  echo 'hosts.sh: stopped; the same command goes on from there' >&2
  exit "$1"
}
trap 'stop 130' INT
trap 'stop 143' TERM
trap 'stop 129' HUP
for k in "${!hosts[@]}"; do
  share=$((k + 1))/${#hosts[@]}
  remote=$(printf 'cd %q && exec %q ensemble' "$PWD" "$program")$(printf ' %q' "${ensemble[@]}")" --share $share --quiet"
  ${SSH:-ssh} -tt "${hosts[$k]}" "$remote" >"ensemble-hosts-$((k + 1)).log" 2>&1 </dev/null &
  processes+=($!)
done
for k in "${!hosts[@]}"; do
  status=0
  wait "${processes[$k]}" || status=$?
  if ((status)); then
    echo "hosts.sh: share $((k + 1)) on ${hosts[$k]} ended with status $status: see ensemble-hosts-$((k + 1)).log" >&2
  fi
done
exec "$program" ensemble "${table[@]}" --gather
