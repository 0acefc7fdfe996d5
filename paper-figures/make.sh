#!/usr/bin/env bash
# Regenerates the sources' figures, all or those that are named, and prints the table of published values, ours and
# verdicts. A figure that fails is reported and the rest go on; then the exit status is 1.
#   paper-figures/make.sh              all
#   paper-figures/make.sh 7_3 7_4      these
#   paper-figures/make.sh --build DIR    with the programs built there
#   paper-figures/make.sh --results DIR  with the runs kept there (default: output/)
set -uo pipefail

folder=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
figures=() options=()
while (($#)); do
  case $1 in
    --build | --results)
      options+=("$1" "${2:?$1 needs a folder}")
      shift
      ;;
    *)
      if [[ ! -e $folder/figure_$1.py ]]; then
        echo "make.sh: there is no figure_$1.py in $folder; figures are named as in \`make.sh 7_3 7_4\`" >&2
        exit 2
      fi
      figures+=("$1")
      ;;
  esac
  shift
done
if ((!${#figures[@]})); then
  for script in "$folder"/figure_*.py; do
    script=${script##*/figure_}
    figures+=("${script%.py}")
  done
fi

failed=()
for figure in "${figures[@]}"; do
  printf '\n== figure %s\n' "$figure"
  /usr/bin/python3 "$folder/figure_$figure.py" ${options[@]+"${options[@]}"} || failed+=("$figure")
done
echo
/usr/bin/python3 "$folder/table.py" ${failed[@]+"${failed[@]}"}
if ((${#failed[@]})); then
  echo "make.sh: failed, for the reasons above: ${failed[*]}" >&2
  exit 1
fi
