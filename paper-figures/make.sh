#!/usr/bin/env bash
# Generates the sources' figures, all or the named ones, and prints the table of published values, values here and
# verdicts. Reports a failed figure and continues; the exit status is then 1.
#   paper-figures/make.sh              all
#   paper-figures/make.sh 7_3 7_4      these
#   paper-figures/make.sh granular       those of grains (granular_*.py); --full: at the source's size, on a device
#   paper-figures/make.sh granular_4_5   this one of them
#   paper-figures/make.sh --build DIR    with the programs built there
#   paper-figures/make.sh --results DIR  with the runs kept there (default: output/)
set -uo pipefail

folder=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
scripts=() options=() of_grains=()
while (($#)); do
  case $1 in
    --build | --results)
      options+=("$1" "${2:?$1 needs a folder}")
      shift
      ;;
    --full) of_grains+=("$1") ;;
    --seeds | --processes)
      of_grains+=("$1" "${2:?$1 needs a number}")
      shift
      ;;
    granular) scripts+=("$folder"/granular_*.py) ;;
    *)
      script=$folder/figure_$1.py
      [[ $1 == granular_* ]] && script=$folder/$1.py
      if [[ ! -e $script ]]; then
        echo "make.sh: there is no ${script##*/} in $folder; figures are named as in \`make.sh 7_3 granular_4_5\`" >&2
        exit 2
      fi
      scripts+=("$script")
      ;;
  esac
  shift
done
((${#scripts[@]})) || scripts=("$folder"/figure_*.py "$folder"/granular_*.py)

failed=()
for script in "${scripts[@]}"; do
  figure=${script##*/}
  figure=${figure#figure_}
  figure=${figure%.py}
  printf '\n== figure %s\n' "$figure"
  more=()
  [[ $figure == granular_* ]] && more=(${of_grains[@]+"${of_grains[@]}"})
  /usr/bin/python3 "$script" ${options[@]+"${options[@]}"} ${more[@]+"${more[@]}"} || failed+=("$figure")
done
echo
/usr/bin/python3 "$folder/table.py" ${failed[@]+"${failed[@]}"}
if ((${#failed[@]})); then
  echo "make.sh: failed, for the reasons above: ${failed[*]}" >&2
  exit 1
fi
