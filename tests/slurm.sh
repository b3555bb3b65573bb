#!/usr/bin/env bash
# The scripts of `cargo xtask slurm` on a real Slurm: one task is killed, one runs out of time, one is given up; what is made
# in the end must be what one run makes, byte for byte.
#
#     sudo tests/slurm.sh                  # builds the runner; XTASK=path/to/xtask takes one that is built
#
# Needs root: installs Debian's slurm-wlm, munge and shellcheck if they are not there, and starts munged, slurmctld and slurmd
# with settings, ports and folders of their own, which end and vanish with the script. Takes four minutes on two cores.
set -euo pipefail
repository=$(cd "$(dirname "$0")/.." && pwd)

for package in slurm-wlm munge shellcheck; do
    if ! dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed; then
        DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends "$package"
    fi
done
if [ -z "${XTASK:-}" ]; then
    (cd "$repository" && cargo build --release --package xtask)
    XTASK=${CARGO_TARGET_DIR:-$repository/target}/release/xtask
fi

# --- A cluster of one node ---

root=$(mktemp -d /tmp/slurm-test.XXXXXX)
chmod 755 "$root"
daemons=()
finish() {
    status=$?
    [ "$status" -eq 0 ] || tail -n 20 "$root"/*.log "$root"/work*/*-slurm/log/* 2>/dev/null || true
    [ ${#daemons[@]} -eq 0 ] || kill "${daemons[@]}" 2>/dev/null || true
    wait
    rm -rf "$root"
    exit "$status"
}
trap finish EXIT

fail() {
    echo "FAILED: $*" >&2
    exit 1
}

# Repeats a command until it succeeds, for so many seconds.
until_true() {
    local seconds=$1 end=$((SECONDS + $1))
    shift
    until "$@" >/dev/null 2>&1; do
        [ "$SECONDS" -lt "$end" ] || fail "after $seconds s still not: $*"
        sleep 0.1
    done
}

mkdir "$root/munge" "$root/state" "$root/spool"
dd if=/dev/urandom of="$root/munge/key" bs=1024 count=1 status=none
chown -R munge: "$root/munge"
chmod 755 "$root/munge"
chmod 400 "$root/munge/key"
setpriv --reuid munge --regid munge --clear-groups munged --foreground --force --key-file "$root/munge/key" \
    --socket "$root/munge/socket" --pid-file "$root/munge/pid" --log-file "$root/munge/log" \
    --seed-file "$root/munge/seed" >"$root/munged.log" 2>&1 &
daemons+=($!)
until_true 10 munge --no-input --socket "$root/munge/socket"

host=$(hostname -s)
export SLURM_CONF=$root/slurm.conf
cat >"$SLURM_CONF" <<END
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=16817
SlurmdPort=16818
SlurmUser=root
AuthType=auth/munge
# A requeued job starts when its old credential has expired: seconds here, two minutes by default.
AuthInfo=socket=$root/munge/socket,cred_expire=5
StateSaveLocation=$root/state
SlurmdSpoolDir=$root/spool
SlurmctldPidFile=$root/slurmctld.pid
SlurmdPidFile=$root/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_interval=1
SlurmdParameters=config_overrides
MaxArraySize=7
ReturnToService=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=4
PartitionName=all Nodes=ALL Default=YES State=UP
END
slurmctld -D >"$root/slurmctld.log" 2>&1 &
daemons+=($!)
slurmd -D >"$root/slurmd.log" 2>&1 &
daemons+=($!)
node_is_idle() { sinfo --noheader --format=%T | grep -qx idle; }
until_true 30 node_is_idle
echo "== $(slurmctld -V) is up"

# --- What one run makes ---

work="$root/work of art"
mkdir "$work"
cd "$work"
settings=(--maps synthetic:8 --profile full --tx-per-map 50 --rx-per-map 2000 --limits r2d1)
"$XTASK" dataset "${settings[@]}" --out whole >/dev/null
echo "== one run: $(du -sh whole | cut -f1)"

# --- The same by an array of which three tasks meet with something ---

campaign() { "$XTASK" slurm "${settings[@]}" --nodes 3 --tasks 4 --out "$@"; }
field() { scontrol show job --oneliner "$1" | grep -o "\b$2=[^ ]*" | head -n 1 | cut -d= -f2; }
job_of() { sed -n "s/^$1: job //p" submitted; }
queue_is_empty() { [ -z "$(squeue --noheader)" ]; }
has_map() { [ -d "$1/map_000$2" ]; }
# The process that makes a shard.
maker() { pgrep --full -- "--out $1 --shard $2/4 "; }

"$XTASK" slurm "${settings[@]}" --nodes 3 --tasks 8 --out too-many --submit 2>refused && fail "8 tasks were submitted"
grep -q -- "--tasks 6 or less" refused || fail "the limit of the cluster is not told: $(cat refused)"
queue_is_empty || fail "something was submitted"
shellcheck too-many-slurm/*.sh
echo "== more tasks than the cluster takes: refused"

campaign shards --cpus 1 | tail -n 1
shellcheck "$repository/tests/slurm.sh" shards-slurm/*.sh
echo "== scripts are clean"
campaign shards --cpus 1 --submit | tee submitted
array=$(job_of array)
# Shard 2 makes maps 1 and 5: killed between them, as the kernel does when memory is short.
until_true 120 has_map shards 1
kill -KILL "$(maker shards 2)"
# Shard 1 is told that its time is over.
until_true 120 has_map shards 0
scancel --batch --signal=USR1 "${array}_1"
until_true 300 queue_is_empty
for task in 1 2; do
    [ "$(field "${array}_$task" Restarts)" = 1 ] || fail "task $task was not started again"
done
for task in 3 4; do
    [ "$(field "${array}_$task" Restarts)" = 0 ] || fail "task $task was started again"
done
[ "$(field "$(job_of merge)" JobState)" = COMPLETED ] || fail "the merge did not succeed"
grep -h "back into the queue" shards-slurm/log/*
grep -h "is as it should be" shards-slurm/log/merge_*
diff --recursive whole shards
echo "== killed, out of time, requeued, merged: the same bytes"

# --- A task that is given up is submitted alone; each has the node for itself ---

campaign given-up --retries 0 --submit | tee submitted
array=$(job_of array)
until_true 120 has_map given-up 2
kill -KILL "$(maker given-up 3)"
until_true 300 queue_is_empty
[ "$(field "${array}_3" JobState)" = FAILED ] || fail "task 3 did not fail"
[ "$(field "$(job_of merge)" JobState)" = CANCELLED ] || fail "the merge was not withdrawn"
grep -h "given up" given-up-slurm/log/*
campaign given-up --retries 0 --submit | tee submitted
grep -q '^#SBATCH --array=.*3%3' given-up-slurm/array.sh || fail "not task 3 alone"
until_true 300 queue_is_empty
[ "$(field "$(job_of merge)" JobState)" = COMPLETED ] || fail "the merge did not succeed"
diff --recursive whole given-up
campaign given-up --submit | tee submitted
until_true 60 queue_is_empty
echo "== given up, submitted alone, merged: the same bytes"
