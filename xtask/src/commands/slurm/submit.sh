#!/usr/bin/env bash
# Submits the array, and the job that waits for it.
#
# Written by: @COMMAND@
set -eu

# Numbers of tasks stay below this; sbatch would only call the array invalid.
limit=$(scontrol show config 2>/dev/null | sed -n 's/^MaxArraySize *= *//p')
if [ -n "$limit" ] && [ @LAST@ -ge "$limit" ]; then
    echo "this cluster numbers tasks up to $((limit - 1)) (MaxArraySize), here the last is @LAST@;" \
        "write the scripts again with --tasks $((limit - 1)) or less" >&2
    exit 1
fi
array=$(sbatch --parsable @ARRAY@)
# Behind the number stands the cluster, where there are several.
array=${array%%;*}
echo "array: job $array"
# Starts when all tasks have ended well; is withdrawn when one has been given up. The command above then submits it alone.
merge=$(sbatch --parsable --dependency="afterok:$array" --kill-on-invalid-dep=yes @MERGE@)
echo "merge: job ${merge%%;*}"
echo "to watch: squeue --me; logs in "@LOG@
