#!/usr/bin/env bash
# The models on a GPU, in ten minutes at most: parity with the CPU, times beside PyTorch's, and trainings for the time that is left.
#
#     tests/gpu.sh PROGRAMS OUT [--device cuda] [--minutes 10] [--maps synthetic:51] [--quick]
#
# PROGRAMS is a folder of programs built elsewhere, as tests/cuda/build.sh makes it: this needs neither cargo nor a network, but a driver
# and libraries of CUDA 13, those of python3's PyTorch if it has them. xtask, xtask-models, step_time, device_parity and, if it is there,
# unit_tests. OUT gets report.md, which is printed last, the weights and the curves of the trainings.
# PyTorch's times need python3 with torch; without it the column is empty. --maps is a folder of RadioMapSeer files; the data set is traced
# here. --quick takes small sizes: with `--device cpu --quick` the script itself can be tried without a GPU.
set -euo pipefail

programs=$(realpath "$1") out=$2
shift 2
device=cuda minutes=10 maps=synthetic:51 quick=
while [ $# -gt 0 ]; do
    case $1 in
        --device | --minutes | --maps) declare "${1#--}=$2" && shift ;;
        --quick) quick=yes ;;
        *) echo "'$1' is none of --device --minutes --maps --quick" >&2 && exit 2 ;;
    esac
    shift
done
end=$((SECONDS + minutes * 60))
# Seconds left, one at least; a command that is stopped when they are over.
left() { echo $((SECONDS < end ? end - SECONDS : 1)); }
limited() { timeout "$(left)" "$@"; }
here=$(realpath "$(dirname "$0")")
if libraries=$(python3 -c 'import nvidia.cu13; print(*nvidia.cu13.__path__)' 2>/dev/null); then
    export LD_LIBRARY_PATH=$libraries/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
fi
report=$out/report.md failed=
[ ! -e "$report" ] || { echo "'$out' holds a report already: name another folder" >&2 && exit 2; }
mkdir -p "$out"

# Sizes: images, links a step, seconds a time, terminals a map, seconds kept for Polar-Reg, and for predictions and metrics of MS-AReg.
pixels="64 128 256" batch=64 seconds=1 terminals="--tx-per-map 100 --rx-per-map 200" polar=80 closing=30
models="ms_areg resnet_mlp"
if [ -n "$quick" ]; then
    pixels=32 batch=8 seconds=0.2 terminals="--tx-per-map 4 --rx-per-map 20" polar=20 closing=10 models=resnet_mlp maps=synthetic:6
fi

section() { printf '\n## %s\n\n' "$1" | tee -a "$report"; }
# What a step prints is kept; one that fails does not end the others.
step() { "$@" 2>>"$out/log" | tee -a "$report" || { failed+=" $1" && echo "FAIL: $1, see log" | tee -a "$report"; }; }

{
    echo "# Models on $device"
    echo
    date -u +%Y-%m-%d
    nproc
    nvidia-smi --query-gpu=name,driver_version,memory.total --format=csv,noheader 2>/dev/null || true
} >"$report"

section "Parity with the CPU"
parity() { limited "$programs/device_parity" "$device" 64; }
step parity

section "Convolutions against candle's own and the CPU's loops"
convolutions() {
    [ -x "$programs/unit_tests" ] || { echo "left out: there is no program unit_tests" && return; }
    limited "$programs/unit_tests" --quiet convolutions | grep 'test result'
}
step convolutions

section "Times"
cases=()
for model in $models; do
    for size in $pixels; do
        cases+=("$model-train-$size-$batch" "$model-infer-$size-$batch")
    done
done
times() {
    if python3 -c 'import torch, torchvision' 2>/dev/null; then
        limited python3 "$here/golden/models_speed.py" --program "$programs/step_time" --device "$device" --precision full mixed --rounds 1 \
            --seconds "$seconds" --threads "$(nproc)" "${cases[@]}"
        return
    fi
    printf 'ms a step, without PyTorch\n\n| case | precision | aps-model |\n|---|---|---|\n'
    for case in "${cases[@]}"; do
        for precision in full mixed; do
            echo "| $case | $precision | $(limited "$programs/step_time" "$case" "$device" "$precision" "$seconds") |"
        done
    done
}
step times

section "Training"
data=$out/data
# Trains a model for some seconds, and prints its scores on the test maps.
learn() {
    local model=$1 seconds=$2
    shift 2
    printf '\n%s, device %s, %s s of training, maps %s\n\n' "$model" "$device" "$seconds" "$maps"
    [ "$seconds" -ge 5 ] || { echo "left out: no time is left for it" && return 1; }
    timeout $((seconds + 60)) "$programs/xtask-models" train --data "$data" --maps "$maps" --model "$model" --preset small --mirror --device "$device" \
        --budget "${seconds}s" --dev-limit 2000 --out "$out/$model" "$@" >&2 || return 1
    limited "$programs/xtask-models" predict --data "$data" --maps "$maps" --weights "$out/$model/best.safetensors" --device "$device" \
        --batch 256 --out "$out/$model/predicted.npy" >&2 || return 1
    limited "$programs/xtask" metrics --truth "$data" --split test --prediction "$out/$model/predicted.npy" --format markdown || return 1
    rm -f "$out/$model/predicted.npy" "$out/$model/predicted.links.csv" "$out/$model/last.safetensors"
}
train() {
    local status=0
    # shellcheck disable=SC2086
    limited "$programs/xtask" dataset --maps "$maps" --protocol paper $terminals --out "$data" >&2 || return 1
    learn ms_areg $(($(left) - closing - polar)) --image-size 64 --batch "$batch" || status=1
    # Its ways lie on the device. Half of the time that was kept for it: its links are found first, its scores last.
    learn polar_reg $((($(left) < polar ? $(left) : polar) / 2)) || status=1
    return $status
}
step train
rm -rf "$data"

printf '\n%s s of %s\n' "$SECONDS" $((minutes * 60)) >>"$report"
printf '\n' && cat "$report"
[ -z "$failed" ] || { echo "failed:$failed" >&2 && exit 1; }
