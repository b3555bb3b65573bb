#!/usr/bin/env bash
# Makes one shard of a data set: task I of the array makes the maps with id mod @TASKS@ = I - 1.
#
# Tasks do not wait for each other. One that fails, or has two minutes left, goes back into the queue by itself, at most
# @RETRIES@ times, and then goes on after the maps it has finished. What a killed task leaves half-written is never taken for a
# map.
#
# Written by: @COMMAND@
@OPTIONS@
set -u
shard="$SLURM_ARRAY_TASK_ID/@TASKS@"

# Ends this run of the task; the reason is the first argument.
end() {
    # Slurm counts how often it started this task again; at first there is no such number.
    if [ "${SLURM_RESTART_COUNT:-0}" -lt @RETRIES@ ]; then
        echo "shard $shard: $1; back into the queue" >&2
        # The number of the job alone would mean the whole array.
        scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID" && exit 0
    fi
    echo "shard $shard: $1; given up" >&2
    exit 1
}

# In the background, for bash does not listen to signals while it waits for a command in the foreground.
@PROGRAM@ @DATASET@ \
    --out @OUT@ --shard "$shard" --threads "$SLURM_CPUS_ON_NODE" &
program=$!
trap 'kill -TERM "$program"; wait "$program"; end "out of time"' USR1
wait "$program"
status=$?
[ "$status" -eq 0 ] || end "exit code $status"
echo "shard $shard: done"
