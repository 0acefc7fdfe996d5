#!/usr/bin/env bash
# Runs an ensemble as a Slurm array job, and then a job that makes its table.
#
#   scenes/cluster/slurm.sh SHARES SCENE [options of `lichtenberg ensemble`] [-- options of sbatch for the array]
#   scenes/cluster/slurm.sh 8 scenes/seedling.toml --conductors 16,25,36 --seeds 8 -- --time=2:00:00 --cpus-per-task=4
#
# Task K of the array runs share K of SHARES. Five minutes before its time limit a task ends at checkpoints and queues
# itself again; a task that scancel ends is not queued again. The same command continues after a failure: finished members
# are not run again. All nodes must see the present folder and the program. Messages of task K are in ensemble-JOB-K.log.
# Those of the last job are in ensemble-JOB-table.log; it names the members that are not finished. LICHTENBERG names
# another program.
set -euo pipefail

# The job of one share. After SIGUSR1, which Slurm sends before the time limit, the ensemble is stopped and the job queued
# again. SIGTERM would not do: Slurm sends it also to cancelled jobs.
run_share() {
  local share=$1 status=0
  shift
  "$LICHTENBERG" ensemble "$@" --share "$share" --jobs "${SLURM_CPUS_PER_TASK:-1}" --quiet &
  local ensemble=$!
  trap 'kill -TERM $ensemble' USR1
  wait $ensemble || status=$?
  # After the signal the first wait ends early.
  while kill -0 $ensemble 2>/dev/null; do
    status=0
    wait $ensemble || status=$?
  done
  if ((status == 128 + 15)); then exec scontrol requeue "$SLURM_JOB_ID"; fi
  exit $status
}

case ${1:-} in
  --run-share) run_share "$SLURM_ARRAY_TASK_ID/$2" "${@:3}" ;;
  --make-table) exec "$LICHTENBERG" ensemble "${@:2}" --gather ;;
esac

if (($# < 2)) || [[ ! $1 =~ ^[1-9][0-9]*$ ]]; then
  echo 'usage: slurm.sh SHARES SCENE [options of lichtenberg ensemble] [-- options of sbatch]' >&2
  exit 2
fi
command -v sbatch >/dev/null || { echo 'slurm.sh: Slurm is not installed here: the command sbatch is missing' >&2; exit 2; }
script=$(readlink -f "${BASH_SOURCE[0]}")
program=${script%/scenes/cluster/slurm.sh}/lichtenberg
if [[ ! -x $program ]]; then program=lichtenberg; fi
export LICHTENBERG=${LICHTENBERG:-$program}

shares=$1
shift
ensemble=()
while (($#)) && [[ $1 != -- ]]; do
  ensemble+=("$1")
  shift
done
if (($#)); then shift; fi
for word in "${ensemble[@]}"; do
  case ${word%%=*} in
    --gather | --share) echo "slurm.sh: leave out $word: each task gets its own share, and the last job makes the table" >&2 ;;
    --jobs) echo "slurm.sh: leave out $word: --cpus-per-task of sbatch is the number of jobs" >&2 ;;
    *) continue ;;
  esac
  exit 2
done

# Wrong input is refused before anything is queued.
status=0
message=$("$LICHTENBERG" ensemble "${ensemble[@]}" --gather 2>&1 >/dev/null) || status=$?
case $status in
  0) echo 'all members are finished'; exec "$LICHTENBERG" ensemble "${ensemble[@]}" --gather ;;
  1) ;;
  *) echo "$message" >&2; exit $status ;;
esac

job=$(sbatch --parsable --job-name=lichtenberg --array="1-$shares" --signal=B:USR1@300 --requeue --open-mode=append \
  --output=ensemble-%A-%a.log "$@" "$script" --run-share "$shares" "${ensemble[@]}")
job=${job%%;*}
table=$(sbatch --parsable --job-name=lichtenberg-table --dependency="afterany:$job" \
  --output="ensemble-$job-table.log" "$script" --make-table "${ensemble[@]}")
echo "job $job runs $shares shares, then job ${table%%;*} makes the table; messages: ensemble-$job-*.log"
