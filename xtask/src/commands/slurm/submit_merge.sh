#!/usr/bin/env bash
# Submits the array, and the job that waits for it.
#
# Written by: @COMMAND@
set -eu

# All maps are there.
merge=$(sbatch --parsable @MERGE@)
echo "merge: job ${merge%%;*}"
echo "to watch: squeue --me; logs in "@LOG@
