#!/bin/bash
# Runs an experiment of jde as a Slurm job array, one part of the experiment for each task:
#
#   sbatch --array=1-16 slurm.sh FILE OUT
#
# FILE and OUT are on a file system that all nodes share; `jde` and its plugins are found there as in the shell
# that calls sbatch (PATH, JDE_PLUGIN_PATH). Add --cpus-per-task, --time and --partition as for any other job.
# A task that is killed or reaches its time limit returns to the queue and goes on where it stopped.

#SBATCH --job-name=jde-experiment
# Slurm itself starts a task again whose node is lost.
#SBATCH --requeue
#SBATCH --open-mode=append
# A minute before the time limit, so that results are written and the task returns to the queue.
#SBATCH --signal=B:USR1@60

# How often a task may return to the queue before something is wrong with it.
readonly RESTARTS=20

if [ $# -ne 2 ] || [ "$SLURM_ARRAY_TASK_MIN" != 1 ] || [ "$SLURM_ARRAY_TASK_COUNT" != "$SLURM_ARRAY_TASK_MAX" ]; then
    echo "usage: sbatch --array=1-N slurm.sh FILE OUT" >&2
    exit 2
fi
part=$SLURM_ARRAY_TASK_ID
parts=$SLURM_ARRAY_TASK_MAX

# In the background: bash handles a signal only between commands, and in `wait`.
jde experiment "$1" --shard "$part/$parts" --out "$2/part-$part-of-$parts" --resume \
    --jobs "${SLURM_CPUS_PER_TASK:-1}" &
jde=$!
stopped=no
trap 'stopped=yes; kill -TERM $jde' USR1
wait $jde
status=$?
if [ $stopped = yes ]; then
    wait $jde # the signal ended the first wait
elif [ $status -lt 128 ]; then
    # 1 means that a drive failed, which is a result. 2 and 3 are errors in the file or a plugin: see above.
    [ $status -le 1 ]
    exit
fi

if [ "${SLURM_RESTART_COUNT:-0}" -ge $RESTARTS ]; then
    echo "part $part was restarted $RESTARTS times and is not done" >&2
    exit 1
fi
echo "part $part was stopped (status $status) and returns to the queue"
scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
